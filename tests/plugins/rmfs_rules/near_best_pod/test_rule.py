"""POA rule near-best-pod; test_oracles.py has it on random worlds."""

from __future__ import annotations

import numpy as np

from rmfs_commands.testing import small_layout, small_world
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.near_best_pod import NearBestPod


def decide(world: Warehouse) -> list[tuple[str, int]]:
    """Return (order's name, station) of each assignment."""
    given = NearBestPod().assign_orders(WarehouseView(world), np.random.default_rng(0))
    return [(world.orders[one.order].name, one.station) for one in given]


def between(pods: dict[str, list[str]], **orders: list[str]) -> Warehouse:
    """Return a world of two stations, in which the first pod is nearest to station 0 and the last one to station 1."""
    places = len(small_layout(2).storage_locations)
    fill = {f"empty {i}": ["z"] for i in range(places - len(pods) - 2)}
    (first, held), *others = pods.items()
    world = small_world(orders, {first: held, **fill, **dict(others)}, capacities=[9, 9])
    times = [world.travel.times_to(station.cell, True) for station in world.stations]
    near, far = ([int(table[pod.cell].min()) for table in times] for pod in (world.pods[0], world.pods[-1]))
    assert near[0] < near[1]
    assert far[1] < far[0]
    return world


def test_an_order_goes_where_its_best_pod_is_near() -> None:
    """Order 1 has two items on the far pod and one on the near one; order 2 has its only one on the near one."""
    world = between({"near": ["a", "c"], "far": ["a", "b"]}, one=["a", "b"], two=["c"])
    assert decide(world) == [("one", 1), ("two", 0)]


def test_of_equally_good_pods_the_one_that_is_nearest_to_a_station_counts() -> None:
    """Both pods have the item."""
    world = between({"near": ["a"], "far": ["a"]}, one=["a"])
    times = [world.travel.times_to(station.cell, True) for station in world.stations]
    drives = {(s, pod.id): int(times[s][pod.cell].min()) for s in (0, 1) for pod in (world.pods[0], world.pods[-1])}
    assert decide(world) == [("one", min(drives, key=lambda pair: drives[pair])[0])]


def test_pods_in_use_do_not_count() -> None:
    """The far pod is on its way to station 0 already; the near one is as good as any then."""
    world = between({"near": ["a"], "far": ["a", "b"]}, one=["a", "b"])
    assert decide(world) == [("one", 1)]
    world.bind(world.pods[-1], world.stations[0])
    assert decide(world) == [("one", 0)]


def test_an_order_that_no_free_pod_has_goes_to_the_lowest_load() -> None:
    """As if all stations were equally near."""
    world = between({"near": ["c"], "far": ["a"]}, begun=["c"], one=["a"])
    world.assign(world.orders[0], world.stations[0], [line.sku for line in world.orders[0].open_lines])
    world.bind(world.pods[-1], world.stations[0])
    assert decide(world) == [("one", 1)]
