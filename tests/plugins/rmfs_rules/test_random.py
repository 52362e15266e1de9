from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.stats import chi2_contingency

from rmfs_commands.testing import small_world
from rmfs_core.clock import TICKS_PER_S
from rmfs_core.roles import Role
from rmfs_core.warehouse import WarehouseView
from rmfs_rules.helpers import assign_best_pairs
from rmfs_rules.random import Random
from standing import put_at_station


def about_equal(drawn: Counter[object], number: int) -> bool:
    """Whether so many things were each drawn 100 times on average, give or take 4.5 standard deviations."""
    return len(drawn) == number and all(55 <= times <= 145 for times in drawn.values())


def test_every_free_location_is_equally_likely() -> None:
    """47 places in 4,700 draws; occupied ones never."""
    world = small_world({}, {"p": ["a"], "q": ["a"]})
    put_at_station(world, 0, 0)
    rng = np.random.default_rng(1)
    view = WarehouseView(world)
    drawn = Counter(Random().choose_storage_location(view, rng) for _ in range(100 * len(world.free_locations)))
    assert sorted(drawn) == world.free_locations
    assert about_equal(drawn, len(world.free_locations))


def test_pairs_of_order_and_station_are_equally_likely() -> None:
    orders = {"1": {"a": 2}, "2": {"a": 1}, "3": {"a": 3}}
    view = WarehouseView(small_world(orders, {"p": ["a"]}, capacities=[2, 3]))
    rng = np.random.default_rng(2)
    first = Counter((one.order, one.station) for one, *_ in (Random().assign_orders(view, rng) for _ in range(500)))
    assert about_equal(first, 5)
    assert (2, 0) not in first
    view = WarehouseView(small_world({str(i): ["a"] for i in range(9)}, {"p": ["a"]}, capacities=[2, 3]))
    for seed in range(20):
        found = Random().assign_orders(view, np.random.default_rng(seed))
        assert Counter(one.station for one in found) == {0: 2, 1: 3}


def test_pods_and_tasks_are_equally_likely() -> None:
    world = small_world({"1": ["a"]}, {"p": ["a"], "x": ["b"], "q": ["a", "b"], "r": ["a"]})
    world.assign(world.orders[0], world.stations[0], [0])
    rng = np.random.default_rng(3)
    view = WarehouseView(world)
    drawn = Counter(Random().select_pods(view, 1, rng)[0].pod for _ in range(300))
    assert about_equal(drawn, 3)
    assert 1 not in drawn
    world = small_world({}, {"p": ["a"], "q": ["a"], "r": ["a"]})
    for pod in world.pods:
        world.bind(pod, world.stations[0])
    rng = np.random.default_rng(4)
    tasks = [Random().assign_tasks(WarehouseView(world), rng) for _ in range(300)]
    assert all(len(given) == 2 and len({task.pod for task in given}) == 2 for given in tasks)
    assert about_equal(Counter((task.robot, task.pod) for given in tasks for task in given), 6)


@pytest.mark.parametrize("role", [Role.POA, Role.PPS, Role.PR, Role.TA])
def test_the_same_stream_gives_the_same_decisions(role: Role) -> None:
    world = small_world({str(i): ["a"] for i in range(9)}, {str(i): ["a"] for i in range(9)}, capacities=[3, 3])
    world.assign(world.orders[0], world.stations[0], [0])
    for pod in world.pods[:4]:
        world.bind(pod, world.stations[1])
    view, rule = WarehouseView(world), Random()
    ask: dict[Role, Callable[[np.random.Generator], object]] = {
        Role.POA: lambda rng: rule.assign_orders(view, rng),
        Role.PPS: lambda rng: rule.select_pods(view, 3, rng),
        Role.PR: lambda rng: rule.choose_storage_location(view, rng),
        Role.TA: lambda rng: rule.assign_tasks(view, rng),
    }
    first, second = ([ask[role](rng) for _ in range(5)] for rng in (np.random.default_rng(7), np.random.default_rng(7)))
    assert first == second
    assert any(answer != first[0] for answer in first)


ORDERS = {"two": {"a": 2}, "one": ["a"], "both": ["a", "b"], "many": {"b": 7}, "three": {"a": 3}}
"""Of which `many` is larger than any station."""


@pytest.mark.parametrize("counts", [False, True], ids=["items", "orders"])
@pytest.mark.parametrize(("now_s", "max_wait_s"), [(0, None), (700, None), (50, 60), (60, 60)], ids=str)
def test_decisions_are_as_likely_as_those_of_lots(counts: bool, now_s: int, max_wait_s: float | None) -> None:
    """Whole decisions, by chi-square against those of `assign_best_pairs` with a lot for each pair as its score."""
    world = small_world(ORDERS, {"p": ["a", "b"]}, capacities=[2, 3], counts_orders=counts)
    world.advance(now_s * TICKS_PER_S)
    view, rng = WarehouseView(world), np.random.default_rng(5)

    def lots(_station: Any) -> Any:
        return rng.integers(1 << 62, size=len(ORDERS))

    def drawn() -> tuple[Any, ...]:
        return tuple(Random(max_wait_s).assign_orders(view, rng))

    def plain() -> tuple[Any, ...]:
        return tuple(assign_best_pairs(view, lots, max_wait_s=max_wait_s))

    times = [Counter(decide() for _ in range(3000)) for decide in (drawn, plain)]
    often = [decision for decision in times[1] if times[1][decision] >= 10]
    table = [[of[decision] for decision in often] + [3000 - sum(of[decision] for decision in often)] for of in times]
    assert len(often) > 2
    assert chi2_contingency(np.array(table)[:, np.any(table, axis=0)]).pvalue > 0.001
