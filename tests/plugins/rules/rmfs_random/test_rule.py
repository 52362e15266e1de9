"""PR rule random."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

import numpy as np

from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_random import RandomLocation
from rmfs_testing import small_world


def test_every_free_location_is_equally_likely(put_at_station: Callable[[Warehouse, int, int], None]) -> None:
    """47 places in 4,700 draws: each 100 times, give or take 4.5 standard deviations; occupied ones never."""
    world = small_world({}, {"p": ["a"], "q": ["a"]})
    put_at_station(world, 0, 0)
    rng = np.random.default_rng(1)
    view = WarehouseView(world)
    drawn = Counter(RandomLocation().choose_storage_location(view, rng) for _ in range(100 * len(world.free_locations)))
    assert sorted(drawn) == world.free_locations
    assert all(55 <= number <= 145 for number in drawn.values())


def test_the_same_stream_gives_the_same_locations() -> None:
    """Nothing but the generator it is given decides."""
    view = WarehouseView(small_world({}, {"p": ["a"]}))
    first, second = (
        [RandomLocation().choose_storage_location(view, rng) for _ in range(20)]
        for rng in (np.random.default_rng(7), np.random.default_rng(7))
    )
    assert first == second
