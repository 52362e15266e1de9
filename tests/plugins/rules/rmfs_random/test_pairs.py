"""Lots that are drawn for what can be chosen alone lead where lots for all pairs do."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rmfs_core.warehouse import WarehouseView
from rmfs_random import Random
from rmfs_random.pairs import LOTS, draw, skip
from rmfs_testing import small_world


@pytest.mark.parametrize("bits", [np.random.PCG64, np.random.Philox])
def test_lots_are_whole_numbers_of_the_generator(bits: type[Any]) -> None:
    """Whatever it is; those left out are drawn all the same."""
    rng, plain = np.random.Generator(bits(7)), np.random.Generator(bits(7))
    assert draw(rng, 1000).tolist() == plain.integers(LOTS, size=1000).tolist()
    assert rng.integers(5) == plain.integers(5)  # leaves half a number over
    skip(rng, 333)
    plain.integers(LOTS, size=333)
    assert rng.integers(5) == plain.integers(5)
    assert draw(rng, 9).tolist() == plain.integers(LOTS, size=9).tolist()
    assert rng.random() == plain.random()


@settings(max_examples=150)
@given(
    st.lists(st.dictionaries(st.sampled_from("abc"), st.integers(1, 4), min_size=1), min_size=1, max_size=12),
    st.lists(st.integers(1, 14), min_size=1, max_size=4),
    st.booleans(),
    st.data(),
)
def test_decisions_are_those_of_lots_for_all_pairs(
    orders: list[dict[str, int]], capacities: list[int], counts: bool, data: st.DataObject
) -> None:
    """As where filters choose what is shown, which `assign_best_pairs` decides; and as much is drawn."""
    named = {str(i): order for i, order in enumerate(orders)}
    world = small_world(named, {"p": ["a", "b", "c"]}, capacities=capacities, counts_orders=counts)
    view, rule = WarehouseView(world), Random()
    in_part = data.draw(st.booleans())
    for seed in range(3):
        rng, plain = np.random.default_rng(seed), np.random.default_rng(seed)
        answer = list(rule.assign_orders(view, rng))
        assert answer == list(Random().assign_orders(view.showing(view.backlog), plain))
        assert rng.random() == plain.random()
        for one in answer[: data.draw(st.integers(0, len(answer)))]:
            order = world.orders[one.order]
            some = [line.sku for line in order.open_lines]
            world.assign(order, world.stations[one.station], some[1:] if in_part and some[1:] else some)
