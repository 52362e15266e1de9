"""python-mip within a run."""

from __future__ import annotations

import subprocess
import sys

import pytest

from rmfs_rules.mip.printed.solver import check_installed

DEADLOCK = """
import gc
import mip
from pycparser import c_parser

import rmfs_core

gc.set_threshold(1_000_000)  # the collector runs where this test lets it, and nowhere else
model = mip.Model(solver_name=mip.HIGHS)
model.cycle = model
del model
parse = c_parser.CParser.parse

def parse_and_collect(self, *arguments, **more):
    if gc.isenabled():
        gc.collect()
    return parse(self, *arguments, **more)

c_parser.CParser.parse = parse_and_collect
small = ["instance.orders=12", "instance.skus=8", "instance.pods=8", "rules.pp=free-flow"]
rule = "rules.poa_pps={rule='integrated', formulation='paper'}"
print(rmfs_core.run("paper-250-integrated", overrides=[*small, rule]).status, gc.isenabled())
"""


def test_a_collection_cannot_stop_a_solve() -> None:
    """A model that becomes garbage is not ended while cffi holds its lock; later garbage is collected as before."""
    done = subprocess.run([sys.executable, "-c", DEADLOCK], capture_output=True, text=True, timeout=120, check=True)
    assert done.stdout == "complete True\n"


def test_a_solver_that_is_not_there_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """An environment may do without CBC's libraries; HiGHS is always there."""
    monkeypatch.setattr("rmfs_rules.mip.printed.solver.find_spec", lambda _: None)
    check_installed("highs")
    with pytest.raises(ValueError, match=r'solver = "cbc" needs the package cbcbox'):
        check_installed("cbc")
