"""PR rule fixed."""

from __future__ import annotations

from collections.abc import Callable

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.fixed import Fixed
from rmfs_rules.nearest import Nearest

PutAtStation = Callable[[Warehouse, int, int], None]


def test_a_pod_goes_back_to_where_it_stood(put_at_station: PutAtStation) -> None:
    """Home is the place it had when the run started, not where it was fetched last."""
    world = small_world({}, {"p": ["a"], "q": ["a"]})
    put_at_station(world, 1, 0)
    home = world.homes[1]
    assert Fixed().choose_storage_location(WarehouseView(world), world.pods[1]) == home


def test_it_goes_to_the_nearest_free_place_when_its_home_is_taken(put_at_station: PutAtStation) -> None:
    """Another pod is on its way there."""
    world = small_world({}, {"p": ["a"], "q": ["a"]})
    put_at_station(world, 1, 0)
    world.reserve(world.homes[1])
    view = WarehouseView(world)
    chosen = Fixed().choose_storage_location(view, world.pods[1])
    assert chosen == Nearest().choose_storage_location(view, world.pods[1]) != world.homes[1]
