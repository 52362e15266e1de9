"""Rules for robots and stations: who fetches which pod, where robots rest and charge, which stations are active."""

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import rmfs_core
from cases import cases
from rmfs_commands.testing import check_rule, small_world
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.activation import BacklogThreshold
from rmfs_rules.assignment import Assignment
from rmfs_rules.balanced import Balanced, share_out
from rmfs_rules.idle import ChargeWhenLow
from rmfs_rules.nearest_robot import NearestRobot


def decide(world: Warehouse, rule: Any) -> list[tuple[int, int]]:
    return [(task.robot, task.pod) for task in rule.assign_tasks(WarehouseView(world))]


def three_waiting(robots: int = 3) -> Warehouse:
    """Return a world in which pods 2, 0 and 1 wait in this order; the robot with the highest id is nearest to all."""
    world = small_world({}, {"p": ["a"], "q": ["a"], "r": ["a"]}, robots=robots)
    for pod in (2, 0, 1):
        world.bind(world.pods[pod], world.stations[0])
    return world


def test_tasks_by_hand() -> None:
    assert decide(three_waiting(), NearestRobot()) == [(2, 2), (1, 0), (0, 1)]
    world = world_with(0, 2, 0, 2)
    rule = Balanced()
    assert sorted(decide(world, rule), key=lambda task: task[1]) == [(2, 0), (0, 1), (3, 2), (1, 3)]
    assert rule.station_of == {0: 2, 1: 2, 2: 0, 3: 0}
    assert check_rule(Assignment(defer_s=0.0)).findings == ()


STATIONS = 3
"""Stations 0, 1 and 2 from north to south; all robots stand in the south-east, robot 0 nearest to every station."""


def world_with(*requests: int, robots: int = 4) -> Warehouse:
    orders = {str(i): [f"s{i}"] for i in range(8)}
    world = small_world(orders, {f"p{i}": [f"s{i}"] for i in range(8)}, capacities=[9] * STATIONS, robots=robots)
    for order, station in enumerate(requests):
        world.assign(world.orders[order], world.stations[station], [world.orders[order].lines[0].sku])
        world.bind(world.pods[order], world.stations[station])
    return world


def test_shares_are_kept_for_a_while() -> None:
    """Station 1 becomes active; it gets its share when 30 s have passed, and again 30 s after that at the earliest."""
    world = world_with(0)
    rule = Balanced()
    decide(world, rule)
    assert set(rule.station_of.values()) == {0}
    world.assign(world.orders[5], world.stations[1], [5])
    world.advance(29_999)
    decide(world, rule)
    assert set(rule.station_of.values()) == {0}
    world.advance(30_000)
    decide(world, rule)
    assert sorted(rule.station_of.values()) == [0, 0, 1, 1]
    world.assign(world.orders[6], world.stations[2], [6])
    world.advance(59_999)
    decide(world, rule)
    assert sorted(rule.station_of.values()) == [0, 0, 1, 1]
    world.advance(60_000)
    decide(world, rule)
    assert sorted(rule.station_of.values()) == [0, 1, 2, 2]


@cases(
    "rule wrong problem",
    (Assignment, {"defer_s": -1}, "'defer_s' must be >= 0"),
    *((Balanced, {"reallocation_s": value}, "must be >= 0|a finite number") for value in (-1.0, math.inf, math.nan)),
    (ChargeWhenLow, {"low": 0.5, "full": 0.5}, "expected low below full"),
    (ChargeWhenLow, {"low": 0.1, "full": 1.5}, "'full' must be <= 1"),
    (ChargeWhenLow, {"low": -0.1, "full": 0.5}, "low"),
)
def test_wrong_parameters_are_refused(rule: type[Any], wrong: dict[str, float], problem: str) -> None:
    with pytest.raises(ValueError, match=problem):
        rule(**wrong)


def nothing_to_do(robots: int = 4) -> Warehouse:
    return small_world({}, {"p": ["a"]}, capacities=[9] * STATIONS, robots=robots)


@given(
    robots=st.integers(1, 6),
    stations=st.permutations(range(STATIONS)).flatmap(lambda order: st.integers(1, STATIONS).map(lambda n: order[:n])),
    before=st.dictionaries(st.integers(0, 5), st.integers(0, STATIONS - 1)),
)
def test_shares_differ_by_one_at_most(robots: int, stations: list[int], before: dict[int, int]) -> None:
    before = {robot: station for robot, station in before.items() if robot < robots}
    view = WarehouseView(nothing_to_do(robots))
    after = share_out(view, before, stations)
    each, more = divmod(robots, len(stations))
    assert sorted(after) == list(range(robots))
    assert [list(after.values()).count(station) for station in stations] == [
        each + (rank < more) for rank in range(len(stations))
    ]
    assert share_out(view, after, stations) == after


def test_a_run_with_few_chargers() -> None:
    overrides = [
        "layout.chargers=1",
        "rules.idle=charge-when-low",
        "robots.battery={capacity_wh=55, loaded_w=900, charging_w=20000}",
        "robots.battery.detour=1.2",
        "rules.pp=free-flow",
    ]
    result = rmfs_core.run("examples/small", overrides=overrides)
    assert result.status == "complete"
    assert result.metrics["charges"] > 4
    assert 0 <= result.metrics["charge_lowest_percent"] < 80


def waiting(orders: int = 0, capacities: tuple[int, ...] = (5, 5, 5, 5)) -> Warehouse:
    return small_world({str(i): ["a"] for i in range(orders)}, {"p": ["a"]}, capacities=capacities)


def active(rule: Any, warehouse: Warehouse) -> list[int]:
    chosen = list(rule.activate_stations(WarehouseView(warehouse)))
    for station in warehouse.stations:
        warehouse.activate(station, station.id in chosen)
    return chosen


def test_a_long_backlog_opens_a_station_and_little_to_do_closes_one() -> None:
    warehouse, rule = waiting(orders=12), BacklogThreshold(open_above=10, least=2)
    assert active(rule, warehouse) == [0, 1, 2, 3]  # much waits and nothing is to be done: nothing changes
    for order in warehouse.orders[:3]:
        warehouse.assign(order, warehouse.stations[0], [0])
    assert active(rule, warehouse) == [0, 1, 2]
    assert active(rule, warehouse) == [0, 1, 2]
    warehouse.advance(599_000)
    assert active(rule, warehouse) == [0, 1, 2]
    warehouse.advance(600_000)
    assert active(rule, warehouse) == [0, 1]
    warehouse.advance(1_200_000)
    assert active(rule, warehouse) == [0, 1]


def test_an_activation_rule_forgets_the_run_before() -> None:
    warehouse, rule = waiting(), BacklogThreshold()
    warehouse.advance(700_000)
    assert active(rule, warehouse) == [0, 1, 2]
    rule.run_started()
    assert active(rule, waiting()) == [0, 1, 2]


def test_stations_close_when_there_is_little_to_do_and_open_again() -> None:
    overrides = ["instance.orders=40", "instance.arrivals={process='poisson', orders_per_hour=60}"]
    rule = "rules.activate={rule='backlog-threshold', open_above=1, timeout_s=60}"
    all_of_them = rmfs_core.run("examples/small", overrides=[*overrides, "rules.activate=all"])
    by_load = rmfs_core.run("examples/small", overrides=[*overrides, rule])
    assert all_of_them.status == by_load.status == "complete"
    assert (by_load.metrics["station_open_h"] or 0) < 0.8 * (all_of_them.metrics["station_open_h"] or 0)


@pytest.mark.slow
def test_stations_that_close_soon_conform() -> None:
    check_rule(BacklogThreshold(open_above=2, timeout_s=10))
