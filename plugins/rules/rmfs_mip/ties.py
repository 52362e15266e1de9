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

from rmfs_mip.aggregated import Builder, Gains
from rmfs_mip.decoding import parts_of, visits_of
from rmfs_mip.period import Period
from rmfs_mip.reduction import Reduced
from rmfs_mip.search import Search
from rmfs_mip.solution import Model, Part, Solution

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


def seniority(period: Period, parts: tuple[Part, ...]) -> float:
    """Return the second objective of ``oldest``."""
    gains, lines = order_gains(period), period.lines
    return float(sum(gains[part.order] * dict(lines[part.order])[sku] for part in parts for sku in part.skus))


def demand_covered(period: Period, visits: tuple[tuple[int, int], ...]) -> float:
    """Return the second objective of ``demand``."""
    gains = pod_gains(period)
    return float(sum(gains[pod] for pod, station in visits if pod not in period.inbound[station]))


def break_ties(search: Search, tie_break: TieBreak) -> Solution:
    """Return the solution that the tie-break prefers among all with the objective (1) that the search found."""
    best = search.incumbent
    period = search.reduced.period
    if tie_break == "solver" or best.stopped_early or not search.reduced.candidates.any():
        return best
    if tie_break == "demand" and best.objective - period.visits_before < 1:
        return best  # a new visit would cost more
    if tie_break == "oldest" and best.how == "flow" and search.reduced.model is Model.SPLIT_OVER_TIME:
        return best  # no new visit, and the oldest lines that can be placed (see `rmfs_mip.placing`)
    reduced = Reduced(period, search.reduced.model, counted=tie_break != "oldest")
    gains = Gains(order=order_gains(period)) if tie_break == "oldest" else Gains(pod=pod_gains(period))
    builder = Builder(reduced, search.weight, search.splits, gains)
    model = builder.build()
    builder.limit_objective(best.objective, best.objective)
    outcome = model.program.solve(search.limits, absolute_gap=0.999, seconds=search.seconds_left)
    if outcome.values is None:
        return evolve(best, how="stopped")
    visits = tuple((pod, s) for s, pods in enumerate(period.inbound) for pod in pods)
    return evolve(
        best,
        parts=parts_of(reduced, model, outcome.values),
        visits=tuple(sorted({*visits, *visits_of(model, outcome.values)})),
        how="solver" if outcome.optimal and search.limits.gap == 0 else "stopped",
    )
