"""Second objectives: which of the many optima of objective (1) is taken.

Lexicographic and exact: objective (1) is fixed at its optimum by a row, then the second objective is maximised.
``oldest``: sum over the assigned items of the number of orders in the backlog that are not older than theirs.
``demand``: sum over the new visits of the items that the whole backlog wants of the pod's SKUs.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from attrs import evolve
from numpy.typing import NDArray

from rmfs_mip.period.decoding import parts_of
from rmfs_mip.period.period import Period
from rmfs_mip.period.reduction import Reduced
from rmfs_mip.period.solution import Model, Solution
from rmfs_mip.proof.aggregated import Gains
from rmfs_mip.proof.parts import builder_of
from rmfs_mip.proof.proof import Proof

TieBreak = Literal["solver", "oldest", "demand"]


def order_gains(period: Period) -> NDArray[np.float64]:
    """Return what an item of each order is worth under ``oldest``: n for the oldest, 1 for the youngest."""
    n = len(period.orders)
    return np.arange(n, 0, -1, dtype=np.float64)


def pod_gains(period: Period) -> NDArray[np.float64]:
    """Return what a visit of each pod is worth under ``demand``."""
    wanted = np.bincount(
        period.line_sku, weights=period.line_quantity.astype(np.float64), minlength=period.stock.n_skus
    )
    gains: NDArray[np.float64] = period.stock.holds @ wanted
    return gains


def break_ties(proof: Proof, tie_break: TieBreak) -> Solution:
    """Return the solution that a tie-break prefers among all that have the objective (1) of a proven one.

    Parameters
    ----------
    proof
        What was proven.
    tie_break
        The second objective; ``"solver"`` for none.
    """
    best = proof.incumbent
    period = proof.reduced.period
    if tie_break == "solver" or best.stopped_early or not proof.reduced.candidates.any():
        return best
    if tie_break == "demand" and best.objective - period.visits_before < 1:
        return best  # a new visit would cost more
    if tie_break == "oldest" and best.how == "flow" and proof.reduced.model is Model.SPLIT_OVER_TIME:
        return best  # no new visit, and the oldest lines that can be placed (see `rmfs_mip.period.placing`)
    reduced = Reduced(period, proof.reduced.model, counted=tie_break != "oldest")
    gains = Gains(order=order_gains(period)) if tie_break == "oldest" else Gains(pod=pod_gains(period))
    builder = builder_of(reduced, proof.weight, proof.splits, gains)
    model = builder.build()
    builder.limit_objective(best.objective, best.objective)
    outcome = model.program.solve(proof.limits, absolute_gap=0.999, seconds=proof.seconds_left)
    if outcome.values is None:
        return evolve(best, how="stopped")
    counts = model.counts(outcome.values)
    before = ((pod, s) for s, pods in enumerate(period.inbound) for pod in pods)
    return evolve(
        best,
        parts=parts_of(reduced, counts),
        visits=tuple(sorted({*before, *counts.visits})),
        how="solver" if outcome.optimal and proof.limits.gap == 0 else "stopped",
    )
