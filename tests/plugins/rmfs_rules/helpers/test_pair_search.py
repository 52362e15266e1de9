"""The compiled search for the best pair, over several blocks of orders, against a look at every pair."""

from __future__ import annotations

import numpy as np
import pytest

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import Station, WarehouseView
from rmfs_rules.helpers import assign_best_pairs, pair_search, sum_per_order
from rmfs_rules.helpers.options import by_lot, due_s, lots
from rmfs_rules.helpers.pair_scores import PairScores, by_due_time


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("counts", [False, True])
@pytest.mark.parametrize("ties", ["oldest", "due", "lots"])
def test_the_best_of_several_blocks(seed: int, counts: bool, ties: str) -> None:
    """The highest score that fits; then due time or lot, the oldest order, the lowest load, the lowest id."""
    rng = np.random.default_rng(seed)
    names = [f"s{i}" for i in range(12)]
    orders = {
        str(i): {sku: int(rng.integers(1, 4)) for sku in rng.choice(names, rng.integers(1, 6), replace=False)}
        for i in range(3 * pair_search.BLOCK - 7)
    }
    due = {name: float(rng.integers(9)) for name in orders}
    world = small_world(orders, {"p": names}, capacities=[6, 11, 7], counts_orders=counts, due_s=due)
    view, scores = WarehouseView(world), PairScores(by_due_time if ties == "due" else None)
    assigned = 0
    for turn in range(8):
        available = rng.integers(0, 4, (3, 12)) * (rng.random((3, 12)) < 0.2 + 0.1 * turn)
        extra = rng.integers(0, 3, 3).astype(float)
        key = turn + 1 if ties == "lots" else 0

        def score(station: Station, now: np.ndarray = available, extra: np.ndarray = extra) -> np.ndarray:
            lines = view.backlog_lines
            return sum_per_order(view, np.minimum(now[station.id, lines.sku], lines.quantity)) + int(extra[station.id])

        rank = due_s(view) if ties == "due" else by_lot(view, key) if key else None
        assert scores.decides(view, available)
        answer = scores.assign(view, extra=extra, key=key)
        assert answer == assign_best_pairs(view, score, rank=rank)
        assigned += len(answer)
        for one in answer[: int(rng.integers(1, 5))]:
            order = world.orders[one.order]
            world.assign(order, world.stations[one.station], [line.sku for line in order.open_lines])
            if rng.random() < 0.7:
                for request in world.stations[one.station].open_requests:
                    world.fulfil(request, world.pods[0])
    assert assigned > 5


def test_lots_are_the_same_whoever_draws_them() -> None:
    """In one search as for all orders at once."""
    drawn = lots(12345, np.arange(50, dtype=np.uint64))
    assert [pair_search.lot(12345, order) for order in range(50)] == drawn.tolist()
    assert drawn.min() >= 0
    assert drawn.max() < 1
    assert len(set(drawn)) == 50


def test_nothing_is_best_when_the_last_order_has_left(monkeypatch: pytest.MonkeyPatch) -> None:
    """Not even where the orders so far have filled all blocks: as Python, no index is beyond the arrays."""
    world = small_world({str(i): ["a"] for i in range(2 * pair_search.BLOCK)}, {"p": ["a"]})
    view, scores = WarehouseView(world), PairScores()
    for order in world.orders:
        world.assign(order, world.stations[0], [0])
        for request in world.stations[0].open_requests:
            world.fulfil(request, world.pods[0])
    scores.update(view)
    monkeypatch.setattr(pair_search, "best_pair", pair_search.best_pair.py_func)
    assert world.stations[0].free_capacity > 0
    assert scores.assign(view) == []
