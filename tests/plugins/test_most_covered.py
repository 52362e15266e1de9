"""Filter most-covered."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

import numpy as np
import pytest
from rmfs_most_covered import MostCovered

from rmfs_core.testing import small_world
from rmfs_core.warehouse import Warehouse, WarehouseView


def kept(world: Warehouse, n: int) -> list[str]:
    """Return the names of the orders that the filter keeps."""
    view = WarehouseView(world)
    return [order.name for order in MostCovered(n).filter_backlog(view, view.backlog)]


def test_the_highest_share_wins_and_ties_go_to_the_older() -> None:
    """With `a` and `b` at a station, the shares are 1/2, 1, 0, 1 and 2/3."""
    orders = {"half": ["a", "x"], "all": ["b"], "none": ["x"], "all too": ["a", "b"], "most": ["a", "b", "y"]}
    world = small_world(orders, {"p": ["a", "b"], "q": ["x", "y"]})
    world.bind(world.pods[0], world.stations[0])
    assert kept(world, 1) == ["all"]
    assert kept(world, 4) == ["all", "all too", "most", "half"]
    assert kept(world, 9) == ["all", "all too", "most", "half", "none"]


def test_without_pods_at_stations_the_oldest_stay() -> None:
    """All shares are 0 then."""
    world = small_world({"1": ["a"], "2": ["b"], "3": ["a"]}, {"p": ["a", "b"]})
    assert kept(world, 2) == ["1", "2"]


@pytest.mark.parametrize("seed", range(30))
def test_brute_force_keeps_the_same(seed: int, put_at_station: Callable[[Warehouse, int, int], None]) -> None:
    """No order left out has a higher share, or the same and is older."""
    rng = np.random.default_rng(seed)
    skus = "abcdefgh"
    orders = {str(i): list(rng.choice(list(skus), rng.integers(1, 5), replace=False)) for i in range(12)}
    pods = {f"p{i}": list(rng.choice(list(skus), 2, replace=False)) for i in range(8)} | {"all": list(skus)}
    world = small_world(orders, pods, capacities=(15, 15), robots=4)
    put_at_station(world, 0, 0)
    world.bind(world.pods[1], world.stations[1])
    there = {*pods["p0"], *pods["p1"]}

    def rank(name: str) -> tuple[Fraction, int]:
        return -Fraction(sum(sku in there for sku in orders[name]), len(orders[name])), int(name)

    n = int(rng.integers(1, 13))
    assert kept(world, n) == sorted(orders, key=rank)[:n]


def test_n_has_to_be_positive() -> None:
    """A filter that keeps nothing would stop the run."""
    with pytest.raises(ValueError, match=r"'n' must be >= 1"):
        MostCovered(0)
