"""What was ordered until now."""

from __future__ import annotations

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import WarehouseView
from rmfs_rules.replenishment.ordered import Ordered


def test_pairs_are_counted_once() -> None:
    """Orders by pairs, none with itself; a second look changes nothing, another run begins anew."""
    ordered = Ordered()
    for orders in ({"1": {"a": 3, "b": 1}, "2": {"a": 1, "b": 2, "c": 1}}, {"1": {"a": 3, "b": 1}}):
        view = WarehouseView(small_world(orders, {"P": "abc"}))
        for _ in range(2):
            assert ordered.together(view, 0).tolist() == ([0, 2, 1] if len(orders) == 2 else [0, 1, 0])
