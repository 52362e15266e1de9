"""Tables whose names are long, and JSON."""

from __future__ import annotations

import io
import json
import os

import pytest
from attrs import frozen
from rich import box
from rich.console import Console
from rich.table import Table

from rmfs_commands.cli.screen import new_table, output_console, print_described, print_json, print_named, say

NAMES = ("short", "a-rule-with-a-very-long-name-of-someone-else", '{ rule = "split-among-stations", max_seconds = 10 }')
FIGURES = 6


def printed(width: int, *, boxed: bool, names: tuple[str, ...] = NAMES) -> list[str]:
    """Return the lines of a table with these names."""
    table = Table(box=box.SIMPLE_HEAD if boxed else None, title="Runs")
    table.add_column("Rule")
    for number in range(FIGURES):
        table.add_column(f"figure\n{number}", justify="right")
    for name in names:
        table.add_row(name, *(f"{1000.25 + number}" for number in range(FIGURES)))
    stream = io.StringIO()
    print_named(Console(file=stream, width=width), table)
    return stream.getvalue().splitlines()


@pytest.mark.parametrize("boxed", [True, False])
@pytest.mark.parametrize("width", [80, 140])
def test_names_and_figures_are_whole(width: int, boxed: bool) -> None:
    """Beside their row where there is room, above it where there is none; no line is wider than the console."""
    lines = printed(width, boxed=boxed)
    assert max(map(len, lines)) <= width
    assert not any("…" in line for line in lines)
    for name in NAMES:
        (at,) = [number for number, line in enumerate(lines) if name in line]
        row = lines[at] if width == 140 else lines[at + 1]
        assert row.split()[-FIGURES:] == [f"{1000.25 + number}" for number in range(FIGURES)]
        assert width == 140 or lines[at] == name
    assert width == 140 or "Rule" in lines[:3]  # what the names are stands above them


def test_short_names_stay_in_their_row() -> None:
    """Nothing changes for a table that fits."""
    assert any(
        line.split() == ["short", *(f"{1000.25 + n}" for n in range(FIGURES))]
        for line in printed(80, boxed=True, names=NAMES[:1])
    )


def test_a_pipe_is_80_columns_wide(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Whatever the terminal that the other streams have, unless COLUMNS says another number; no line ends in blanks."""
    monkeypatch.setattr("os.get_terminal_size", lambda _=0: os.terminal_size((140, 40)))
    monkeypatch.delenv("COLUMNS", raising=False)
    table = new_table("Words")
    table.add_column("Name")
    table.add_column("What")
    table.add_row("a-name", 40 * "word ")
    output_console().print(table)
    assert 60 < max(map(len, lines := capsys.readouterr().out.splitlines())) <= 80
    assert [line for line in lines if line != line.rstrip()] == []
    assert lines[0] == "Words"
    monkeypatch.setenv("COLUMNS", "120")
    output_console().print(table)
    assert 100 < max(map(len, capsys.readouterr().out.splitlines())) <= 120


@pytest.mark.parametrize("width", [30, 80])
def test_names_beside_what_they_are(width: int) -> None:
    """Or above it, where there is no room; a name is whole either way."""
    stream = io.StringIO()
    print_described(Console(file=stream, width=width), {"a": 12 * "word ", "a-long-name": "[brackets]"})
    lines = [line.rstrip() for line in stream.getvalue().splitlines()]
    assert max(map(len, lines)) <= width
    assert lines[0] == (f"a            {11 * 'word '}word" if width == 80 else "a")
    assert lines[-1] == ("a-long-name  [brackets]" if width == 80 else "    [brackets]")


def test_a_line_is_printed_as_it_is() -> None:
    """What looks like markup is none, and a long line is not wrapped."""
    stream = io.StringIO()
    say(Console(file=stream, width=20), "a [run] of " + 30 * "x")
    assert stream.getvalue() == "a [run] of " + 30 * "x" + "\n"


def test_json_of_objects(capsys: pytest.CaptureFixture[str]) -> None:
    """attrs objects become tables, numbers that JSON does not know become texts."""

    @frozen
    class Thing:
        name: str
        parts: tuple[float, ...]

    print_json({"things": [Thing("a", (1.5, float("inf")))], "none": None})
    assert json.loads(capsys.readouterr().out) == {"things": [{"name": "a", "parts": [1.5, "inf"]}], "none": None}


def test_names_in_tables_are_no_markup(capsys: pytest.CaptureFixture[str]) -> None:
    """A rule or a station may be called as markup is written."""
    table = new_table("[/a]")
    table.add_column("Rule [b]")
    table.add_row("[/mine]")
    output_console().print(table)
    printed = capsys.readouterr().out
    assert all(name in printed for name in ("[/a]", "Rule [b]", "[/mine]"))
