"""Every printed constraint is named when a solution violates it."""

from __future__ import annotations

import numpy as np
import pytest

from rmfs_rules.mip.period.period import Period, Stock
from rmfs_rules.mip.period.solution import Model, Part, Solution
from rmfs_rules.mip.printed.constraints import violation

INTEGRATED, AMONG, OVER_TIME = Model


@pytest.fixture
def period() -> Period:
    """Two stations; order 10 wants SKUs 0 and 1, order 11 SKU 2; pod 0 is at the first station."""
    lines = np.array([[0, 0, 1], [0, 1, 1], [1, 2, 1]]).T
    return Period(Stock((0, 1), ((0, 1), (2,)), 4), (0, 1), (2, 1), ((0,), ()), (10, 11), *lines, busy=(0,))


def solution(parts, visits=((0, 0), (0, 1), (1, 0), (1, 1)), unused=None, bound=0.0) -> Solution:
    """Return a solution of these parts with the objective that it has, unless ``unused`` is given."""
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
    """The sentence begins with the equation's number."""
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
