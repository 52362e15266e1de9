"""Orders that pods complete; test_wanted.py of rmfs_rules.scorers has random ones."""

from __future__ import annotations

import numpy as np

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import WarehouseView
from rmfs_rules.helpers.pod_completing import KeptCompleted
from rmfs_rules.helpers.pod_sending import KeptPods


def test_orders_take_items_from_each_other() -> None:
    """Of three `a` the oldest order takes two, so that the second is not complete; the third needs `b` alone by now."""
    world = small_world({"1": {"a": 2}, "2": {"a": 2, "b": 1}, "3": {"a": 9, "b": 1}}, {"p": {"a": 9, "b": 9}})
    orders, held, view = KeptCompleted(), KeptPods(), WarehouseView(world)
    world.assign(world.orders[2], world.stations[0], [0])
    held.update(view)
    orders.alone(view, held)
    pods, skus = np.array([0, 0, 1, 1, 2]), np.array([0, 1, 0, 1, 1])

    def completed(items: list[int], shown: set[int] | None = None) -> list[int]:
        return orders.one_after_another(4, pods, skus, np.array(items), shown).tolist()

    assert completed([3, 9, 4, 9, 1]) == [2, 3, 1, 0]
    assert completed([3, 9, 4, 1, 0]) == [2, 2, 0, 0]
    assert completed([3, 9, 4, 9, 1], {1, 2}) == [2, 2, 1, 0]
    assert completed([0, 0, 1, 0, 0]) == [0, 0, 0, 0]
