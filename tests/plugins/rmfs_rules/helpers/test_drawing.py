"""Orders that are drawn before others; test_pair_search.py has the decisions, against a look at every pair."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import WarehouseView
from rmfs_rules.helpers.drawing import DRAWS, draws
from rmfs_rules.helpers.options import by_lot
from rmfs_rules.helpers.pair_scores import PairScores


def test_every_place_is_drawn_as_often_as_any_other() -> None:
    """From the first place on, before the end."""
    drawn = np.concatenate([draws(key, 10, 42) for key in range(1, 101)])
    times = np.bincount(drawn, minlength=42)
    assert not times[:10].any()
    assert len(times) == 42
    assert np.all(np.abs(times[10:] - 800) < 130)  # 4.6 standard deviations


def test_those_drawn_go_first() -> None:
    """In the order in which they are drawn for the first time, and then the others."""
    view = WarehouseView(small_world({str(i): ["a"] for i in range(900)}, {"p": ["a"]}))
    first = list(dict.fromkeys(draws(5, 0, 900).tolist()))
    found = by_lot(view, 5).argsort().tolist()
    assert found[: len(first)] == first
    assert sorted(found) == list(range(900))
    assert len(first) < DRAWS


@pytest.mark.parametrize("number", [4, 2000])
def test_each_of_a_few_that_are_alike_is_as_likely(number: int) -> None:
    """Whether one of them is drawn or hardly ever: with 2,000 orders it is left to lots two times in three."""
    orders = {str(i): ["b"] for i in range(number)}
    orders |= {str(i): ["a"] for i in range(0, number, number // 4)}
    view, scores = WarehouseView(small_world(orders, {"p": ["a", "b"]}, capacities=[1])), PairScores()
    assert scores.decides(view, np.array([[1, 0]]))
    drawn = Counter(scores.assign(view, key=key)[0].order for key in range(1, 401))
    assert set(drawn) == set(range(0, number, number // 4))
    assert all(55 <= times <= 145 for times in drawn.values())
