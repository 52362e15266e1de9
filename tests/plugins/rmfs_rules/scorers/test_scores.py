"""Scores of pods, one by one; test_oracles.py has them on random worlds."""

from __future__ import annotations

import numpy as np
import pytest

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import WarehouseView
from rmfs_rules.scorers.scores import SCORES, PodScores, Weights

ORDERS = {"1": {"a": 1, "b": 1}, "2": {"a": 2}, "3": {"c": 1}, "backlog": {"c": 2, "d": 1}}
PODS = {"p": {"a": 3, "c": 1}, "q": {"b": 1, "c": 4, "d": 1}, "r": {"z": 5}, "s": {"a": 1, "b": 1}}


def table(weights: Weights | None = None) -> tuple[PodScores, WarehouseView]:
    """Return the scores where three orders are assigned to the only station, and one is in the backlog."""
    world = small_world(ORDERS, PODS)
    for order in world.orders[:3]:
        world.assign(order, world.stations[0], [line.sku for line in order.open_lines])
    view = WarehouseView(world)
    return PodScores(view, np.random.default_rng(3), weights or Weights()), view


@pytest.mark.parametrize(
    ("name", "weights", "expected"),
    [
        ("completes", Weights(), [2, 1, 0, 1]),  # orders 2 and 3; 3; none; 1
        ("completes", Weights(count_backlog=True), [2, 2, 0, 1]),  # q has three of c left, and d
        ("picks", Weights(), [4, 2, 0, 2]),  # three of a and c; b and c; none; a and b
        ("demand", Weights(), [4, 5, 0, 2]),  # of c three are wanted, of z none
        ("work", Weights(time_cost_per_s=0, backlog_weight=0, completion_boost=0), [4, 2, 0, 2]),
        ("work", Weights(time_cost_per_s=0, backlog_weight=0, completion_boost=1), [7, 3, 0, 4]),
        ("work", Weights(time_cost_per_s=0, backlog_weight=0.5, completion_boost=0), [4, 3.5, 0, 2]),
    ],
)
def test_a_score(name: str, weights: Weights, expected: list[float]) -> None:
    """By hand, pod by pod."""
    scores, view = table(weights)
    assert SCORES[name](scores, view.stations[0], np.arange(4)).tolist() == expected


def test_only_pods_that_are_asked_for_are_scored() -> None:
    """In the order in which they are given."""
    scores, view = table(Weights(count_backlog=True, time_cost_per_s=0))
    station, two = view.stations[0], np.array([1, 3])
    for name in ("completes", "picks", "demand", "work", "nearest"):
        assert SCORES[name](scores, station, two).tolist() == SCORES[name](scores, station, np.arange(4))[two].tolist()


def test_the_nearest_has_the_shortest_drive() -> None:
    """Seconds with the pod, negative."""
    scores, view = table()
    station = view.stations[0]
    ticks = [view.travel.times_to(station.cell, True)[pod.cell].min() for pod in view.pods]
    assert SCORES["nearest"](scores, station, np.arange(4)).tolist() == [-tick / 1000 for tick in ticks]


def test_lots_come_from_the_generator() -> None:
    """One for each pod."""
    scores, view = table()
    drawn = SCORES["random"](scores, view.stations[0], np.arange(4))
    assert drawn.tolist() == np.random.default_rng(3).random(4).tolist()


def test_what_was_chosen_counts_for_the_next_choice() -> None:
    """Pod p takes all of `a` and `c`; only `b` is left to do."""
    scores, view = table()
    station = view.stations[0]
    assert scores.choose(("completes", "picks"), station, np.array([0, 1, 3])) == 0
    assert SCORES["picks"](scores, station, np.arange(4)).tolist() == [0, 1, 0, 1]
    assert scores.choose(("picks",), station, np.array([1, 3])) == 1
