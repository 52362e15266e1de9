"""Few pods for chosen orders, and what is kept of pods from call to call."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from rmfs_rules.helpers.pod_sending import KeptPods, KeptSums
from rmfs_rules.joint.lacking import Ints, Lacking

if TYPE_CHECKING:
    from rmfs_core.warehouse import WarehouseView

Sent = Sequence[tuple[int, int]]
"""Pods (ids) and the stations that they are sent to."""
Chosen = Sequence[tuple[int, int]]
"""Orders, by place, and their stations."""


class Covering:
    """What pods have for the orders that are chosen; ``update`` begins a decision.

    Attributes
    ----------
    stock
        Free items of each SKU on all pods together.
    """

    def __init__(self) -> None:
        self._pods, self._sums = KeptPods(), KeptSums()
        self._log: object = None

    def load(self) -> None:
        """Load what is compiled, or compile it."""
        from rmfs_rules.joint import covering_search  # compiled: imported when needed, for it takes its time

        self._pods.load()
        self._sums.load()
        one, by_pod = np.zeros(1, np.int64), np.zeros((1, 1), np.int64)
        shown = one.copy()
        shown.setflags(write=False)
        arrays = covering_search.PodArrays(
            shown, shown, one, np.array([0, 1]), one, by_pod, np.zeros(1, np.bool_), by_pod, one, one
        )
        nowhere = np.zeros((0, 2), np.int64)
        covering_search.few(nowhere, one, by_pod, arrays)
        covering_search.serve(nowhere, -1, one, by_pod, arrays)

    def update(self, warehouse: WarehouseView) -> None:
        """Take in what pods have become."""
        from rmfs_rules.joint import covering_search  # see above

        self._work: Any = covering_search
        self._warehouse = warehouse
        self._pods.update(warehouse)
        items, by_sku = self._pods.items, self._pods.by_sku
        if self._pods.log is not self._log:
            self._log, self._seen = self._pods.log, 0
            self.stock, self._known = np.zeros(warehouse.n_skus, np.int64), np.zeros(0, np.int64)
            self._ticks: Ints = np.zeros((len(warehouse.stations), 0), np.int64)
            self._gains = np.zeros((len(warehouse.stations), len(warehouse.pods)), np.int64)
            self._busy, self._used = np.zeros(len(warehouse.pods), np.bool_), self._known
            self._no_worth = np.zeros(len(warehouse.pods), np.int64)
        if (more := len(by_sku) - len(self._known)) > 0:
            self._known = np.concatenate([self._known, np.zeros(more, np.int64)])
            self._used = np.zeros(len(by_sku), np.int64)
        changed = self._pods.log.changed(self._seen)  # type: ignore[union-attr]
        self._seen += len(changed)
        entries = np.unique(changed)
        np.add.at(self.stock, items.sku[entries], items.number[entries] - self._known[entries])
        self._known[entries] = items.number[entries]
        self._cells = self._pods.places.copy()
        for robot in warehouse.robots:
            if robot.task is not None:
                self._cells[robot.task] = warehouse.pods[robot.task].cell
        trips = [(pod.id, station.id) for station in warehouse.stations for pod in station.inbound_pods]
        self._inbound: Ints = np.array(trips, np.int64).reshape(-1, 2)

    def wanted_on(self, wanted: Ints) -> Ints:
        """Return how many items on each pod are wanted, of those wanted by SKU."""
        return self._sums.of_free(self._pods, wanted)

    def pods_for(self, orders: Lacking, chosen: Chosen, worth: Ints | None = None) -> Sent:
        """Return few pods that bring what chosen orders lack at their stations.

        Again and again the pod that brings a station most goes there; of equals one that is bound for no station, the
        one with most ``worth``, the nearest, the lowest id. Then those that the others make needless stay.

        Parameters
        ----------
        orders
            The orders. All pods together have what they want.
        chosen
            Which ones are chosen.
        worth
            Of each pod, what else speaks for it; left out: nothing.
        """
        if not chosen:
            return ()
        for station in {at for _, at in chosen}:
            self._know_ticks(station)
        trips, enough = self._work.few(self._inbound, *self._needed(orders, chosen), self._arrays(worth))
        assert enough, "all pods together have enough"
        return [(pod, station) for pod, station in trips.tolist()]

    def serve(self, orders: Lacking, chosen: Chosen, sent: Sent) -> bool:
        """Whether the pods at, bound for and sent to stations have what chosen orders want, dealt out in this order."""
        trips = np.concatenate([self._inbound, np.array(sent, np.int64).reshape(-1, 2)])
        enough: bool = self._work.serve(trips, -1, *self._needed(orders, chosen), self._arrays(None))
        return enough

    def available(self, sent: Sent) -> Ints:
        """Return what stations have for orders, and in the last row all pods: with what pods bring that are sent."""
        at = np.concatenate([self._warehouse.available(), self.stock[None]])
        for number, station in sent:
            pod = self._warehouse.pods[number]
            for sku in pod.contents:
                at[station, sku] += pod.free_items(sku)
        if self._warehouse.unlimited_stock:
            at[-1] = self._work.ENDLESS
        return at

    def _arrays(self, worth: Ints | None) -> Any:
        """Return what compiled code has of the pods."""
        items = self._pods.items
        return self._work.PodArrays(
            items.pod, items.number, self._pods.by_sku, self._pods.first, self._used, self._gains, self._busy,
            self._ticks, self._cells, self._no_worth if worth is None else worth,
        )  # fmt: skip

    def _needed(self, orders: Lacking, chosen: Chosen) -> tuple[Ints, Ints]:
        """Return the SKUs that chosen orders want, and how many items of each at each station."""
        columns: dict[int, int] = {}
        lines = orders.lines_of([place for place, _ in chosen])
        need = np.zeros((len(self._gains), len(lines)), np.int64)
        for which, sku, quantity in lines:
            need[chosen[which][1], columns.setdefault(sku, len(columns))] += quantity
        return np.array(list(columns), np.int64), need[:, : len(columns)].copy()

    def _know_ticks(self, station: int) -> None:
        """Know the driving times to a station."""
        ticks = self._pods.ticks_from(self._warehouse, self._warehouse.stations[station])
        if not self._ticks.shape[1]:
            self._ticks = np.zeros((len(self._ticks), len(ticks)), np.int64)
            self._known_ticks: set[int] = set()
        if station not in self._known_ticks:
            self._known_ticks.add(station)
            self._ticks[station] = ticks
