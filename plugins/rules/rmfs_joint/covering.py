"""Few pods for chosen orders, what both cost by the objective (1), and the decision that they are."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from attrs import field, validators
from numpy.typing import NDArray

from rmfs_core import JointDecision, OrderAssignment, PodTrip, SolveReport
from rmfs_joint.choosing import Chosen, Integers, Sent
from rmfs_rule_helpers import items_per_order, lines_at, ticks_to_station

if TYPE_CHECKING:
    from rmfs_core.warehouse import WarehouseView


def pods_for(warehouse: WarehouseView, chosen: Chosen, worth: Integers | None = None) -> Sent:
    """Return few pods that bring what chosen orders lack at their stations.

    Again and again the pod that brings a station most goes there; of equals one that is bound for no station, the one
    with most ``worth``, the nearest, the lowest id. Then those that the others make needless stay.

    Parameters
    ----------
    warehouse
        The warehouse now. All pods together have what the orders want.
    chosen
        The orders.
    worth
        Of each pod, what else speaks for it; left out: nothing.
    """
    period = _Covering(warehouse, chosen)
    sent: list[tuple[int, int]] = []
    stock, need = period.dealt(sent)
    gains = np.minimum(stock[:, None, :], need[None, :, :]).sum(axis=2)
    while need.any():
        most = np.argwhere(gains == gains.max())
        pod, station = min(
            ((int(pod), int(at)) for pod, at in most), key=lambda pair: period.rank(pair[0], pair[1], worth)
        )
        assert gains[pod, station] > 0, "all pods together have enough"
        sent.append((pod, station))
        _deal(stock[pod], need[station])
        gains[pod] = np.minimum(stock[pod], need).sum(axis=1)
        gains[:, station] = np.minimum(stock, need[station]).sum(axis=1)
    for trip in sent[:-1]:
        others = [other for other in sent if other != trip]
        if not period.dealt(others)[1].any():
            sent = others
    return sent


def serve(warehouse: WarehouseView, chosen: Chosen, sent: Sent) -> bool:
    """Whether the pods at, bound for and sent to stations have what chosen orders want, dealt out in this order."""
    return not _Covering(warehouse, chosen).dealt(sent)[1].any()


def _deal(stock: Integers, need: Integers) -> None:
    """Give what a pod has to a station that needs it."""
    given = np.minimum(stock, need)
    stock -= given
    need -= given


class _Covering:
    """What chosen orders want, and what pods have of it."""

    def __init__(self, warehouse: WarehouseView, chosen: Chosen) -> None:
        self.warehouse = warehouse
        lines, free = warehouse.backlog_lines, warehouse.free_items
        at = [(station, lines_at(warehouse, position)) for position, station in chosen]
        wanted = np.zeros((len(warehouse.stations), warehouse.n_skus), np.int64)
        for station, where in at:
            wanted[station, lines.sku[where]] += lines.quantity[where]
        columns = np.flatnonzero(wanted.any(axis=0))
        self._need = wanted[:, columns]
        self._stock = np.zeros((len(warehouse.pods), len(columns)), np.int64)
        column = np.full(warehouse.n_skus, -1)
        column[columns] = np.arange(len(columns))
        held = column[free.sku] >= 0
        self._stock[free.pod[held], column[free.sku[held]]] = free.number[held]
        self._inbound = [(pod.id, station.id) for station in warehouse.stations for pod in station.inbound_pods]
        self._busy = {pod for pod, _ in self._inbound}

    def dealt(self, sent: Sent) -> tuple[Integers, Integers]:
        """Return what pods have left, and what stations lack, once the pods at or bound for them have served."""
        stock, need = self._stock.copy(), self._need.copy()
        for pod, station in (*self._inbound, *sent):
            _deal(stock[pod], need[station])
        return stock, need

    def rank(self, pod: int, station: int, worth: NDArray[np.int64] | None) -> tuple[bool, int, int, int, int]:
        """Return which of two pods that bring as much is sent: the lower one."""
        ticks = ticks_to_station(self.warehouse, self.warehouse.pods[pod], self.warehouse.stations[station])
        return pod in self._busy, 0 if worth is None else -int(worth[pod]), ticks, pod, station


def unused_capacity_weight() -> Any:
    """Return the parameter ``unused_capacity_weight`` of a rule that goes by `cost`."""
    return field(
        default=2.0,
        validator=validators.gt(0),
        metadata={"doc": "W_u in the cost: what a free place that stays unused costs, in pod-station visits"},
    )


def cost(warehouse: WarehouseView, chosen: Chosen, sent: Sent, weight: float) -> float:
    """Return the objective (1): visits to stations with free places, and ``weight`` for every place that stays free.

    At a station that counts orders, a free place counts times the items of the largest order.
    """
    free = {station.id: station.free_capacity for station in warehouse.stations if station.free_capacity}
    visits = len(sent) + sum(len(warehouse.stations[station].inbound_pods) for station in free)
    for position, station in chosen:
        free[station] -= warehouse.size_at(warehouse.backlog[position], warehouse.stations[station])
    largest = int(items_per_order(warehouse).max(initial=1))
    return visits + weight * sum(
        places * (largest if warehouse.stations[station].counts_orders else 1) for station, places in free.items()
    )


def decision(warehouse: WarehouseView, chosen: Chosen, sent: Sent, weight: float | None = None) -> JointDecision:
    """Return orders and pods as the kernel takes them; with a ``weight``, their cost as well."""
    if not chosen:
        return JointDecision()
    return JointDecision(
        [OrderAssignment(warehouse.backlog[position].id, station) for position, station in chosen],
        [PodTrip(pod, station) for pod, station in sent],
        None if weight is None else SolveReport("heuristic", cost(warehouse, chosen, sent, weight)),
    )
