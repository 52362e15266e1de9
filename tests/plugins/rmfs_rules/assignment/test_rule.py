"""TA rule assignment."""

from __future__ import annotations

import numpy as np
import pytest

from rmfs_commands.testing import check_rule, small_world
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.assignment import Assignment


def waiting_world(robots: int, pods: int, seed: int = 0) -> Warehouse:
    """Return a world in which pods wait in a random order, and robots stand in random aisles."""
    rng = np.random.default_rng(seed)
    world = small_world({}, {str(i): ["a"] for i in range(pods)}, robots=robots)
    for pod in rng.permutation(pods).tolist():
        world.bind(world.pods[pod], world.stations[0])
    for robot in world.robots:
        world.move(robot, int(rng.choice(world.travel.layout.storage_locations)), int(rng.integers(4)))
    return world


def decide(world: Warehouse, rule: Assignment) -> list[tuple[int, int]]:
    """Return (robot, pod) of each task."""
    return [(task.robot, task.pod) for task in rule.assign_tasks(WarehouseView(world))]


def drive(world: Warehouse, robot: int, pod: int) -> int:
    """Driving time of a robot to a pod."""
    at = world.robots[robot]
    return world.travel.ticks(at.cell, at.heading, world.pods[pod].cell, False)


def test_the_sum_of_drives_counts() -> None:
    """Robot 0 is the nearest to both pods, but robot 1 is much farther from pod 0 than it is itself."""
    world = small_world({}, {str(i): ["a"] for i in range(16)}, robots=2)
    first, last = world.pods[0], world.pods[15]
    for pod in (first, last):
        world.bind(pod, world.stations[0])
    times = [world.travel.times_to(pod.cell, False) for pod in (first, last)]
    cells = world.travel.layout.storage_locations

    def both(one: int, other: int) -> tuple[int, int]:
        straight = times[0][one, 0] + times[1][other, 0]
        return int(straight), int(times[0][other, 0] + times[1][one, 0])

    near, far = next(
        (one, other)
        for one in cells
        for other in cells
        if times[0][one, 0] < times[0][other, 0] and both(one, other)[0] > both(one, other)[1]
    )
    world.move(world.robots[0], near, 0)
    world.move(world.robots[1], far, 0)
    assert sorted(decide(world, Assignment())) == [(0, 15), (1, 0)]


def storing_world(robots: int, *waiting: int) -> Warehouse:
    """Return a world in which robot 1 brings pod 0 back and stood by pod 11 last; the others are idle, by pod 1."""
    world = small_world({}, {str(i): ["a"] for i in range(12)}, robots=robots)
    station, storing = world.stations[0], world.robots[1]
    world.place_at_station(storing, world.pods[0], station)
    world.leave(storing, world.pods[0], station)
    for pod in waiting:
        world.bind(world.pods[pod], station)
    for robot in world.robots:
        world.move(robot, world.pods[11 if robot is storing else 1].cell, 0)
    return world


def test_an_idle_robot_may_stay_for_it() -> None:
    """Robots 0 and 2 are idle and far from pod 11; robot 1 will be there sooner, unless it takes long to get free."""
    world = storing_world(3, 1, 11)
    assert [pod for _, pod in decide(world, Assignment(defer_s=1))] == [1]
    assert [pod for _, pod in sorted(decide(world, Assignment(defer_s=1000)), key=lambda pair: pair[1])] == [1, 11]


def test_the_pod_that_waits_longest_is_not_deferred() -> None:
    """Robot 1 would be there at once."""
    world = storing_world(2, 11)
    assert decide(world, Assignment(defer_s=0)) == [(0, 11)]


def test_it_conforms_with_deferral() -> None:
    """No pod waits for ever."""
    assert check_rule(Assignment(defer_s=0.0)).findings == ()


def test_a_time_below_zero_is_refused() -> None:
    """Before the run."""
    with pytest.raises(ValueError, match="'defer_s' must be >= 0"):
        Assignment(defer_s=-1)


def test_nothing_waits() -> None:
    """As where a state is decided in which no pod has to be fetched: no task."""
    assert decide(waiting_world(2, 0), Assignment()) == []
    assert decide(waiting_world(2, 0), Assignment(defer_s=5.0)) == []
