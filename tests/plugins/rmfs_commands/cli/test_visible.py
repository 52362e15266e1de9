"""Names with signs that would steer a terminal."""

from __future__ import annotations

import io

import pytest
from rich.console import Console
from rich.text import Text

from rmfs_commands.cli.notes import notes_console
from rmfs_commands.cli.screen import new_table, output_console, say
from rmfs_commands.cli.visible import VisibleSigns

EVIL = "\x1b[31mred\x1b]0;title\x07\u202egnp\x9b2J"
SHOWN = r"\x1b[31mred\x1b]0;title" + r"\x07\u202egnp\x9b2J"


def test_no_name_steers_a_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    """In lines and in tables, on both streams; a line end stays one."""
    table = new_table()
    table.add_column("Order")
    table.add_row(Text(EVIL.replace("\x07", "")))
    console = output_console()
    console.print(table)
    say(console, f"one\n{EVIL.replace(chr(7), '')}")
    say(notes_console(), EVIL.replace("\x07", ""))
    printed = capsys.readouterr()
    shown = SHOWN.replace(r"\x07", "")
    assert printed.out.count(shown) == 2
    assert f"one\n{shown}\n" in printed.out
    assert printed.err.rstrip("\n").replace("\n", "") == shown
    for sign in "\x1b\x07\u202e\x9b":
        assert sign not in printed.out + printed.err


def test_what_styles_a_text_stays() -> None:
    """The console's own escapes are its own."""
    stream = io.StringIO()
    console = Console(file=stream, force_terminal=True, color_system="standard")
    console.push_render_hook(VisibleSigns())
    console.print(Text("a\x1bb", style="red"))
    assert stream.getvalue() == "\x1b[31ma\\x1bb\x1b[0m\n"
