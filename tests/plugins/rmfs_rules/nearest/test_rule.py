"""PR rule nearest."""

from __future__ import annotations

from collections.abc import Callable

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_core.world import NORTH, parse_map
from rmfs_rules.nearest import Nearest

PutAtStation = Callable[[Warehouse, int, int], None]


def test_the_location_with_the_shortest_loaded_drive_is_chosen(put_at_station: PutAtStation) -> None:
    """Compared with every free location by the travel times to it."""
    world = small_world({}, {"p": ["a"], "q": ["a"]})
    put_at_station(world, 0, 0)
    pod = world.pods[0]
    heading = world.robots[0].heading
    by_time = {cell: world.travel.ticks(pod.cell, heading, cell, True) for cell in world.free_locations}
    chosen = Nearest().choose_storage_location(WarehouseView(world), pod)
    assert type(chosen) is int
    assert by_time[chosen] == min(by_time.values())
    assert pod.cell == world.stations[0].cell
    assert world.pods[1].cell not in by_time


def test_turns_count_and_ties_go_to_the_lowest_cell() -> None:
    """The robot faces north: the place ahead is nearest, and of the equal ones at its sides the western is lower."""
    layout = parse_map("...#...\n.......\n#..O..#\n...q...\n.......\n#######", "cross")
    world = small_world({}, {"p": ["a"]}, robots=1, layout=layout)
    pod, robot = world.pods[0], world.robots[0]
    world.bind(pod, world.stations[0])
    world.take_task(robot, pod)
    world.lift(robot, pod)
    north, west, east = layout.storage_locations[:3]
    world.move(robot, west + 3 - 7, NORTH)  # in the middle of the second row
    assert Nearest().choose_storage_location(WarehouseView(world), pod) == north
    world.reserve(north)
    times = world.travel.times_from(robot.cell, NORTH, True)
    assert times[west] == times[east]
    assert Nearest().choose_storage_location(WarehouseView(world), pod) == west
