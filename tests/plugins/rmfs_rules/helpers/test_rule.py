"""What rules share: sums over lines, greedy pairs, orders that waited too long, pods for stations, driving times."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from rmfs_commands.testing import small_world
from rmfs_core.decisions import OrderAssignment
from rmfs_core.warehouse import Station, Warehouse, WarehouseView
from rmfs_rules.common_lines import CommonLines
from rmfs_rules.first_come import FirstCome
from rmfs_rules.helpers import (
    OVERSIZE_WAIT_S,
    assign_best_pairs,
    lines_at,
    nearest_free_location,
    sum_per_order,
    ticks_to_station,
)
from rmfs_rules.pod_match import PodMatch

RULES = pytest.mark.parametrize("rule", [PodMatch, CommonLines, FirstCome])
"""Those that assign orders with `assign_best_pairs`."""

ORDERS = {"1": {"a": 2, "b": 1}, "2": ["c"], "3": {"a": 1, "b": 1, "c": 4}}


def view(**changes: object) -> WarehouseView:
    """Return a world of three orders of 3, 1 and 6 items; two stations for 6 and 4 items unless said otherwise."""
    settings: dict[str, object] = {"capacities": (6, 4), **changes}
    return WarehouseView(small_world(ORDERS, {"p": ["a", "b", "c"]}, **settings))  # type: ignore[arg-type]


def test_values_of_lines_are_summed_by_order() -> None:
    """Quantities make sizes, ones make numbers of lines; what `lines_at` names is what is summed."""
    world = view()
    quantities = world.backlog_lines.quantity
    assert sum_per_order(world, quantities).tolist() == [3, 1, 6]
    assert sum_per_order(world, np.ones_like(quantities)).tolist() == [2, 1, 3]
    assert [quantities[lines_at(world, i)].tolist() for i in range(3)] == [[2, 1], [1], [1, 1, 4]]


def test_an_order_without_open_lines_at_its_position_is_none() -> None:
    """What is assigned is in the backlog no more, and the lines that are left move up."""
    warehouse = small_world(ORDERS, {"p": ["a", "b", "c"]}, capacities=(6, 4))
    warehouse.assign(warehouse.orders[0], warehouse.stations[0], [0])
    world = WarehouseView(warehouse)
    assert sum_per_order(world, world.backlog_lines.quantity).tolist() == [1, 1, 6]
    warehouse.assign(warehouse.orders[0], warehouse.stations[0], [1])
    world = WarehouseView(warehouse)
    assert sum_per_order(world, world.backlog_lines.quantity).tolist() == [1, 6]


def scores(**by_station: list[int]) -> Callable[[Station], np.ndarray]:
    """Return a score that is a fixed list for each station: ``s0``, ``s1``."""
    return lambda station: np.array(by_station[f"s{station.id}"])


def chosen(found: list[OrderAssignment]) -> list[tuple[int, int]]:
    """Return (order, station) of each assignment."""
    return [(one.order, one.station) for one in found]


@pytest.mark.parametrize(
    ("s0", "s1", "expected"),
    [
        ([0, 0, 9], [0, 0, 0], [(2, 0), (0, 1), (1, 1)]),  # the best pair first; then nothing else fits station 0
        ([1, 5, 0], [1, 1, 0], [(1, 0), (0, 1)]),  # of the tie of order 0 the station with the lower load
        ([0, 0, 0], [0, 0, 0], [(0, 0), (1, 1)]),  # all alike: the oldest order, the lowest id
        ([0, 0, 0], [0, 9, 0], [(1, 1), (0, 0)]),  # order 2 fits nowhere then
    ],
)
def test_the_best_pair_that_fits_goes_first(s0: list[int], s1: list[int], expected: list[tuple[int, int]]) -> None:
    """Scores decide, then age, load, id; an order of six items fits the empty station 0 only."""
    assert chosen(assign_best_pairs(view(), scores(s0=s0, s1=s1))) == expected


def test_stations_that_count_orders_take_any_order() -> None:
    """Capacity one and two: three orders, whatever their size."""
    found = assign_best_pairs(view(capacities=(1, 2), counts_orders=True), scores(s0=[0, 0, 9], s1=[2, 1, 0]))
    assert chosen(found) == [(2, 0), (0, 1), (1, 1)]


def test_scores_are_asked_for_again_where_they_changed() -> None:
    """Who is told of an assignment says which stations' scores are others now."""
    asked: list[int] = []

    def score(station: Station) -> np.ndarray:
        asked.append(station.id)
        return np.array([0, 0, 0]) if asked.count(0) < 2 else np.array([0, 7, 0])

    told: list[tuple[int, int]] = []

    def assigned(station: Station, position: int) -> list[int]:
        told.append((station.id, position))
        return [0] if len(told) == 1 else []

    assert chosen(assign_best_pairs(view(), score, assigned)) == [(0, 0), (1, 0)]
    assert asked == [0, 1, 0]
    assert told == [(0, 0), (0, 1)]


def test_nothing_to_assign() -> None:
    """Neither without orders nor without capacity is any score asked for."""

    def unasked(station: Station) -> np.ndarray:
        raise AssertionError("nothing fits")

    assert assign_best_pairs(WarehouseView(small_world({}, {"p": ["a"]})), unasked) == []
    full = small_world({"1": ["a"], "2": ["b"]}, {"p": ["a", "b"]}, capacities=(1,))
    full.assign(full.orders[0], full.stations[0], [0])
    assert assign_best_pairs(WarehouseView(full), unasked) == []


def two_stations(orders: dict[str, dict[str, int]], begun: dict[str, int], now_s: float) -> Warehouse:
    """Return a world with two stations of four and six places, and some orders assigned already."""
    world = small_world(orders, {"p": ["a"]}, capacities=[4, 6])
    for name, station in begun.items():
        order = next(order for order in world.orders if order.name == name)
        world.assign(order, world.stations[station], [line.sku for line in order.open_lines])
    world.now = int(now_s * 1000)
    return world


def decide(world: Warehouse, rule: PodMatch | CommonLines | FirstCome) -> list[tuple[str, int]]:
    """Return (order's name, station) of each assignment."""
    return [
        (world.orders[one.order].name, one.station)
        for one in rule.assign_orders(WarehouseView(world), np.random.default_rng(0))
    ]


LARGE = {"large": {"a": 9}, "x": {"a": 1}, "y": {"a": 3}, "1": {"a": 1}, "2": {"a": 1}, "3": {"a": 1}, "4": {"a": 1}}


@RULES
def test_an_order_larger_than_any_station_goes_to_an_empty_one(rule) -> None:
    """It takes all of it; the others go elsewhere."""
    assert ("large", 1) in decide(two_stations(LARGE, {"x": 0}, 0), rule())


@RULES
def test_it_waits_for_a_while(rule) -> None:
    """Until then, stations take what fits beside what they have."""
    decided = decide(two_stations(LARGE, {"x": 0, "y": 1}, OVERSIZE_WAIT_S - 1), rule())
    assert {name for name, _ in decided} == {"1", "2", "3", "4"}
    assert {station for _, station in decided} == {0, 1}


@RULES
def test_then_one_station_takes_nothing_else_until_it_is_empty(rule) -> None:
    """The one that is nearest to being empty."""
    world = two_stations(LARGE, {"x": 0, "y": 1}, OVERSIZE_WAIT_S)
    assert {station for _, station in decide(world, rule())} == {1}
    world = two_stations(LARGE, {"y": 1}, OVERSIZE_WAIT_S)
    assert decide(world, rule())[0] == ("large", 0)


@RULES
def test_one_station_at_a_time_is_emptied(rule) -> None:
    """A second order of the kind waits for the first."""
    world = two_stations({**LARGE, "larger": {"a": 12}}, {"x": 0, "y": 1}, OVERSIZE_WAIT_S)
    assert {station for _, station in decide(world, rule())} == {1}


FULL = {"big": {"a": 4}, "x": {"a": 3}, "y": {"a": 3}, "1": {"a": 1}, "2": {"a": 1}, "3": {"a": 1}, "4": {"a": 1}}


@RULES
@pytest.mark.parametrize("max_wait_s", [None, 61.0])
def test_orders_wait_as_long_as_it_takes(rule, max_wait_s: float | None) -> None:
    """Smaller ones fill the places that would add up to room for a larger one."""
    decided = decide(two_stations(FULL, {"x": 0, "y": 1}, 60), rule(max_wait_s=max_wait_s))
    assert sorted(name for name, _ in decided) == ["1", "2", "3", "4"]


@RULES
def test_with_a_limit_a_station_keeps_its_places_for_them(rule) -> None:
    """The second station needs one place more for the order, the first three; only the first takes others."""
    world = two_stations(FULL, {"x": 0, "y": 1}, 60)
    assert [station for _, station in decide(world, rule(max_wait_s=60))] == [0]


@RULES
def test_orders_that_waited_go_first(rule) -> None:
    """Whatever their score: pod and requests at the station are for others."""
    world = small_world({"late": ["b"], "x": ["a"], "1": ["a"], "2": ["a"]}, {"p": ["a"], "q": ["b"]}, capacities=[2])
    world.assign(world.orders[1], world.stations[0], [0])
    world.bind(world.pods[0], world.stations[0])
    world.now = 60_000
    assert decide(world, rule(max_wait_s=30)) == [("late", 0)]


@RULES
def test_a_wait_below_zero_is_refused(rule) -> None:
    """It is no time."""
    with pytest.raises(ValueError, match="max_wait_s"):
        rule(max_wait_s=-1)


def test_the_way_to_a_station_is_timed_with_the_pod() -> None:
    """From where the pod is, with the heading that is best for it."""
    world = view()
    pod = world.pods[0]
    for station in world.stations:
        ways = [world.travel.ticks(pod.cell, heading, station.cell, True) for heading in range(4)]
        assert ticks_to_station(world, pod, station) == min(ways) < max(ways)


def test_a_pod_goes_to_the_free_location_its_robot_reaches_first(
    put_at_station: Callable[[Warehouse, int, int], None],
) -> None:
    """By driving time with the pod, not by distance; it says nothing of a pod that nobody carries."""
    warehouse = small_world({}, {"p": ["a"], "q": ["b"]}, capacities=(9, 9))
    put_at_station(warehouse, 0, 1)
    world = WarehouseView(warehouse)
    pod, robot = world.pods[0], world.robots[world.pods[0].robot]
    times = {cell: world.travel.ticks(pod.cell, robot.heading, cell, True) for cell in world.free_storage_locations}
    assert nearest_free_location(world, pod) == min(times, key=lambda cell: (times[cell], cell))
    assert len({*times.values()}) > 1
    with pytest.raises(AssertionError, match="is being carried"):
        nearest_free_location(world, world.pods[1])


def test_the_nearest_of_some_cells_is_the_robots(put_at_station: Callable[[Warehouse, int, int], None]) -> None:
    """By driving time with the pod from where its robot stands, turns included; ties go to the lowest cell."""
    world = small_world({}, {"p": ["a"]})
    put_at_station(world, 0, 0)
    view, pod, robot = WarehouseView(world), world.pods[0], world.robots[0]
    cells = np.array(world.free_locations)[5:30]
    drives = {cell: world.travel.ticks(pod.cell, robot.heading, cell, True) for cell in cells.tolist()}
    assert nearest_free_location(view, pod, cells) == min(drives, key=lambda cell: (drives[cell], cell))
