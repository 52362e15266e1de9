"""Second objectives: which of the many optima of objective (1) is taken.

Lexicographic and exact: objective (1) is fixed at its optimum by a row, then the second objective is maximised.
``oldest``: sum over the assigned items of the number of orders in the backlog that are not older than theirs.
``demand``: sum over the new visits of the items that the whole backlog wants of the pod's SKUs.
``finish``, for split-over-time: sum over the lines that are taken of 1 / (open lines of their order, this one and those
taken after it): the last line of an order is worth 1, the first of four a quarter. So lines are taken where they finish
orders, as in Smith's rule (weighted shortest processing time; doi:10.1002/nav.3800030106) for one machine.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from attrs import evolve
from numpy.typing import NDArray

from rmfs_rules.mip.period.decoding import parts_of
from rmfs_rules.mip.period.period import Period
from rmfs_rules.mip.period.reduction import Reduced
from rmfs_rules.mip.period.solution import Model, Part, Solution
from rmfs_rules.mip.proof.aggregated import CLOSE, Gains
from rmfs_rules.mip.proof.parts import builder_of
from rmfs_rules.mip.proof.proof import Proof

TieBreak = Literal["solver", "oldest", "demand", "finish"]


def order_gains(period: Period) -> NDArray[np.float64]:
    """Return what an item of each order is worth under ``oldest``: n for the oldest, 1 for the youngest."""
    n = len(period.orders)
    return np.arange(n, 0, -1, dtype=np.float64)


def pod_gains(period: Period) -> NDArray[np.float64]:
    """Return what a visit of each pod is worth under ``demand``."""
    wanted = np.bincount(
        period.line_sku, weights=period.line_quantity.astype(np.float64), minlength=period.stock.n_skus
    )
    return period.stock.sums(wanted)


def line_gain(left: int) -> float:
    """Return what a line of an order is worth under ``finish`` while so many of its lines are open."""
    return 1.0 / left


def break_ties(proof: Proof, tie_break: TieBreak) -> Solution:
    """Return the solution that a tie-break prefers among all that have the objective (1) of a proven one.

    Parameters
    ----------
    proof
        The proof.
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
        return best  # no new visit, and the oldest lines that can be placed (see `rmfs_rules.mip.period.placing`)
    if tie_break == "finish" and _from_one_station(proof):
        return evolve(best, parts=_finishing(proof.reduced))
    reduced = Reduced(period, proof.reduced.model, counted=tie_break == "demand")
    gains = {
        "oldest": lambda: Gains(order=order_gains(period)),
        "demand": lambda: Gains(pod=pod_gains(period)),
        "finish": lambda: Gains(lines=line_gain),
    }[tie_break]()
    builder = builder_of(reduced, proof.weight, proof.splits, gains)
    model = builder.build()
    builder.limit_objective(best.objective, best.objective)
    outcome = proof.solve(model.program, CLOSE if tie_break == "finish" else 0.999)  # the others are whole numbers
    if outcome.values is None:
        return evolve(best, how=proof.unproven)
    counts = model.counts(outcome.values)
    before = ((pod, s) for s, pods in enumerate(period.inbound) for pod in pods)
    return evolve(
        best,
        parts=parts_of(reduced, counts),
        visits=tuple(sorted({*before, *counts.visits})),
        how="solver" if outcome.optimal and proof.limits.gap == 0 else proof.unproven,
    )


def _from_one_station(proof: Proof) -> bool:
    """Whether lines go to a single station, which has what they need without a new visit and without counting items."""
    reduced, best = proof.reduced, proof.incumbent
    one = len(reduced.capacities) == 1 and proof.splits is None and not reduced.period.counting_orders
    return one and not len(reduced.scarce) and best.how == "flow"


def _finishing(reduced: Reduced) -> tuple[Part, ...]:
    """Return the lines that fill as many slots of the only station as its pods allow, worth most under ``finish``.

    Exact: by the slots taken, order after order, oldest first; of orders alike no more than there are slots.
    """
    period, room = reduced.period, reduced.capacities[0]
    there = period.covered[0]
    best: list[tuple[float, tuple[tuple[int, tuple[int, ...]], ...]] | None] = [None] * (room + 1)
    best[0] = (0.0, ())
    alike: dict[tuple[int, tuple[int, ...]], int] = {}
    for order in reduced.orders:
        lines = sorted((quantity, sku) for sku, quantity in reduced.lines_of(order) if there[sku])
        left = len(period.lines[order])
        key = (left, tuple(quantity for quantity, _ in lines))
        alike[key] = alike.get(key, 0) + 1
        if lines and alike[key] <= room:
            _take_of(order, _choices(lines, left, room), best)
    found = next(entry for entry in reversed(best) if entry is not None)
    return tuple(Part(order, 0, tuple(sorted(skus))) for order, skus in found[1])


def _choices(lines: list[tuple[int, int]], left: int, room: int) -> dict[int, tuple[float, tuple[int, ...]]]:
    """Return for each number of slots the most lines of an order (quantity, SKU) that take these, and their worth."""
    most: dict[int, tuple[int, ...]] = {0: ()}
    for quantity, sku in lines:
        for slots, skus in sorted(most.items(), reverse=True):
            now = slots + quantity
            if now <= room and len(most.get(now, ())) <= len(skus):
                most[now] = (*skus, sku)
    del most[0]
    return {slots: (sum(line_gain(left - n) for n in range(len(skus))), skus) for slots, skus in most.items()}


def _take_of(
    order: int,
    choices: dict[int, tuple[float, tuple[int, ...]]],
    best: list[tuple[float, tuple[tuple[int, tuple[int, ...]], ...]] | None],
) -> None:
    """Let an order take some of the slots, where that is worth more."""
    for slots in range(len(best) - 1, 0, -1):
        for taken, (worth, skus) in choices.items():
            before = best[slots - taken] if taken <= slots else None
            now = best[slots]
            if before is not None and (now is None or before[0] + worth > now[0] + CLOSE):
                best[slots] = (before[0] + worth, (*before[1], (order, skus)))
