"""The compiled search for the best pair, against a look at every pair."""

from __future__ import annotations

import numpy as np
import pytest

from rmfs_rule_helpers import pair_search


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("counts", [False, True])
def test_the_best_of_several_blocks(seed: int, counts: bool) -> None:
    """The highest score that fits; then the oldest order, the lowest load, the lowest id."""
    rng = np.random.default_rng(seed)
    number, stations = 3 * pair_search.BLOCK - 7, 3
    orders = np.array([rng.integers(0, 2, number), rng.integers(1, 12, number)])
    scores, taken = rng.integers(0, 6, (stations, number)), rng.random(number) < 0.1
    best = np.full((stations, 3, pair_search.SIZES), 99)  # more than there is
    for _ in range(10):  # what is put right in one search serves the next
        free, load = rng.integers(0, 10, stations), rng.integers(0, 3, stations)
        fitting = [
            (-scores[s, o], o, load[s], s)
            for s in range(stations)
            for o in range(number)
            if orders[0, o] and not taken[o] and (1 if counts else orders[1, o]) <= free[s]
        ]
        expected = (min(fitting)[1], min(fitting)[3]) if fitting else (-1, -1)
        kinds = np.full(stations, counts)
        assert pair_search.best_pair(free, kinds, load, 0, number, orders, taken, scores, best) == expected
        taken[expected[0]] = expected[0] >= 0 or taken[expected[0]]
