from typing import Any

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.demand import Demand
from rmfs_rules.nearest_pod import NearestPod
from standing import put_at_station


def decide(world: Warehouse, rule: Any, max_fetches: int = 9) -> list[tuple[str, int]]:
    return [(world.pods[one.pod].name, one.station) for one in rule.select_pods(WarehouseView(world), max_fetches)]


def assign(world: Warehouse, *pairs: tuple[int, int]) -> None:
    for order, station in pairs:
        skus = [line.sku for line in world.orders[order].open_lines]
        world.assign(world.orders[order], world.stations[station], skus)


def test_pods_are_sent_by_demand_or_distance() -> None:
    world = small_world({"1": ["a"], "2": ["b"]}, {"p": ["a", "c"], "q": ["a", "b"]})
    assign(world, (0, 0))
    assert decide(world, Demand()) == [("q", 0)]
    world = small_world({"1": ["a", "b"]}, NEAR_LAST)
    world.assign(world.orders[0], world.stations[0], [0, 1])
    assert decide(world, NearestPod(), 1) == [("p8", 0)]
    assert decide(world, NearestPod()) == [("p8", 0), ("p0", 0)]


def test_pods_that_leave_and_those_that_are_fetched() -> None:
    world = small_world(
        {"1": ["a", "b"], "2": ["c", "d"]}, {"p": ["a"], "q": ["b"], "r": ["c"], "s": ["d"]}, capacities=[9, 9]
    )
    assign(world, (0, 0), (1, 1))
    assert decide(world, Demand(), 2) == [("p", 0), ("r", 1)]
    assert decide(world, Demand(), 3) == [("p", 0), ("r", 1), ("q", 0)]
    assert decide(world, Demand(), 0) == []
    world = small_world({"1": ["a"], "2": ["b"]}, {"p": ["a"], "q": ["b"]}, capacities=[9, 9])
    put_at_station(world, 0, 0)
    assign(world, (0, 1), (1, 0))
    assert decide(world, Demand(), 0) == [("p", 1)]
    assert decide(world, Demand(), 1) == [("p", 1), ("q", 0)]


NEAR_LAST = {"p0": ["a", "b"], **{f"p{i}": ["z"] for i in range(1, 8)}, "p8": ["a"]}
"""Pod p8, in the second row, is nearer to the station (14.9 s) than any other (19.0 s and more)."""
