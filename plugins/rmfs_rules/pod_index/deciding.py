"""What pod-index reads of the warehouse, and its decision as the kernel takes it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from rmfs_core import JointDecision, OrderAssignment, PodTrip
from rmfs_core.clock import to_ticks
from rmfs_core.warehouse import CAPACITY, UNLIMITED, columns_of, shown, stock_of
from rmfs_rules.helpers.pairs import places_taken
from rmfs_rules.helpers.sending import load
from rmfs_rules.pod_index.period import MOST_STEPS, NONE, Ints, Weights, next_urgent
from rmfs_rules.pod_index.turns import decide

if TYPE_CHECKING:
    from rmfs_core.warehouse import Station, WarehouseView

MOST_SECONDS = 4096
"""Of how many seconds the power is kept in a table."""
NOTHING, NOWHERE = JointDecision(), np.zeros((0, 0), np.bool_)


def weights_of(rule: Any) -> Weights:
    """Return the parameters of a `PodIndex` as compiled code takes them."""
    return Weights(
        **{name: float(getattr(rule, name)) for name in Weights._fields[:11]},
        most_pods=rule.most_pods,
        urge_ticks=to_ticks(rule.urge_s),
        base_ticks=to_ticks(rule.base_s),
        priority=np.array([float(rule.priority_factor) ** steps for steps in range(-MOST_STEPS, MOST_STEPS + 1)]),
        least=np.power(np.arange(MOST_SECONDS, dtype=np.float64), rule.finish),
    )


def state(warehouse: WarehouseView, weights: Weights) -> tuple[Any, ...]:
    """Return the arguments that `decide` and `next_urgent` begin with.

    Without any wait of pods, unless orders have come after the first ones: more may come.
    """
    lines, first_s = warehouse.lines, warehouse.order(0).arrival_s
    # No need to look through all orders where one in the backlog came later
    if weights.urge_ticks and lines.arrival_s[-1] == first_s and warehouse.orders[-1].arrival_s == first_s:
        weights = weights._replace(urge_ticks=0)
    return tuple(lines), tuple(warehouse.stock), tuple(weights), warehouse.capacities, warehouse.now_tick


def decision(
    warehouse: WarehouseView, weights: Weights, ticks: Ints, room: int | None, without: Station | None
) -> JointDecision:
    """Let stations take lines and send pods; ``room`` more orders may be split, ``without`` takes nothing now."""
    takes, sends = decide(
        *state(warehouse, weights),
        NONE if without is None else without.id,
        places_taken(warehouse) if warehouse.capacities["counts_orders"].any() else NOWHERE,
        ticks,
        UNLIMITED if room is None else room,
    )
    if not len(takes) and not len(sends):
        return NOTHING
    parts: dict[tuple[int, int], list[int]] = {}
    for at, order, sku in takes.tolist():
        parts.setdefault((order, at), []).append(sku)
    assigned = [OrderAssignment(order, at, tuple(skus)) for (order, at), skus in parts.items()]
    return JointDecision(assigned, [PodTrip(pod, at) for pod, at in sends.tolist()])


def prepare(weights: Weights) -> None:
    """Load compiled code, or compile it."""
    load()
    empty = tuple(columns_of((), 1)), tuple(stock_of((), 1)), tuple(weights), shown(np.zeros(1, CAPACITY)), 0
    decide(*empty, NONE, NOWHERE, np.zeros((1, 1), np.int64), 0)
    next_urgent(*empty)
