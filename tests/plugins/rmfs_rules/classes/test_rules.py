"""PR rules station-based, turnover-classes, cache and utility, against their definitions in plain Python."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import rmfs_core
from rmfs_commands.testing import check_rule, small_layout, small_world
from rmfs_core import hookimpl
from rmfs_core.info import Question
from rmfs_core.roles import Role
from rmfs_core.warehouse import Pod, Warehouse, WarehouseView
from rmfs_rules.classes import Cache, StationBased, TurnoverClasses, Utility
from rmfs_rules.classes.places import Places

PutAtStation = Callable[[Warehouse, int, int], None]
SKUS = "abcdefgh"


@pytest.fixture
def leaving(put_at_station: PutAtStation) -> Callable[[int], Warehouse]:
    """Return a function that makes a random world in which pod 0 is at one of two stations."""

    def make(seed: int) -> Warehouse:
        rng = np.random.default_rng(seed)
        layout = small_layout(2)
        number = int(rng.integers(4, len(layout.storage_locations) - 3))

        def some() -> list[str]:
            return [str(sku) for sku in rng.choice(list(SKUS), int(rng.integers(1, 4)), replace=False)]

        orders = {str(i): some() for i in range(int(rng.integers(0, 12)))}
        world = small_world(orders, {str(i): some() for i in range(number)}, capacities=[9, 9])
        put_at_station(world, 0, int(rng.integers(2)))
        return world

    return make


def drive(world: Warehouse, cell: int) -> int:
    """Driving time with a pod from a cell to the nearest station."""
    return min(int(world.travel.times_to(station.cell, True)[cell].min()) for station in world.stations)


def trip(world: Warehouse, cell: int) -> int:
    """Driving time of pod 0 to a cell."""
    return world.travel.ticks(world.pods[0].cell, world.robots[0].heading, cell, True)


def decide(world: Warehouse, rule: Any) -> int:
    """Return where pod 0 is stored."""
    chosen = rule.choose_storage_location(WarehouseView(world), world.pods[0])
    assert type(chosen) is int
    return chosen


def wanted(world: Warehouse, pod: Pod) -> tuple[int, int]:
    """Items ordered of the pod's SKUs, which are the items wanted now: none was picked, and stock is unlimited."""
    skus = [sku for order in world.orders for sku, _ in order.lines]
    number = sum(skus.count(sku) for sku in pod.contents)
    return number, number


@pytest.mark.parametrize("seed", range(20))
def test_station_based(seed: int, leaving: Callable[[int], Warehouse]) -> None:
    """No free place has a shorter drive to any station; of equal ones none is nearer to the pod."""
    world = leaving(seed)
    best = min(world.free_locations, key=lambda cell: (drive(world, cell), trip(world, cell), cell))
    assert decide(world, StationBased()) == best


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("borders", [(0.1, 0.3, 1.0), (0.4, 0.6, 0.8, 1.0), (1.0,)])
def test_turnover_classes(seed: int, borders: tuple[float, ...], leaving: Callable[[int], Warehouse]) -> None:
    """Class by class, from the pod's own to both sides."""
    world = leaving(seed)

    def cut(ranked: list[int]) -> dict[int, int]:
        ends = [math.floor(border * len(ranked)) for border in borders[:-1]]
        return {one: sum(rank >= end for end in ends) for rank, one in enumerate(ranked)}

    cells = sorted(world.travel.layout.storage_locations)
    places = cut(sorted(cells, key=lambda cell: (drive(world, cell), cell)))
    own = cut(sorted(range(len(world.pods)), key=lambda pod: (-wanted(world, world.pods[pod])[0], pod)))[0]
    sequence = [own]
    for away in range(1, len(borders)):
        sequence += [own + away, own - away]
    free = next(found for one in sequence if (found := [cell for cell in world.free_locations if places[cell] == one]))
    assert decide(world, TurnoverClasses(borders)) == min(free, key=lambda cell: (trip(world, cell), cell))


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("threshold", [0.0, 0.5, 0.9, 9.0])
def test_cache(seed: int, threshold: float, leaving: Callable[[int], Warehouse]) -> None:
    """Into the cache of the station if it is empty enough, or the pod is wanted more than those there."""
    world = leaving(seed)
    station = world.pods[0].bound_for[0]
    places = Places.of(WarehouseView(world))
    owner = dict(zip(places.cells.tolist(), places.caches(0.3).tolist(), strict=True))
    cache = [cell for cell in owner if owner[cell] == station]
    there = [pod for pod in world.pods if pod.location in cache]
    free = sum(cell in world.free_locations for cell in cache) / len(cache)
    less = sum(wanted(world, pod) < wanted(world, world.pods[0]) for pod in there) / len(there) if there else 1
    belongs = (free + less) / 2 > threshold

    def rank(cell: int) -> int:
        if belongs:
            return 0 if owner[cell] == station else 1 if owner[cell] < 0 else 2
        return 0 if owner[cell] < 0 else 1

    best = min(world.free_locations, key=lambda cell: (rank(cell), trip(world, cell), cell))
    assert decide(world, Cache(share=0.3, threshold=threshold)) == best


def test_without_a_cache_a_pod_goes_to_the_nearest_place(leaving: Callable[[int], Warehouse]) -> None:
    """As under the rule `nearest`."""
    world = leaving(1)
    assert decide(world, Cache(share=0)) == min(world.free_locations, key=lambda cell: (trip(world, cell), cell))


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize(("corridor", "buffer"), [(1, 0.0), (3, 0.05), (6, 0.2)])
def test_utility(seed: int, corridor: int, buffer: float, leaving: Callable[[int], Warehouse]) -> None:
    """Ranks are gone through from the pod's own, the better one first, until enough were seen and a place is found."""
    world = leaving(seed)
    ranked = sorted(range(len(world.pods)), key=lambda pod: (-wanted(world, world.pods[pod])[0], pod))
    cells = sorted(world.travel.layout.storage_locations)
    drives = sorted(drive(world, cell) for cell in cells)
    at = math.floor(ranked.index(0) / len(ranked) * (len(ranked) + buffer * len(cells)))
    ranks = sorted(set(drives))
    own = ranks.index(drives[min(at, len(drives) - 1)])
    found: list[int] = []
    seen = 0
    while seen < corridor or not found:
        rank = own + (-1 if seen % 2 else 1) * ((seen + 1) // 2)
        seen += 1
        found += [c for c in world.free_locations if 0 <= rank < len(ranks) and drive(world, c) == ranks[rank]]
    best = min(found, key=lambda cell: (trip(world, cell), cell))
    assert decide(world, Utility(corridor=corridor, buffer=buffer)) == best


def test_speed_and_demand_can_be_told_apart(put_at_station: PutAtStation) -> None:
    """Nothing of `a` is open any more: by speed pod 0 comes before pod 1, by demand after it."""
    world = small_world({"1": {"a": 3}, "2": {"b": 1}}, {"p": ["a"], "q": ["b"]})
    world.assign(world.orders[0], world.stations[0], [0])
    put_at_station(world, 0, 0)
    for request in world.stations[0].open_requests:
        world.fulfil(request, world.pods[0])
    best = min(world.free_locations, key=lambda cell: (drive(world, cell), trip(world, cell)))
    fast = Utility(weight_speed=1, weight_demand=0, corridor=1, buffer=1)
    slow = Utility(weight_speed=0, weight_demand=1, corridor=1, buffer=1)
    assert drive(world, decide(world, fast)) == drive(world, best) < drive(world, decide(world, slow))


@pytest.mark.parametrize(
    ("rule", "wrong"),
    [
        (Cache, {"share": 1.5}),
        (Cache, {"threshold": -1}),
        (Utility, {"corridor": 0}),
        (Utility, {"buffer": -0.1}),
        (Utility, {"weight_speed": -1}),
    ],
)
def test_wrong_parameters_are_refused(rule: type[Any], wrong: dict[str, float]) -> None:
    """Before the run."""
    (name,) = wrong
    with pytest.raises(ValueError, match=f"'{name}' must be"):
        rule(**wrong)


def test_a_large_cache_conforms() -> None:
    """Every place belongs to one."""
    assert check_rule(Cache(share=1.0, threshold=0.1)).findings == ()


class Doubter:
    """Observer that has each place chosen once more, by a rule that remembers nothing."""

    def __init__(self, rule: type[Any]) -> None:
        self.rule, self.places = rule, 0

    @hookimpl
    def rule_answered(self, question: Question, answer: Any) -> None:
        """Compare."""
        if question.decides is Role.PR:
            assert answer == self.rule().choose_storage_location(question.warehouse, question.arguments["pod"])
            self.places += 1


@pytest.mark.parametrize("rule", [TurnoverClasses, Cache, Utility])
@pytest.mark.parametrize("scenario", ["examples/small", "examples/replenished"])
def test_what_is_kept_decides_as_what_is_read_anew(rule: type[Any], scenario: str) -> None:
    """In whole runs: orders arrive, and pods come and go, are moved, and are given SKUs that they never held."""
    doubter = Doubter(rule)
    rules = {"pr": (chosen := rule()), **({"move": chosen} if hasattr(chosen, "move_pods") else {})}
    overrides = ["run.until_s=3000", "rules.pp=free-flow", "robots.count=8"]
    rmfs_core.run(scenario, overrides=overrides, rules=rules, observers=[doubter])
    assert doubter.places > 10
