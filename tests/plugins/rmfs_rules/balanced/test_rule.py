"""TA rule balanced."""

from __future__ import annotations

import pytest

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.balanced import Balanced

STATIONS = 3
"""Stations 0, 1 and 2 from north to south; all robots stand in the south-east, robot 0 nearest to every station."""


def world_with(*requests: int, robots: int = 4) -> Warehouse:
    """Return a world with an open request at each of these stations; pod i is the one for order i."""
    orders = {str(i): [f"s{i}"] for i in range(8)}
    world = small_world(orders, {f"p{i}": [f"s{i}"] for i in range(8)}, capacities=[9] * STATIONS, robots=robots)
    for order, station in enumerate(requests):
        world.assign(world.orders[order], world.stations[station], [world.orders[order].lines[0].sku])
        world.bind(world.pods[order], world.stations[station])
    return world


def decide(rule: Balanced, world: Warehouse) -> list[tuple[int, int]]:
    """Return (robot, pod) of each task."""
    return [(task.robot, task.pod) for task in rule.assign_tasks(WarehouseView(world))]


def test_a_robot_fetches_the_longest_waiting_pod_of_its_own_station() -> None:
    """Two robots each: pods 0 and 2 wait for station 0, pods 1 and 3 for station 2."""
    world = world_with(0, 2, 0, 2)
    rule = Balanced()
    assert sorted(decide(rule, world), key=lambda task: task[1]) == [(2, 0), (0, 1), (3, 2), (1, 3)]
    assert rule.station_of == {0: 2, 1: 2, 2: 0, 3: 0}


def test_a_robot_without_work_helps_the_nearest_station() -> None:
    """Pods wait for stations 0 and 1; robot 0 of station 2 goes for the nearer one."""
    world = world_with(0, 1, 2, robots=3)
    rule = Balanced()
    rule.assign_tasks(WarehouseView(world))
    own = {station: robot for robot, station in rule.station_of.items()}
    world.take_task(world.robots[own[0]], world.pods[2])
    world.take_task(world.robots[own[1]], world.pods[0])
    assert decide(rule, world) == [(own[2], 1)]


def test_without_help_a_pod_waits_for_a_robot_of_its_station() -> None:
    """Both robots of station 0 are idle and stay so, while station 2 has two pods left and no idle robot."""
    world = world_with(0, 2, 2, 2)
    rule, helping = Balanced(help_others=False), Balanced()
    for either in (rule, helping):
        either.assign_tasks(WarehouseView(world))
    own = [robot for robot, station in rule.station_of.items() if station == 2]
    world.take_task(world.robots[own[0]], world.pods[0])
    world.take_task(world.robots[own[1]], world.pods[1])
    assert decide(rule, world) == []
    assert [pod for _, pod in decide(helping, world)] == [2, 3]


def test_a_station_without_robots_is_served_all_the_same() -> None:
    """Three stations, one robot: nothing starves although nobody helps."""
    world = world_with(0, 1, 2, robots=1)
    rule = Balanced(help_others=False)
    assert decide(rule, world) == [(0, 2)]
    robot, pod = world.robots[0], world.pods[2]
    world.take_task(robot, pod)
    world.lift(robot, pod)
    world.join_line(robot, world.stations[2])
    world.leave(robot, pod, world.stations[2])
    world.store(robot, pod)
    assert rule.station_of == {0: 2}
    assert decide(rule, world) == [(0, 1)]


def test_shares_are_kept_for_a_while() -> None:
    """Station 1 becomes active; it gets its share when 30 s have passed, and again 30 s after that at the earliest."""
    world = world_with(0)
    rule = Balanced()
    decide(rule, world)
    assert set(rule.station_of.values()) == {0}
    world.assign(world.orders[5], world.stations[1], [5])
    world.advance(29_999)
    decide(rule, world)
    assert set(rule.station_of.values()) == {0}
    world.advance(30_000)
    decide(rule, world)
    assert sorted(rule.station_of.values()) == [0, 0, 1, 1]
    world.assign(world.orders[6], world.stations[2], [6])
    world.advance(59_999)
    decide(rule, world)
    assert sorted(rule.station_of.values()) == [0, 0, 1, 1]
    world.advance(60_000)
    decide(rule, world)
    assert sorted(rule.station_of.values()) == [0, 1, 2, 2]


def test_another_run_starts_without_shares() -> None:
    """What an instance has worked out in one warehouse counts for nothing in the next, whatever the time there."""
    rule = Balanced()
    decide(rule, world_with(0, 0, 1))
    world = world_with(1, 2)
    assert decide(rule, world) == decide(Balanced(), world)
    assert set(rule.station_of.values()) == {1, 2}


@pytest.mark.parametrize("value", [-1.0, float("inf"), float("nan")])
def test_the_time_between_reallocations_is_checked(value: float) -> None:
    """Less than nothing, or no number at all."""
    with pytest.raises(ValueError, match="expected a number >= 0, found"):
        Balanced(reallocation_s=value)
