"""Rules that select pods for open requests."""

from __future__ import annotations

from typing import Any

from rmfs_commands.testing import small_world
from rmfs_core.decisions import PodTrip
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.demand import Demand
from rmfs_rules.nearest_pod import NearestPod
from standing import put_at_station


def decide(world: Warehouse, rule: Any, max_fetches: int = 9) -> list[tuple[str, int]]:
    """Return (pod's name, station) of each trip."""
    return [(world.pods[one.pod].name, one.station) for one in rule.select_pods(WarehouseView(world), max_fetches)]


NINE_PODS = {"p0": ["a"], **{f"p{i}": ["z"] for i in range(1, 8)}, "p8": ["a"]}
"""Pods p0 and p8 hold `a`; p8, in the second row, is nearer to the station (14.9 s against 19.0 s)."""


def assign(world: Warehouse, *pairs: tuple[int, int]) -> None:
    """Assign whole orders to stations: (order, station)."""
    for order, station in pairs:
        skus = [line.sku for line in world.orders[order].open_lines]
        world.assign(world.orders[order], world.stations[station], skus)


def test_the_demand_of_the_whole_system_counts() -> None:
    world = small_world({"1": ["a"], "2": ["b"]}, {"p": ["a", "c"], "q": ["a", "b"]})
    assign(world, (0, 0))
    assert decide(world, Demand()) == [("q", 0)]


def test_a_pod_must_serve_an_uncovered_request() -> None:
    world = small_world({"1": ["a"], "2": ["b"], "3": ["b"]}, {"p": ["a"], "q": ["b"], "r": ["a", "b"]})
    assign(world, (0, 0))
    world.bind(world.pods[2], world.stations[0])
    assert decide(world, Demand()) == []


def test_no_more_than_the_items_on_the_pod_count() -> None:
    world = small_world({"1": {"a": 5}, "2": ["b"]}, {"p": {"a": 1, "b": 9}, "q": {"a": 3}})
    assign(world, (0, 0))
    assert decide(world, Demand(), 1) == [("q", 0)]


def test_what_was_picked_no_longer_counts() -> None:
    orders = {"1": ["a"], "2": {"a": 2}, "3": ["b"], "4": {"a": 9}}
    world = small_world(orders, {"p": {"a": 3}, "q": {"a": 1, "b": 1}}, capacities=[9, 9])
    rule, view = Demand(), WarehouseView(world)
    assign(world, (0, 1))
    assert rule.select_pods(view, 1) == [PodTrip(0, 1)]
    assign(world, (1, 0))
    put_at_station(world, 0, 0)
    for request in world.stations[0].open_requests:
        world.fulfil(request, world.pods[0])
    assert rule.select_pods(view, 1) == [PodTrip(1, 1)]


def test_ties_go_to_the_nearer_pod() -> None:
    world = small_world({"1": ["a"]}, NINE_PODS)
    assign(world, (0, 0))
    assert decide(world, Demand()) == [("p8", 0)]


def test_pods_follow_until_every_request_is_served() -> None:
    world = small_world({"1": {"a": 3}}, {"p": {"a": 1}, "q": {"a": 2}, "r": {"a": 1}})
    assign(world, (0, 0))
    assert decide(world, Demand()) == [("q", 0), ("p", 0)]


def test_at_most_max_fetches_pods_leave_their_places() -> None:
    world = small_world(
        {"1": ["a", "b"], "2": ["c", "d"]}, {"p": ["a"], "q": ["b"], "r": ["c"], "s": ["d"]}, capacities=[9, 9]
    )
    assign(world, (0, 0), (1, 1))
    assert decide(world, Demand(), 2) == [("p", 0), ("r", 1)]
    assert decide(world, Demand(), 3) == [("p", 0), ("r", 1), ("q", 0)]
    assert decide(world, Demand(), 0) == []


def test_the_station_with_fewest_inbound_pods_then_most_uncovered_requests_chooses_first() -> None:
    orders = {"1": ["a"], "2": ["a", "b"], "3": ["x"]}
    world = small_world(orders, {"p": ["a"], "q": ["x"]}, capacities=[9, 9])
    assign(world, (0, 0), (1, 1))
    assert decide(world, Demand()) == [("p", 1)]
    world.bind(world.pods[1], world.stations[1])
    assert decide(world, Demand()) == [("p", 0)]


def test_a_leaving_pod_goes_on_without_a_fetch() -> None:
    world = small_world({"1": ["a"], "2": ["b"]}, {"p": ["a"], "q": ["b"]}, capacities=[9, 9])
    put_at_station(world, 0, 0)
    assign(world, (0, 1), (1, 0))
    assert decide(world, Demand(), 0) == [("p", 1)]
    assert decide(world, Demand(), 1) == [("p", 1), ("q", 0)]


def test_a_leaving_pod_is_sent_once_in_a_decision() -> None:
    world = small_world({"1": ["a"], "2": ["a"]}, {"p": ["a"]}, capacities=[9, 9, 9])
    put_at_station(world, 0, 0)
    assign(world, (0, 1), (1, 2))
    assert decide(world, Demand()) == [("p", 1)]


NEAR_LAST = {"p0": ["a", "b"], **{f"p{i}": ["z"] for i in range(1, 8)}, "p8": ["a"]}
"""Pod p8, in the second row, is nearer to the station (14.9 s) than any other (19.0 s and more)."""


def test_the_nearest_pod_that_serves_a_request_is_sent() -> None:
    world = small_world({"1": ["a", "b"]}, NEAR_LAST)
    world.assign(world.orders[0], world.stations[0], [0, 1])
    assert decide(world, NearestPod(), 1) == [("p8", 0)]
    assert decide(world, NearestPod()) == [("p8", 0), ("p0", 0)]


def test_a_nearer_pod_in_use_is_no_candidate() -> None:
    world = small_world({"1": ["a"]}, NEAR_LAST, capacities=[9, 9])
    world.assign(world.orders[0], world.stations[0], [0])
    world.bind(world.pods[8], world.stations[1])
    assert decide(world, NearestPod()) == [("p0", 0)]


def test_a_leaving_pod_is_a_candidate() -> None:
    world = small_world({"1": ["a"]}, {"p": ["a"], "q": ["a"]}, capacities=[9, 9])
    put_at_station(world, 1, 1)
    world.assign(world.orders[0], world.stations[0], [0])
    times = world.travel.times_to(world.stations[0].cell, True)
    assert times[world.pods[1].cell].min() < times[world.pods[0].cell].min()
    assert decide(world, NearestPod()) == [("q", 0)]
