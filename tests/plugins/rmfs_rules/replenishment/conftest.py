"""Worlds with bundles."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import Warehouse

SKUS = "abcdef"


@pytest.fixture
def midway() -> Callable[[int], Warehouse]:
    """Return a function that makes a random world: two stations, bundles everywhere, pods stored and on their way."""

    def make(seed: int) -> Warehouse:
        rng = np.random.default_rng(seed)

        def some(most: int) -> dict[str, int]:
            skus = rng.choice(list(SKUS), int(rng.integers(1, 4)), replace=False)
            return {str(sku): int(rng.integers(1, most)) for sku in skus}

        pods = {"all": dict.fromkeys(SKUS, 1)} | {str(i): some(6) for i in range(int(rng.integers(2, 12)))}
        orders = {str(i): some(2) for i in range(int(rng.integers(0, 9)))}
        capacity = None if rng.random() < 0.2 else int(rng.integers(15, 22))
        world = small_world(orders, pods, capacities=(9, 9), robots=4, bundle_capacity=4, pod_capacity=capacity)
        for pod in rng.permutation(len(world.pods))[: int(rng.integers(0, 4))].tolist():
            world.bind(world.pods[pod], world.stations[int(rng.integers(2))])
        for _ in range(int(rng.integers(1, 9))):
            bundle = world.bundle_arrives(int(rng.integers(len(SKUS))), int(rng.integers(1, 9)))
            station = world.stations[int(rng.integers(2))]
            if rng.random() < 0.7 and station.free_bundle_capacity:
                world.assign_bundle(bundle, station)
                fitting = [pod for pod in world.pods if pod.free_space >= bundle.size]
                if rng.random() < 0.3 and fitting:
                    world.bind_bundle(bundle, fitting[int(rng.integers(len(fitting)))])
        return world

    return make
