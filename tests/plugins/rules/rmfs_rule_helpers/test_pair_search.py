"""The compiled search for the best pair, against a look at every pair."""

from __future__ import annotations

import numpy as np
import pytest

from rmfs_rule_helpers import pair_search
from rmfs_rule_helpers.options import lots
from rmfs_rule_helpers.pair_scores import PairScores
from rmfs_testing import small_world


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("counts", [False, True])
@pytest.mark.parametrize("ties", ["oldest", "rank", "lots"])
def test_the_best_of_several_blocks(seed: int, counts: bool, ties: str) -> None:
    """The highest score that fits; then rank or lot, the oldest order, the lowest load, the lowest id."""
    rng = np.random.default_rng(seed)
    number, stations, skus = 3 * pair_search.BLOCK - 7, 3, 12
    scores = PairScores()
    scores._begin(stations, skus, 20)
    wanted = [rng.choice(skus, rng.integers(1, 6), replace=False).tolist() for _ in range(number)]
    rows = [(order, sku, int(rng.integers(1, 4))) for order, chosen in enumerate(wanted) for sku in chosen]
    scores._join(np.array(rows).T, None)
    if ties == "rank":
        scores._ranks[:number] = rng.integers(0, 9, number)
        scores._best_values[0], scores._best_values[1] = 99.0, -1.0  # no worse than there is
    items = np.array([sum(q for o, _, q in rows if o == order) for order in range(number)])
    key = 77 if ties == "lots" else 0
    rank = lots(key, np.arange(number, dtype=np.uint64)) if key else scores._ranks
    for _ in range(10):  # what is put right in one search serves the next
        for _ in range(6):
            scores.change(int(rng.integers(stations)), int(rng.integers(skus)), int(rng.integers(4)))
        free, load = rng.integers(0, 12, stations), rng.integers(0, 3, stations)
        extra = rng.integers(0, 3, stations).astype(float)
        value = np.zeros((stations, number))
        for order, sku, quantity in rows:
            value[:, order] += np.minimum(quantity, scores.available[:, sku])
        fitting = [
            (-value[s, o] - extra[s], rank[o], o, load[s], s)
            for s in range(stations)
            for o in range(number)
            if not scores._taken[o] and (1 if counts else items[o]) <= free[s]
        ]
        expected = (min(fitting)[2], min(fitting)[4]) if fitting else (-1, -1)
        at = np.array([free, free, [20] * stations, [counts] * stations, load])
        assert scores._best(at, extra, np.zeros((2, 0), np.int64), key) == expected
        scores._taken[expected[0]] |= bool(fitting)


def test_lots_are_the_same_whoever_draws_them() -> None:
    """In one search as for all orders at once."""
    drawn = lots(12345, np.arange(50, dtype=np.uint64))
    assert [pair_search.lot(12345, order) for order in range(50)] == drawn.tolist()
    assert drawn.min() >= 0
    assert drawn.max() < 1
    assert len(set(drawn)) == 50


def test_worlds_have_whole_orders() -> None:
    """What joins is counted by order: lines, items and size."""
    world = small_world({"1": {"a": 2, "b": 1}, "2": {"a": 9}}, {"p": ["a", "b"]})
    scores = PairScores()
    scores._begin(1, 2, 15)
    scores._join(world.backlog.log.joined(), None)
    assert scores._orders[:, :2].tolist() == [[2, 1], [3, 9], [2, 7]]
