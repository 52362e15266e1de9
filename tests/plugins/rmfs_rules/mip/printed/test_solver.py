"""python-mip within a run."""

from __future__ import annotations

import subprocess
import sys
from threading import Thread

import pytest

from rmfs_rules.mip.printed.solver import Limits, check_installed, new_model, optimise

DEADLOCK = """
import gc
import mip
from pycparser import c_parser

import rmfs_core

gc.disable()  # the collector runs where this test lets it, and nowhere else
model = mip.Model(solver_name=mip.HIGHS)
model.cycle = model
before = gc.get_threshold()
del model
parse = c_parser.CParser.parse

def parse_and_collect(self, *arguments, **more):
    gc.collect()
    return parse(self, *arguments, **more)

c_parser.CParser.parse = parse_and_collect
small = ["instance.orders=12", "instance.skus=8", "instance.pods=8", "rules.pp=free-flow"]
rule = "rules.poa_pps={rule='integrated', formulation='paper'}"
status = rmfs_core.run("paper-250-integrated", overrides=[*small, rule]).status
print(status, gc.isenabled(), gc.get_threshold() == before)
"""


def test_a_collection_cannot_stop_a_solve() -> None:
    """A model that is ended while cffi parses a type does not wait for cffi's lock; the collector's settings stay."""
    done = subprocess.run([sys.executable, "-c", DEADLOCK], capture_output=True, text=True, timeout=120, check=True)
    assert done.stdout == "complete False True\n"


def test_a_solver_that_is_not_there_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """An environment may do without CBC's libraries; HiGHS is always there."""
    monkeypatch.setattr("rmfs_rules.mip.printed.solver.find_spec", lambda _: None)
    check_installed("highs")
    with pytest.raises(ValueError, match=r'solver = "cbc" needs the package cbcbox'):
        check_installed("cbc")


def test_each_thread_asks_for_its_own_number_of_threads() -> None:
    """HiGHS's pool is of the calling thread: one that had another number before does not stop a solve."""
    found = []

    def solve(threads: int) -> None:
        limits = Limits(threads=threads)
        model = new_model(limits)
        taken = [model.add_var(var_type="B") for _ in range(4)]
        model += taken[0] + taken[1] + taken[2] + taken[3] >= 2
        model.objective = taken[0] + 2 * taken[1] + 3 * taken[2] + 4 * taken[3]
        found.append((threads, optimise(model, limits).objective))

    solve(1)
    other = Thread(target=solve, args=(2,))
    other.start()
    other.join()
    solve(2)
    solve(1)
    assert found == [(1, 3), (2, 3), (2, 3), (1, 3)]
