"""Tables put into a database."""

from __future__ import annotations

import sqlite3
from pathlib import Path

import pytest

from rmfs_commands.convert import loading
from rmfs_commands.convert.cleaning import Choice, Cleaner, Columns, Reader
from rmfs_commands.convert.loading import load
from rmfs_commands.convert.tables import Table
from rmfs_core.errors import InputError


def loaded(file: Path, text: str) -> tuple[list[tuple[object, ...]], list[tuple[str]]]:
    """Load a table of orders, SKUs and quantities; return the lines, and the orders that lost one."""
    file.write_text(text, encoding="utf-8")
    base = sqlite3.connect(":memory:", isolation_level=None)
    base.executescript("CREATE TABLE line (a, b, c, d, e, f, g, h); CREATE TABLE lost (name, shortens)")
    cleaner = Cleaner(Columns("o", "s", quantity="q"), Reader(), Choice())
    load(Table(file), cleaner, base, "line")
    assert cleaner.lost == []
    return base.execute("SELECT a, b, e, h FROM line").fetchall(), base.execute("SELECT name FROM lost").fetchall()


def test_all_rows_are_loaded_in_batches(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The last is smaller; orders that lost a line are kept beside."""
    monkeypatch.setattr(loading, "ROWS_PER_BATCH", 2)
    lines, lost = loaded(tmp_path / "t.csv", "o,s,q\nA,tea,1\nB,tea,0\nC,jam,2\nD,,1\nE,rye,3\n")
    assert lines == [("A", "tea", 1, 1), ("C", "jam", 2, 3), ("E", "rye", 3, 5)]
    assert lost == [("B",), ("D",)]


def test_a_question_is_asked_before_all_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """After the batch that has it: the row of another kind behind it is never reached."""
    monkeypatch.setattr(loading, "ROWS_PER_BATCH", 2)
    with pytest.raises(InputError, match=r'row 2, q: found "1.000", which may be 1 or 1000'):
        loaded(tmp_path / "t.csv", "o,s,q\nA,tea,1\nB,tea,1.000\nC,jam,2\nD,jam\n")
