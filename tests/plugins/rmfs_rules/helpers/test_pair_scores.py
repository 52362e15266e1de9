"""Open lines that are kept from call to call."""

from __future__ import annotations

import numpy as np

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import WarehouseView
from rmfs_rules.helpers.pair_scores import PairScores


def test_orders_that_a_pod_completes_follow_the_backlog() -> None:
    """One that left is not among them, and one that was assigned in part needs less."""
    world = small_world({"1": ["a"], "2": ["a", "b"], "3": {"a": 3}}, {"p": ["a", "b"]})
    view, kept = WarehouseView(world), PairScores()
    kept.update(view)
    assert kept.completed(np.array([2, 0])).tolist() == [0]
    world.assign(world.orders[0], world.stations[0], [0])
    world.assign(world.orders[1], world.stations[0], [1])
    kept.update(view)
    assert [kept.order_at(place) for place in kept.completed(np.array([2, 0])).tolist()] == [1]
