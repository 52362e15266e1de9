"""Order lines, cleaned and brought together by order, in a database file: memory does not grow with their number."""

from __future__ import annotations

import csv
import re
import sqlite3
import tempfile
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from types import TracebackType
from typing import Self, TextIO

from attrs import define, field, frozen

from rmfs_convert.tables import batches
from rmfs_convert.times import Clock, ClockError
from rmfs_core.clock import TICKS_PER_S, to_seconds
from rmfs_core.errors import InputError

SHOWN = 3
"""Rows that are named as examples of what was dropped."""

_WHOLE = re.compile(r"[0-9]{1,9}(\.0*)?")
_SCHEMA = """
PRAGMA journal_mode = OFF;
PRAGMA synchronous = OFF;
PRAGMA cache_size = -65536;
PRAGMA temp_store = FILE;
CREATE TABLE line (
  name TEXT NOT NULL, sku TEXT NOT NULL, tick INTEGER NOT NULL, quantity INTEGER NOT NULL, due INTEGER, priority INTEGER
);
"""


@frozen
class Columns:
    """Names of the columns of a table of order lines.

    None: the table has none. Then every line is one item, arrives at 0, is due whenever, and has no priority.
    """

    order: str
    sku: str
    time: str | None = None
    quantity: str | None = None
    due: str | None = None
    priority: str | None = None


@define
class Dropped:
    """Rows that were left out for one reason.

    Parameters
    ----------
    rows
        How many.
    examples
        Numbers of the first of them and what was found there.
    """

    rows: int = 0
    examples: list[tuple[int, str]] = field(factory=list)

    def note(self, row: int, found: str) -> None:
        """Count a row."""
        self.rows += 1
        if len(self.examples) < SHOWN:
            self.examples.append((row, found))


_Line = tuple[str, str, int, int, int | None, int | None]
"""Order, SKU, tick, items, tick at which it is due, priority."""


@frozen
class Sku:
    """A SKU, the order lines that want it, and their items."""

    name: str
    lines: int
    items: int


class OrderLines:
    """The order lines of a table.

    Parameters
    ----------
    clock
        Reads the times.

    Attributes
    ----------
    rows
        Rows read.
    dropped
        Rows that were left out, by reason.
    emptied
        Fields that were left empty, by reason: due times and priorities that cannot be read.
    several
        Orders whose lines differ in their times, due times and priorities, by what they differ in: the earliest time,
        the earliest due time and the highest priority is the order's.
    """

    def __init__(self, clock: Clock | None = None) -> None:
        self.clock = clock or Clock()
        self.rows = 0
        self.dropped: dict[str, Dropped] = {}
        self.emptied: dict[str, Dropped] = {}
        self.several: dict[str, int] = {}
        self._columns = Columns("", "")
        self._folder = tempfile.TemporaryDirectory(prefix="rmfs-convert-")
        self._base = sqlite3.connect(Path(self._folder.name) / "lines.sqlite", isolation_level=None)
        self._base.executescript(_SCHEMA)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._base.close()
        self._folder.cleanup()

    def read(self, file: Path, columns: Columns, separator: str = ",") -> None:
        """Take in a table.

        Raises
        ------
        InputError
            When the file cannot be read, lacks a column, or none of its rows is an order line.
        """
        self._columns = columns
        given = (columns.time, columns.quantity, columns.due, columns.priority)
        names = [columns.order, columns.sku, *(name for name in given if name is not None)]
        for batch in batches(file, names, separator):
            texts = dict(zip(names, batch.columns, strict=True))
            fields = [[None] * len(batch.columns[0]) if name is None else texts[name] for name in given]
            rows = zip(batch.columns[0], batch.columns[1], *fields, strict=True)
            self._base.execute("BEGIN")
            self._base.executemany(
                "INSERT INTO line VALUES (?, ?, ?, ?, ?, ?)", self._clean(file, enumerate(rows, batch.first_row))
            )
            self._base.execute("COMMIT")
        if self._count("SELECT count(*) FROM line") == 0:
            reasons = "; ".join(f"{what.rows:,} with {why}" for why, what in self.dropped.items())
            raise InputError(str(file), f"has no order line that could be kept: {reasons or 'it has no rows'}")

    def _clean(self, file: Path, rows: Iterable[tuple[int, tuple[str | None, ...]]]) -> Iterator[_Line]:
        columns = self._columns
        for row, fields in rows:
            self.rows += 1
            name, wanted, time, amount, due, priority = [(field or "").strip() for field in fields]
            time, amount = time if columns.time else "0", amount if columns.quantity else "1"
            if not name:
                self._drop("no order", row, "")
            elif not wanted:
                self._drop("no SKU", row, name)
            elif not _WHOLE.fullmatch(amount) or (items := int(float(amount))) < 1:
                self._drop("a quantity that is no whole number from 1 on (returns, weights)", row, amount)
            elif (tick := self._tick(file, row, time)) is None:
                self._drop("no time that can be read", row, time)
            else:
                yield name, wanted, tick, items, self._due(file, row, due), self._priority(row, priority)

    def _due(self, file: Path, row: int, text: str) -> int | None:
        if text and (tick := self._tick(file, row, text)) is not None:
            return tick
        if text:
            self.emptied.setdefault("a due time that cannot be read", Dropped()).note(row, text)
        return None

    def _priority(self, row: int, text: str) -> int | None:
        if _WHOLE.fullmatch(text):
            return int(float(text))
        if text:
            self.emptied.setdefault("a priority that is no whole number from 0 on", Dropped()).note(row, text)
        return None

    def _drop(self, reason: str, row: int, found: str) -> None:
        self.dropped.setdefault(reason, Dropped()).note(row, found)

    def _tick(self, file: Path, row: int, text: str) -> int | None:
        try:
            return self.clock.tick(text)
        except ClockError as error:
            raise InputError(f"{file}, row {row}", str(error)) from None
        except (ValueError, OverflowError):
            return None

    def gather(self, begin: int | None = None, end: int | None = None) -> int:
        """Bring the lines of each order together; return the time, in ticks, of the first order.

        Parameters
        ----------
        begin, end
            Orders that arrive before ``begin``, or at ``end`` or later, are left out (ticks).
        """
        self._base.executescript(
            "CREATE TABLE whole AS SELECT name, min(tick) AS tick, min(rowid) AS first, min(due) AS due,"
            " max(priority) AS priority, min(tick) < max(tick) AS times, min(due) < max(due) AS dues,"
            " min(priority) < max(priority) AS priorities FROM line GROUP BY name;"
        )
        kept = "tick >= ifnull(?, tick) AND tick < ifnull(?, tick + 1)"
        left_out = self._count(f"SELECT count(*) FROM whole WHERE NOT ({kept})", begin, end)
        if left_out:
            self.dropped["a time outside the chosen span (orders)"] = Dropped(left_out)
        self._base.execute(f"DELETE FROM whole WHERE NOT ({kept})", (begin, end))
        if self.n_orders == 0:
            raise InputError(
                "--from, --until", f"all {left_out:,} orders are outside; expected a span with some of them"
            )
        for what in ("times", "dues", "priorities"):
            self.several[what] = self._count(f"SELECT count(*) FROM whole WHERE {what}")
        self._base.executescript(
            "CREATE UNIQUE INDEX whole_name ON whole (name);"
            "CREATE TABLE packed AS SELECT whole.tick AS tick, whole.first AS first, line.name, line.sku,"
            " sum(line.quantity) AS quantity, min(line.rowid) AS row, count(*) AS rows"
            " FROM line JOIN whole USING (name) GROUP BY line.name, line.sku;"
            "DROP TABLE line;"
        )
        return self._count("SELECT min(tick) FROM whole")

    @property
    def n_orders(self) -> int:
        """Number of orders that are kept."""
        return self._count("SELECT count(*) FROM whole")

    @property
    def n_lines(self) -> int:
        """Number of their lines: each SKU of an order once."""
        return self._count("SELECT count(*) FROM packed")

    @property
    def joined(self) -> int:
        """Rows that went into another row of the same order and SKU."""
        return self._count("SELECT ifnull(sum(rows - 1), 0) FROM packed")

    def skus(self) -> list[Sku]:
        """Return the SKUs that are wanted, most order lines first, then by name."""
        query = "SELECT sku, count(*), sum(quantity) FROM packed GROUP BY sku ORDER BY count(*) DESC, sku"
        return [Sku(*row) for row in self._base.execute(query)]

    def baskets(self, most: int) -> Iterator[list[str]]:
        """Yield the SKUs of each of the first ``most`` orders, by arrival."""
        found: list[str] = []
        last, orders = None, 0
        for first, sku in self._base.execute("SELECT first, sku FROM packed ORDER BY tick, first, row"):
            if first != last:
                if found:
                    yield found
                if orders == most:
                    return
                last, found, orders = first, [], orders + 1
            found.append(sku)
        if found:
            yield found

    def write(self, stream: TextIO, start: int) -> Counter[str]:
        """Write the orders, by arrival, with time 0 at ``start``; return totals.

        The columns are ``order,arrival_s,sku,quantity``, and ``due_s`` and ``priority`` where the table has them.

        Returns
        -------
        Counter
            ``items``; ``last``: the arrival of the last order in ticks after ``start``; ``early``: orders that were due
            before ``start``, for which 0 is written.
        """
        writer = csv.writer(stream, lineterminator="\n")
        more = {"due_s": self._columns.due, "priority": self._columns.priority}
        shown = [column for column, name in more.items() if name is not None]
        writer.writerow(("order", "arrival_s", "sku", "quantity", *shown))
        totals: Counter[str] = Counter()
        totals["early"] = self._count("SELECT count(*) FROM whole WHERE due < ?", start)
        query = (
            "SELECT packed.name, packed.tick, sku, quantity, due, priority"
            " FROM packed JOIN whole USING (name) ORDER BY packed.tick, packed.first, row"
        )
        for name, tick, sku, quantity, due, priority in self._base.execute(query):
            said = {"due_s": None if due is None else _seconds(max(due - start, 0)), "priority": priority}
            writer.writerow((name, _seconds(tick - start), sku, quantity, *(said[column] for column in shown)))
            totals["items"] += quantity
            totals["last"] = tick - start
        return totals

    def _count(self, query: str, *arguments: int | None) -> int:
        (found,) = self._base.execute(query, arguments).fetchone()
        return int(found)


def _seconds(ticks: int) -> int | float:
    """Return a time in seconds, whole where it is."""
    return ticks // TICKS_PER_S if ticks % TICKS_PER_S == 0 else to_seconds(ticks)
