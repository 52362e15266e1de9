"""The cheapest pods that hold all that is ordered: a set cover, and with finite stock a multi-cover.

Minimise the sum of c_p x_p over the pods, such that for every SKU i the sum of min(q_ip, d_i) x_p is at least d_i: d_i
items are ordered, pod p holds q_ip of them, and x_p is 0 or 1. Items of different SKUs do not compete on a pod, so that
pods chosen in this way can indeed serve every order.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np
from attrs import frozen

from rmfs_core.world import Instance

MOST_NODES = 100
"""Nodes of branch and bound: a limit that is the same on every machine. More of them hardly raise a bound."""

MOST_PAIRS = 10_000
"""Pairs of a pod and a SKU that it holds, above which whole pods are not asked for: the linear relaxation is."""

MOST_ITERATIONS = 50_000
"""Iterations of the first-order method (PDLP) that solves the relaxation."""

TOLERANCE = 1e-6
"""By how much the bound that the solver proves may be too large, as a share."""


@frozen
class Cover:
    """The cheapest cover.

    Parameters
    ----------
    cost
        No cover costs less.
    how
        ``"optimal"`` where one costs no more; otherwise how far that was proven.
    pods
        Ids of the pods of the cheapest cover that was found; none where parts of pods may be taken.
    """

    cost: int
    how: str
    pods: tuple[int, ...] = ()


def cheapest_cover(
    instance: Instance, costs: Sequence[int], most_nodes: int = MOST_NODES, most_pairs: int = MOST_PAIRS
) -> Cover:
    """Return what the pods cost at least that hold all that is ordered.

    Parameters
    ----------
    instance
        Orders and pods.
    costs
        Whole numbers, a pod each, none below 0.
    most_nodes
        When to stop.
    most_pairs
        Above so many pairs of a pod and a SKU parts of pods may be taken, too.
    """
    from highspy import Highs, HighsLp, HighsModelStatus, HighsVarType, MatrixFormat  # imported here: it takes a while

    demand = Counter[int]()
    for order in instance.orders:
        for sku, quantity in order.lines:
            demand[sku] += quantity
    if not demand:
        return Cover(0, "optimal")
    row_of = {sku: row for row, sku in enumerate(demand)}
    columns = [(p, _column(pod.contents, demand)) for p, pod in enumerate(instance.pods)]
    ids = [p for p, column in columns if column]
    pods = [(costs[p], column) for p, column in columns if column]
    model = HighsLp()
    model.num_col_, model.num_row_ = len(pods), len(demand)
    model.col_cost_ = np.array([cost for cost, _ in pods], dtype=float)
    model.col_lower_, model.col_upper_ = np.zeros(len(pods)), np.ones(len(pods))
    model.row_lower_ = np.ones(len(demand))
    model.row_upper_ = np.full(len(demand), math.inf)
    model.a_matrix_.format_ = MatrixFormat.kColwise
    model.a_matrix_.start_ = np.cumsum([0, *(len(column) for _, column in pods)])
    model.a_matrix_.index_ = np.array([row_of[sku] for _, column in pods for sku in column])
    model.a_matrix_.value_ = np.array([share for _, column in pods for share in column.values()])
    solver: Any = Highs()  # type: ignore[no-untyped-call]
    solver.setOptionValue("output_flag", False)
    solver.setOptionValue("threads", 1)
    relaxed = len(model.a_matrix_.index_) > most_pairs
    if relaxed:
        solver.setOptionValue("solver", "pdlp")
        solver.setOptionValue("pdlp_iteration_limit", MOST_ITERATIONS)
    else:
        model.integrality_ = [HighsVarType.kInteger] * len(pods)
        solver.setOptionValue("mip_rel_gap", 0.0)
        solver.setOptionValue("mip_max_nodes", most_nodes)
    solver.passModel(model)
    Highs.resetGlobalScheduler(True)  # a process has one pool of threads: others may want another number of them
    solver.run()
    Highs.resetGlobalScheduler(True)
    optimal = solver.getModelStatus() == HighsModelStatus.kOptimal
    if relaxed:
        bound, how = _dual_bound(model, solver.getSolution().row_dual), "linear relaxation"
    else:
        bound, how = solver.getInfo().mip_dual_bound, "optimal" if optimal else "as far as proven in the limit of nodes"
    taken = [] if relaxed else solver.getSolution().col_value
    found = tuple(p for p, share in zip(ids, taken, strict=False) if share > 0.5)
    return Cover(math.ceil(max(bound, 0.0) * (1 - TOLERANCE) - TOLERANCE), how, found)


def _dual_bound(model: Any, prices: Sequence[float]) -> float:
    """Return what a cover costs at least by prices of the SKUs, however far these are from the best ones.

    With prices y >= 0 the cost is no less than the sum of y, and of all pods' costs less the prices of what they hold,
    where these are below 0.
    """
    y = np.maximum(np.array(prices), 0.0)
    gained = np.add.reduceat(model.a_matrix_.value_ * y[model.a_matrix_.index_], model.a_matrix_.start_[:-1])
    return float(y.sum() + np.minimum(model.col_cost_ - gained, 0.0).sum())


def _column(contents: Sequence[tuple[int, int | None]], demand: Counter[int]) -> dict[int, float]:
    """Return how much of each SKU's demand a pod can serve, as a share."""
    return {
        sku: 1.0 if number is None else min(number / demand[sku], 1.0)
        for sku, number in contents
        if demand[sku] and number != 0
    }
