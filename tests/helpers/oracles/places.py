"""Literal versions of the rules that decide where pods are stored and moved."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any

from attrs import define

from oracles.orders import free_on
from oracles.pods import classes, demand, ordered
from oracles.worlds import Moment
from rmfs_core import PodMove
from rmfs_core.warehouse import Pod, Station

NOWHERE = -1


def locations(now: Moment) -> list[int]:
    """Storage locations that hold no empty pod, ascending."""
    return [cell for cell in sorted(now.world.travel.layout.storage_locations) if cell not in now.world.blocked]


def drive(now: Moment, cell: int, station: Station) -> int:
    """Loaded driving time from a cell to a station."""
    return int(now.world.travel.times_to(station.cell, True)[cell].min())


def to_any(now: Moment, cell: int) -> int:
    """Loaded driving time from a cell to the nearest picking station."""
    return min(drive(now, cell, station) for station in now.stations)


def reached_first(now: Moment, cells: Iterable[int]) -> int:
    """The cell that the robot with the pod reaches first."""
    return min(cells, key=lambda cell: (now.turned_ticks(now.pod, cell), cell))


def nearest(now: Moment, told: Any) -> int:
    return reached_first(now, now.world.free_locations)


def fixed(now: Moment, told: Any) -> int:
    """Where the pod stood when the run started, else the nearest."""
    home = now.world.homes[now.pod.id]
    return home if home in now.world.free_locations else nearest(now, told)


def drawn(now: Moment, told: Any, *, max_wait_s: float | None = None) -> int:
    return now.world.free_locations[int(now.rng.integers(len(now.world.free_locations)))]


def station_based(now: Moment, told: Any) -> int:
    """The free location that is nearest to any station."""
    least = min(to_any(now, cell) for cell in now.world.free_locations)
    return reached_first(now, [cell for cell in now.world.free_locations if to_any(now, cell) == least])


def speed(now: Moment, pod: Pod) -> int:
    """Items ordered until now of the SKUs that a pod has free."""
    return sum(number for sku, number in ordered(now).items() if free_on(pod)[sku] > 0)


def turnover_classes(now: Moment, told: Any, *, borders: tuple[float, ...] = (0.1, 0.3, 1.0)) -> int:
    """The nearest location of the pod's class, else of the next class down, the next up, and so on."""
    cells = locations(now)
    of_cells = dict(zip(cells, classes([-to_any(now, cell) for cell in cells], borders), strict=True))
    own = classes([speed(now, pod) for pod in now.world.pods], borders)[now.pod.id]
    turns = [own, *(own + sign * away for away in range(1, len(borders)) for sign in (1, -1))]
    free = ([cell for cell in now.world.free_locations if of_cells[cell] == one] for one in turns)
    return reached_first(now, next(filter(None, free)))


def worth(now: Moment, weight_speed: float, weight_demand: float) -> dict[Pod, float]:
    """How much pods are wanted: speed and demand, each as a share of the largest."""
    wanted = demand(now)
    total = dict.fromkeys(now.world.pods, 0.0)
    for weight, value in ((weight_speed, speed), (weight_demand, lambda _, pod: wanted(pod, now.stations[0]))):
        values = {pod: value(now, pod) for pod in now.world.pods}
        if weight and max(values.values()):
            total = {pod: total[pod] + weight * values[pod] / max(values.values()) for pod in total}
    return total


def best_first(wanted: dict[Pod, float]) -> list[Pod]:
    """Pods, the one that is wanted most first, ties by id."""
    return sorted(wanted, key=lambda pod: (-wanted[pod], pod.id))


def movable(now: Moment) -> list[Pod]:
    """Pods that are stored, bound nowhere and fetched by nobody."""
    return [pod for pod in now.world.pods if pod.location is not None and not pod.bound_for and pod.robot is None]


def moved_to(now: Moment, pod: Pod, cells: Iterable[int]) -> int:
    """The cell nearest to a stored pod, whatever way the robot faces."""
    travel = now.world.travel
    return min(cells, key=lambda cell: (min(travel.ticks(pod.cell, way, cell, True) for way in range(4)), cell))


def paused(decide: Callable[..., list[PodMove]]) -> Callable[..., list[PodMove]]:
    """Let moves pause for ``retry_s`` when there are none."""

    def after(now: Moment, told: Any, *, retry_s: float = 120.0, **options: Any) -> list[PodMove]:
        if now.memory.get("until_s", now.now_s) > now.now_s:
            return []
        moves = decide(now, **options)
        now.memory["until_s"] = now.now_s if moves else now.now_s + retry_s
        return moves

    return after


# cache


@define
class Caches:
    """Whose cache each location belongs to."""

    owner: dict[int, int]  # station, or `NOWHERE`, by location
    free: list[int]  # free locations

    @classmethod
    def of(cls, now: Moment, share: float) -> Caches:
        """Divide a share of the locations among the stations, the shortest drive first."""
        cells, number = locations(now), len(now.stations)
        room = dict.fromkeys(now.stations, math.ceil(share * len(cells) / number))
        owner = dict.fromkeys(cells, NOWHERE)
        for _, at, cell in sorted((drive(now, cell, station), station.id, cell) for station in room for cell in cells):
            if room[now.stations[at]] and owner[cell] == NOWHERE:
                owner[cell] = at
                room[now.stations[at]] -= 1
        return cls(owner, [*now.world.free_locations])

    def free_in(self, of: int) -> list[int]:
        """Free locations of a cache, or outside of all."""
        return [cell for cell in self.free if self.owner[cell] == of]


def cache(
    now: Moment,
    told: Any,
    *,
    share: float = 0.25,
    threshold: float = 0.5,
    weight_speed: float = 0.0,
    weight_demand: float = 1.0,
    **_: Any,
) -> int:
    """In the cache of the station if the pod belongs there, else outside of all."""
    caches, wanted = Caches.of(now, share), worth(now, weight_speed, weight_demand)
    station = min(now.stations, key=lambda station: (drive(now, now.pod.cell, station), station.id)).id
    places = [cell for cell in caches.owner if caches.owner[cell] == station]
    stored = [pod for pod in now.world.pods if pod.location in places]
    belongs = False
    if caches.free_in(station):
        less = sum(wanted[pod] < wanted[now.pod] for pod in stored) / len(stored) if stored else 1.0
        free = len(caches.free_in(station)) / len(places)
        belongs = (free + less) / 2 > threshold
    others = [cell for cell in caches.free if caches.owner[cell] not in (NOWHERE, station)]
    outside = caches.free_in(NOWHERE)
    turns = [caches.free_in(station), outside, others] if belongs else [outside, [*others, *caches.free_in(station)]]
    return reached_first(now, next(filter(None, turns)))


def cache_moves(
    now: Moment,
    *,
    share: float = 0.25,
    weight_speed: float = 0.0,
    weight_demand: float = 1.0,
    free_places: int = 8,
    **_: Any,
) -> list[PodMove]:
    """Useless pods leave caches that are too full, useful ones come into caches that are too empty."""
    caches, wanted = Caches.of(now, share), worth(now, weight_speed, weight_demand)
    number = sum(owner != NOWHERE for owner in caches.owner.values()) - free_places * len(now.stations)
    useful = [pod for pod in best_first(wanted) if wanted[pod] > 0][: max(number, 0)]
    coming = [pod for pod in useful if pod in movable(now) and caches.owner[pod.cell] == NOWHERE]
    moves: list[PodMove] = []

    def move(pod: Pod, cells: list[int]) -> None:
        moves.append(PodMove(pod.id, moved_to(now, pod, cells)))
        caches.free.remove(moves[-1].cell)

    for station in now.stations:
        inside = [pod for pod in movable(now) if caches.owner[pod.cell] == station.id and pod not in useful]
        leaving = sorted(inside, key=lambda pod: (wanted[pod], pod.id))
        lacking = free_places - len(caches.free_in(station.id))
        for pod in leaving[: max(lacking, 0)]:
            if caches.free_in(NOWHERE) and len(moves) < now.max_moves:
                move(pod, caches.free_in(NOWHERE))
        for _ in range(-lacking):
            if coming and len(moves) < now.max_moves:
                move(coming.pop(0), caches.free_in(station.id))
    return moves


# utility


@define
class Ranks:
    """Ranks of locations by their drives, and the rank that each pod belongs to."""

    of_cell: dict[int, int]  # rank by location, those with the same drive together
    own: dict[Pod, int]  # rank by pod

    @classmethod
    def of(cls, now: Moment, buffer: float, weight_speed: float, weight_demand: float) -> Ranks:
        """Rank locations and pods."""
        cells = locations(now)
        drives = sorted(to_any(now, cell) for cell in cells)
        ranks = sorted(set(drives))
        pods = best_first(worth(now, weight_speed, weight_demand))
        at = [min(int(k / len(pods) * (len(pods) + buffer * len(cells))), len(cells) - 1) for k in range(len(pods))]
        own = {pod: ranks.index(drives[at[k]]) for k, pod in enumerate(pods)}
        return cls({cell: ranks.index(to_any(now, cell)) for cell in cells}, own)

    def found(self, pod: Pod, free: Iterable[int], corridor: int) -> list[int]:
        """Free locations of a pod's rank, the next better, the next worse, ... until enough ranks were looked at."""
        own, cells = self.own[pod], [*free]
        turns = [own, *(own + sign * away for away in range(1, len(self.of_cell)) for sign in (-1, 1))]
        found: list[int] = []
        for number, rank in enumerate(turns):
            if number < corridor or not found:
                found += [cell for cell in cells if self.of_cell[cell] == rank]
        return found


def utility(
    now: Moment,
    told: Any,
    *,
    weight_speed: float = 1.0,
    weight_demand: float = 1.0,
    corridor: int = 3,
    buffer: float = 0.05,
    **_: Any,
) -> int:
    """The nearest free location of about the pod's rank."""
    ranks = Ranks.of(now, buffer, weight_speed, weight_demand)
    return reached_first(now, ranks.found(now.pod, now.world.free_locations, corridor))


def utility_moves(
    now: Moment,
    *,
    weight_speed: float = 1.0,
    weight_demand: float = 1.0,
    corridor: int = 3,
    buffer: float = 0.05,
    **_: Any,
) -> list[PodMove]:
    """The pod that is most ranks off goes first."""
    if not ordered(now):
        return []
    ranks, free = Ranks.of(now, buffer, weight_speed, weight_demand), [*now.world.free_locations]
    off = {pod: abs(ranks.of_cell[pod.cell] - ranks.own[pod]) for pod in movable(now)}
    moves: list[PodMove] = []
    for pod in sorted(off, key=lambda pod: (-off[pod], pod.id)):
        if off[pod] >= corridor and len(moves) < now.max_moves:
            found = ranks.found(pod, free, corridor)
            better = [cell for cell in found if abs(ranks.of_cell[cell] - ranks.own[pod]) < off[pod]]
            if better:
                moves.append(PodMove(pod.id, moved_to(now, pod, better)))
                free.remove(moves[-1].cell)
    return moves


def pause_ends(now: Moment, told: Any, **_: Any) -> float | None:
    until_s: float = now.memory.get("until_s", now.now_s)
    return until_s if until_s > now.now_s else None
