"""Compiled code that numba keeps on disk, and when it compiles anew."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from cases import cases

OLD = """
import typing
from rmfs_core.jit import njit
class Pair(typing.NamedTuple):
    x: int
@njit(cache=True)
def twice(pair): return 2 * pair.x
print(twice(Pair(3)))
"""


def printed(folder: Path, code: str, *arguments: str) -> str:
    """Return what a program prints in a fresh Python that imports from a folder, and finds numba's cache there."""
    variables = {**os.environ, "NUMBA_CACHE_DIR": str(folder / "cache"), "PYTHONPATH": str(folder)}
    command = [sys.executable, "-c", code, *arguments]
    return subprocess.run(command, env=variables, capture_output=True, text=True, check=True).stdout


@pytest.fixture
def run_cached(tmp_path: Path) -> Callable[[str], str]:
    """Return what runs the program that is called ``before`` and returns what it prints."""

    def run(code: str) -> str:
        program = tmp_path / "before.py"
        if not program.exists() or program.read_text(encoding="utf-8") != code:  # numba looks at the file's time
            program.write_text(code, encoding="utf-8")
        return printed(tmp_path, "import before")

    return run


def test_an_old_cache_is_compiled_anew(tmp_path: Path, run_cached: Callable[[str], str]) -> None:
    assert run_cached(OLD) == "6\n"
    for file in (tmp_path / "cache").rglob("*.nbc"):
        file.write_bytes(file.read_bytes().replace(b"before", b"beside"))
    assert (run_cached(OLD), run_cached(OLD)) == ("6\n", "6\n")
    assert run_cached(OLD.replace("Pair", "Couple")) == "6\n"


CALLING = """
import helping
from helping import helped
from rmfs_core.jit import njit
near = helping.near_to(0)
@njit(cache=True)
def called(): return helped() + helping.MORE + near()
found = called()
print(found, sum(called.stats.cache_hits.values()))
"""
HELPING = """
from rmfs_core.jit import njit
FACTOR, MORE = 2, 0
def again(number): return 1
@njit(cache=True)
def helped(): return 10 * FACTOR
def near_to(place):
    @njit(cache=True)
    def near(): return 0 if "west" in {"east", "west", "north"} else place
    return near
"""


@cases(
    "edit told",
    (("10", "20"), "40 0\n"),
    (("2, 0", "3, 0"), "30 0\n"),
    (("2, 0", "2, 7"), "27 0\n"),
    (("return 0 if", "return 5 if"), "25 0\n"),
    (("def again(number): return 1", "def again(number): return 2"), "20 1\n"),
    ids=["what it calls", "a constant", "a constant of a module", "what is made by another function", "nothing of it"],
)
def test_what_another_file_brings_is_part_of_the_code(edit, told, tmp_path, run_cached) -> None:
    (tmp_path / "helping.py").write_text(HELPING, encoding="utf-8")
    assert (run_cached(CALLING), run_cached(CALLING)) == ("20 0\n", "20 1\n")
    (tmp_path / "helping.py").write_text(HELPING.replace(*edit), encoding="utf-8")
    assert run_cached(CALLING) == told


FOREIGN = """
import sys
import numba
class Lazy:
    asked = []
    def __getattr__(self, name):
        self.asked.append(name)
        raise AttributeError(name)
lazy = Lazy()
if "rmfs" in sys.argv:
    import rmfs_core.jit
@numba.njit(cache=True)
def own(number): return number + 1
print(own(1), sum(own.stats.cache_hits.values()), Lazy.asked)
"""


def test_compiled_code_of_others_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "foreign.py").write_text(FOREIGN, encoding="utf-8")
    assert printed(tmp_path, "import foreign") == "2 0 []\n"
    assert printed(tmp_path, "import foreign", "rmfs") == printed(tmp_path, "import foreign") == "2 1 []\n"


RUNS = """
import sys
from pathlib import Path
from rmfs_core import jit
if sys.argv[1] == "interpreted":
    jit.decide_later()
    jit.interpret(print)
from rmfs_core import run
from rmfs_core.scenario import load_scenario
for rules in sys.argv[3:]:
    scenario = load_scenario("examples/small", overrides=[f"rules.{rule}" for rule in rules.split()])
    run(scenario, out=Path(sys.argv[2]) / rules.replace(" ", "_"), record=["trace"])
print("numba" in sys.modules)
"""
RULES = (
    *("poa=pod-match", "poa=common-lines", "poa=near-best-pod", "poa=station-queue", "poa=workload", "pps=completes"),
    *("pps=work-amount", "pr=utility", "pp=whca-n", "pp=pbs", "poa_pps=pod-index ta=nearest-robot"),
    *("poa_pps=lns ta=nearest-robot", "poa_pps=alternating ta=nearest-robot"),
)


@pytest.mark.slow
def test_interpreted_runs_have_the_bytes_of_compiled_ones(tmp_path: Path) -> None:
    """Also where numbers of numpy would overflow, of which it warns."""
    told = {}
    for how in ("interpreted", "compiled"):
        command = [sys.executable, "-W", "error::RuntimeWarning", "-c", RUNS, how, str(tmp_path / how), *RULES]
        told[how] = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert told == {"interpreted": "False\n", "compiled": "True\n"}
    files = sorted(file.relative_to(tmp_path / "compiled") for file in (tmp_path / "compiled").rglob("*.*"))
    assert len(files) > 5 * len(RULES)
    for file in files:
        if file.name not in ("result.json", "periods.csv"):  # which have times of the clock
            assert (tmp_path / "interpreted" / file).read_bytes() == (tmp_path / "compiled" / file).read_bytes(), file


OPEN = """
import sys
from rmfs_core import jit
jit.decide_later()
@jit.helper
def doubled(number): return 2 * number
@jit.njit(cache=False, interpreted=True)
def first(numbers): return doubled(numbers[0]), numbers[0] > 1
@jit.inlined
def more(number): return number + 1
@jit.njit(cache=False)
def always(number): return more(number)
if "interpret" in sys.argv:
    jit.interpret(lambda: print("compiles"))
import numpy as np
found, large = first(np.array([3]))
print(type(found).__name__, found, large is True, "numba" in sys.modules, always(1))
"""


def test_what_is_open_is_compiled_unless_it_is_interpreted(tmp_path: Path) -> None:
    (tmp_path / "opened.py").write_text(OPEN, encoding="utf-8")
    assert printed(tmp_path, "import opened") == "int 6 True True 2\n"
    assert printed(tmp_path, "import opened", "interpret") == "compiles\nint 6 True False 2\n"
