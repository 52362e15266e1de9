"""TA rule ``balanced``."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from attrs import define, field

from rmfs_core import TaskAssignment, hookimpl
from rmfs_rules.helpers.parameters import NOT_NEGATIVE, finite, parameter

if TYPE_CHECKING:
    from rmfs_core.warehouse import Pod, Robot, WarehouseView


NOWHERE = -1


@define
class Balanced:
    """Share the robots out over the active stations, as evenly as possible.

    A station is active while it has open requests. With R robots and S active stations each gets R // S robots, and the
    R mod S stations farthest from the middle of the grid get one more. A robot whose station is not active or has too
    many moves to a station that has too few, the pair with the shortest drive first. The shares are worked out again
    once ``reallocation_s`` has passed since the last time and other stations are active than then.

    An idle robot fetches the pod that has been waiting longest of those whose first stop is the robot's own station. If
    there is none, it helps another station, the one with the shortest drive first. Without ``help_others`` it does not,
    and a pod may wait although a robot is idle; pods for stations that no robot belongs to are fetched all the same.

    References
    ----------
    M. Merschformann, L. Xie, H. Li: RAWSim-O: a simulation framework for robotic mobile fulfillment systems.
    Logistics Research 11, 8, 2018. https://doi.org/10.23773/2018_8
    """

    reallocation_s: float = parameter(
        30.0, [NOT_NEGATIVE, finite], "Least simulated time between two reallocations", "s"
    )
    help_others: bool = parameter(True, None, "Whether a robot without work at its own station fetches pods for others")
    station_of: dict[int, int] = field(init=False, factory=dict)
    """Robot -> the station that it belongs to now."""
    _active: frozenset[int] = field(init=False, default=frozenset(), repr=False, eq=False)
    _shared_at_s: float = field(init=False, default=-math.inf, repr=False, eq=False)
    _robots: tuple[Robot, ...] = field(init=False, default=(), repr=False, eq=False)  # whose shares these are

    @hookimpl
    def assign_tasks(self, warehouse: WarehouseView) -> Sequence[TaskAssignment]:
        """Let idle robots fetch the longest waiting pods, for their own stations first."""
        self._reallocate(warehouse)
        waiting: dict[int, list[Pod]] = {}
        for pod in warehouse.waiting_pods:
            waiting.setdefault(pod.bound_for[0], []).append(pod)
        tasks, left = [], []
        for robot in warehouse.idle_robots:
            own = waiting.get(self.station_of.get(robot.id, NOWHERE))
            if own:
                tasks.append(TaskAssignment(robot.id, own.pop(0).id))
            else:
                left.append(robot)
        for robot in left:
            if not (stations := [i for i, pods in waiting.items() if pods]):
                break
            station = self._station_to_help(warehouse, robot, stations)
            if station is not None:
                tasks.append(TaskAssignment(robot.id, waiting[station].pop(0).id))
        return tasks

    def memory(self) -> dict[str, Any]:
        """Return whose station each robot belongs to, and since when, for the state of a run."""
        at_s = None if math.isinf(self._shared_at_s) else self._shared_at_s
        return {"station_of": [*self.station_of.items()], "active": sorted(self._active), "shared_at_s": at_s}

    def remember(self, memory: dict[str, Any], warehouse: WarehouseView) -> None:
        """Take that back."""
        self._robots, self._active = warehouse.robots, frozenset(memory["active"])
        self.station_of = {int(robot): int(station) for robot, station in memory["station_of"]}
        self._shared_at_s = -math.inf if memory["shared_at_s"] is None else float(memory["shared_at_s"])

    def _reallocate(self, warehouse: WarehouseView) -> None:
        if self._robots is not warehouse.robots:  # another run
            self._robots = warehouse.robots
            self.station_of, self._active, self._shared_at_s = {}, frozenset(), -math.inf
        active = frozenset(station.id for station in warehouse.stations if station.open_requests)
        due = warehouse.now_s - self._shared_at_s >= self.reallocation_s
        if due and active and active != self._active:
            ranked = middle_last(warehouse, active)
            self.station_of = share_out(warehouse, self.station_of, ranked)
            self._active = active
            self._shared_at_s = warehouse.now_s

    def _station_to_help(self, warehouse: WarehouseView, robot: Robot, stations: Sequence[int]) -> int | None:
        manned = set(self.station_of.values())
        candidates = [station for station in stations if self.help_others or station not in manned]
        return min(candidates, key=lambda station: drive(warehouse, robot, station), default=None)


def drive(warehouse: WarehouseView, robot: Robot, station: int) -> tuple[int, int]:
    """Return a robot's driving time to a station without a pod, and the station's id to break ties."""
    times = warehouse.travel.times_to(warehouse.station(station).cell, False)
    return int(times[robot.cell, robot.heading]), station


def middle_last(warehouse: WarehouseView, stations: Iterable[int]) -> list[int]:
    """Return stations by their distance from the middle of the grid, the farthest first; ties by id."""
    layout = warehouse.travel.layout

    def twice_distance_squared(station: int) -> int:
        row, column = divmod(warehouse.station(station).cell, layout.width)
        return (2 * row + 1 - layout.height) ** 2 + (2 * column + 1 - layout.width) ** 2

    return sorted(stations, key=lambda station: (-twice_distance_squared(station), station))


def share_out(warehouse: WarehouseView, before: Mapping[int, int], stations: Sequence[int]) -> dict[int, int]:
    """Return the station of each robot.

    Parameters
    ----------
    warehouse
        The warehouse now.
    before
        Station of each robot until now.
    stations
        The stations to share the robots among; the first ones get the remainder.
    """
    each, remainder = divmod(len(warehouse.robots), len(stations))
    room = Counter({station: each + (rank < remainder) for rank, station in enumerate(stations)})
    after = dict(before)
    room.subtract(station for station in after.values() if station in room)
    while short := [station for station in stations if room[station] > 0]:
        movable = [robot for robot in warehouse.robots if _may_move(room, after.get(robot.id))]
        robot, station = min(
            ((robot, station) for robot in movable for station in short),
            key=lambda pair: (drive(warehouse, *pair)[0], pair[0].id, pair[1]),
        )
        if after.get(robot.id) in room:
            room[after[robot.id]] += 1
        after[robot.id] = station
        room[station] -= 1
    return after


def _may_move(room: Mapping[int, int], station: int | None) -> bool:
    """Whether a robot belongs to no active station, or to one with more robots than its share."""
    return station is None or station not in room or room[station] < 0
