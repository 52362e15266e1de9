"""Pods for the stations that lack one."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from rmfs_commands.testing import small_world
from rmfs_core.decisions import PodTrip
from rmfs_core.warehouse import Pod, Station, Warehouse, WarehouseView
from rmfs_rules.helpers import send_pods, ticks_to_station
from rmfs_rules.helpers.sending import held, may_send, nearest, ticks_from, worth


def busy(pods: dict[str, list[str]], *wanted: list[str]) -> Warehouse:
    """Return a world in which each station has one order of these SKUs."""
    world = small_world(
        {str(i): skus for i, skus in enumerate(wanted)}, pods, capacities=[9] * len(wanted), robots=len(wanted)
    )
    for order, station in zip(world.orders, world.stations, strict=True):
        world.assign(order, station, [line.sku for line in order.open_lines])
    return world


def first(station: Station, pods: list[Pod]) -> Pod:
    """Choose the first pod offered."""
    return pods[0]


def trips(found: list[PodTrip]) -> list[tuple[int, int]]:
    """Return (pod, station) of each trip."""
    return [(one.pod, one.station) for one in found]


def test_the_station_with_fewest_pods_chooses_next() -> None:
    """Then the one with most uncovered requests, then the lowest id."""
    world = WarehouseView(busy({"p": ["a"], "q": ["b"], "r": ["c"], "s": ["d"]}, ["a", "b"], ["c", "d"]))
    assert trips(send_pods(world, 9, first)) == [(0, 0), (2, 1), (1, 0), (3, 1)]
    world = WarehouseView(busy({"p": ["a"], "q": ["b"], "r": ["c"]}, ["a"], ["b", "c"]))
    assert trips(send_pods(world, 9, first)) == [(1, 1), (0, 0), (2, 1)]


def test_no_more_stored_pods_are_sent_than_robots_can_fetch(
    put_at_station: Callable[[Warehouse, int, int], None],
) -> None:
    """A pod that leaves a station needs no robot, but goes to one other station only."""
    world = busy({"p": ["c"], "q": ["a"]}, ["a"], ["c"], ["c"])
    assert trips(send_pods(WarehouseView(world), 1, first)) == [(1, 0)]
    put_at_station(world, 0, 0)
    assert trips(send_pods(WarehouseView(world), 0, first)) == [(0, 1)]
    assert trips(send_pods(WarehouseView(world), 1, first)) == [(0, 1), (1, 0)]


def test_only_pods_that_serve_an_uncovered_request_are_offered() -> None:
    """By id, and not those that are bound for somewhere already."""
    world = busy({"p": ["x"], "q": ["a"], "r": ["a", "b"], "s": ["b"], "t": ["a"]}, ["a", "b"])
    world.bind(world.pods[4], world.stations[0])  # covers a
    offered: list[list[int]] = []

    def choose(station: Station, pods: list[Pod]) -> Pod:
        offered.append([pod.id for pod in pods])
        return pods[-1]

    assert trips(send_pods(WarehouseView(world), 9, choose)) == [(3, 0)]
    assert offered == [[2, 3]]


@pytest.mark.parametrize(("wanted", "found"), [(["b"], False), (["c"], True)])
def test_without_a_robot_only_a_leaving_pod_may_be_sent(
    put_at_station: Callable[[Warehouse, int, int], None], wanted: list[str], found: bool
) -> None:
    """To another station that wants what it holds; what its own wants is not sent there."""
    world = busy({"p": ["c"], "q": ["b", "c"]}, ["a"], wanted)
    assert not may_send(WarehouseView(world), 0)
    put_at_station(world, 0, 0)
    assert may_send(WarehouseView(world), 0) == found
    assert may_send(WarehouseView(world), 1)


def test_the_nearest_pod_is_that_with_the_shortest_drive() -> None:
    """Loaded, whatever way its robot will face; ties go to the lowest id."""
    world = WarehouseView(small_world({}, {name: ["a"] for name in "pqrs"}))
    station, stock, pods = world.stations[0], world.stock, np.arange(4)
    ticks = [ticks_to_station(world, pod, station) for pod in world.pods]
    assert ticks_from(world, stock.cell, station).tolist() == ticks
    assert nearest(world, stock, pods, station) == ticks.index(min(ticks))
    assert nearest(world, stock, pods[2:3], station) == 2


def test_pods_are_worth_what_they_hold() -> None:
    """Items up to what is wanted; or a value for each SKU that is there."""
    stock = WarehouseView(small_world({}, {"p": {"a": 2, "b": 1}, "q": {"b": 4}})).stock
    assert worth(stock, np.arange(2), np.array([1, 3])).tolist() == [2, 3]
    assert held(stock, np.array([10, 5])).tolist() == [15, 5]
