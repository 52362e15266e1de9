"""PPS rule demand."""

from __future__ import annotations

from collections.abc import Callable

from rmfs_commands.testing import small_world
from rmfs_core.decisions import PodTrip
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.demand import Demand

NINE_PODS = {"p0": ["a"], **{f"p{i}": ["z"] for i in range(1, 8)}, "p8": ["a"]}
"""Pods p0 and p8 hold `a`; p8, in the second row, is nearer to the station (14.9 s against 19.0 s)."""


def decide(world: Warehouse, max_fetches: int = 9) -> list[tuple[str, int]]:
    """Return (pod's name, station) of each trip."""
    given = Demand().select_pods(WarehouseView(world), max_fetches)
    return [(world.pods[one.pod].name, one.station) for one in given]


def assign(world: Warehouse, *pairs: tuple[int, int]) -> None:
    """Assign whole orders to stations: (order, station)."""
    for order, station in pairs:
        skus = [line.sku for line in world.orders[order].open_lines]
        world.assign(world.orders[order], world.stations[station], skus)


def test_the_demand_of_the_whole_system_counts() -> None:
    """Both pods serve the request for `a`; `b` is wanted in the backlog, `c` by nobody."""
    world = small_world({"1": ["a"], "2": ["b"]}, {"p": ["a", "c"], "q": ["a", "b"]})
    assign(world, (0, 0))
    assert decide(world) == [("q", 0)]


def test_a_pod_must_serve_an_uncovered_request() -> None:
    """Much wanted is not enough, and what is covered needs no pod."""
    world = small_world({"1": ["a"], "2": ["b"], "3": ["b"]}, {"p": ["a"], "q": ["b"], "r": ["a", "b"]})
    assign(world, (0, 0))
    world.bind(world.pods[2], world.stations[0])
    assert decide(world) == []


def test_no_more_than_the_items_on_the_pod_count() -> None:
    """Five items of `a` are wanted: a pod with three has 3, one with a single `a` and a `b` has 2."""
    world = small_world({"1": {"a": 5}, "2": ["b"]}, {"p": {"a": 1, "b": 9}, "q": {"a": 3}})
    assign(world, (0, 0))
    assert decide(world, 1) == [("q", 0)]


def test_what_was_picked_no_longer_counts(put_at_station: Callable[[Warehouse, int, int], None]) -> None:
    """From one decision to the next: a pod with three items of `a` has one when two were picked from it."""
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
    """Both hold the same."""
    world = small_world({"1": ["a"]}, NINE_PODS)
    assign(world, (0, 0))
    assert decide(world) == [("p8", 0)]


def test_pods_follow_until_every_request_is_served() -> None:
    """Finite stock: two items are on the first pod, the third comes with another."""
    world = small_world({"1": {"a": 3}}, {"p": {"a": 1}, "q": {"a": 2}, "r": {"a": 1}})
    assign(world, (0, 0))
    assert decide(world) == [("q", 0), ("p", 0)]


def test_at_most_max_fetches_pods_leave_their_places() -> None:
    """Each station gets one before any gets two."""
    world = small_world(
        {"1": ["a", "b"], "2": ["c", "d"]}, {"p": ["a"], "q": ["b"], "r": ["c"], "s": ["d"]}, capacities=[9, 9]
    )
    assign(world, (0, 0), (1, 1))
    assert decide(world, 2) == [("p", 0), ("r", 1)]
    assert decide(world, 3) == [("p", 0), ("r", 1), ("q", 0)]
    assert decide(world, 0) == []


def test_the_station_with_fewest_inbound_pods_then_most_uncovered_requests_chooses_first() -> None:
    """Only one pod has `a`."""
    orders = {"1": ["a"], "2": ["a", "b"], "3": ["x"]}
    world = small_world(orders, {"p": ["a"], "q": ["x"]}, capacities=[9, 9])
    assign(world, (0, 0), (1, 1))
    assert decide(world) == [("p", 1)]
    world.bind(world.pods[1], world.stations[1])
    assert decide(world) == [("p", 0)]


def test_a_leaving_pod_goes_on_without_a_fetch(put_at_station: Callable[[Warehouse, int, int], None]) -> None:
    """It is nothing the robots are counted for, and its own station is no goal for it."""
    world = small_world({"1": ["a"], "2": ["b"]}, {"p": ["a"], "q": ["b"]}, capacities=[9, 9])
    put_at_station(world, 0, 0)
    assign(world, (0, 1), (1, 0))
    assert decide(world, 0) == [("p", 1)]
    assert decide(world, 1) == [("p", 1), ("q", 0)]


def test_a_leaving_pod_is_sent_once_in_a_decision(put_at_station: Callable[[Warehouse, int, int], None]) -> None:
    """Stations 2 and 3 both want what only it holds; the second has to wait."""
    world = small_world({"1": ["a"], "2": ["a"]}, {"p": ["a"]}, capacities=[9, 9, 9])
    put_at_station(world, 0, 0)
    assign(world, (0, 1), (1, 2))
    assert decide(world) == [("p", 1)]
