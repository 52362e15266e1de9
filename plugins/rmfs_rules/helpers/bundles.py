"""Choosing the pods that bundles are stored on: what the rules for RPS share."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rmfs_core.decisions import StoreBundle
from rmfs_core.warehouse import STORED, UNLIMITED
from rmfs_rules.helpers.sending import Ids, held, ticks_from

if TYPE_CHECKING:
    from rmfs_core.warehouse import Bundle, Station, WarehouseView

Values = NDArray[np.float64] | NDArray[np.int64]

NO_ROOM = -1


class StoragePods:
    """The pods that bundles can be stored on, with what the decision under construction takes up.

    Arrays are by pod id.

    Parameters
    ----------
    warehouse
        The warehouse now.
    max_fetches
        How many stored pods that are bound nowhere may be chosen.

    Attributes
    ----------
    room
        Free space on each pod; less than 0 for pods that cannot come.
    """

    def __init__(self, warehouse: WarehouseView, max_fetches: int) -> None:
        self.warehouse, self._fetches, self._stock = warehouse, max_fetches, warehouse.stock
        stations = *warehouse.stations, *warehouse.replenishment_stations
        coming = {pod.id: pod for station in stations for pod in station.inbound_pods}
        self._pods = warehouse.pods
        self._coming = np.zeros(len(self._pods), dtype=bool)
        self._coming[list(coming)] = True
        can_come = (self._stock.at == STORED) & (max_fetches > 0)
        self.room, self._cells = np.where(can_come, self._stock.space, NO_ROOM), self._stock.cell.copy()
        for pod in coming.values():
            self.room[pod.id], self._cells[pod.id] = pod.free_space, pod.cell
        self._to_come = [(pod.id, bundle.sku, bundle.items) for pod in coming.values() for bundle in pod.bundles]

    def able(self, bundle: Bundle) -> Ids:
        """Return the pods that can take a bundle, ascending."""
        fitting = self.room >= bundle.size
        return np.flatnonzero(fitting if self._fetches > 0 else fitting & self._coming)

    def items(self, sku: int) -> NDArray[np.int64]:
        """Return the items of a SKU on each pod that no request was promised, with those of bundles to come."""
        items = np.zeros(len(self._pods), np.int64)
        for pod in self.warehouse.pods_with(sku):
            items[pod.id] = pod.free_items(sku)
        for number, coming, more in self._to_come:
            items[number] += more * (coming == sku)
        return items

    def sums(self, values: Ids) -> Ids:
        """Return for each pod the sum of a value by SKU over the SKUs that it has free or that are to come, each once.

        Parameters
        ----------
        values
            Value (>= 0, a whole number) of each SKU, shape (n_skus,).
        """
        sums = held(self._stock, values.astype(np.int64, casting="safe"))
        for number, sku in {(number, sku) for number, sku, _ in self._to_come}:
            if self._pods[number].free_items(sku) <= 0:
                sums[number] += values[sku]
        return sums

    def nearest(self, pods: Ids, stations: Sequence[Station]) -> int:
        """Return the pod with the shortest loaded driving time to one of some stations; ties go to the lowest id."""
        if len(pods) == 1:  # a state without a layout has no driving times
            return int(pods[0])
        ticks = [ticks_from(self.warehouse, self._cells[pods], station) for station in stations]
        return int(pods[np.min(ticks, axis=0).argmin()])

    def take(self, bundle: Bundle, pod: int) -> None:
        """Take account of a choice: the pod's space is less, and it comes."""
        self.room[pod] -= bundle.size * (self.room[pod] < UNLIMITED)
        self._fetches -= not self._coming[pod]
        self._coming[pod] = True
        self._to_come.append((pod, bundle.sku, bundle.items))


Cost = Callable[[StoragePods, "Bundle"], Values]
"""Cost of storing a bundle on each pod, by pod id."""


def store_bundles(warehouse: WarehouseView, max_fetches: int, cost: Cost) -> list[StoreBundle]:
    """Choose for each bundle that lacks a pod the one with the lowest cost, of the pods that have space and can come.

    Ties go to the shortest loaded driving time to the bundle's station, then to the lowest id. Bundles choose in the
    order in which they were assigned, station by station; each choice counts for those after it.

    Parameters
    ----------
    warehouse
        The warehouse now.
    max_fetches
        How many stored pods that are bound nowhere may be chosen.
    cost
        Cost of storing a bundle on each pod, shape (pods,).

    Returns
    -------
    list[StoreBundle]
        The choices; bundles that no pod can take are left out.
    """
    pods = StoragePods(warehouse, max_fetches)
    return [
        StoreBundle(bundle.id, pod)
        for station in warehouse.replenishment_stations
        for bundle in station.bundles
        if bundle.pod is None and (pod := cheapest(pods, bundle, cost, (station,))) is not None
    ]


def cheapest(pods: StoragePods, bundle: Bundle, cost: Cost, stations: Sequence[Station]) -> int | None:
    """Choose a bundle's pod as `store_bundles` does, and take account of it; None where no pod can take it."""
    able = pods.able(bundle)
    if not len(able):
        return None
    costs = cost(pods, bundle)[able]
    pod = pods.nearest(able[costs == costs.min()], stations)
    pods.take(bundle, pod)
    return pod
