"""The compiled choice of orders against the plain one, and what orders lack."""

from __future__ import annotations

import numpy as np
import pytest

import plain_joint
from rmfs_commands.testing import small_world
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.helpers import assign_best_pairs
from rmfs_rules.joint.choosing import Chosen, Period, Sent
from rmfs_rules.joint.order_search import OUT

SKUS = [f"s{i}" for i in range(40)]


def large_world(seed: int) -> Warehouse:
    """Return a world with hundreds of orders, and pods bound for stations; stock is finite or not."""
    rng = np.random.default_rng(seed)
    orders = {
        str(i): {sku: int(rng.integers(1, 3)) for sku in rng.choice(SKUS, rng.integers(1, 4), False).tolist()}
        for i in range(400)
    }
    items = 4 if seed % 2 else None
    pods = {f"p{i}": dict.fromkeys(rng.choice(SKUS, 8, False).tolist(), items) for i in range(20)}
    pods["rest"] = dict.fromkeys(SKUS, None if items is None else 30)
    world = small_world(orders, pods, capacities=[12, 7, 9], counts_orders=seed % 3 == 0)  # type: ignore[arg-type]
    for station in world.stations:
        for pod in rng.choice(20, 2, False).tolist():
            world.bind(world.pods[pod], station)
    return world


@pytest.mark.parametrize("seed", range(6))
def test_the_cheapest(seed: int) -> None:
    """Fewest missing lines for each place, then the oldest, the lowest load, the lowest id."""
    view = WarehouseView(large_world(seed))
    left = plain_joint.Left(view, [(3, 0)])
    pairs = assign_best_pairs(view, left.score, left.take)
    assert Period(view, None).filled([(3, 0)]) == plain_joint.placed(view, pairs)


@pytest.mark.parametrize("seed", range(6))
def test_the_oldest(seed: int) -> None:
    """While stations have less than half their load."""
    view = WarehouseView(large_world(seed))
    until = np.array([0.5 * station.capacity for station in view.stations])
    expected = plain_joint.first_stage(view, 0.5, "oldest", None)
    assert Period(view, None).filled([], oldest=True, until=until) == expected


@pytest.mark.parametrize("seed", range(6))
def test_with_what_orders_lack_by_chance(seed: int) -> None:
    """Some orders are kept."""
    view = WarehouseView(large_world(seed))
    period = Period(view, None)
    kept = period.filled([])[::2]
    noise = np.random.default_rng(seed).integers(0, 500_000, (len(view.backlog), 3))
    expected = plain_joint.filled(view, kept, plain_joint.sizes_of(view), np.random.default_rng(seed))
    assert period.refilled(period.places, kept, period.pods_for(kept), noise) == expected


@pytest.mark.parametrize("seed", range(6))
def test_complete_orders(seed: int) -> None:
    """The oldest of which the pods at stations have all."""
    view = WarehouseView(large_world(seed))
    first = plain_joint.first_stage(view, 0.3, "cheapest", None)
    sent = plain_joint.pods_for(view, first)
    found = Period(view, None).completed(first, sent)
    assert found == plain_joint.second_stage(view, first, sent, None)
    assert found


def test_the_foremost() -> None:
    """Of each station those that lack least, oldest first, that go first to no station before it."""
    view = WarehouseView(large_world(3))
    period = Period(view, None)
    scores = [plain_joint.Left(view).score(station) for station in view.stations]
    for number in (0, 3, 90):
        expected: set[int] = set()
        for score in scores:
            ordered = [place for place in np.argsort(-score, kind="stable").tolist() if place not in expected]
            expected.update(ordered[: number // 3])
        assert period.foremost(number, [(395, 0)], []).tolist() == sorted(expected | {395})
    assert period.foremost(400, [(395, 0)], []).tolist() == [*range(400)]


def lacks(world: Warehouse, sent: Sent, chosen: Chosen) -> list[list[int]]:
    """Return the missing lines of each order at each station, when pods are sent and orders are chosen."""
    rows: list[list[int]] = Period(WarehouseView(world), None).choice(sent, chosen).lacks.tolist()
    return rows


def test_lines_are_missing_until_an_order_has_them_brought() -> None:
    """p is bound for station 0 and has a; b is missing everywhere, until order 2, chosen for station 0, wants it."""
    world = small_world({"1": ["a", "b"], "2": ["b"]}, {"p": ["a"], "q": ["b"]}, capacities=[5, 5])
    world.bind(world.pods[0], world.stations[0])
    assert lacks(world, [], []) == [[1, 1], [2, 1]]
    assert lacks(world, [], [(1, 0)]) == [[0, OUT], [2, OUT + 1]]
    assert lacks(world, [(1, 1)], []) == [[1, 1], [1, 0]]


def test_finite_stock_runs_out() -> None:
    """p has two items at the station: enough for 1 or for 2, and once one of them is chosen no pod has any for 3."""
    orders = {"1": {"a": 2}, "2": {"a": 1}, "3": {"a": 1, "b": 1}}
    world = small_world(orders, {"p": {"a": 2}, "q": {"b": 1}})
    world.bind(world.pods[0], world.stations[0])
    assert lacks(world, [], []) == [[0, 0, 1]]
    assert [missing >= OUT for missing in lacks(world, [], [(0, 0)])[0]] == [True, True, True]
