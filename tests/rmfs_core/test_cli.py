"""The command line: it stays light, and a plugin that cannot be had costs the others nothing."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import click
import pytest

from rmfs_core.cli import main, rmfs

SLOW = (
    *("numpy", "numba", "simpy", "mip", "matplotlib", "pyarrow", "rich"),
    *("scipy", "joblib", "jinja2", "attrs", "cattrs", "pluggy"),
)
COMMANDS = "rmfs.commands"
Install = Callable[..., None]


def calls(command: click.Command, *words: str) -> list[list[str]]:
    """Return the words of every command and group below one, itself included."""
    found = [list(words)]
    if isinstance(command, click.Group):
        context = click.Context(command)
        for name in command.list_commands(context):
            below = command.get_command(context, name)
            assert below is not None
            found += calls(below, *words, name)
    return found


def test_the_help_of_every_command_imports_nothing_slow() -> None:
    """`rmfs --help` and `rmfs COMMAND --help` are there at once: what is slow is imported by what needs it."""
    asked = calls(rmfs)
    assert ["scenario", "check"] in asked
    code = (
        "import sys\nfrom rmfs_core.cli import main\n"
        f"for words in {asked}:\n    main([*words, '--help'])\n"
        f"print('slow:', [name for name in {SLOW} if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.count("Usage: ") == len(asked)
    assert done.stdout.splitlines()[-1] == "slow: []"


def test_the_list_of_commands_is_whole(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """What each command is for fits its line at 80 columns: click would cut it short."""
    monkeypatch.setenv("COLUMNS", "80")
    for arguments in (["--help"], ["scenario", "--help"], ["convert", "--help"]):
        main(arguments)
        lines = capsys.readouterr().out.partition("Commands:\n")[2].splitlines()
        assert lines
        assert [line for line in lines if not line.endswith(".") or line.endswith("...")] == []


def sentence(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    """Return the one line that a call ends with, exit code 2."""
    capsys.readouterr()
    with pytest.raises(SystemExit) as stop:
        main(arguments)
    assert stop.value.code == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    (line,) = printed.err.splitlines()
    return line


@pytest.mark.parametrize(
    ("target", "source", "problem"),
    [
        ("acme_missing:tool", "", "cannot be imported from acme_missing:tool: ModuleNotFoundError: No module named"),
        ("acme_tool:tool", "import acme_missing", "cannot be imported from acme_tool:tool: ModuleNotFoundError"),
        ("acme_tool:tool", "raise ValueError('two\\nlines')", "acme_tool:tool: ValueError: two lines"),
        ("acme_tool:tool", "raise SystemExit(3)", "cannot be imported from acme_tool:tool: SystemExit: 3"),
        ("acme_tool:tool", "", "cannot be imported from acme_tool:tool: AttributeError"),
        ("acme_tool:tool", "def tool(): pass", "is function; expected a click.Command"),
        ("acme_tool:tool", "import click\ntool = click.Command", "is type; expected a click.Command"),
    ],
)
def test_a_broken_command_costs_one_sentence(
    target: str, source: str, problem: str, install: Install, capsys: pytest.CaptureFixture[str]
) -> None:
    """It is named with its distribution when it is called, whatever it is called with; everything else works."""
    install("acme", {"acme-tool": target}, group=COMMANDS, acme_tool=source)
    for arguments in ([], ["--help"], ["file", "--option", "1"]):
        line = sentence(["acme-tool", *arguments], capsys)
        assert line.startswith('Error: rmfs acme-tool: command "acme-tool" (acme 1.0) ')
        assert problem in line
    main(["--help"])
    listed = capsys.readouterr().out
    assert "  acme-tool  (not usable: " in listed
    assert "  validate   Check the trace" in listed
    main(["scenario", "--help"])
    assert "Usage: " in capsys.readouterr().out


def test_commands_of_one_name_are_refused(install: Install, capsys: pytest.CaptureFixture[str]) -> None:
    """Neither is preferred, not even rmfs's own; the others work."""
    source = "import click\n@click.command()\ndef tool():\n    click.echo('hello')\n"
    for name in ("acme", "bolt"):
        install(name, {"tool": f"{name}_tool:tool"}, group=COMMANDS, **{f"{name}_tool": source})
    install("acme_two", {"validate": "acme_two:tool", "hello": "acme_two:tool"}, group=COMMANDS, acme_two=source)
    assert "acme 1.0 and bolt 1.0" in sentence(["tool"], capsys)
    assert "acme_two 1.0 and rmfs " in sentence(["validate", "out"], capsys)
    main(["hello"])
    assert capsys.readouterr().out == "hello\n"
    main(["--help"])
    assert "  run " in capsys.readouterr().out


def test_an_unknown_command_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    """With the nearest one that there is."""
    with pytest.raises(SystemExit) as stop:
        main(["valdate"])
    assert stop.value.code == 2
    assert 'there is no command "valdate"' in (printed := capsys.readouterr().err)
    assert "validate" in printed


PRINTING = [
    ("rules",),
    ("rules", "--json"),
    ("scenario", "list"),
    ("scenario", "map", "examples/small"),
    ("scenario", "schema"),
    ("scenario", "check", "examples/small"),
    ("compare", "--list"),
    ("run", "examples/example-1-integrated", "--out", "out"),
    ("run", "examples/example-1-integrated", "--out", "out", "--json"),
]


@pytest.mark.parametrize("arguments", PRINTING, ids=" ".join)
def test_a_reader_that_goes_away_ends_a_command_quietly(arguments: tuple[str, ...], tmp_path: Path) -> None:
    """As in `rmfs rules | head`: the exit code is a shell's for a closed pipe, and nothing is said of it."""
    command = [sys.executable, "-c", "from rmfs_core.cli import main; main()", *arguments]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, cwd=tmp_path) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        errors = process.stderr.read()
    assert process.returncode == 141
    for word in ("Traceback", "Exception", "Error", "pipe"):
        assert word not in errors
    if arguments[0] == "run":
        assert (tmp_path / "out" / "result.json").exists()
