"""Lines end where their words do."""

from __future__ import annotations

import io

import pytest
from rich.console import Console, RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from rmfs_commands.cli.trimming import WithoutTrailingBlanks


def printed(what: RenderableType, *, end: str = "\n", styled: bool = False, trimmed: bool = True) -> str:
    """Return what a console of 20 columns prints."""
    stream = io.StringIO()
    console = Console(file=stream, width=20, force_terminal=styled, color_system="standard" if styled else None)
    if trimmed:
        console.push_render_hook(WithoutTrailingBlanks())
    console.print(what, end=end)
    return stream.getvalue()


def table() -> Table:
    """Return a table that rich fills up with blanks, one row of it empty."""
    made = Table("Rule", "Says", box=None, padding=(0, 1))
    for row in (("one", "yes"), ("", ""), ("another", "no")):
        made.add_row(*row)
    return made


def test_a_table_keeps_its_columns_and_loses_its_blanks() -> None:
    """All that differs from what rich prints is at the end of lines; an empty row stays a line."""
    plain, found = printed(table(), trimmed=False), printed(table())
    assert plain != found
    assert found == "".join(f"{line.rstrip()}\n" for line in plain.splitlines())
    assert found.splitlines()[2] == ""


@pytest.mark.parametrize(
    ("what", "expected"),
    [
        (Text("  two  words  "), "  two  words\n"),
        (Text("first \n\n  third "), "first\n\n  third\n"),
        (Padding(Text("inside"), (1, 2)), "\n  inside\n\n"),
        (Text(""), "\n"),
    ],
)
def test_blanks_before_and_between_words_stay(what: RenderableType, expected: str) -> None:
    """So do empty lines."""
    assert printed(what) == expected


def test_no_line_is_ended_that_was_not() -> None:
    """What is printed next goes on in it."""
    assert printed(Text("asks: "), end="") == "asks:"


def test_words_keep_their_style() -> None:
    """Also the last one, which loses a blank, and none after it."""
    words = Text.assemble(("red ", "red"), ("bold ", "bold"), ("   ", "underline"))
    assert printed(words, styled=True) == "\x1b[31mred \x1b[0m\x1b[1mbold\x1b[0m\n"
