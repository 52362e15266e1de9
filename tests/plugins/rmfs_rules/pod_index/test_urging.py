"""When pods are wanted enough."""

from __future__ import annotations

import numpy as np

from rmfs_commands.testing import small_instance, small_world
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.pod_index import PodIndex
from rmfs_rules.pod_index.deciding import weights_of
from rmfs_rules.pod_index.urging import NEVER, count_lines, needed, next_urgent


def test_the_ages_of_the_lines_that_a_pod_has_items_for_add_up() -> None:
    """Pod p has lines of 0 and 40 ticks, q the second alone, r none: two lines age twice as fast."""
    wanted_of, held = {"1": ["a"], "2": ["b"]}, {"p": ["a", "b"], "q": ["b"], "r": ["c"]}
    plain, instance = small_world(wanted_of, held), small_instance(wanted_of, held, arrivals_s={"2": 0.04})
    world = Warehouse(instance, plain.travel, plain.stations, plain.robots, plain.homes)
    for order in world.orders:
        world.order_arrives(order)
    view = WarehouseView(world)
    wanted, number, arrivals = count_lines(view.lines, view.stock)
    assert (wanted.tolist(), number.tolist(), arrivals.tolist()) == ([0, 1], [2, 1, 0], [40, 40, 0])
    weights = weights_of(PodIndex(urge_s=0.1, base_s=0.01, full=1))

    def soonest(now: int, load: int = 1, inbound: int = 0) -> int:
        told = np.array([[1], [load], [2], [inbound], [0], [1]], np.int64)
        return int(next_urgent(view.lines, view.stock, weights, told, now))

    assert soonest(50) == 60  # 2 * (60 + 10) - 40
    assert soonest(59) == 60
    assert soonest(60) == 130  # p is wanted enough by now; q is at 130 + 10 - 40
    assert soonest(130) == NEVER
    assert soonest(50, inbound=2) == NEVER


def test_the_fuller_a_station_the_more_it_takes() -> None:
    """Sixteen times as much where all places are taken, or more than all."""
    weights = weights_of(PodIndex(urge_s=0.5, full=16))
    assert [needed(load, 30, weights) for load in (0, 2, 30, 31)] == [500, 1000, 8000, 8000]
