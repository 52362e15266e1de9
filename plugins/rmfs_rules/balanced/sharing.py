"""Which robot belongs to which station."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rmfs_core.warehouse import Robot, WarehouseView


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
