"""A period of pod-index: what is read of the warehouse, and the decision as the kernel takes it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from rmfs_core import JointDecision, OrderAssignment, PodTrip
from rmfs_core.clock import to_seconds, to_ticks
from rmfs_core.warehouse import CAPACITY, columns_of, shown, stock_of
from rmfs_rules.helpers.sending import load
from rmfs_rules.pod_index.period import MOST_STEPS, NEVER, NONE, Ints, Weights, quiet_until
from rmfs_rules.pod_index.turns import decide

if TYPE_CHECKING:
    from rmfs_core.warehouse import Station, WarehouseView

MOST_SECONDS = 4096
"""Of how many seconds the power is kept in a table."""
NOTHING, NOWHERE = JointDecision(), np.zeros((1, 0), np.bool_)


def weights_of(rule: Any) -> Weights:
    """Return the parameters of a `PodIndex` as compiled code takes them."""
    seconds_and_shares = {name: float(getattr(rule, name)) for name in Weights._fields[:11]}
    with np.errstate(divide="ignore"):  # a negative exponent, which is refused after this
        least = np.power(np.arange(MOST_SECONDS, dtype=np.float64), rule.finish)
    return Weights(
        **seconds_and_shares,
        most_pods=rule.most_pods,
        urge_ticks=to_ticks(rule.urge_s),
        base_ticks=to_ticks(rule.base_s),
        packing=False,
        priority=np.array([float(rule.priority_factor) ** steps for steps in range(-MOST_STEPS, MOST_STEPS + 1)]),
        least=least,
    )


def ticks_to(stations: Sequence[Station], warehouse: WarehouseView) -> Ints:
    """Return the driving times to stations from each cell, shape (stations, cells)."""
    return np.array([warehouse.travel.times_to(station.cell, True).min(axis=1) for station in stations])


def quiet(warehouse: WarehouseView, weights: Weights, without: Station | None = None, *, urgent: bool = False) -> int:
    """Return the tick until which nothing can be decided, as `quiet_until` says; ``without`` takes nothing now."""
    columns = tuple(warehouse.lines), tuple(warehouse.stock), tuple(weights), warehouse.capacities
    shut = NONE if without is None else without.id
    return quiet_until(*columns, shut, warehouse.now_tick, urgent)  # type: ignore[no-any-return]


def decision(
    warehouse: WarehouseView, weights: Weights, ticks: Ints, room: int | None, without: Station | None
) -> JointDecision:
    """Let stations take lines and send pods; ``room`` more orders may be split, ``without`` takes nothing now."""
    lines, stations = warehouse.lines, warehouse.stations
    counting = [station for station in stations if station.counts_orders]
    # The last order stands for missing ones
    placed = np.zeros((len(stations), len(lines.items) + 1), np.bool_) if counting else NOWHERE
    for station in counting:
        ids = {request.order.id for request in station.open_requests}
        placed[station.id, lines.row[[order for order in ids if order < len(lines.row)]]] = True
    weights = weights if room is None else weights._replace(packing=True)
    columns = tuple(lines), tuple(warehouse.stock), tuple(weights), warehouse.capacities
    shut = NONE if without is None else without.id
    takes, sends = decide(*columns, shut, placed, ticks, warehouse.now_tick, room or 0)
    if not len(takes) and not len(sends):
        return NOTHING
    parts: dict[tuple[int, int], list[int]] = {}
    for at, order, sku in takes.tolist():
        parts.setdefault((order, at), []).append(sku)
    assigned = [OrderAssignment(order, at, tuple(skus)) for (order, at), skus in parts.items()]
    return JointDecision(assigned, [PodTrip(pod, at) for pod, at in sends.tolist()])


def waiting(warehouse: WarehouseView, weights: Weights) -> Weights:
    """Return the weights without any wait of pods, unless orders have come after the first ones: more may come."""
    first_s, arrival_s = warehouse.order(0).arrival_s, warehouse.lines.arrival_s
    # No need to look through all orders where one in the backlog came later
    if weights.urge_ticks and arrival_s[-1] == first_s and warehouse.orders[-1].arrival_s == first_s:
        return weights._replace(urge_ticks=0)
    return weights


def wake_s(warehouse: WarehouseView, weights: Weights) -> float | None:
    """Return when the ages of the lines of a pod will add up, if a station could take it then; None for never."""
    weights = waiting(warehouse, weights)
    if not weights.urge_ticks:
        return None
    tick = quiet(warehouse, weights, urgent=True)
    return None if tick == NEVER else to_seconds(tick)


def prepare(weights: Weights) -> None:
    """Load compiled code, or compile it."""
    load()
    lines, stock, capacities = columns_of((), 1), stock_of((), 1), shown(np.zeros(1, CAPACITY))
    columns = tuple(lines), tuple(stock), tuple(weights), capacities
    decide(*columns, NONE, NOWHERE, np.zeros((1, 1), np.int64), 0, 0)
    quiet_until(*columns, NONE, 0, False)
