"""Pairs that are drawn one after another: of those that fit, each as likely as with a lot for every pair."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import chi2_contingency

from rmfs_commands.testing import small_world
from rmfs_core.clock import TICKS_PER_S
from rmfs_core.warehouse import WarehouseView
from rmfs_rules.helpers import assign_best_pairs
from rmfs_rules.random import Random
from rmfs_rules.random.pairs import draw_pairs

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
        return tuple(draw_pairs(view, rng, max_wait_s))

    def plain() -> tuple[Any, ...]:
        return tuple(assign_best_pairs(view, lots, max_wait_s=max_wait_s))

    times = [Counter(decide() for _ in range(3000)) for decide in (drawn, plain)]
    often = [decision for decision in times[1] if times[1][decision] >= 10]
    table = [[of[decision] for decision in often] + [3000 - sum(of[decision] for decision in often)] for of in times]
    assert len(often) > 2
    assert chi2_contingency(np.array(table)[:, np.any(table, axis=0)]).pvalue > 0.001


@settings(max_examples=150)
@given(
    st.lists(st.dictionaries(st.sampled_from("abc"), st.integers(1, 4), min_size=1), min_size=1, max_size=12),
    st.lists(st.integers(1, 14), min_size=1, max_size=4),
    st.booleans(),
    st.sampled_from([None, 0.0, 300.0]),
    st.data(),
)
def test_pairs_that_fit_are_drawn_until_none_does(
    orders: list[dict[str, int]], capacities: list[int], counts: bool, max_wait_s: float | None, data: st.DataObject
) -> None:
    """Whatever was kept from call to call; a rule that has kept nothing draws the same ones."""
    named = {str(i): order for i, order in enumerate(orders)}
    world = small_world(named, {"p": ["a", "b", "c"]}, capacities=capacities, counts_orders=counts)
    view, rule = WarehouseView(world), Random(max_wait_s)
    in_part = data.draw(st.booleans())
    for seed in range(4):
        rng, plain = np.random.default_rng(seed), np.random.default_rng(seed)
        answer = list(rule.assign_orders(view, rng))
        assert answer == list(Random(max_wait_s).assign_orders(view.showing(view.backlog), plain))
        assert rng.random() == plain.random()
        every = data.draw(st.booleans())
        for one in answer if every else answer[: data.draw(st.integers(0, len(answer)))]:
            order, station = world.orders[one.order], world.stations[one.station]
            assert view.size_at(order, station) <= station.free_capacity
            some = [line.sku for line in order.open_lines]
            world.assign(order, station, some[1:] if in_part and some[1:] else some)
        if every and max_wait_s is None and not in_part:
            left = [(order, station) for order in view.backlog for station in view.stations]
            assert not any(view.size_at(order, station) <= station.free_capacity for order, station in left)
        world.advance(world.now + data.draw(st.integers(0, 400_000)))
