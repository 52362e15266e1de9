"""Rule ``random``, for POA, PPS, PR, TA, ROA and RPS: the baseline that every study prints."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from attrs import define
from numpy.typing import NDArray

from rmfs_core import BundleAssignment, OrderAssignment, PodTrip, StoreBundle, TaskAssignment, hookimpl
from rmfs_rules.helpers import StoragePods, store_bundles, waiting_limit
from rmfs_rules.helpers.late import assign_late
from rmfs_rules.helpers.pairs import places_taken
from rmfs_rules.helpers.sending import ByStock, send

if TYPE_CHECKING:
    from rmfs_core.warehouse import Bundle, WarehouseView

LOTS = 1 << 62
"""Lots are whole numbers below this: two are hardly ever the same."""


@define
class Random(ByStock):
    """Draw lots, each choice as likely as any other.

    As POA: again and again one of the pairs of order and station that fit, until nothing does. As PPS: one of the
    pods not in use (or leaving a station with no next one) that can serve an uncovered request of the station, which
    is that with the fewest inbound pods. As PR: one of the free storage locations. As TA: for each idle robot one of
    the waiting pods. As ROA: again and again one of the bundles, and one of the replenishment stations with a free
    slot. As RPS: for each bundle that lacks a pod, one of the pods that have space for it and can come.

    References
    ----------
    M. Merschformann, T. Lamballais, R. de Koster, L. Suhl: Decision rules for robotic mobile fulfillment systems.
    Operations Research Perspectives 6, 100128, 2019. https://doi.org/10.1016/j.orp.2019.100128
    """

    max_wait_s: float | None = waiting_limit()

    @hookimpl
    def assign_orders(self, warehouse: WarehouseView, rng: np.random.Generator) -> Sequence[OrderAssignment]:
        """Draw pairs of order and station."""
        return draw_pairs(warehouse, rng, self.max_wait_s)

    @hookimpl
    def select_pods(self, warehouse: WarehouseView, max_fetches: int, rng: np.random.Generator) -> Sequence[PodTrip]:
        """Draw pods for the stations that lack one."""
        return send(warehouse, max_fetches, lambda _, __, pods: int(pods[int(rng.integers(len(pods)))]))

    @hookimpl
    def choose_storage_location(self, warehouse: WarehouseView, rng: np.random.Generator) -> int:
        """Draw a free storage location."""
        free = warehouse.free_storage_locations
        return free[int(rng.integers(len(free)))]

    @hookimpl
    def assign_tasks(self, warehouse: WarehouseView, rng: np.random.Generator) -> Sequence[TaskAssignment]:
        """Draw a pod for each robot, or a robot for each pod: whichever are fewer."""
        robots, pods = warehouse.idle_robots, warehouse.waiting_pods
        pairs = zip(rng.permutation(len(robots)).tolist(), rng.permutation(len(pods)).tolist(), strict=False)
        return [TaskAssignment(robots[robot].id, pods[pod].id) for robot, pod in pairs]

    @hookimpl
    def assign_bundles(self, warehouse: WarehouseView, rng: np.random.Generator) -> Sequence[BundleAssignment]:
        """Draw bundles, and a station for each, until no slot is free."""
        bundles = warehouse.bundles
        places = [station.id for station in warehouse.replenishment_stations if station.free_bundle_capacity > 0]
        free = {station.id: station.free_bundle_capacity for station in warehouse.replenishment_stations}
        assignments: list[BundleAssignment] = []
        for number in rng.permutation(len(bundles)).tolist():
            if not places:
                break
            station = places[int(rng.integers(len(places)))]
            assignments.append(BundleAssignment(bundles[number].id, station))
            free[station] -= 1
            if not free[station]:
                places.remove(station)
        return assignments

    @hookimpl
    def select_replenishment_pods(
        self, warehouse: WarehouseView, max_fetches: int, rng: np.random.Generator
    ) -> Sequence[StoreBundle]:
        """Draw a pod for each bundle: of the pods that can take it, the one with the lowest lot."""

        def lots(_pods: StoragePods, _bundle: Bundle) -> NDArray[np.int64]:
            return rng.integers(LOTS, size=len(warehouse.pods))

        return store_bundles(warehouse, max_fetches, lots)


def draw_pairs(warehouse: WarehouseView, rng: np.random.Generator, max_wait_s: float | None) -> list[OrderAssignment]:
    """Assign whole orders, again and again one of the pairs of order and station that fit; late orders first.

    Parameters
    ----------
    warehouse
        The warehouse now.
    rng
        Draws lots.
    max_wait_s
        How long an order may wait, as `assign_late` has it.
    """
    lines, stations, drawn = warehouse.lines, warehouse.stations, list[OrderAssignment]()
    left, free = lines.items > 0, np.array([station.free_capacity for station in stations])
    sizes = np.empty((len(stations), len(left)), np.int64)
    placed = places_taken(warehouse)
    for at, station in enumerate(stations):
        sizes[at] = np.where(lines.items > warehouse.largest_capacity, station.capacity, lines.items)
        if station.counts_orders:
            sizes[at] = ~placed[at] if placed.size else 1

    def draw(among: NDArray[np.bool_]) -> bool:
        """Assign one of some orders, if any fits; say whether. Lots count stations, then sizes, then orders by id."""
        fits = among & (sizes <= free[:, None])
        up_to = np.count_nonzero(fits, axis=1).cumsum()
        if not len(up_to) or not up_to[-1]:
            return False
        lot = int(rng.integers(up_to[-1]))
        at = int(up_to.searchsorted(lot, side="right"))
        rows = np.flatnonzero(fits[at])
        rows = rows[np.lexsort((lines.order_id[rows], lines.items[rows]))]
        row = rows[lot - up_to[at]]  # counted from the last one
        drawn.append(OrderAssignment(int(lines.order_id[row]), at))
        free[at] -= sizes[at, row]
        left[row] = False
        return True

    assign_late(warehouse, max_wait_s, free, lambda row: draw(left & (np.arange(len(left)) == row)))
    while draw(left):
        pass
    return drawn
