"""The standard streams belong to the command: what belongs on them, and what does not."""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

import pytest

from rmfs_commands.cli.main import main
from rmfs_commands.cli.streams import answer, kept_output, no_input, own_input
from rmfs_commands.serve.service import SMALL

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


def test_what_else_is_printed_goes_to_standard_error(capfd: pytest.CaptureFixture[str]) -> None:
    """Python's prints and those of libraries below; afterwards everything is as before."""
    print("before")
    with kept_output() as answers, kept_output() as same:
        assert answers is same
        print("from a rule")
        os.write(1, b"from a solver\n")
        answer("answer")
    print("after")
    out, err = capfd.readouterr()
    assert out == "before\nanswer\nafter\n"
    assert sorted(err.splitlines()) == ["from a rule", "from a solver"]


def test_answers_reach_what_stands_for_the_output(capsys: pytest.CaptureFixture[str]) -> None:
    """A caller within the process, who has put something else in its place, gets the answers alone."""
    with kept_output():
        print("from a rule")
        answer("answer")
    assert capsys.readouterr() == ("answer\n", "from a rule\n")


def test_streams_of_text_alone_serve_as_well(monkeypatch: pytest.MonkeyPatch) -> None:
    """Those of a notebook, which have no bytes below them."""
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
    """They find its end, whatever there is; the command itself can read it, then and afterwards."""
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
    """As it is imported, asked and at the end of the process, in Python, in C or by a child; and it reads nothing."""
    (tmp_path / "noisy.py").write_text(NOISY, encoding="utf-8")
    (tmp_path / "state.json").write_text(json.dumps(STATE), encoding="utf-8")
    command = [sys.executable, "-c", "from rmfs_commands.cli.main import main; main()", *arguments]
    given = json.dumps(STATE) + "\n"
    done = subprocess.run(command, input=given, capture_output=True, text=True, cwd=tmp_path, check=False)
    json.loads(done.stdout)
    assert set(PRINTED) <= set(done.stderr.splitlines())
    if arguments[0] in ("run", "decide", "serve"):
        assert {"ASKED '' b''", "FROM A SHELL"} <= set(done.stderr.splitlines())


@pytest.mark.parametrize("closed", ["0<&-", "1>&-", "2>&-", "0<&- 1>&- 2>&-"])
def test_a_stream_that_is_closed_is_no_fault(closed: str, tmp_path: Path) -> None:
    """No file that is opened takes its place; a command with rules works without."""
    (tmp_path / "noisy.py").write_text(NOISY, encoding="utf-8")
    (tmp_path / "state.json").write_text(json.dumps(STATE), encoding="utf-8")
    call = f'"{sys.executable}" -c "from rmfs_commands.cli.main import main; main()"'
    done = subprocess.run(
        ["sh", "-c", f"{call} decide state.json --rule ./noisy.py:Noisy {closed}"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "1>&-" in closed or json.loads(done.stdout)["assignments"] == []
