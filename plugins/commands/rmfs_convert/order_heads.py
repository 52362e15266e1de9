"""Headers of orders in a table of their own, as ERP exports have them, joined to order lines."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator

from attrs import frozen

from rmfs_convert.cleaning import Cleaner, join_time_of_day
from rmfs_convert.tables import Table
from rmfs_core.errors import InputError
from rmfs_core.wording import counted, first_few, listed, shown_short

_SCHEMA = """
CREATE TABLE head (
  name TEXT NOT NULL, tick INTEGER NOT NULL, ahead INTEGER NOT NULL, due INTEGER, priority INTEGER, row INTEGER NOT NULL
);
"""
_HEADED = """
CREATE TABLE headed AS SELECT name, tick, ahead, due, priority, times, dues, priorities
  FROM (SELECT name, tick, ahead, row_number() OVER (PARTITION BY name ORDER BY tick, row) AS rank FROM head)
  JOIN (SELECT name, min(due) AS due, max(priority) AS priority, min(tick) < max(tick) AS times,
    min(due) < max(due) AS dues, min(priority) < max(priority) AS priorities FROM head GROUP BY name) USING (name)
  WHERE rank = 1;
CREATE UNIQUE INDEX headed_name ON headed (name);
DROP TABLE head;
"""
_WITHOUT_HEAD = "SELECT DISTINCT name FROM line WHERE name NOT IN (SELECT name FROM headed)"
_WITHOUT_LINES = "SELECT name FROM headed EXCEPT SELECT name FROM line EXCEPT SELECT name FROM lost"


@frozen
class Unmatched:
    """Orders that only one of two tables has: how many, and some of their names."""

    number: int
    names: str


class OrderHeads:
    """The headers of orders: when they arrive, when they are due, how urgent they are.

    Parameters
    ----------
    table
        Where they are; a row for each order.
    cleaner
        Reads them: its column of orders is the key that lines are joined by.
    base
        Where the lines are, in the table ``line``, and the orders of those that were left out, in ``lost``.

    Attributes
    ----------
    without_lines
        Orders that have a header and no line.
    """

    def __init__(self, table: Table, cleaner: Cleaner, base: sqlite3.Connection) -> None:
        self.table, self.cleaner = table, cleaner
        self.without_lines = Unmatched(0, "")
        self._base = base
        base.executescript(_SCHEMA)

    def read(self) -> None:
        """Take in the table.

        Raises
        ------
        InputError
            When the file cannot be read, lacks a column, or none of its rows is a header.
        """
        columns, file = self.cleaner.columns, str(self.table.file)
        given = (columns.time, columns.due, columns.priority)
        names = [name for name in (columns.order, *given, columns.time_of_day) if name is not None]
        for batch in self.table.batches(names):
            texts = dict(zip(names, batch.columns, strict=True))
            join_time_of_day(texts, columns)
            fields = [[None] * len(batch.columns[0]) if name is None else texts[name] for name in given]
            rows = zip(batch.columns[0], *fields, strict=True)
            self._base.execute("BEGIN")
            heads = self.cleaner.heads(file, enumerate(rows, batch.first_row))
            self._base.executemany("INSERT INTO head VALUES (?, ?, ?, ?, ?, ?)", heads)
            self._base.execute("COMMIT")
            self.cleaner.ask(file)
        if not self._base.execute("SELECT count(*) FROM head").fetchone()[0]:
            found = "; ".join(self.cleaner.left_out()) or "it has no rows"
            raise InputError(file, f"has no header of an order that could be kept: {found}")

    def join(self, file: str) -> dict[str, int]:
        """Give the lines of a file what their headers say; leave out lines without; return orders left out, by reason.

        Raises
        ------
        InputError
            When no order of the lines has a header.
        """
        self._base.executescript(_HEADED)
        missing, self.without_lines = self._unmatched(_WITHOUT_HEAD), self._unmatched(_WITHOUT_LINES)
        self._base.execute("DELETE FROM line WHERE name NOT IN (SELECT name FROM headed)")
        if not self._base.execute("SELECT count(*) FROM line").fetchone()[0]:
            problem = (
                f"no order of {file} has a header: found orders {missing.names} there, and "
                f"{self.without_lines.names or 'none'} here; expected the same in both (--order, --order-key)"
            )
            raise InputError(str(self.table.file), problem)
        self._base.execute(
            "UPDATE line SET (tick, ahead, due, priority) ="
            " (SELECT tick, ahead, due, priority FROM headed WHERE headed.name = line.name)"
        )
        return {f"no header in {self.table.file} ({missing.names})": missing.number} if missing.number else {}

    def several(self, what: str) -> int:
        """Return how many orders that are kept have headers that differ in ``times``, ``dues`` or ``priorities``."""
        found = self._base.execute(f"SELECT count(*) FROM headed JOIN whole USING (name) WHERE headed.{what}")
        return int(found.fetchone()[0])

    def sentences(self) -> Iterator[str]:
        """Yield what is to be said of the table."""
        yield f"Read {counted(self.cleaner.rows, 'header')} of {self.table.file}."
        for part in self.cleaner.left_out():
            yield f"Left out of {self.table.file}: {part}."
        for _, part in self.cleaner.emptied.parts():
            yield f"Left empty of {self.table.file}: {part}."
        if self.without_lines.number:
            left = counted(self.without_lines.number, "order")
            yield f"Left out of {self.table.file}: {left} without lines ({self.without_lines.names})."

    def _unmatched(self, query: str) -> Unmatched:
        number = self._base.execute(f"SELECT count(*) FROM ({query})").fetchone()[0]
        some = [shown_short(name)[1:-1] for (name,) in self._base.execute(f"{query} ORDER BY name LIMIT 3")]
        return Unmatched(number, listed([*some, f"{number - 3:,} more"]) if number > 3 else first_few(some))
