"""Choosing pods for bundles. How rules do so is held against their definitions in tests of rmfs_rules.replenishment."""

from __future__ import annotations

from rmfs_commands.testing import small_world
from rmfs_core import StoreBundle
from rmfs_core.warehouse import WarehouseView
from rmfs_rules.helpers import StoragePods, store_bundles


def test_each_choice_counts_for_the_next() -> None:
    """Room, fetches and items: one pod may be fetched, and has room for two of three bundles."""
    world = small_world({}, {"P": {"a": 1}, "Q": {"b": 2}}, bundle_capacity=3, pod_capacity=10)
    bundles = [world.bundle_arrives(0, size) for size in (5, 4, 1)]
    for bundle in bundles:
        world.assign_bundle(bundle, world.stations[0])
    view = WarehouseView(world)
    assert store_bundles(view, 1, lambda pods, _: -pods.room) == [StoreBundle(0, 0), StoreBundle(1, 0)]
    pods = StoragePods(view, 1)
    assert pods.able(bundles[0]).tolist() == [0, 1]
    pods.take(bundles[0], 0)
    assert pods.able(bundles[0]).tolist() == []
    assert pods.able(bundles[1]).tolist() == [0]
    assert pods.items(0).tolist() == [6, 0]
