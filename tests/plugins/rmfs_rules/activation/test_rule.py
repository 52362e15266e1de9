"""Activation rules."""

from __future__ import annotations

from typing import Any

import pytest

import rmfs_core
from rmfs_commands.testing import check_rule, small_world
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.activation import All, BacklogThreshold, ConstantRatio


def world(orders: int = 0, capacities: tuple[int, ...] = (5, 5, 5, 5)) -> Warehouse:
    """Return a world with so many orders in the backlog."""
    return small_world({str(i): ["a"] for i in range(orders)}, {"p": ["a"]}, capacities=capacities)


def active(rule: Any, warehouse: Warehouse) -> list[int]:
    """Ask a rule, activate what it says, and return that."""
    chosen = list(rule.activate_stations(WarehouseView(warehouse)))
    for station in warehouse.stations:
        warehouse.activate(station, station.id in chosen)
    return chosen


def test_all_is_all() -> None:
    """Also those that their timetables have closed: these open by themselves."""
    closed = world()
    closed.staff(closed.stations[2], False, None)
    assert active(All(), closed) == [0, 1, 2, 3]


@pytest.mark.parametrize(("ratio", "expected"), [(1.0, 4), (0.75, 3), (0.74, 2), (0.5, 2), (0.25, 1), (0.1, 1)])
def test_a_share_of_the_stations_is_rounded_down_but_never_to_none(ratio: float, expected: int) -> None:
    """The first ones, where all are equally large."""
    assert active(ConstantRatio(ratio), world()) == list(range(expected))


def test_the_share_is_that_of_the_stations_that_are_staffed_the_largest_first() -> None:
    """Of three, half is one; so no order waits for a station that could take it and stays closed."""
    warehouse = world(capacities=(5, 5, 9, 7))
    warehouse.staff(warehouse.stations[2], False, None)
    assert active(ConstantRatio(), warehouse) == [3]


def test_a_long_backlog_opens_a_station_and_little_to_do_closes_one() -> None:
    """One at a time, and then not again for ten minutes."""
    warehouse, rule = world(orders=12), BacklogThreshold(open_above=10, least=2)
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


def test_one_more_is_opened_when_the_others_are_busy() -> None:
    """More than ten orders wait, and two of two stations are full."""
    warehouse, rule = world(orders=30), BacklogThreshold(open_above=10)
    for i, order in enumerate(warehouse.orders[:10]):
        warehouse.assign(order, warehouse.stations[i // 5], [0])
    for station in warehouse.stations[2:]:
        warehouse.activate(station, False)
    assert active(rule, warehouse) == [0, 1, 2]


def test_when_a_shift_begins_some_stations_are_active_at_once() -> None:
    """All that are left of the last shift have gone home."""
    warehouse = world()
    for station in warehouse.stations:
        warehouse.staff(station, station.id >= 2, None)
        warehouse.activate(station, station.id < 2)
    assert active(BacklogThreshold(), warehouse) == [0, 1, 2]


def test_an_instance_forgets_the_run_before() -> None:
    """Its next run may change a station at time 0."""
    warehouse, rule = world(), BacklogThreshold()
    warehouse.advance(700_000)
    assert active(rule, warehouse) == [0, 1, 2]
    rule.run_started()
    assert active(rule, world()) == [0, 1, 2]


def test_stations_close_when_there_is_little_to_do_and_open_again() -> None:
    """In a whole run: fewer station hours than with all of them, and every order complete."""
    overrides = ["instance.orders=40", "instance.arrivals={process='poisson', orders_per_hour=60}"]
    rule = "rules.activate={rule='backlog-threshold', open_above=1, timeout_s=60}"
    all_of_them = rmfs_core.run("examples/small", overrides=[*overrides, "rules.activate=all"])
    by_load = rmfs_core.run("examples/small", overrides=[*overrides, rule])
    assert all_of_them.status == by_load.status == "complete"
    assert (by_load.metrics["station_open_h"] or 0) < 0.8 * (all_of_them.metrics["station_open_h"] or 0)


@pytest.mark.slow
@pytest.mark.parametrize("rule", [All(), ConstantRatio(), BacklogThreshold(open_above=2, timeout_s=10)])
def test_it_conforms(rule: object) -> None:
    """No order starves in any small world."""
    check_rule(rule)
