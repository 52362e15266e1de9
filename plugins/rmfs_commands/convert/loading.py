"""Rows of a table, cleaned, put into a database."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable
from itertools import islice

from attrs import astuple

from rmfs_commands.convert.cleaning import Cleaner
from rmfs_commands.convert.headers import plain
from rmfs_commands.convert.tables import Table

ROWS_PER_BATCH = 16_384


def load(
    table: Table,
    cleaner: Cleaner,
    base: sqlite3.Connection,
    into: str,
    passed: Callable[[str], None] | None = None,
) -> None:
    """Put what a cleaner makes of a table into one of a database, and the orders of rows left out into ``lost``.

    ``passed`` is told the order of each row that is not read.

    Raises
    ------
    InputError
        When the file cannot be read, lacks a column, or has numbers or times that may mean two things.
    """
    file, rows, cleaner.others = str(table.file), table.rows(astuple(cleaner.columns), passed), table.others
    while batch := list(islice(rows, ROWS_PER_BATCH)):
        base.execute("BEGIN")
        base.executemany(f"INSERT INTO {into} VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)", cleaner.lines(file, batch))
        keep_lost(cleaner, base)
        base.execute("COMMIT")
        cleaner.ask(file)
    used = {plain(column) for column in (*astuple(cleaner.columns), *(table.only or ())) if column}
    cleaner.unused = [*dict.fromkeys(name for name in map(plain, table.header) if name and name not in used)]


def keep_lost(cleaner: Cleaner, base: sqlite3.Connection) -> None:
    """Move the orders of rows that were left out from memory into the table ``lost``."""
    base.executemany("INSERT INTO lost VALUES (?, ?)", cleaner.lost)
    cleaner.lost.clear()
