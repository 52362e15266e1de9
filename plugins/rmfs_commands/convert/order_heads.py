"""Headers of orders in a table of their own, as ERP exports have them, joined to order lines."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable, Iterator

from rmfs_commands.convert.cleaning import Cleaner
from rmfs_commands.convert.loading import load
from rmfs_commands.convert.names import short
from rmfs_commands.convert.tables import Table
from rmfs_commands.convert.tally import SHOWN, Tally, why_none
from rmfs_core.errors import InputError
from rmfs_core.wording import counted, listed

_HEADED = """
CREATE TABLE headed AS SELECT name, row, tick, ahead, due, priority, cancelled, route, times, dues, priorities, routes
  FROM (SELECT name, row, tick, ahead, row_number() OVER (PARTITION BY name ORDER BY tick, row) AS rank FROM head)
  JOIN (SELECT name, min(due) AS due, max(priority) AS priority,
    CASE count(cancelled) WHEN count(*) THEN max(cancelled) END AS cancelled, max(tick) - min(tick) AS times,
    min(due) < max(due) AS dues, min(priority) < max(priority) AS priorities,
    min(route) AS route, min(route) < max(route) AS routes FROM head GROUP BY name) USING (name)
  WHERE rank = 1;
CREATE UNIQUE INDEX headed_name ON headed (name);
DROP TABLE head;
"""
_WITHOUT_HEAD = "FROM line WHERE name NOT IN (SELECT name FROM headed)"
_NOT_READ = "a header that is not read"
_PASSED = "name IN (SELECT name FROM passed)"
_WITHOUT_LINES = "SELECT name FROM headed EXCEPT SELECT name FROM line EXCEPT SELECT name FROM lost"


class OrderHeads:
    """The headers of orders: when they arrive, when they are due or cancelled, how urgent they are.

    Parameters
    ----------
    table
        Where they are; a row for each order.
    cleaner
        Reads them: its column of orders is the key that lines are joined by.
    base
        Where the lines are, in the table ``line``, and the orders of lines left out, in ``lost``.

    Attributes
    ----------
    file
        Where the table is.
    without_lines
        Number of orders that have a header and no line.
    """

    def __init__(self, table: Table, cleaner: Cleaner, base: sqlite3.Connection) -> None:
        self.file, self.cleaner = str(table.file), cleaner
        self.without_lines = 0
        self._table, self._base = table, base
        self._without_lines = ""
        base.execute("CREATE TABLE head AS SELECT * FROM line WHERE 0")
        base.execute("CREATE TABLE passed (name TEXT NOT NULL)")

    def read(self) -> None:
        """Take in the table.

        Raises
        ------
        InputError
            When the file cannot be read, lacks a column, or none of its rows is a header.
        """
        load(self._table, self.cleaner, self._base, "head", self._pass)
        self._base.execute("DELETE FROM lost")  # an order that lost a header has lost no line
        if not self._count("SELECT count(*) FROM head"):
            found = why_none(self.cleaner.others, self.cleaner.left_out())
            raise InputError(self.file, f"has no header of an order that could be kept: {found}")

    def _pass(self, order: str) -> None:
        name = self.cleaner.reader.names.clean(order.strip())
        self._base.execute("INSERT INTO passed VALUES (?)", (name,))

    def join(self, file: str, dropped: Tally) -> None:
        """Give the lines of a file what their headers say; leave out lines without.

        Raises
        ------
        InputError
            When no order of the lines has a header.
        """
        self._base.executescript(_HEADED)
        self.without_lines = self._count(f"SELECT count(*) FROM ({_WITHOUT_LINES})")
        some = self._base.execute(f"{_WITHOUT_LINES} ORDER BY name LIMIT {SHOWN}")
        self._without_lines = _some(name for (name,) in some)
        shown = self._base.execute(f"SELECT row, name {_WITHOUT_HEAD} ORDER BY row LIMIT {SHOWN}").fetchall()
        for reason, of in ((_NOT_READ, _PASSED), (f"no header in {self.file} that is kept", f"NOT {_PASSED}")):
            which = f"{_WITHOUT_HEAD} AND {of}"
            if rows := self._count(f"SELECT count(*) {which}"):
                first = self._base.execute(f"SELECT row, name {which} ORDER BY row LIMIT {SHOWN}").fetchall()
                dropped.add(reason, rows, first, chosen=reason == _NOT_READ)
        if shown:
            self._base.execute(f"INSERT INTO lost SELECT DISTINCT name, 1 {_WITHOUT_HEAD}")
            self._base.execute(f"DELETE {_WITHOUT_HEAD}")
        if not self._count("SELECT count(*) FROM line"):
            there = _some(name for _, name in shown)
            found = f"no order of {file} has a header: found orders {there} there, and {self._without_lines} here"
            raise InputError(self.file, f"{found}; expected the same in both (--order, --order-key)")
        self._base.execute(
            "UPDATE line SET (tick, ahead, due, priority, cancelled, route) ="
            " (SELECT tick, ahead, due, priority, cancelled, route FROM headed WHERE headed.name = line.name)"
        )

    def sentences(self) -> Iterator[str]:
        """Yield what is to be said of the table."""
        yield from self.cleaner.sentences(f" of {self.file}", "header")
        if self.without_lines:
            left = f"{counted(self.without_lines, 'order')} without lines: {self._without_lines}"
            yield f"Left out of {self.file}: {left}."

    def _count(self, query: str) -> int:
        return int(self._base.execute(query).fetchone()[0])


def _some(names: Iterable[str]) -> str:
    return listed(f'"{short(name)}"' for name in dict.fromkeys(names))
