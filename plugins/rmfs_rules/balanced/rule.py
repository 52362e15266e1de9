"""Robots are shared out over the stations, and fetch pods for their own station first."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from attrs import define, field

from rmfs_core import TaskAssignment, hookimpl
from rmfs_rules.balanced.sharing import drive, middle_last, share_out
from rmfs_rules.helpers.parameters import parameter

if TYPE_CHECKING:
    from rmfs_core.warehouse import Pod, Robot, WarehouseView


NOWHERE = -1


def _not_negative(_instance: object, _attribute: Any, value: float) -> None:
    if not 0 <= value < math.inf:
        raise ValueError(f"expected a number >= 0, found {value}")


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

    reallocation_s: float = parameter(30.0, _not_negative, "Least simulated time between two reallocations", "s")
    help_others: bool = parameter(True, None, "Whether a robot without work at its own station fetches pods for others")
    station_of: dict[int, int] = field(init=False, factory=dict)
    """Robot -> the station that it belongs to now."""
    _active: frozenset[int] = field(init=False, default=frozenset())
    _shared_at_s: float = field(init=False, default=-math.inf)
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
