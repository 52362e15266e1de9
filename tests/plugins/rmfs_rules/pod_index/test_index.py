"""The largest ratio of worth to seconds; `test_turns.py` has it against all sets of lines."""

from __future__ import annotations

import numpy as np

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import WarehouseView
from rmfs_rules.pod_index.index import by_gain, find_within
from rmfs_rules.pod_index.period import Bids


def test_lines_that_gain_more_are_first_and_others_left_out() -> None:
    """SKU 1 has three lines: at a rate of 2 an item one gains 1, one nothing, one 3."""
    bids = Bids(
        items=np.array([1, 1, 2, 1]),
        worth=np.array([9.0, 3.0, 4.0, 5.0]),
        first=np.array([0, 1]),
        end=np.array([1, 4]),
        within=np.zeros((0, 3), np.int64),
        bearers=np.zeros(0, np.int64),
    )
    assert by_gain(bids, 1, 2.0).tolist() == [3, 1]
    assert by_gain(bids, 0, 10.0).tolist() == []


def test_only_movable_pods_with_items_bear_a_sku() -> None:
    """SKU 0 is on pods p and r, of which r may not be sent; q has no item left of SKU 1."""
    world = small_world({"1": ["a"], "2": ["b"]}, {"p": {"a": 1}, "q": {"b": 0}, "r": {"a": 2}})
    stock = WarehouseView(world).stock
    within, bearers = find_within(np.array([0, 1]), stock, np.array([True, True, False]))
    assert (within.tolist(), stock.pod[bearers].tolist()) == ([[0, 0, 1]], [0])
