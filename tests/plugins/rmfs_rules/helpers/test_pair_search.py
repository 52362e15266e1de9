"""Compiled work on open lines that are kept, over several blocks of orders."""

from __future__ import annotations

import numpy as np

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import WarehouseView
from rmfs_rules.helpers import pair_search
from rmfs_rules.helpers.pair_scores import PairScores


def test_orders_are_found_in_all_blocks() -> None:
    """Each once, until it has left."""
    world = small_world({str(i): ["a"] for i in range(2 * pair_search.BLOCK)}, {"p": ["a"]}, capacities=[9])
    view, kept = WarehouseView(world), PairScores()
    kept.update(view)
    for order in world.orders[:5]:
        world.assign(order, world.stations[0], [0])
    kept.update(view)
    assert sorted(kept.completed(np.array([1])).tolist()) == [*range(5, 2 * pair_search.BLOCK)]
