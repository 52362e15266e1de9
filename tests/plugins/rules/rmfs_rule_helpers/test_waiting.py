"""Orders that wait: those larger than any station, and with `max_wait_s` all others."""

from __future__ import annotations

import pytest

from rmfs_common_lines import CommonLines
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_first_come import FirstCome
from rmfs_pod_match import PodMatch
from rmfs_rule_helpers import OVERSIZE_WAIT_S
from rmfs_testing import small_world

RULES = pytest.mark.parametrize("rule", [PodMatch, CommonLines, FirstCome])


def world_of(orders: dict[str, dict[str, int]], begun: dict[str, int], now_s: float) -> Warehouse:
    """Return a world with two stations of four and six places, and some orders assigned already."""
    world = small_world(orders, {"p": ["a"]}, capacities=[4, 6])
    for name, station in begun.items():
        order = next(order for order in world.orders if order.name == name)
        world.assign(order, world.stations[station], [line.sku for line in order.open_lines])
    world.now = int(now_s * 1000)
    return world


def decide(world: Warehouse, rule: PodMatch | CommonLines | FirstCome) -> list[tuple[str, int]]:
    """Return (order's name, station) of each assignment."""
    return [(world.orders[one.order].name, one.station) for one in rule.assign_orders(WarehouseView(world))]


LARGE = {"large": {"a": 9}, "x": {"a": 1}, "y": {"a": 3}, "1": {"a": 1}, "2": {"a": 1}, "3": {"a": 1}, "4": {"a": 1}}


@RULES
def test_an_order_larger_than_any_station_goes_to_an_empty_one(rule) -> None:
    """It takes all of it; the others go elsewhere."""
    assert ("large", 1) in decide(world_of(LARGE, {"x": 0}, 0), rule())


@RULES
def test_it_waits_for_a_while(rule) -> None:
    """Until then, stations take what fits beside what they have."""
    decided = decide(world_of(LARGE, {"x": 0, "y": 1}, OVERSIZE_WAIT_S - 1), rule())
    assert {name for name, _ in decided} == {"1", "2", "3", "4"}
    assert {station for _, station in decided} == {0, 1}


@RULES
def test_then_one_station_takes_nothing_else_until_it_is_empty(rule) -> None:
    """The one that is nearest to being empty."""
    world = world_of(LARGE, {"x": 0, "y": 1}, OVERSIZE_WAIT_S)
    assert {station for _, station in decide(world, rule())} == {1}
    world = world_of(LARGE, {"y": 1}, OVERSIZE_WAIT_S)
    assert decide(world, rule())[0] == ("large", 0)


@RULES
def test_one_station_at_a_time_is_emptied(rule) -> None:
    """A second order of the kind waits for the first."""
    world = world_of({**LARGE, "larger": {"a": 12}}, {"x": 0, "y": 1}, OVERSIZE_WAIT_S)
    assert {station for _, station in decide(world, rule())} == {1}


FULL = {"big": {"a": 4}, "x": {"a": 3}, "y": {"a": 3}, "1": {"a": 1}, "2": {"a": 1}, "3": {"a": 1}, "4": {"a": 1}}


@RULES
@pytest.mark.parametrize("max_wait_s", [None, 61.0])
def test_orders_wait_as_long_as_it_takes(rule, max_wait_s: float | None) -> None:
    """Smaller ones fill the places that would add up to room for a larger one."""
    decided = decide(world_of(FULL, {"x": 0, "y": 1}, 60), rule(max_wait_s=max_wait_s))
    assert sorted(name for name, _ in decided) == ["1", "2", "3", "4"]


@RULES
def test_with_a_limit_a_station_keeps_its_places_for_them(rule) -> None:
    """The second station needs one place more for the order, the first three; only the first takes others."""
    world = world_of(FULL, {"x": 0, "y": 1}, 60)
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
