"""Filter most-covered."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

import numpy as np
import pytest

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.most_covered import MostCovered


def kept(world: Warehouse, n: int, lines: str = "all") -> list[str]:
    """Return the names of the orders that the filter keeps."""
    view = WarehouseView(world)
    return [order.name for order in MostCovered(n, lines).filter_backlog(view, view.backlog)]


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


def test_lines_that_are_assigned_count_or_do_not() -> None:
    """Of `begun`, `a` is assigned and `b` open; with only `a` at a station its share is 1/2 of all, 0 of the open."""
    world = small_world({"begun": ["a", "b"], "third": ["a", "x", "y"]}, {"p": ["a"], "q": ["b", "x", "y"]})
    world.bind(world.pods[0], world.stations[0])
    assert kept(world, 1) == ["begun"]
    world.assign(world.orders[0], world.stations[0], [0], 1)
    assert kept(world, 1) == ["begun"]
    assert kept(world, 1, "open") == ["third"]


def test_behind_another_filter() -> None:
    """What another filter left is ranked, whatever else is in the backlog."""
    world = small_world({"1": ["a"], "2": ["b"], "3": ["a", "b"], "4": ["a"]}, {"p": ["a"], "q": ["b"]})
    world.bind(world.pods[0], world.stations[0])
    view = WarehouseView(world)
    assert [order.name for order in MostCovered(2).filter_backlog(view, view.backlog[1:])] == ["4", "3"]


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


def test_lines_have_to_be_all_or_open() -> None:
    """Other values are refused."""
    with pytest.raises(ValueError, match="'lines' must be in"):
        MostCovered(1, "some")
