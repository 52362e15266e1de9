"""Orders that have waited too long, and the stations that are kept for them."""

import numpy as np

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.helpers.late import SHUT, assign_late, late


def test_who_waits_too_long() -> None:
    """With a limit all who reach it; without, only orders larger than any station, after ten minutes."""
    world = small_world({"1": ["a"], "2": {"a": 4}}, {"p": ["a"]}, capacities=[3])
    view = WarehouseView(world)
    world.now = 599_999
    assert late(view, 600) == []
    assert late(view, None) == []
    world.now = 600_000
    assert late(view, 600) == [0, 1]
    assert late(view, None) == [1]


def free_after(world: Warehouse, max_wait_s: float | None, *fitting: int) -> tuple[list[int], list[int]]:
    asked: list[int] = []

    def assign(place: int) -> bool:
        asked.append(place)
        return place in fitting

    free = np.array([station.free_capacity for station in world.stations])
    assign_late(WarehouseView(world), max_wait_s, free, assign)
    return asked, free.tolist()


def test_each_order_that_fits_nowhere_keeps_a_station() -> None:
    """That with most room of those that could take it: 2 wants three items, 3 wants one."""
    world = small_world({"1": ["a"], "2": {"a": 3}, "3": ["a"]}, {"p": ["a"]}, capacities=[2, 3, 4])
    assert free_after(world, 0, 0) == ([0, 1, 2], [2, SHUT, SHUT])
    assert free_after(world, 0, 0, 1, 2) == ([0, 1, 2], [2, 3, 4])
