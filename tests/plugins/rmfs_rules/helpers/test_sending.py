"""Pods for the stations that lack one, and how far they drive."""

from collections.abc import Mapping, Sequence

import pytest

from rmfs_commands.testing import small_world
from rmfs_core.decisions import PodTrip
from rmfs_core.warehouse import Pod, Station, Warehouse, WarehouseView
from rmfs_rules.helpers import nearest_free_location, send_pods, ticks_to_station
from standing import put_at_station


def busy(pods: dict[str, list[str]], *wanted: list[str]) -> Warehouse:
    world = small_world(
        {str(i): skus for i, skus in enumerate(wanted)}, pods, capacities=[9] * len(wanted), robots=len(wanted)
    )
    for order, station in zip(world.orders, world.stations, strict=True):
        world.assign(order, station, [line.sku for line in order.open_lines])
    return world


def first(station: Station, pods: Sequence[Pod], wanted: Mapping[int, int]) -> Pod:
    return pods[0]


def trips(found: list[PodTrip]) -> list[tuple[int, int]]:
    return [(one.pod, one.station) for one in found]


def test_the_station_with_fewest_pods_chooses_next() -> None:
    """Then the one with most uncovered requests, then the lowest id."""
    world = WarehouseView(busy({"p": ["a"], "q": ["b"], "r": ["c"], "s": ["d"]}, ["a", "b"], ["c", "d"]))
    assert trips(send_pods(world, 9, first)) == [(0, 0), (2, 1), (1, 0), (3, 1)]
    world = WarehouseView(busy({"p": ["a"], "q": ["b"], "r": ["c"]}, ["a"], ["b", "c"]))
    assert trips(send_pods(world, 9, first)) == [(1, 1), (0, 0), (2, 1)]


def test_no_more_stored_pods_are_sent_than_robots_can_fetch() -> None:
    """A pod that leaves a station needs no robot, but goes to one other station only."""
    world = busy({"p": ["c"], "q": ["a"]}, ["a"], ["c"], ["c"])
    assert trips(send_pods(WarehouseView(world), 1, first)) == [(1, 0)]
    put_at_station(world, 0, 0)
    assert trips(send_pods(WarehouseView(world), 0, first)) == [(0, 1)]
    assert trips(send_pods(WarehouseView(world), 1, first)) == [(0, 1), (1, 0)]


def test_only_pods_that_serve_an_uncovered_request_are_offered() -> None:
    """By id, not those that are bound for somewhere already, with what no pod serves yet: also none sent just now."""
    world = busy({"p": ["x"], "q": ["a"], "r": ["a", "b"], "s": ["b", "c"], "t": ["a"]}, ["a", "b", "c"])
    world.bind(world.pods[4], world.stations[0])  # covers a
    sku = {name: line.sku for name, line in zip("abc", world.orders[0].lines, strict=True)}
    offered: list[tuple[list[int], dict[int, int]]] = []

    def choose(station: Station, pods: Sequence[Pod], wanted: Mapping[int, int]) -> Pod:
        offered.append(([pod.id for pod in pods], dict(wanted)))
        return pods[0]

    assert trips(send_pods(WarehouseView(world), 9, choose)) == [(2, 0), (3, 0)]
    assert offered == [([2, 3], {sku["b"]: 1, sku["c"]: 1}), ([3], {sku["c"]: 1})]


def test_the_way_to_a_station_is_timed_with_the_pod() -> None:
    """From where the pod is, with the heading that is best for it."""
    world = WarehouseView(small_world({}, {"p": ["a"]}, capacities=(6, 4)))
    pod = world.pods[0]
    for station in world.stations:
        ways = [world.travel.ticks(pod.cell, heading, station.cell, True) for heading in range(4)]
        assert ticks_to_station(world, pod, station) == min(ways) < max(ways)


def test_a_pod_goes_to_the_free_location_its_robot_reaches_first() -> None:
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
