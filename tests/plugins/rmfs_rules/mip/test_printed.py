"""The printed constraints, each named when it is violated, and python-mip within a run."""

import subprocess
import sys
from threading import Thread

import numpy as np
import pytest

from rmfs_rules.mip.period.period import Period, Stock
from rmfs_rules.mip.period.solution import Model, Part, Solution
from rmfs_rules.mip.printed.constraints import violation
from rmfs_rules.mip.printed.models import solve_printed
from rmfs_rules.mip.printed.solver import Limits, check_installed, new_model, optimise
from rmfs_rules.mip.proof.program import Program

INTEGRATED, AMONG, OVER_TIME = Model


@pytest.fixture
def period() -> Period:
    """Two stations; order 10 wants SKUs 0 and 1, order 11 SKU 2; pod 0 is at the first station."""
    lines = np.array([[0, 0, 1], [0, 1, 1], [1, 2, 1]]).T
    return Period(Stock((0, 1), ((0, 1), (2,)), 4), (0, 1), (2, 1), ((0,), ()), (10, 11), *lines, busy=(0,))


def solution(parts, visits=((0, 0), (0, 1), (1, 0), (1, 1)), unused=None, bound=0.0) -> Solution:
    taken = sum(len(skus) for _, _, skus in parts)
    objective = len(visits) + 2 * ((3 - taken) if unused is None else unused)
    return Solution(tuple(Part(*part) for part in parts), visits, objective, bound, "solver")


GOOD = [(0, 0, (0, 1)), (1, 1, (2,))]


@pytest.mark.parametrize("model", Model)
def test_a_right_solution_passes(period, model):
    """Both orders, each as a whole at one station, with all pods at all stations."""
    assert violation(period, solution(GOOD), model, 2) is None


WRONG = [
    ("(1) objective", INTEGRATED, solution(GOOD, unused=1)),
    ("(1) objective", INTEGRATED, solution(GOOD, bound=99.0)),
    ("(2) whole orders", INTEGRATED, solution([(0, 0, (0,))])),
    ("(3) one station", INTEGRATED, solution([(0, 0, (0,)), (0, 1, (1,))])),
    ("(4) item capacity", INTEGRATED, solution([(0, 1, (0, 1))])),
    ("(5) pods", INTEGRATED, solution(GOOD, visits=((0, 0), (0, 1)))),
    ("(6) pods", INTEGRATED, solution([(1, 1, (2,))], visits=((1, 1),))),
    ("(8) lines: SKU id 3 is no open line", OVER_TIME, solution([(0, 0, (3,))])),
    ("(8) lines: SKU id 0 of order id 10 is twice", OVER_TIME, solution([(0, 0, (0, 0))])),
    ("(9) pods", INTEGRATED, solution(GOOD, visits=((0, 0), (0, 0), (1, 1)))),
    ("(11) whole orders", AMONG, solution([(0, 0, (0,))])),
    ("(11) lines", AMONG, solution([(0, 0, (0, 1)), (0, 1, (0,))])),
    ("(11.1) lines", OVER_TIME, solution([(0, 0, (0, 1)), (0, 1, (0,))])),
    ("(13) order at a station without a line", AMONG, solution([(0, 0, ())])),
]


@pytest.mark.parametrize(("named", "model", "wrong"), WRONG, ids=[f"{w[0]}, {w[1]}" for w in WRONG])
def test_the_violated_constraint_is_named(period, named, model, wrong):
    assert violation(period, wrong, model, 2).startswith(named)


def test_packing_capacity(period):
    """A split order needs a place (18), also when a line stays in the backlog; not if it was split already."""
    split = solution([(0, 0, (0,)), (0, 1, (1,))])
    assert violation(period, split, AMONG, 2, 1) is None
    assert violation(period, split, AMONG, 2, 0).startswith("(18) packing capacity")
    left = solution([(0, 0, (0,))])
    assert violation(period, left, OVER_TIME, 2, 0).startswith("(18) packing capacity")
    period.split_open = 1
    assert violation(period, left, OVER_TIME, 2, 1).startswith("(18) packing capacity")
    period.begun = (True, False)
    assert violation(period, left, OVER_TIME, 2, 1) is None


def test_too_few_items_are_named():
    """Two orders want SKU 0 at different stations, and the pod that goes to both has one item of it."""
    lines = np.array([[0, 0, 1], [1, 0, 1]]).T
    sent = solution([(0, 0, (0,)), (1, 1, (0,))], visits=((0, 0), (0, 1)))
    for items, said in (
        (1, "stock: the pods at the stations and sent to them have too few free items of SKU id 0"),
        (2, None),
    ):
        period = Period(Stock.counted([{0: items}], 1), (0, 1), (2, 1), ((0,), ()), (10, 11), *lines)
        for model in Model:
            assert violation(period, sent, model, 2) == said


def test_a_limit_before_any_solution(random_period):
    """Then nothing is assigned, and the bound that is known lies below the objective."""
    for seed in range(10):
        period = random_period(seed)
        solution = solve_printed(period, INTEGRATED, 2, Limits(max_seconds=1e-9))
        assert violation(period, solution, INTEGRATED, 2) is None
        assert solution.bound <= solution.objective


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


@pytest.mark.parametrize("solver", ["highs", "cbc"])
def test_a_knapsack(solver):
    """Of items worth 5, 4 and 3 with sizes 4, 3 and 2, room 5 takes the last two."""
    program = Program(constant=10.0)
    columns = [program.column(cost=-worth) for worth in (5.0, 4.0, 3.0)]
    program.row(columns, [4.0, 3.0, 2.0], "<", 5.0)
    outcome = program.solve(Limits(solver))
    assert outcome.optimal
    assert outcome.objective == pytest.approx(outcome.bound) == pytest.approx(3.0)
    assert [round(value) for value in outcome.values] == [0, 1, 1]


def test_programs_without_whole_columns_or_values():
    """Half a unit where whole numbers are not asked for; what is infeasible has a bound above all, and no values."""
    program = Program()
    column = program.column(cost=-1.0, whole=False)
    program.row([column], [2.0], "<", 1.0)
    assert program.solve(Limits()).values == [pytest.approx(0.5)]
    program.row([column], [1.0], ">", 2.0)
    outcome = program.solve(Limits())
    assert (outcome.values, outcome.bound) == (None, float("inf"))
