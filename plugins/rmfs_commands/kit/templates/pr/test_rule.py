"""Tests of the rule."""

import numpy as np
from rmfs.helpers import nearest_free_location
from rmfs.testing import check_rule, small_world
from rmfs.warehouse import Pod, WarehouseView

from the_rule import TheRule


def carried_pod() -> tuple[WarehouseView, Pod]:
    """Return a world in which a robot has lifted a pod, and the pod."""
    world = small_world({}, {"P": ["a"]})
    robot, pod = world.robots[0], world.pods[0]
    world.bind(pod, world.stations[0])
    world.take_task(robot, pod)
    world.lift(robot, pod)
    return WarehouseView(world), pod


def test_it_conforms() -> None:
    """It decides only what is possible, repeatably, and starves no order, in every small world."""
    print(check_rule(TheRule()))


def test_with_one_choice_it_is_the_nearest() -> None:
    """Nothing is left to chance then."""
    warehouse, pod = carried_pod()
    rule, rng = TheRule(choices=1), np.random.default_rng(1)
    assert rule.choose_storage_location(warehouse, pod, rng) == nearest_free_location(warehouse, pod)


def test_it_draws_from_so_many() -> None:
    """Three locations turn up, and no fourth."""
    warehouse, pod = carried_pod()
    rule, rng = TheRule(choices=3), np.random.default_rng(1)
    assert len({rule.choose_storage_location(warehouse, pod, rng) for _ in range(100)}) == 3
