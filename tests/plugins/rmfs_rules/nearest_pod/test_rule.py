"""PPS rule nearest-pod."""

from __future__ import annotations

from collections.abc import Callable

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.nearest_pod import NearestPod

NINE_PODS = {"p0": ["a", "b"], **{f"p{i}": ["z"] for i in range(1, 8)}, "p8": ["a"]}
"""Pod p8, in the second row, is nearer to the station (14.9 s) than any other (19.0 s and more)."""


def decide(world: Warehouse, max_fetches: int = 9) -> list[tuple[str, int]]:
    """Return (pod's name, station) of each trip."""
    given = NearestPod().select_pods(WarehouseView(world), max_fetches)
    return [(world.pods[one.pod].name, one.station) for one in given]


def test_the_nearest_pod_that_serves_a_request_is_sent() -> None:
    """That p0 holds more of what is wanted does not matter; it brings what is left."""
    world = small_world({"1": ["a", "b"]}, NINE_PODS)
    world.assign(world.orders[0], world.stations[0], [0, 1])
    assert decide(world, 1) == [("p8", 0)]
    assert decide(world) == [("p8", 0), ("p0", 0)]


def test_a_nearer_pod_in_use_is_no_candidate() -> None:
    """p8 is bound for another station."""
    world = small_world({"1": ["a"]}, NINE_PODS, capacities=[9, 9])
    world.assign(world.orders[0], world.stations[0], [0])
    world.bind(world.pods[8], world.stations[1])
    assert decide(world) == [("p0", 0)]


def test_a_leaving_pod_is_a_candidate(put_at_station: Callable[[Warehouse, int, int], None]) -> None:
    """It stands at the next station, nearer than the one in the storage area."""
    world = small_world({"1": ["a"]}, {"p": ["a"], "q": ["a"]}, capacities=[9, 9])
    put_at_station(world, 1, 1)
    world.assign(world.orders[0], world.stations[0], [0])
    times = world.travel.times_to(world.stations[0].cell, True)
    assert times[world.pods[1].cell].min() < times[world.pods[0].cell].min()
    assert decide(world) == [("q", 0)]
