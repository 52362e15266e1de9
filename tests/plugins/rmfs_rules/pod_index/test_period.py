"""What lines are worth, and when pods are wanted enough."""

from __future__ import annotations

import numpy as np

from rmfs_commands.testing import small_instance, small_world
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.pod_index import PodIndex
from rmfs_rules.pod_index.deciding import weights_of
from rmfs_rules.pod_index.period import (
    NEVER,
    POWER,
    SECONDS,
    WORTH,
    Stations,
    Weights,
    bound_orders,
    count_lines,
    line_of,
    needed,
    next_urgent,
    share_visits,
)


def test_all_numbers_are_of_the_kind_that_was_compiled() -> None:
    """Whole numbers that are given for seconds or shares as well: nothing is compiled for them in a run."""
    whole = weights_of(PodIndex(visit_s=300, finish=1, priority_factor=2, due_factor=1))
    kinds = {name: type(value) for name, value in zip(Weights._fields, weights_of(PodIndex()), strict=True)}
    assert {name: type(value) for name, value in zip(Weights._fields, whole, strict=True)} == kinds
    assert (whole.priority[20], whole.priority[22], whole.least[7]) == (1.0, 4.0, 7.0)
    assert whole.priority.dtype == whole.least.dtype == float


def test_a_line_whose_sku_is_at_no_station_bears_its_share_of_a_visit() -> None:
    """SKU b shares a visit with SKU a, three lines in all on p; a is at a station, and no pod has c."""
    orders = {"1": ["a"], "2": ["b"], "3": ["b"], "4": ["c"]}
    view = WarehouseView(small_world(orders, {"p": ["a", "b"], "q": ["a"], "r": {"c": 0}}))
    available = np.array([[5, 0], [0, 0], [0, 0]])
    share = share_visits(np.array([0, 1, 2]), view.stock, available, np.array([3, 1, 0]), 300.0)
    assert share.tolist() == [0.0, 100.0, 0.0]


def test_orders_are_bounded_by_priority_and_due_time() -> None:
    """The second order is due: three times the worth at most."""
    view = WarehouseView(small_world({"1": {"a": 2}, "2": {"a": 1, "b": 3}}, {"p": ["a", "b"]}, due_s={"2": 9.0}))
    orders = bound_orders(view.lines, weights_of(PodIndex(handle_s=10, due_factor=3)))
    assert orders[:, POWER].tolist() == [0.0, 0.0]
    assert orders[:, WORTH].tolist() == [1.0, 3.0]
    assert orders[:, SECONDS].tolist() == [20.0, 40.0]


def test_lines_are_found_from_the_lists_by_sku() -> None:
    """The list of b has the lines 1 and 2, the first of the second order."""
    lines = WarehouseView(small_world({"1": ["a", "b"], "2": ["b", "a"]}, {"p": ["a", "b"]})).lines
    assert [line_of(lines, int(lines.first[1]) + i) for i in range(2)] == [1, 2]


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
        stations = Stations(*np.array([[1], [load], [2], [inbound], [0], [1]], np.int64))
        return int(next_urgent(view.lines, view.stock, weights, stations, now))

    assert soonest(50) == 60  # 2 * (60 + 10) - 40
    assert soonest(59) == 60
    assert soonest(60) == 130  # p is wanted enough by now; q is at 130 + 10 - 40
    assert soonest(130) == NEVER
    assert soonest(50, inbound=2) == NEVER


def test_the_fuller_a_station_the_more_it_takes() -> None:
    """Sixteen times as much where all places are taken, or more than all."""
    weights = weights_of(PodIndex(urge_s=0.5, full=16))
    assert [needed(load, 30, weights) for load in (0, 2, 30, 31)] == [500, 1000, 8000, 8000]
