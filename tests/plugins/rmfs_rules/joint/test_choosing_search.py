"""The compiled choice of orders, over several blocks of them, against the plain one."""

from __future__ import annotations

import numpy as np
import pytest

import plain_joint
from rmfs_commands.testing import small_world
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.helpers import assign_best_pairs
from rmfs_rules.joint import choosing_search as work
from rmfs_rules.joint.choosing import Kept
from rmfs_rules.joint.lacking_search import BLOCK

SKUS = [f"s{i}" for i in range(40)]


def large_world(seed: int) -> Warehouse:
    """Return a world with more orders than two blocks have, and pods bound for stations; stock is finite or not."""
    rng = np.random.default_rng(seed)
    orders = {
        str(i): {sku: int(rng.integers(1, 3)) for sku in rng.choice(SKUS, rng.integers(1, 4), False).tolist()}
        for i in range(3 * BLOCK)
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
    assert Kept().period(view, None).filled([(3, 0)]) == plain_joint.placed(view, pairs)


@pytest.mark.parametrize("seed", range(6))
def test_the_oldest(seed: int) -> None:
    """While stations have less than half their load."""
    view = WarehouseView(large_world(seed))
    until = np.array([0.5 * station.capacity for station in view.stations])
    expected = plain_joint.first_stage(view, 0.5, "oldest", None)
    assert Kept().period(view, None).filled((), oldest=True, until=until) == expected


@pytest.mark.parametrize("seed", range(6))
def test_with_what_orders_lack_by_chance(seed: int) -> None:
    """Some orders are kept."""
    view = WarehouseView(large_world(seed))
    period = Kept().period(view, None)
    kept = period.filled(())[::2]
    noise = np.random.default_rng(seed).integers(0, 500_000, (len(view.backlog), 3))
    expected = plain_joint.filled(view, kept, plain_joint.sizes_of(view), np.random.default_rng(seed))
    assert period.refilled(kept, period.pods_for(kept), noise) == expected


@pytest.mark.parametrize("seed", range(6))
def test_complete_orders(seed: int) -> None:
    """The oldest of which the pods at stations have all."""
    view = WarehouseView(large_world(seed))
    first = plain_joint.first_stage(view, 0.3, "cheapest", None)
    sent = plain_joint.pods_for(view, first)
    found = Kept().period(view, None).completed(first, sent)
    assert found == plain_joint.second_stage(view, first, sent, None)
    assert found


def test_the_foremost() -> None:
    """Those that lack least, oldest first, as if each were taken and nothing changed by it."""
    view = WarehouseView(large_world(3))
    period = Kept().period(view, None)
    period.orders.let(period.pods.available(()))
    scores = np.max([plain_joint.Left(view).score(station) for station in view.stations], axis=0)
    expected = np.lexsort((np.arange(len(scores)), -scores))[:100].tolist()
    until, orders = np.full(3, np.inf), period.orders.kept
    assert work.foremost(100, period.empty, until, period.placed, np.inf, orders).tolist() == expected
    for place in expected:  # they are out of the question
        assert work.station_for(place, work.CHEAPEST, period.empty, until, period.placed, np.inf, orders) < 0
