"""Order lines, cleaned and brought together by order, in a database file: memory does not grow with their number."""

from __future__ import annotations

import csv
import sqlite3
import tempfile
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from itertools import groupby, islice
from operator import itemgetter
from pathlib import Path
from types import TracebackType
from typing import NoReturn, Self, TextIO

from attrs import frozen

from rmfs_commands.cli.loads import Demand
from rmfs_commands.convert.cleaning import Cleaner
from rmfs_commands.convert.loading import keep_lost, load
from rmfs_commands.convert.order_heads import OrderHeads
from rmfs_commands.convert.tables import Table
from rmfs_commands.convert.tally import SHOWN, Dropped, why_none
from rmfs_commands.convert.time_formats import Moment
from rmfs_commands.instances.csv_files import TEN_YEARS
from rmfs_core.clock import TICKS_PER_S, to_seconds
from rmfs_core.errors import InputError

_SCHEMA = """
PRAGMA journal_mode = OFF;
PRAGMA synchronous = OFF;
PRAGMA cache_size = -65536;
PRAGMA temp_store = FILE;
CREATE TABLE line (
  name TEXT NOT NULL, sku TEXT NOT NULL, tick INTEGER NOT NULL, ahead INTEGER NOT NULL, quantity INTEGER NOT NULL,
  due INTEGER, priority INTEGER, cancelled INTEGER, row INTEGER NOT NULL, route TEXT
);
CREATE TABLE lost (name TEXT NOT NULL, shortens INTEGER NOT NULL);
"""

NO_ROW = "no row that is kept"
LACK, WITH_ANOTHER = "lack of stock", "another line of the order"
"""Why a line was left out with a stock: its own SKU, or that of another line with --whole-orders."""


@frozen
class Span:
    """Which orders are kept, by their arrival, and time 0; None: all, and the midnight before the first.

    Orders that arrive before ``history_end`` are history, and not kept either. ``options`` are those that say the
    begin and the end.
    """

    begin: Moment | None = None
    end: Moment | None = None
    start: Moment | None = None
    history_end: Moment | None = None
    options: str = "--from, --until"


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
    cleaner
        Makes order lines of rows.

    Attributes
    ----------
    file
        Where the table is.
    several
        Orders whose lines differ in their times, due times, priorities and routes, by what they differ in: the earliest
        time, the earliest due time, the highest priority and the first route by name is the order's.
    most_apart
        Ticks by which the times of an order differ, at most.
    due_before, cancelled_before
        Orders that are due, or cancelled, before they arrive.
    left_out
        Orders that were left out whole, by reason.
    shortened
        Orders that are kept, and lost a line of another SKU than those to leave out.
    offsets
        Ticks by which the clocks of the kept lines are ahead of UTC.
    lacking
        Order, SKU, items and reason of the lines that were left out for lack of stock, and of lines left out
        with them, by arrival; None where none may be.
    """

    def __init__(self, cleaner: Cleaner) -> None:
        self.cleaner = cleaner
        self.several: dict[str, Dropped] = {}
        self.most_apart = 0
        self.due_before = self.cancelled_before = Dropped()
        self.left_out: dict[str, int] = {}
        self.shortened = 0
        self.heads: OrderHeads | None = None
        self.offsets: list[int] = []
        self.lacking: list[tuple[str, str, int, str]] | None = None
        self.file = "the table"
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

    def read_heads(self, table: Table, cleaner: Cleaner) -> None:
        """Take in a table of headers of orders, with their times; then the table of lines has none."""
        self.heads = OrderHeads(table, cleaner, self._base)
        self.heads.read()

    def read(self, table: Table) -> None:
        """Take in a table.

        Raises
        ------
        InputError
            When the file cannot be read, lacks a column, has numbers that may mean two things, or none of its rows is
            an order line.
        """
        self.file = str(table.file)
        load(table, self.cleaner, self._base, "line")
        if self._count("SELECT count(*) FROM line") == 0:
            self._refuse_all()

    def _refuse_all(self) -> NoReturn:
        found = why_none(self.cleaner.others, self.cleaner.left_out())
        raise InputError(self.file, f"has no order line that could be kept: {found}")

    def gather(
        self, span: Span | None = None, whole: bool = False, stock: Mapping[str, int | None] | None = None
    ) -> Moment:
        """Bring the lines of each order together; return time 0.

        Parameters
        ----------
        span
            Orders that arrive before its begin, or at its end or later, are left out.
        whole
            Whether orders that lost a line are left out.
        stock
            Items of each SKU that there are, None: any number. Lines that want more than is left are left out.

        Raises
        ------
        InputError
            When no order is left, or the first arrives before time 0.
        """
        span = span or Span()
        if self.heads is not None:
            self.heads.join(self.file, self.cleaner.dropped)
        self._count_orders_lost()
        self._base.executescript(
            "CREATE TABLE whole AS SELECT name, min(tick) AS tick, min(rowid) AS first, min(due) AS due,"
            " max(priority) AS priority, max(tick) - min(tick) AS times, min(due) < max(due) AS dues,"
            " min(priority) < max(priority) AS priorities, min(route) AS route, min(route) < max(route) AS routes,"
            " CASE count(cancelled) WHEN count(*) THEN max(cancelled) END AS cancelled FROM line GROUP BY name;"
        )
        self._choose(span)
        self._base.executescript(
            "CREATE UNIQUE INDEX whole_name ON whole (name);"
            "CREATE TABLE packed AS SELECT whole.tick AS tick, whole.first AS first, line.name, line.sku,"
            " sum(line.quantity) AS quantity, min(line.row) AS row, count(*) AS rows"
            " FROM line JOIN whole USING (name) GROUP BY line.name, line.sku;"
        )
        self._leave_out_large()
        if stock is not None:
            if whole:  # orders that are left out take nothing of the stock
                self._leave_out_shortened(whole)
            self._leave_out_lacking(stock, whole)
        self._leave_out_shortened(whole)
        zero = self._zero(span.start)
        self._leave_out_late(zero)
        kept = self._base.execute("SELECT DISTINCT ahead FROM line WHERE name IN (SELECT name FROM whole)")
        self.offsets = sorted(ahead for (ahead,) in kept)
        self._base.executescript("DROP TABLE line; DROP TABLE lost;")
        for what in ("times", "dues", "priorities", "routes"):
            self.several[what] = self._noted(what)
        self.due_before, self.cancelled_before = self._noted("due < tick"), self._noted("cancelled < tick")
        self.most_apart = self._count(
            f"SELECT ifnull(max(times), 0) FROM {self._heads} WHERE name IN (SELECT name FROM whole)"
        )
        return zero

    @property
    def _heads(self) -> str:
        """Name of the table that says when orders arrive."""
        return "whole" if self.heads is None else "headed"

    def _noted(self, what: str) -> Dropped:
        """Return of how many orders that are kept something is to be said, and their first rows."""
        names = f"SELECT name FROM {self._heads} WHERE {what} INTERSECT SELECT name FROM whole"
        if not (found := self._count(f"SELECT count(*) FROM ({names})")):
            return Dropped()
        rows = "packed" if self.heads is None else "headed"
        query = f"SELECT min(row), name FROM {rows} WHERE name IN ({names}) GROUP BY name ORDER BY 1 LIMIT {SHOWN}"
        return Dropped(found, self._base.execute(query).fetchall())

    def _count_orders_lost(self) -> None:
        """Count the orders none of whose rows is kept."""
        if found := self._count("SELECT count(*) FROM (SELECT name FROM lost EXCEPT SELECT name FROM line)"):
            self.left_out[NO_ROW] = found

    def _choose(self, span: Span) -> None:
        """Leave out the orders outside a span."""
        begin, end = (None if moment is None else moment.tick for moment in (span.begin, span.end))
        first, last = self._base.execute("SELECT min(tick), max(tick) FROM whole").fetchone()
        kept = "tick >= ifnull(?, tick) AND tick < ifnull(?, tick + 1)"
        found = self._base.execute(f"DELETE FROM whole WHERE NOT ({kept})", (begin, end)).rowcount
        if found:
            self.left_out["a time outside the chosen span"] = found
        if span.history_end is not None:
            found = self._base.execute("DELETE FROM whole WHERE tick < ?", (span.history_end.tick,)).rowcount
            self.left_out["a time before --history-until, which are history"] = found
            if self.n_orders == 0:
                there = f"all orders ({found:,}) are earlier, the last at {self._time(last)}"
                raise InputError("--history-until", f"{there}; expected some from then on")
        if self.n_orders == 0:
            there = f"all orders ({found:,}) are outside: from {self._time(first)} to {self._time(last)}"
            raise InputError(span.options, f"{there}; expected a span with some of them")

    def _time(self, tick: int) -> str:
        """Return the time of an order as text, with the offset from UTC that one of its lines has."""
        (ahead,) = self._base.execute("SELECT min(ahead) FROM line WHERE tick = ?", (tick,)).fetchone()
        return self.cleaner.reader.clock.iso(Moment(tick, ahead))

    def _leave_out_large(self) -> None:
        """Leave out lines that are too large once rows of a SKU are added up."""
        large = self._base.execute(
            "SELECT row, quantity, name, sku FROM packed WHERE quantity > ? ORDER BY row", (self.cleaner.choice.most,)
        ).fetchall()
        for row, quantity, name, _ in large:
            self.cleaner.drop_large(row, f"{quantity:,}", name)
        keep_lost(self.cleaner, self._base)
        self._base.executemany("DELETE FROM packed WHERE name = ? AND sku = ?", [one[2:] for one in large])
        self._leave_out_empty(NO_ROW)

    def _leave_out_lacking(self, stock: Mapping[str, int | None], whole: bool) -> None:
        """Leave out lines for which too few items are left of a stock, by arrival; or all of their orders."""
        left, self.lacking = {sku: items for sku, items in stock.items() if items is not None}, []
        query = "SELECT first, name, sku, quantity, row FROM packed ORDER BY tick, first, row"
        for _, of_order in groupby(self._base.execute(query), itemgetter(0)):
            rows = [row[1:] for row in of_order]
            lacking = [row for row in rows if stock.get(row[1], 0) is not None and left.get(row[1], 0) < row[2]]
            for row in rows:
                if row in lacking or (whole and lacking):
                    self.lacking.append((*row[:3], LACK if row in lacking else WITH_ANOTHER))
                elif row[1] in left:
                    left[row[1]] -= row[2]
        found = [(name, sku) for name, sku, _, reason in self.lacking if reason == LACK]
        if len({sku for _, sku in found}) == len(self.skus()) and len(found) == self.n_lines:
            raise InputError("--in-stock", "found no item there for any of the order lines; expected the same SKUs")
        self._base.executemany("DELETE FROM packed WHERE name = ? AND sku = ?", found)
        self._base.executemany("INSERT INTO lost VALUES (?, 1)", {one[:1] for one in found})
        self._leave_out_empty("no line that stock can serve")

    def _leave_out_empty(self, reason: str) -> None:
        """Leave out the orders that lost all lines."""
        self._count_left_out(reason, "DELETE FROM whole WHERE name NOT IN (SELECT name FROM packed)")

    def _count_left_out(self, reason: str, query: str) -> None:
        if found := self._base.execute(query).rowcount:
            self.left_out[reason] = self.left_out.get(reason, 0) + found

    def _leave_out_shortened(self, whole: bool) -> None:
        """Count the orders that lost a line, or leave them out."""
        lost = "name IN (SELECT name FROM lost WHERE shortens)"
        self.shortened = self._count(f"SELECT count(*) FROM whole WHERE {lost}")
        if whole and self.shortened:
            reason = "a line that is left out (--whole-orders)"
            self.left_out[reason] = self.left_out.get(reason, 0) + self.shortened
            self._base.executescript(f"DELETE FROM packed WHERE {lost}; DELETE FROM whole WHERE {lost};")
            self.shortened = 0
        if self.n_orders == 0:
            self._refuse_all()

    def _zero(self, start: Moment | None) -> Moment:
        """Return time 0: the start, or the midnight before the first order by the clock of its time."""
        clock = self.cleaner.reader.clock
        tick, ahead = self._base.execute(
            "SELECT tick, min(ahead) FROM line WHERE tick = (SELECT min(tick) FROM whole)"
            " AND name IN (SELECT name FROM whole)"
        ).fetchone()
        first = Moment(tick, ahead)
        if start is not None and start.tick > tick:
            found = f"found {clock.iso(start)}, but the first order arrives at {clock.iso(first)}"
            raise InputError("--start", f"{found}; expected a time that is not later (--from leaves out orders)")
        return clock.midnight_before(first) if start is None else start

    def _leave_out_late(self, zero: Moment) -> None:
        """Leave out the orders that a run would refuse, since they arrive years after time 0."""
        late = f"SELECT name FROM whole WHERE tick > {zero.tick + TEN_YEARS}"
        rows = self._count(f"SELECT count(*) FROM line WHERE name IN ({late})")
        if rows:
            shown = self._base.execute(
                f"SELECT row, tick, ahead FROM line WHERE name IN ({late}) ORDER BY row LIMIT {SHOWN}"
            )
            iso = self.cleaner.reader.clock.iso
            reason = f"a time more than ten years after time 0 ({iso(zero)}; --from leaves out what is earlier)"
            self.cleaner.dropped.add(reason, rows, [(row, iso(Moment(tick, ahead))) for row, tick, ahead in shown])
            self._base.execute(f"DELETE FROM packed WHERE name IN ({late})")
            self._count_left_out(NO_ROW, f"DELETE FROM whole WHERE tick > {zero.tick + TEN_YEARS}")
        if self.n_orders == 0:
            found = "; ".join(self.cleaner.left_out())
            raise InputError(self.file, f"has no order in time: {found}; expected another --start or --time-format")

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

    @property
    def cancelled(self) -> int:
        """Number of orders that are cancelled."""
        return self._count("SELECT count(*) FROM whole WHERE cancelled IS NOT NULL")

    def names(self) -> Iterator[str]:
        """Yield the names of the orders that are kept."""
        yield from (name for (name,) in self._base.execute("SELECT name FROM whole"))

    def forget(self, names: Iterable[str]) -> int:
        """Leave out orders by their names; return how many of them there were."""
        self._base.execute("CREATE TEMP TABLE forgotten (name TEXT PRIMARY KEY) WITHOUT ROWID")
        self._base.execute("BEGIN")
        self._base.executemany("INSERT OR IGNORE INTO forgotten VALUES (?)", ((name,) for name in names))
        self._base.execute("COMMIT")
        self._base.execute("DELETE FROM packed WHERE name IN (SELECT name FROM forgotten)")
        found = self._base.execute("DELETE FROM whole WHERE name IN (SELECT name FROM forgotten)").rowcount
        self._base.execute("DROP TABLE forgotten")
        return found

    def largest(self, number: int) -> list[tuple[str, str, int]]:
        """Return order, SKU and items of the lines with most items."""
        return self._base.execute(
            "SELECT name, sku, quantity FROM packed ORDER BY quantity DESC, row LIMIT ?", (number,)
        ).fetchall()

    def skus(self) -> list[Sku]:
        """Return the SKUs that are wanted, most order lines first, then by name."""
        query = "SELECT sku, count(*), sum(quantity) FROM packed GROUP BY sku ORDER BY count(*) DESC, sku"
        return [Sku(*row) for row in self._base.execute(query)]

    def baskets(self, most: int) -> Iterator[list[str]]:
        """Yield the SKUs of each of the first ``most`` orders, by arrival."""
        rows = self._base.execute("SELECT first, sku FROM packed ORDER BY tick, first, row")
        for _, order in islice(groupby(rows, itemgetter(0)), most):
            yield [sku for _, sku in order]

    def write(self, stream: TextIO, start: int) -> tuple[Counter[str], Demand]:
        """Write the orders, by arrival, with time 0 at the tick ``start``; return totals and what they want.

        The columns are ``order,arrival_s,sku,quantity``, and ``due_s``, ``priority``, ``cancelled_s`` and ``route``
        where the table has them.

        Returns
        -------
        tuple
            Totals: ``items``; ``early``: orders that were due before ``start``, for which 0 is written. And what they
            want, by the hour.
        """
        writer = csv.writer(stream, lineterminator="\n")
        columns = (self.cleaner if self.heads is None else self.heads.cleaner).columns
        more = {"due_s": columns.due, "priority": columns.priority}
        more |= {"cancelled_s": columns.cancelled, "route": columns.route}
        shown = [column for column, name in more.items() if name is not None]
        writer.writerow(("order", "arrival_s", "sku", "quantity", *shown))
        totals: Counter[str] = Counter()
        totals["early"] = self._count("SELECT count(*) FROM whole WHERE due < ?", start)
        query = (
            "SELECT packed.name, packed.tick, sku, quantity, due, priority, cancelled, route"
            " FROM packed JOIN whole USING (name) ORDER BY packed.tick, packed.first, row"
        )
        demand = Demand()
        for name, tick, sku, quantity, due, priority, cancelled, route in self._base.execute(query):
            said = {"due_s": None if due is None else _seconds(max(due - start, 0)), "priority": priority}
            said["cancelled_s"] = None if cancelled is None else _seconds(max(cancelled, tick) - start)
            said["route"] = route
            writer.writerow((name, _seconds(tick - start), sku, quantity, *(said[column] for column in shown)))
            totals["items"] += quantity
            demand.add(tick - start, quantity)
        return totals, demand

    def _count(self, query: str, *arguments: int | None) -> int:
        (found,) = self._base.execute(query, arguments).fetchone()
        return int(found)


def _seconds(ticks: int) -> int | float:
    """Return a time in seconds, whole where it is."""
    return ticks // TICKS_PER_S if ticks % TICKS_PER_S == 0 else to_seconds(ticks)
