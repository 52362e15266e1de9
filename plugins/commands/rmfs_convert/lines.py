"""Order lines, cleaned and brought together by order, in a database file: memory does not grow with their number."""

from __future__ import annotations

import csv
import re
import sqlite3
import tempfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import Self, TextIO

from attrs import define, field, frozen

from rmfs_convert.tables import Batch, batches
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
CREATE TABLE line (name TEXT NOT NULL, sku TEXT NOT NULL, tick INTEGER NOT NULL, quantity INTEGER NOT NULL);
"""


@frozen
class Columns:
    """Names of the columns of a table of order lines; None: the table has none, and every line is one item, or at 0."""

    order: str
    sku: str
    time: str | None = None
    quantity: str | None = None


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
        What was left out, by reason.
    several_times
        Orders whose lines have different times: the earliest is the order's.
    """

    def __init__(self, clock: Clock | None = None) -> None:
        self.clock = clock or Clock()
        self.rows = 0
        self.dropped: dict[str, Dropped] = {}
        self.several_times = 0
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
        names = [columns.order, columns.sku, *(name for name in (columns.time, columns.quantity) if name is not None)]
        for batch in batches(file, names, separator):
            self._base.execute("BEGIN")
            self._base.executemany("INSERT INTO line VALUES (?, ?, ?, ?)", self._clean(file, batch, columns))
            self._base.execute("COMMIT")
        if self._count("SELECT count(*) FROM line") == 0:
            reasons = "; ".join(f"{what.rows:,} with {why}" for why, what in self.dropped.items())
            raise InputError(str(file), f"has no order line that could be kept: {reasons or 'it has no rows'}")

    def _clean(self, file: Path, batch: Batch, columns: Columns) -> Iterator[tuple[str, str, int, int]]:
        n = len(batch.columns[0])
        rest = list(batch.columns[2:])
        times = rest.pop(0) if columns.time is not None else ("0",) * n
        quantities = rest.pop(0) if columns.quantity is not None else ("1",) * n
        for row, (order, sku, time, quantity) in enumerate(
            zip(batch.columns[0], batch.columns[1], times, quantities, strict=True), batch.first_row
        ):
            self.rows += 1
            name, wanted = (order or "").strip(), (sku or "").strip()
            amount = (quantity or "").strip()
            if not name:
                self._drop("no order", row, "")
            elif not wanted:
                self._drop("no SKU", row, name)
            elif not _WHOLE.fullmatch(amount) or (items := int(float(amount))) < 1:
                self._drop("a quantity that is no whole number from 1 on (returns, weights)", row, amount)
            elif (tick := self._tick(file, row, (time or "").strip())) is None:
                self._drop("no time that can be read", row, (time or "").strip())
            else:
                yield name, wanted, tick, items

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
            "CREATE TABLE whole AS SELECT name, min(tick) AS tick, min(rowid) AS first,"
            " min(tick) < max(tick) AS several FROM line GROUP BY name;"
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
        self.several_times = self._count("SELECT count(*) FROM whole WHERE several")
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
        """Write ``order,arrival_s,sku,quantity``, orders by arrival, with time 0 at ``start``; return totals.

        Returns
        -------
        Counter
            ``items``, and ``last``: the arrival of the last order in ticks after ``start``.
        """
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(("order", "arrival_s", "sku", "quantity"))
        totals: Counter[str] = Counter()
        query = "SELECT name, tick, sku, quantity FROM packed ORDER BY tick, first, row"
        for name, tick, sku, quantity in self._base.execute(query):
            since = tick - start
            arrival = since // TICKS_PER_S if since % TICKS_PER_S == 0 else to_seconds(since)
            writer.writerow((name, arrival, sku, quantity))
            totals["items"] += quantity
            totals["last"] = since
        return totals

    def _count(self, query: str, *arguments: int | None) -> int:
        (found,) = self._base.execute(query, arguments).fetchone()
        return int(found)
