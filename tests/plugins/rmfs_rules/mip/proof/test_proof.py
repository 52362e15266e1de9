"""What is known about an optimum: which solutions are kept, and when they are proven."""

from __future__ import annotations

import numpy as np
import pytest

from rmfs_rules.mip.period.period import Period, Stock
from rmfs_rules.mip.period.reduction import Reduced
from rmfs_rules.mip.period.solution import Model, Part
from rmfs_rules.mip.printed.solver import Limits
from rmfs_rules.mip.proof.proof import Proof

WHOLE = Part(0, 0, (0, 1))
BOTH_PODS = ((0, 0), (1, 0))


@pytest.fixture
def reduced() -> Reduced:
    """Return two stations of two places, and an order of two SKUs, each on a pod of its own."""
    lines = np.array([[0, 0, 1], [0, 1, 1]]).T
    period = Period(Stock((0, 1), ((0,), (1,)), 2), (0, 1), (2, 2), ((), ()), (10,), *lines)
    return Reduced(period, Model.SPLIT_AMONG_STATIONS)


def test_the_better_solution_is_kept(reduced: Reduced) -> None:
    """Nothing assigned costs 8, the order 2 + 4; what is worse is not taken."""
    proof = Proof(reduced, 2, Limits())
    proof.offer((), (), "bounds")
    assert proof.incumbent.objective == 8
    proof.offer(BOTH_PODS, (WHOLE,), "search")
    proof.offer((), (), "bounds")
    assert (proof.incumbent.objective, proof.incumbent.how) == (6, "search")


def test_a_visit_of_no_use_is_left_out(reduced: Reduced) -> None:
    """A pod that no part needs is not sent."""
    proof = Proof(reduced, 2, Limits())
    proof.offer((*BOTH_PODS, (0, 1)), (WHOLE,), "search")
    assert proof.incumbent.visits == BOTH_PODS


def test_no_more_orders_are_split_than_allowed(reduced: Reduced) -> None:
    """The order at two stations is taken only where one may be split."""
    split = Part(0, 0, (0,)), Part(0, 1, (1,))
    for splits in (0, 1):
        proof = Proof(reduced, 2, Limits(), splits)
        proof.offer((), (), "bounds")
        proof.offer(((0, 0), (1, 1)), split, "search")
        assert proof.incumbent.objective == (6 if splits else 8)


@pytest.mark.parametrize(("weight", "bound", "proven"), [(2, 5.0, False), (2, 5.1, True), (1.5, 4.9, False)])
def test_bound_and_solution_meet(reduced: Reduced, weight: float, bound: float, proven: bool) -> None:
    """With a whole W_u, a bound above the next whole number proves as much as one that is reached."""
    proof = Proof(reduced, weight, Limits(), bound=bound)
    assert not proof.proven
    proof.offer(BOTH_PODS, (WHOLE,), "search")
    assert proof.proven == proven


def test_steps_end_with_the_proof(reduced: Reduced) -> None:
    """No step is taken after the one that proves the best solution."""
    taken = []

    def offer(proof: Proof) -> None:
        taken.append("offer")
        proof.offer(BOTH_PODS, (WHOLE,), "search")

    def bound(proof: Proof) -> None:
        taken.append("bound")
        proof.bound = 6.0

    solution = Proof(reduced, 2, Limits(), steps=(offer, bound, offer)).run()
    assert taken == ["offer", "bound"]
    assert solution.bound == solution.objective == 6
