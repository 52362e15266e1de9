"""The command line: it stays light, and a plugin that cannot be had costs the others nothing."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import click
import pytest

from rmfs_commands.cli.main import main, rmfs

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
        "import sys\nfrom rmfs_commands.cli.main import main\n"
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
    """Neither is preferred, not even rmfs's own: each is there under its distribution's name; the others work."""
    source = "import click\n@click.command()\ndef tool():\n    click.echo('hello')\n"
    for name in ("acme", "bolt"):
        install(name, {"tool": f"{name}_tool:tool"}, group=COMMANDS, **{f"{name}_tool": source})
    install("acme_two", {"validate": "acme_two:tool", "hello": "acme_two:tool"}, group=COMMANDS, acme_two=source)
    assert sentence(["tool"], capsys) == (
        'Error: rmfs tool: command "tool" is offered by acme 1.0 and bolt 1.0; '
        "expected one of them: `acme:tool` or `bolt:tool`"
    )
    assert "acme_two 1.0 and rmfs " in sentence(["validate", "out"], capsys)
    assert "out: cannot be read" in sentence(["rmfs:validate", "out"], capsys)
    main(["acme_two:validate"])
    assert capsys.readouterr().out == "hello\n"
    main(["hello"])
    assert capsys.readouterr().out == "hello\n"
    main(["--help"])
    assert "  run " in capsys.readouterr().out


def test_an_unknown_command_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    """With the nearest one that there is, in one sentence."""
    with pytest.raises(SystemExit) as stop:
        main(["valdate"])
    assert stop.value.code == 2
    assert capsys.readouterr().err == 'Error: there is no command "valdate" (did you mean `validate`?)\n'


PRINTING = [
    ("--help",),
    ("rules", "--help"),
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
    command = [sys.executable, "-c", "from rmfs_commands.cli.main import main; main()", *arguments]
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


ENDING = """
import sys
import click


class Told(click.Command):
    def get_short_help_str(self, limit=45):
        return 1 / 0


told = Told("told")


@click.command()
@click.argument("how")
@click.pass_context
def tool(context, how):
    if how == "raise":
        raise LookupError("no\\npods")
    if how == "interrupt":
        raise SystemError("a result with an exception set") from KeyboardInterrupt()
    if how == "return":
        return 5
    if how == "exit":
        context.exit(77)
    sys.exit(how if how == "text" else int(how))
"""


@pytest.fixture
def tool(install: Install) -> None:
    """Install a command that ends in many ways, and one that cannot say what it does."""
    install("acme", {"acme-tool": "acme_tool:tool", "told": "acme_tool:told"}, group=COMMANDS, acme_tool=ENDING)


@pytest.mark.usefixtures("tool")
def test_a_command_that_raises_is_named(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """One sentence with its distribution; its traceback for who asks for it."""
    with pytest.raises(SystemExit) as stop:
        main(["acme-tool", "raise"])
    assert stop.value.code == 1
    assert capsys.readouterr().err == (
        'Error: command "acme-tool" (acme 1.0) raised LookupError: no pods; RMFS_TRACEBACK=1 in the environment shows '
        "where\n"
    )
    monkeypatch.setenv("RMFS_TRACEBACK", "1")
    with pytest.raises(SystemExit):
        main(["acme-tool", "raise"])
    assert "in tool\n" in capsys.readouterr().err


@pytest.mark.usefixtures("tool")
def test_an_interrupt_within_compiled_code_is_one(capsys: pytest.CaptureFixture[str]) -> None:
    """Whatever Python makes of it, a command that was interrupted ends as such."""
    with pytest.raises(SystemExit) as stop:
        main(["acme-tool", "interrupt"])
    assert (stop.value.code, capsys.readouterr().err.strip()) == (130, "Interrupted.")


@pytest.mark.usefixtures("tool")
@pytest.mark.parametrize(("how", "code"), [("exit", 1), ("77", 1), ("256", 1), ("-1", 1), ("2", 2), ("text", 1)])
def test_a_command_ends_with_an_exit_code_that_is_documented(how: str, code: int) -> None:
    """Any other is 1, also one that a shell would see as 0."""
    with pytest.raises(SystemExit) as stop:
        main(["acme-tool", "--", how])
    assert stop.value.code == code


@pytest.mark.usefixtures("tool")
def test_what_a_command_returns_is_no_exit_code() -> None:
    """It is done."""
    main(["acme-tool", "return"])


@pytest.mark.usefixtures("tool")
def test_a_command_that_cannot_say_what_it_does_is_listed(capsys: pytest.CaptureFixture[str]) -> None:
    """With the reason; so are all others."""
    main(["--help"])
    listed = " ".join(capsys.readouterr().out.split())
    assert "told (not usable: command" in listed
    assert "validate Check the trace" in listed
    assert 'command "told" (acme 1.0) cannot say what it does: ZeroDivisionError' in sentence(["told"], capsys)


FULL = "Error: output: cannot be written: No space left on device\n"


@pytest.mark.parametrize(
    ("call", "code", "said"),
    [
        ("--help >/dev/full", 2, FULL),
        ("scenario list >/dev/full", 2, FULL),
        ("scenario list >/dev/full 2>/dev/full", 2, ""),
        ("nope 2>/dev/full", 2, ""),
        ("--help >&-", 0, ""),
        ("scenario list >&- 2>&-", 0, ""),
    ],
)
def test_output_that_cannot_be_written_is_no_traceback(call: str, code: int, said: str) -> None:
    """A full disk is one sentence, and exit code 2; output that nobody wants is none."""
    program = f"{sys.executable} -c 'from rmfs_commands.cli.main import main; main()'"
    done = subprocess.run(f"{program} {call}", shell=True, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (code, said)


def test_what_click_refuses_is_one_line_too(capsys: pytest.CaptureFixture[str]) -> None:
    """Below how the command is used: also where click names all choices, or quotes what cannot be shown."""
    for arguments, said in (
        (["new-rule", "x"], "Error: Missing option '--decides'. Choose from: POA, PPS,"),
        (["run", "a", "b\x1b[31m\nc"], "Error: Got unexpected extra argument (b\\x1b[31m c)"),
        (["decide", "a", "--rule", "b", "--seed", "9" * 5000], "Error: Invalid value for '--seed': expected a whole"),
    ):
        with pytest.raises(SystemExit) as stop:
            main(arguments)
        assert stop.value.code == 2
        usage, *_, last = capsys.readouterr().err.splitlines()
        assert usage.startswith("Usage: ")
        assert last.startswith(said)
        assert len(last) < 1200


FAILING = [
    (("run", "nowhere"), 2, "nowhere"),
    (("run", "examples/small", "--seed", "x"), 2, " run"),
    (("run", "examples/small", "--set", "instance.orders=x"), 2, "--set instance.orders=x"),
    (("validate", "nowhere"), 2, "nowhere"),
    (("bound", "nowhere"), 2, "nowhere"),
    (("compare", "nowhere"), 2, "nowhere"),
    (("explain", "nowhere"), 2, "nowhere"),
    (("rules", "nowhere"), 2, "rmfs rules"),
    (("plan", "nowhere"), 2, "nowhere"),
    (("size", "nowhere", "--p95", "3"), 2, "nowhere"),
    (("bench", "nowhere"), 2, None),
    (("cite", "nowhere"), 2, "rmfs cite"),
    (("scenario", "check", "nowhere"), 2, "nowhere"),
    (("reproduce", "--jobs", "0"), 2, " reproduce"),
]


@pytest.mark.parametrize(("arguments", "code", "place"), FAILING, ids=lambda value: str(value)[:40])
def test_a_failure_is_json_where_json_is_asked_for(
    arguments: tuple[str, ...], code: int, place: str | None, capsys: pytest.CaptureFixture[str]
) -> None:
    """What and where, on the output; the sentence on standard error and the exit code are as without."""
    with pytest.raises(SystemExit) as stop:
        main([*arguments, "--json"])
    printed = capsys.readouterr()
    told = json.loads(printed.out)
    assert stop.value.code == told["exit_code"] == code
    assert told.keys() == {"error", "place", "problem", "exit_code"}
    assert place is None or told["place"].endswith(place)
    assert told["error"] == f"{told['place']}: {told['problem']}"
    assert told["problem"] in printed.err


FAILS = """
from attrs import frozen
from rmfs_core import hookimpl

@frozen
class Fails:
    "PPS: fails."

    @hookimpl
    def select_pods(self, warehouse):
        raise ValueError("no \x1b[31m idea")
"""


def test_a_run_that_fails_is_json(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """What was measured until then, and what went wrong where."""
    (tmp_path / "fails.py").write_text(FAILS, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as stop:
        main(["run", "examples/small", "--set", "rules.pps=./fails.py:Fails", "--out", "out", "--json"])
    told = json.loads(capsys.readouterr().out)
    assert (stop.value.code, told["exit_code"], told["status"], told["folder"]) == (1, 1, "failed", "out")
    assert told["place"].endswith('fails.py:Fails" (fails.py inline), select_pods, at 0.000 s')
    assert told["problem"].startswith("raised ValueError: no \\x1b[31m idea (")


def test_an_interrupt_is_json(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Of a command that has not answered yet."""

    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("rmfs_commands.validation.check_trace", interrupted)
    with pytest.raises(SystemExit):
        main(["validate", "nowhere", "--json"])
    assert json.loads(capsys.readouterr().out) == {
        "error": "Interrupted.",
        "place": None,
        "problem": "Interrupted.",
        "exit_code": 130,
    }


def test_without_a_command_the_help_is_shown(capsys: pytest.CaptureFixture[str]) -> None:
    """As it is printed with `--help`, in lines."""
    for arguments in ([], ["scenario"]):
        with suppress(SystemExit):
            main(arguments)
        told = capsys.readouterr()
        assert re.search(r"^Commands:\n  \w+", told.out + told.err, re.MULTILINE)
        assert "Error:" not in told.err


NOTING = """
import warnings
import click
from rmfs_commands.cli.main import main, rmfs

@click.command()
def noting():
    warnings.warn("it goes", FutureWarning)

rmfs.get_command = lambda *_: noting
rmfs.list_commands = lambda *_: ["noting"]
main()
"""


def test_what_users_have_to_know_is_a_note() -> None:
    """Without the line of code that warns."""
    done = subprocess.run([sys.executable, "-c", NOTING, "noting"], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "Note: it goes\n")
