"""The rules: good locations for pods that are wanted much."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from attrs import define, field
from numpy.typing import NDArray

from rmfs_core import PodMove, hookimpl
from rmfs_core.warehouse import STORED
from rmfs_rules.classes.locations import NO_STATION, Ids, Kept, Locations, nearest_to
from rmfs_rules.helpers import nearest_free_location
from rmfs_rules.helpers.classes import by_share, class_borders, turn
from rmfs_rules.helpers.parameters import AT_LEAST_1, NOT_NEGATIVE, POSITIVE, SHARE, parameter
from rmfs_rules.helpers.sending import ByStock, held, worth

if TYPE_CHECKING:
    from rmfs_core.warehouse import Pod, Robot, WarehouseView

NOT_OFF = -1
"""How far from its rank a pod counts that may not be moved."""


def _weight(default: float, of: str) -> Any:
    return parameter(
        default,
        NOT_NEGATIVE,
        f"What the number of items {of} counts in how much a pod is wanted, as a share of that of the most wanted pod",
    )


def _weight_speed(default: float) -> Any:
    return _weight(default, "ordered until now of the SKUs on it")


@define(kw_only=True)
class _Moving(ByStock):
    """A rule that moves pods by how much they are wanted, and pauses when there is nothing to move."""

    weight_speed: float
    weight_demand: float = _weight(1.0, "on it that are wanted now")
    retry_s: float = parameter(
        120.0, POSITIVE, "Seconds until repositioning is looked into again, once all pods were where they belong"
    )
    _until_s: float | None = field(init=False, default=None, repr=False, eq=False)  # a pause until then
    _robots: tuple[Robot, ...] = field(init=False, default=(), repr=False, eq=False)  # whose run it is

    @hookimpl
    def move_pods(self, warehouse: WarehouseView, max_moves: int) -> Sequence[PodMove]:
        """Move the pods that are not where they belong; none during a pause, which begins when there are none."""
        if self.wake_at(warehouse) is not None:
            return []
        found = self._moves(warehouse, max_moves)
        self.remember(None if found else warehouse.now_s + self.retry_s, warehouse)
        return found

    @hookimpl
    def wake_at(self, warehouse: WarehouseView) -> float | None:
        """Look into repositioning again when the pause is over."""
        pausing = self._robots is warehouse.robots and self._until_s is not None and self._until_s > warehouse.now_s
        return self._until_s if pausing else None

    def memory(self) -> float | None:
        """Return when the pause is over, for the state of a run."""
        return self._until_s

    def remember(self, memory: float | None, warehouse: WarehouseView) -> None:
        """Take that back."""
        self._robots, self._until_s = warehouse.robots, None if memory is None else float(memory)

    def _wanted(self, warehouse: WarehouseView) -> NDArray[np.float64]:
        """Return how much each pod is wanted: the weighted sum of two sums by pod, each as a share of the largest.

        These are the items ordered until now of the SKUs that it has free, and the items on it that are wanted now.
        """
        stock, total = warehouse.stock, np.zeros(len(warehouse.pods))
        if self.weight_speed and (speed := held(stock, warehouse.ordered())).any():
            total += self.weight_speed * speed / speed.max()
        if self.weight_demand and (demand := worth(stock, np.arange(len(total)), warehouse.open_demand())).any():
            total += self.weight_demand * demand / demand.max()
        return total

    @abstractmethod
    def _moves(self, warehouse: WarehouseView, max_moves: int) -> list[PodMove]: ...


def _movable(warehouse: WarehouseView) -> NDArray[np.bool_]:
    """Return whether each pod is stored, bound nowhere, and fetched by nobody, by pod."""
    free: NDArray[np.bool_] = warehouse.stock.at == STORED
    for robot in warehouse.robots:  # one that is on its way to move a pod
        if robot.task is not None:
            free[robot.task] = False
    return free


@define
class StationBased:
    """Store a pod as near as possible to any picking station.

    That is in the free storage location with the shortest loaded driving time to the station that is nearest to it;
    ties go to the shortest drive from where the pod is, then to the lowest cell index.

    References
    ----------
    M. Merschformann, T. Lamballais, R. de Koster, L. Suhl: Decision rules for robotic mobile fulfillment systems.
    Operations Research Perspectives 6, 100128, 2019. https://doi.org/10.1016/j.orp.2019.100128
    """

    @hookimpl
    def choose_storage_location(self, warehouse: WarehouseView, pod: Pod) -> int:
        """Choose the free location that is nearest to a station."""
        free = np.array(warehouse.free_storage_locations)
        times = [warehouse.travel.times_to(station.cell, True)[free].min(axis=1) for station in warehouse.stations]
        ticks = np.min(times, axis=0)
        return nearest_free_location(warehouse, pod, free[ticks == ticks.min()])


@define
class TurnoverClasses(ByStock):
    """Store a pod in the class of locations that is as good as the pod is wanted.

    The storage locations without an empty pod, sorted by the loaded driving time to the nearest station, and
    the pods, sorted by

        sum over the SKUs i that pod p has free of (items of i in all orders until now),

    most first, are cut into classes at the same shares. A pod goes to the free location of its class with the shortest
    driving time from where it is. When its class is full, the next class down is tried, then the next one up, and so on
    to both sides. Ties go to the lowest id and cell index.

    References
    ----------
    R. Yuan, T. Cezik, S. C. Graves: Velocity-based storage assignment in semi-automated storage systems. Production and
    Operations Management, 2018.

    M. Merschformann, T. Lamballais, R. de Koster, L. Suhl: Decision rules for robotic mobile fulfillment systems.
    Operations Research Perspectives 6, 100128, 2019. https://doi.org/10.1016/j.orp.2019.100128
    """

    borders: tuple[float, ...] = class_borders("locations and of all pods")
    _classes: Kept[Ids] = field(init=False, factory=Kept, repr=False, eq=False)

    @hookimpl
    def choose_storage_location(self, warehouse: WarehouseView, pod: Pod) -> int:
        """Choose the nearest free location of the pod's class."""
        locations, classes = self._classes.of(warehouse, self._by_drive)
        speed = held(warehouse.stock, warehouse.ordered())
        own = by_share(np.argsort(-speed, kind="stable"), self.borders)[pod.id]
        free = np.isin(locations.cells, warehouse.free_storage_locations)
        away = turn(classes - own, better_first=False)
        return nearest_free_location(warehouse, pod, locations.cells[free & (away == away[free].min())])

    def _by_drive(self, locations: Locations) -> Ids:
        return by_share(np.argsort(locations.nearest_ticks, kind="stable"), self.borders)


@define
class Cache(_Moving):
    """Keep the best locations of each station for pods that are wanted much.

    Each station has a cache: of the storage locations without an empty pod a share is divided among the
    stations, the shortest loaded drive to a station first. A pod that leaves station s belongs there if

        (f + u) / 2 > threshold,

    f being the share of the cache of s that is free, and u the share of the pods stored in it that are wanted less than
    the pod (1 where there are none). How much a pod is wanted is the weighted sum of the items on it that are wanted
    now and of the items ordered until now of its SKUs. It goes to the location with the shortest driving time from
    where it is: in the cache of s, else in none; a pod that does not belong there to one in no cache. Caches of others
    come last, as does that of s for such a pod. Ties go to the lowest cell index.

    Repositioning: of the pods that are wanted at all, as many as the caches have locations besides ``free_places`` in
    each are useful, the most wanted ones. Where fewer locations of a cache are free, the pods in it that are not
    useful go out, the one that is wanted least first, to the nearest free location in no cache; where more are, useful
    pods in no cache come in, the one that is wanted most first, to the free location nearest to it. When there is
    nothing to move it is looked into again after ``retry_s``.

    References
    ----------
    M. Merschformann, T. Lamballais, R. de Koster, L. Suhl: Decision rules for robotic mobile fulfillment systems.
    Operations Research Perspectives 6, 100128, 2019. https://doi.org/10.1016/j.orp.2019.100128
    """

    share: float = parameter(0.25, SHARE, "Share of the storage locations that the caches have")
    threshold: float = parameter(
        0.5, NOT_NEGATIVE, "What has to be exceeded for a pod to go into the cache: the higher, the fewer pods do"
    )
    weight_speed: float = _weight_speed(0.0)
    free_places: int = parameter(8, NOT_NEGATIVE, "Repositioning: locations that are kept free in each cache")
    _caches: Kept[tuple[Ids, Ids]] = field(init=False, factory=Kept, repr=False, eq=False)

    @hookimpl
    def choose_storage_location(self, warehouse: WarehouseView, pod: Pod) -> int:
        """Choose the nearest free location in the station's cache, or outside all caches."""
        locations, (owner, _) = self._caches.of(warehouse, self._owners)
        station = min(
            warehouse.stations,
            key=lambda s: (int(warehouse.travel.times_to(s.cell, True)[pod.cell].min()), s.id),
        ).id
        free = np.isin(locations.cells, warehouse.free_storage_locations)
        if self._belongs(warehouse, pod, station, free[owner == station]):
            away = np.where(owner == station, 0, np.where(owner == NO_STATION, 1, 2))
        else:
            away = np.where(owner == NO_STATION, 0, 1)
        return nearest_free_location(warehouse, pod, locations.cells[free & (away == away[free].min())])

    def _moves(self, warehouse: WarehouseView, max_moves: int) -> list[PodMove]:
        locations, (owner, at) = self._caches.of(warehouse, self._owners)
        wanted = self._wanted(warehouse)
        stored, movable = warehouse.stock.location, _movable(warehouse)
        there = int((owner != NO_STATION).sum()) - self.free_places * len(warehouse.stations)
        order = np.argsort(-wanted, kind="stable")
        useful = order[: min(max(there, 0), np.count_nonzero(wanted > 0))]
        useless = movable.copy()
        useless[useful] = False
        now = at[stored]
        outside = useful[movable[useful] & (now[useful] == NO_STATION)].tolist()
        free = np.isin(locations.cells, warehouse.free_storage_locations)
        moves: list[PodMove] = []

        def move(pod: int, of: int) -> None:
            cell = nearest_to(warehouse, int(stored[pod]), locations.cells[free & (owner == of)])
            moves.append(PodMove(pod, cell))
            free[locations.cells == cell] = False

        for station in warehouse.stations:
            inside = np.flatnonzero(useless & (now == station.id))
            inside = inside[np.argsort(wanted[inside], kind="stable")]
            own, elsewhere = (int(np.count_nonzero(free & (owner == of))) for of in (station.id, NO_STATION))
            for pod in inside[: min(max(self.free_places - own, 0), elsewhere)].tolist()[: max_moves - len(moves)]:
                move(pod, NO_STATION)
            for _ in range(min(max(own - self.free_places, 0), len(outside), max_moves - len(moves))):
                move(outside.pop(0), station.id)
        return moves

    def _owners(self, locations: Locations) -> tuple[Ids, Ids]:
        """Return whose cache each location belongs to, and the same by cell."""
        owner = locations.caches(self.share)
        return owner, locations.by_cell(owner, NO_STATION)

    def _belongs(self, warehouse: WarehouseView, pod: Pod, station: int, free: NDArray[np.bool_]) -> bool:
        """Whether a pod belongs into the cache of a station, of which these locations are free."""
        if not len(free):
            return False
        _, (_, at) = self._caches.of(warehouse, self._owners)
        wanted = self._wanted(warehouse)
        stored = at[warehouse.stock.location] == station
        less = float((wanted[stored] < wanted[pod.id]).mean()) if stored.any() else 1.0
        return bool((free.mean() + less) / 2 > self.threshold)


@define
class Utility(_Moving):
    """Store a pod at a location of the rank that the pod has among all pods.

    Pods are ranked by how much they are wanted, a weighted sum of the items ordered until now of the SKUs on them and
    of the items on them that are wanted now, each as a share of the largest; storage locations (those that hold no
    empty pod) by the loaded driving time to the nearest station, those with the same time together. The pod of rank k
    (0 is the first) of n belongs to the rank of location

        floor(k / n * (n + buffer * number of locations)),

    counted from the best. Of the free locations of this rank, the next better, the next worse and so on, corridor ranks
    in all, or else the first such rank that has any, the one with the shortest driving time from where the pod is
    is taken. Ties go to the lowest id and cell index.

    Repositioning: the pod whose location is the most ranks from its own, ``corridor`` at least, goes first, to the
    location that would be chosen so, if that is nearer to its rank. When there is nothing to move it is looked into
    again after ``retry_s``.

    References
    ----------
    M. Merschformann, T. Lamballais, R. de Koster, L. Suhl: Decision rules for robotic mobile fulfillment systems.
    Operations Research Perspectives 6, 100128, 2019. https://doi.org/10.1016/j.orp.2019.100128
    """

    weight_speed: float = _weight_speed(1.0)
    corridor: int = parameter(3, AT_LEAST_1, "How many ranks of locations are looked at, beginning with the pod's own")
    buffer: float = parameter(0.05, SHARE, "Share of the locations that are used besides one for each pod")
    _ranks: Kept[tuple[Ids, Ids, Ids]] = field(init=False, factory=Kept, repr=False, eq=False)

    @hookimpl
    def choose_storage_location(self, warehouse: WarehouseView, pod: Pod) -> int:
        """Choose the nearest free location of about the pod's rank."""
        locations, (ranks, ranked, _) = self._ranks.of(warehouse, _ranked)
        own = self._own_ranks(warehouse, ranked)[pod.id]
        free = np.isin(locations.cells, warehouse.free_storage_locations)
        away = turn(ranks - own, better_first=True)
        least = max(self.corridor - 1, int(away[free].min()))
        return nearest_free_location(warehouse, pod, locations.cells[free & (away <= least)])

    def _moves(self, warehouse: WarehouseView, max_moves: int) -> list[PodMove]:
        locations, (ranks, ranked, at) = self._ranks.of(warehouse, _ranked)
        if not warehouse.ordered().any():  # nothing is known of any pod
            return []
        own = self._own_ranks(warehouse, ranked)
        cells = warehouse.stock.location
        off = np.where(_movable(warehouse), np.abs(at[cells] - own), NOT_OFF)
        out_of_place = np.flatnonzero(off >= self.corridor)
        free = np.isin(locations.cells, warehouse.free_storage_locations)
        moves: list[PodMove] = []
        for pod in out_of_place[np.argsort(-off[out_of_place], kind="stable")].tolist():
            if len(moves) == max_moves or not free.any():
                break
            away = turn(ranks - own[pod], better_first=True)
            least = max(self.corridor - 1, int(away[free].min()))
            better = free & (away <= least) & (np.abs(ranks - own[pod]) < off[pod])
            if better.any():
                cell = nearest_to(warehouse, int(cells[pod]), locations.cells[better])
                moves.append(PodMove(pod, cell))
                free &= locations.cells != cell
        return moves

    def _own_ranks(self, warehouse: WarehouseView, ranked: Ids) -> Ids:
        """Return the rank of the location that each pod belongs to."""
        wanted = self._wanted(warehouse)
        number, own = len(wanted), np.empty(len(wanted), np.int64)
        at = (np.arange(number) / number * (number + self.buffer * len(ranked))).astype(np.int64)
        own[np.argsort(-wanted, kind="stable")] = ranked[np.minimum(at, len(ranked) - 1)]
        return own


def _ranked(locations: Locations) -> tuple[Ids, Ids, Ids]:
    """Return the ranks of locations, 0 for those with the shortest drive, the same in ascending order, and by cell."""
    ranks = np.unique(locations.nearest_ticks, return_inverse=True)[1].astype(np.int64)
    return ranks, np.sort(ranks), locations.by_cell(ranks, 0)
