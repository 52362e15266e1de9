"""The command line: light, with standard streams of its own, and unharmed by plugins that cannot be had."""

import io
import json
import os
import random
import re
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import redirect_stderr, redirect_stdout, suppress
from pathlib import Path
from textwrap import dedent
from types import ModuleType

import click
import pytest
from numba import njit
from rich.console import Console

from bad_rules import write_rule
from calling import exit_code, refused
from cases import cases
from rmfs_commands.cli import interrupts
from rmfs_commands.cli.compiling import compile_told, compiling_announced
from rmfs_commands.cli.interrupts import Interrupt
from rmfs_commands.cli.main import main, rmfs
from rmfs_commands.cli.streams import answer, kept_output, no_input, own_input
from rmfs_commands.serve.service import SMALL

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
            found += calls(below, *words, name)
    return found


def test_the_help_of_every_command_imports_nothing_slow() -> None:
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
    """The summary of each command fits its line at 80 columns: click would cut it short."""
    monkeypatch.setenv("COLUMNS", "80")
    for arguments in (["--help"], ["scenario", "--help"], ["convert", "--help"]):
        main(arguments)
        lines = capsys.readouterr().out.partition("Commands:\n")[2].splitlines()
        assert lines
        assert [line for line in lines if not line.endswith(".") or line.endswith("...")] == []


def sentence(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    (line,) = refused(capsys, main, arguments).splitlines()
    return line


@cases(
    "target source problem",
    ("acme_missing:tool", "", "cannot be imported from acme_missing:tool: ModuleNotFoundError: No module named"),
    ("acme_tool:tool", "import acme_missing", "cannot be imported from acme_tool:tool: ModuleNotFoundError"),
    ("acme_tool:tool", "raise ValueError('two\\nlines')", "acme_tool:tool: ValueError: two lines"),
    ("acme_tool:tool", "raise SystemExit(3)", "cannot be imported from acme_tool:tool: SystemExit: 3"),
    ("acme_tool:tool", "", "cannot be imported from acme_tool:tool: AttributeError"),
    ("acme_tool:tool", "def tool(): pass", "is function; expected a click.Command"),
    ("acme_tool:tool", "import click\ntool = click.Command", "is type; expected a click.Command"),
)
def test_a_broken_command_costs_one_sentence(target, source, problem, install, capsys) -> None:
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


def test_help_and_unknown_commands(capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("valdate") == 2
    assert capsys.readouterr().err == 'Error: there is no command "valdate" (did you mean `validate`?)\n'
    for arguments in ([], ["scenario"]):
        with suppress(SystemExit):
            main(arguments)
        told = capsys.readouterr()
        assert re.search(r"^Commands:\n  \w+", told.out + told.err, re.MULTILINE)
        assert "Error:" not in told.err


RMFS = [sys.executable, "-c", "from rmfs_commands.cli.main import main; main()"]
RUN = ("run", "examples/example-1-integrated", "--out", "out")


@pytest.mark.parametrize("arguments", [("--help",), ("rules",), RUN, (*RUN, "--json")], ids=" ".join)
def test_a_reader_that_goes_away_ends_a_command_quietly(arguments: tuple[str, ...], tmp_path: Path) -> None:
    """As in `rmfs rules | head`: the exit code is a shell's for a closed pipe, and nothing is said of it."""
    pipe = subprocess.PIPE
    with subprocess.Popen([*RMFS, *arguments], stdout=pipe, stderr=pipe, text=True, cwd=tmp_path) as process:
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
    assert exit_code("acme-tool", "raise") == 1
    assert capsys.readouterr().err == (
        'Error: command "acme-tool" (acme 1.0) raised LookupError: no pods; RMFS_TRACEBACK=1 in the environment shows '
        "where\n"
    )
    monkeypatch.setenv("RMFS_TRACEBACK", "1")
    with pytest.raises(SystemExit):
        main(["acme-tool", "raise"])
    assert "in tool\n" in capsys.readouterr().err


@pytest.mark.usefixtures("tool")
@pytest.mark.parametrize(
    ("how", "code"),
    [("exit", 1), ("77", 1), ("256", 1), ("-1", 1), ("2", 2), ("text", 1), ("return", 0), ("interrupt", 130)],
)
def test_a_command_ends_with_an_exit_code_that_is_documented(how: str, code: int) -> None:
    """Any other is 1, also one that a shell would see as 0; an interrupt within compiled code is one."""
    assert exit_code("acme-tool", "--", how) == code


@pytest.mark.usefixtures("tool")
def test_a_command_that_cannot_say_what_it_does_is_listed(capsys: pytest.CaptureFixture[str]) -> None:
    main(["--help"])
    listed = " ".join(capsys.readouterr().out.split())
    assert "told (not usable: command" in listed
    assert "validate Check the trace" in listed
    assert 'command "told" (acme 1.0) cannot say what it does: ZeroDivisionError' in sentence(["told"], capsys)


FULL = "Error: output: cannot be written: No space left on device\n"


@cases(
    "call code said",
    ("--help >/dev/full", 2, FULL),
    ("scenario list >/dev/full", 2, FULL),
    ("scenario list >/dev/full 2>/dev/full", 2, ""),
    ("nope 2>/dev/full", 2, ""),
    ("--help >&-", 0, ""),
    ("scenario list >&- 2>&-", 0, ""),
)
def test_output_that_cannot_be_written_is_no_traceback(call: str, code: int, said: str) -> None:
    done = subprocess.run(f"{shlex.join(RMFS)} {call}", shell=True, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (code, said)


def test_what_click_refuses_is_one_line_too(capsys: pytest.CaptureFixture[str]) -> None:
    """Below how the command is used: also where click names all choices, or quotes what cannot be shown."""
    for arguments, said in (
        (["new-rule", "x"], "Error: Missing option '--decides'. Choose from: POA, PPS,"),
        (["run", "a", "b\x1b[31m\nc"], "Error: Got unexpected extra argument (b\\x1b[31m c)"),
        (["decide", "a", "--rule", "b", "--seed", "9" * 5000], "Error: Invalid value for '--seed': expected a whole"),
    ):
        usage, *_, last = refused(capsys, main, arguments).splitlines()
        assert usage.startswith("Usage: ")
        assert last.startswith(said)
        assert len(last) < 1200


FAILING = [
    (("run", "nowhere"), 2, "nowhere"),
    (("run", "examples/small", "--seed", "x"), 2, " run"),
    (("run", "examples/small", "--set", "instance.orders=x"), 2, "--set instance.orders=x"),
    (("compare", "nowhere"), 2, "nowhere"),
    (("rules", "nowhere"), 2, "rmfs rules"),
    (("bench", "nowhere"), 2, None),
    (("scenario", "check", "nowhere"), 2, "nowhere"),
    (("reproduce", "--jobs", "0"), 2, " reproduce"),
]


@pytest.mark.parametrize(("arguments", "code", "place"), FAILING, ids=lambda value: str(value)[:40])
def test_a_failure_is_json_where_json_is_asked_for(arguments, code, place, capsys) -> None:
    with pytest.raises(SystemExit) as stop:
        main([*arguments, "--json"])
    printed = capsys.readouterr()
    told = json.loads(printed.out)
    assert stop.value.code == told["exit_code"] == code
    assert told.keys() == {"error", "place", "problem", "exit_code"}
    assert place is None or told["place"].endswith(place)
    assert told["error"] == f"{told['place']}: {told['problem']}"
    assert told["problem"] in printed.err


def test_a_run_that_fails_is_json(tmp_path, monkeypatch, capsys) -> None:
    write_rule(tmp_path, "pps", r'raise ValueError("no \x1b[31m idea")')
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as stop:
        main(["run", "examples/small", "--set", "rules.pps=./bad.py:Bad", "--out", "out", "--json"])
    told = json.loads(capsys.readouterr().out)
    assert (stop.value.code, told["exit_code"], told["status"], told["folder"]) == (1, 1, "failed", "out")
    assert told["place"].endswith('bad.py:Bad" (bad.py inline), select_pods, at 0.000 s')
    assert told["problem"].startswith("raised ValueError: no \\x1b[31m idea (")


def test_an_interrupt_is_json(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
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
    done = subprocess.run([sys.executable, "-c", NOTING, "noting"], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "Note: it goes\n")
    done = subprocess.run([sys.executable, "-c", DROPPING], capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("heard\n", "")


FIRST = """
import sys
class Interrupting:
    def find_spec(self, name, path, target=None):
        if name == "rmfs_commands.cli.main":
            raise KeyboardInterrupt
from rmfs_commands.cli.start import main
sys.meta_path.insert(0, Interrupting())
main()
"""


def test_it_calls_the_command_line() -> None:
    done = subprocess.run([sys.executable, "-c", FIRST], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "Interrupted.\n")
    assert subprocess.run([*CALL, "--version"], capture_output=True, text=True, check=True).stdout.startswith(
        "-c, version "
    )


CALL = (sys.executable, "-c", "from rmfs_commands.cli.start import main; main()")
DROPPING = """
import os, signal, time
from rmfs_commands.cli.interrupts import hear_interrupts
signal.signal(signal.SIGINT, signal.default_int_handler)  # which tests in the background do not have
hear_interrupts()
class Finalized:
    def __del__(self):
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.1)
try:
    thing = Finalized()
    del thing
    time.sleep(20)
    print("lost")
except KeyboardInterrupt:
    print("heard")
"""


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("arguments", [("run", "examples/small", "--out", "out"), ("compare", "small-rules", "--json")])
def test_an_interrupt_at_any_moment(arguments: tuple[str, ...], seed: int, tmp_path: Path) -> None:
    moment = random.Random(f"{arguments} {seed}")
    pipe = subprocess.PIPE
    with subprocess.Popen(
        [*CALL, *arguments], stdout=pipe, stderr=pipe, text=True, cwd=tmp_path, start_new_session=True
    ) as process:
        time.sleep(0.4 + 2 * moment.random() ** 2)
        os.killpg(process.pid, signal.SIGINT)
        if seed % 2:
            time.sleep(moment.choice((0.001, 0.01, 0.1)))
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGINT)
        _, err = process.communicate(timeout=60)
    assert process.returncode in (0, 130), err
    assert "Traceback" not in err
    assert "Exception ignored" not in err
    assert err.count("Interrupted.") == (process.returncode == 130)


NOISY = """
import atexit, ctypes, os, sys
print("IMPORTED")
os.write(1, b"BELOW\\n")
ctypes.CDLL(None).printf(b"BUFFERED BY C\\n")
(sys.__stdout__ or sys.stdout or open(os.devnull, "w")).write("BUFFERED BY PYTHON\\n")
atexit.register(print, "AT THE END")
atexit.register(os.write, 1, b"BELOW AT THE END\\n")
from attrs import frozen
from rmfs_core import hookimpl
from rmfs_core.decisions import OrderAssignment
@frozen
class Noisy:
    \"\"\"Prints, and reads what there is.\"\"\"
    @hookimpl
    def assign_orders(self, warehouse):
        print("ASKED", repr(sys.stdin.read()), os.read(0, 9))
        os.system("echo FROM A SHELL")
        return []
"""
STATE = {**SMALL, "ask": {"decides": "POA"}}
PRINTED = ("IMPORTED", "BELOW", "BUFFERED BY C", "BUFFERED BY PYTHON", "AT THE END", "BELOW AT THE END")


def test_streams_of_text_alone_serve_as_well(monkeypatch: pytest.MonkeyPatch) -> None:
    out, err = io.StringIO(), io.StringIO()
    monkeypatch.setattr("sys.stdin", io.StringIO("caf\u00e9\n"))
    with redirect_stdout(out), redirect_stderr(err):
        with kept_output() as answers, no_input():
            print("from a rule")
            answers.write(b"raw ")
            answer("caf\u00e9")
            assert own_input().readline() == "caf\u00e9\n".encode()
        main(["scenario", "check", "examples/small", "--json"])
    assert err.getvalue() == "from a rule\n"
    first, rest = out.getvalue().split("\n", 1)
    assert first == "raw caf\u00e9"
    assert json.loads(rest)["valid"]


def test_plugins_have_no_input(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    file = tmp_path / "input"
    file.write_text("a line\nanother\n", encoding="utf-8")
    own = os.dup(0)
    with file.open(encoding="utf-8") as given:
        os.dup2(given.fileno(), 0)
        with os.fdopen(0, closefd=False) as stream:
            monkeypatch.setattr("sys.stdin", stream)
            with no_input(), no_input():
                assert (sys.stdin.read(), os.read(0, 9)) == ("", b"")
                with pytest.raises(EOFError):
                    input()
                assert own_input().readline() == b"a line\n"
            os.lseek(0, 0, os.SEEK_SET)
            assert sys.stdin.readline() == "a line\n"
        os.dup2(own, 0)
        os.close(own)


CALLS = [
    ("run", "examples/small", "--set", "rules.poa=./noisy.py:Noisy", "--out", "out", "--json"),
    ("rules", "./noisy.py:Noisy", "--json"),
    ("decide", "state.json", "--rule", "./noisy.py:Noisy"),
    ("decide", "-", "--rule", "./noisy.py:Noisy"),
    ("serve", "--stdio", "--rule", "./noisy.py:Noisy"),
    ("scenario", "check", "examples/small", "--set", "rules.poa=./noisy.py:Noisy", "--json"),
]


@pytest.mark.parametrize("arguments", CALLS, ids=lambda words: " ".join(words[:2]))
def test_the_output_is_json_whatever_a_rule_prints(arguments: tuple[str, ...], tmp_path: Path) -> None:
    (tmp_path / "noisy.py").write_text(NOISY, encoding="utf-8")
    (tmp_path / "state.json").write_text(json.dumps(STATE), encoding="utf-8")
    given = json.dumps(STATE) + "\n"
    done = subprocess.run([*RMFS, *arguments], input=given, capture_output=True, text=True, cwd=tmp_path, check=False)
    json.loads(done.stdout)
    assert set(PRINTED) <= set(done.stderr.splitlines())
    if arguments[0] in ("run", "decide", "serve"):
        assert {"ASKED '' b''", "FROM A SHELL"} <= set(done.stderr.splitlines())


@pytest.mark.parametrize("closed", ["0<&-", "1>&-", "2>&-", "0<&- 1>&- 2>&-"])
def test_a_stream_that_is_closed_is_no_fault(closed: str, tmp_path: Path) -> None:
    (tmp_path / "noisy.py").write_text(NOISY, encoding="utf-8")
    (tmp_path / "state.json").write_text(json.dumps(STATE), encoding="utf-8")
    call = f"{shlex.join(RMFS)} decide state.json --rule ./noisy.py:Noisy {closed}"
    done = subprocess.run(["sh", "-c", call], capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.returncode == 0, done.stderr
    assert "1>&-" in closed or json.loads(done.stdout)["assignments"] == []


def test_a_run_loads_no_library_that_compiles(tmp_path: Path) -> None:
    program = """
        import sys
        from rmfs_commands.cli.main import main
        main(["run", "examples/small", "--quiet", "--out", sys.argv[1]])
        print("numba.np.arraymath" in sys.modules)
    """
    command = [sys.executable, "-c", dedent(program), str(tmp_path / "out")]
    printed = [subprocess.run(command, capture_output=True, text=True, check=True).stdout for _ in range(2)]
    assert printed[1] == "False\n"


def test_what_another_process_compiles_is_looked_for_again(tmp_path: Path) -> None:
    """It is started by a miss of something else, waited for at a miss of its own, and then what it left is loaded."""
    module = """
        from rmfs_core.jit import njit
        def search(number): return 3 * number
        def compiled(): return njit(cache=True)(search)
    """
    program = """
        import sys
        from rmfs_commands.cli.loading import loading_alone
        import searching
        asked = []
        def missed(module):
            if not asked:
                asked.append(module)
                print(module)
                searching.compiled()(2)  # instead of the other process
            return len(asked) == 1
        found = searching.compiled()
        with loading_alone(missed):
            print(found(2), *found.stats.cache_hits.values())
    """
    (tmp_path / "searching.py").write_text(dedent(module), encoding="utf-8")
    variables = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": str(tmp_path)}
    command = [sys.executable, "-c", dedent(program)]
    for printed in ("searching\n6 1\n", "6 1\n"):
        assert subprocess.run(command, env=variables, capture_output=True, text=True, check=True).stdout == printed


def test_what_a_process_for_compiling_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """It prepares the rule, and only rules that ship with rmfs go to it."""
    asked = []
    monkeypatch.setattr("rmfs_rules.whca.rule.WhcaN.prepare", lambda _rule, roads: asked.append(roads))
    monkeypatch.setattr(sys, "argv", ["-c", json.dumps(["pp", "whca-n", {}])])
    compile_told()
    assert len(asked) == 1


def test_what_is_compiled_is_said_once() -> None:
    increased, doubled = njit(lambda number: number + 1), njit(lambda number: 2 * number)
    said = []
    for _ in range(2):
        notes = Console(file=io.StringIO(), width=40)
        with compiling_announced(notes):
            assert doubled(increased(1)) == 4
        said.append(notes.file.getvalue())
    assert said == ["Compiling searches (once a rule; up to a minute) ...\n", ""]
    terminal = Console(file=io.StringIO(), force_terminal=True, width=90)
    with compiling_announced(terminal):
        assert njit(lambda number: number - 3)(1) == -2
    assert "Compiling, once on this machine: " in terminal.file.getvalue()
    assert terminal.file.getvalue().endswith("\x1b[2K")  # the bar is gone again
    notes = Console(file=io.StringIO())
    with compiling_announced(notes):
        pass
    assert (njit(lambda number: number - 1)(1), notes.file.getvalue()) == (0, "")


CALLING_BACK = """
def call(function):
    try:
        return function()
    except KeyboardInterrupt:
        return "broken"
"""


@pytest.fixture
def library() -> Iterator[ModuleType]:
    """A module that nothing may be raised through, and the handler that knows it."""
    module = ModuleType("delicate.inner")
    exec(CALLING_BACK, vars(module))
    handler = Interrupt(("delicate",))
    before = signal.signal(signal.SIGINT, handler)
    yield module
    signal.signal(signal.SIGINT, before)


def pressed() -> str:
    signal.raise_signal(signal.SIGINT)
    return "whole"


def test_an_interrupt_waits_until_a_library_has_returned(library: ModuleType) -> None:
    with pytest.raises(KeyboardInterrupt):
        assert library.call(pressed) == "whole"
        time.sleep(5)
    with pytest.raises(KeyboardInterrupt):
        pressed()


def test_an_interrupt_is_not_put_off_for_ever(library: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(interrupts, "PATIENCE_S", 0.1)

    def endless() -> str:
        signal.raise_signal(signal.SIGINT)
        time.sleep(5)
        return "whole"

    assert library.call(endless) == "broken"
