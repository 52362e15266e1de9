"""ROA rules."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from rmfs_commands.testing import small_world
from rmfs_core import BundleAssignment
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.random import Random
from rmfs_rules.replenishment import FirstBundle, SamePod

Make = Callable[[int], Warehouse]


def world_with(*sizes: int, **pods: dict[str, int]) -> Warehouse:
    """Return a world with two stations, pods that hold ten items, and bundles of these sizes that wait."""
    world = small_world({}, pods, capacities=(9, 9), bundle_capacity=3, pod_capacity=10)
    for size in sizes:
        world.bundle_arrives(0, size)
    return world


def stations(answer: list[BundleAssignment]) -> list[int]:
    """Return the stations of the bundles, which are assigned oldest first."""
    assert [given.bundle for given in answer] == list(range(len(answer)))
    return [given.station for given in answer]


def test_first_bundle_takes_turns() -> None:
    """Least load first, until no place is free."""
    assert stations([*FirstBundle().assign_bundles(WarehouseView(world_with(*[1] * 9, A={"a": 1})))]) == [0, 1] * 3


def test_same_pod_fills_a_pod() -> None:
    """The emptiest pod has 8 left: 5 and 3 fill it; the next 6 go elsewhere, where 2 more fit, and 7 begin a pod."""
    world = world_with(5, 3, 6, 2, 7, A={"a": 2}, B={"a": 4})
    assert stations([*SamePod().assign_bundles(WarehouseView(world))]) == [0, 0, 1, 1, 0]


def test_same_pod_uses_a_pod_that_comes_anyway() -> None:
    """Pod B is bound for the second station, to pick or to store: what it can take goes there."""
    world = world_with(4, 6, 6, A={"a": 1}, B={"a": 0})
    world.bind(world.pods[1], world.stations[1])
    assert stations([*SamePod().assign_bundles(WarehouseView(world))]) == [1, 1, 0]


def test_same_pod_counts_bundles_without_a_pod() -> None:
    """The first station's bundle takes 6 of the 9 that the pod in mind has: 4 more do not fit."""
    world = world_with(6, A={"a": 1})
    world.assign_bundle(world.bundles[0], world.stations[0])
    world.bundle_arrives(0, 4)
    assert SamePod().assign_bundles(WarehouseView(world)) == [BundleAssignment(1, 1)]


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("rule", [FirstBundle(), SamePod(), Random()], ids=lambda rule: type(rule).__name__)
def test_every_place_is_used(rule: FirstBundle | SamePod | Random, seed: int, midway: Make) -> None:
    """Each bundle goes to a station with a place, as long as there is one."""
    world = midway(seed)
    arguments = (np.random.default_rng(seed),) if isinstance(rule, Random) else ()
    for given in rule.assign_bundles(WarehouseView(world), *arguments):
        assert world.stations[given.station].free_bundle_capacity > 0
        world.assign_bundle(world.bundles[given.bundle], world.stations[given.station])
    assert not world.bundles or not any(station.free_bundle_capacity for station in world.stations)
