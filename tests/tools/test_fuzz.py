"""tools/fuzz.py: nothing that is typed or read breaks a command; and what would, is found."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from fuzzing.bases import Bases, make_bases
from fuzzing.surfaces import SURFACES, make_case

TOOL = Path(__file__).resolve().parents[2] / "tools" / "fuzz.py"
PLANTED = """
import os, sys
from pathlib import Path

import fuzz
import fuzzing.working
from fuzzing.surfaces import Case

fuzzing.working.MOST_CPU_S = 0
HALF, QUIET = "Error: a.toml: found", "Error: a.toml: found x; expected y"

def divide(): 1 / 0
def hang():
    while True: pass
def vanish(): os._exit(0)
def swell(): bytearray(3 << 30)
def exotic(): sys.exit(7)
def mute(): sys.exit(2)
def rambling(): print(HALF, "x", sep="\\n", file=sys.stderr); sys.exit(2)
def halved(): Path("orders.csv").write_text("a"); print(QUIET, file=sys.stderr); sys.exit(2)
def fine(): print(QUIET, file=sys.stderr); sys.exit(2)

PLANTED = [divide, fine, hang, vanish, swell, exotic, mute, rambling, halved, fine]

def call(arguments):
    PLANTED[int(arguments[0])]()

found = fuzz.scan(range(len(PLANTED)), lambda number: Case("planted", (str(number),), {}), call)
fuzz.report(found, seed=5, wall_s=1.0)
"""


@pytest.fixture(scope="module")
def bases() -> Bases:
    """Return what cases are made of."""
    return make_bases(compiled=False)


def test_a_case_is_the_same_for_the_same_seed_and_number(bases: Bases) -> None:
    """Alone or among others; with another seed it is another. Every surface comes."""
    cases = [make_case(bases, 1, number) for number in range(300)]
    assert make_case(bases, 1, 7) == cases[7]
    assert sum(make_case(bases, 2, number) == case for number, case in enumerate(cases)) < 10
    assert {case.surface for case in cases} == {make.__name__.removeprefix("of_") for _, make in SURFACES}


def test_what_breaks_is_found() -> None:
    """Each kind once, with the command that repeats it; a case that ends its process, or hangs, ends no other."""
    done = subprocess.run([sys.executable, "-c", PLANTED], cwd=TOOL.parent, capture_output=True, text=True, check=False)
    first, *told = done.stdout.splitlines()
    assert first == "10 cases in 1 s; exit codes 1: 2, 2: 5, 7: 1, None: 2; 8 kinds of violations"
    kinds = dict(zip(told[::2], told[1::2], strict=True))
    assert set(kinds) == {
        "1 x traceback: ZeroDivisionError in code of others",
        "1 x hang: too much CPU time, in code of others",
        "1 x ended by os._exit, in code of others",
        "1 x traceback: MemoryError in code of others",
        "1 x exit code 7",
        "1 x no sentence: planted, exit code 2",
        "1 x more than a line: Error: a.toml: ...",
        "1 x exit code 2, but written: 8, orders.csv",
    }
    assert kinds["1 x exit code 7"] == "    python tools/fuzz.py --seed 5 --case 5"
    assert done.stderr == ""


@pytest.mark.slow
def test_nothing_breaks(tmp_path: Path) -> None:
    """A thousand cases: no traceback, no hang, no exit code but the documented ones, each error one sentence."""
    done = subprocess.run(
        [sys.executable, str(TOOL), "--seed", "1", "--cases", "1000"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, ""), done.stdout
    assert done.stdout.startswith("1000 cases")
