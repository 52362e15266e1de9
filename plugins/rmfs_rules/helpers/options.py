"""Parameters that POA rules share, as classes to derive them from."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

import numpy as np
from attrs import define, field, validators
from numpy.typing import NDArray

from rmfs_core.decisions import OrderAssignment
from rmfs_rules.helpers.pairs import assign_best_pairs, places_kept, waiting_limit

if TYPE_CHECKING:
    from rmfs_core.warehouse import Station, WarehouseView

Score = Callable[["Station"], NDArray[np.int64]]
Assigned = Callable[["Station", int], Iterable[int]]


@define
class LaneOptions:
    """Parameters of a rule that assigns whole orders, whatever their order."""

    max_wait_s: float | None = waiting_limit()
    fast_lane: int = places_kept()


@define
class PairOptions(LaneOptions):
    """Parameters of a rule that assigns pairs of order and station by a score."""

    tie_break: str = field(
        default="oldest",
        validator=validators.in_(("oldest", "due", "random")),
        metadata={"doc": "Which of the orders that are alike goes first: the oldest, the one due first, or one by lot"},
    )
    late_first: bool = field(
        default=False, metadata={"doc": "Whether orders that are late already go before all others"}
    )

    def assign(
        self, warehouse: WarehouseView, rng: np.random.Generator, score: Score, assigned: Assigned | None = None
    ) -> list[OrderAssignment]:
        """Assign the best pairs, as `assign_best_pairs` does."""
        return assign_best_pairs(
            warehouse,
            score,
            assigned,
            max_wait_s=self.max_wait_s,
            rank=self.rank(warehouse, rng),
            first=late(warehouse) if self.late_first else None,
            fast_lane=self.fast_lane,
        )

    def rank(self, warehouse: WarehouseView, rng: np.random.Generator) -> NDArray[np.generic] | None:
        """Return which order of the backlog goes before which others that are alike; None: the older one."""
        if self.tie_break == "due":
            return due_s(warehouse)
        if self.tie_break == "random":
            return by_lot(warehouse, lot_key(rng))
        return None


def lot_key(rng: np.random.Generator) -> int:
    """Draw the number that the lots of one decision are made from."""
    return int(rng.integers(1, 1 << 63))


def by_lot(warehouse: WarehouseView, key: int) -> NDArray[np.float64]:
    """Return which order of the backlog goes before which others that are alike: those drawn first, then by lot."""
    from rmfs_rules.helpers.drawing import DRAWS, draws  # compiled: imported when needed, for it takes its time

    ids = np.array([order.id for order in warehouse.backlog], np.int64)
    rank = lots(key, ids.astype(np.uint64))
    if len(ids):
        end = 1 + max(order.id for order in warehouse.orders)
        turns = np.full(end, DRAWS)
        drawn = draws(key, ids.min(), end)
        turns[drawn[::-1]] = np.arange(DRAWS)[::-1]  # of an order that is drawn twice, the first time
        rank += turns[ids]
    return rank


def lots(key: int, orders: NDArray[np.uint64]) -> NDArray[np.float64]:
    """Return the lot, from 0 to 1, that each order draws by its id: SplitMix64 of the id, begun with a key."""
    mixed = np.uint64(key) + (orders + np.uint64(1)) * np.uint64(0x9E3779B97F4A7C15)
    mixed = (mixed ^ (mixed >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    mixed = (mixed ^ (mixed >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return ((mixed ^ (mixed >> np.uint64(31))) >> np.uint64(11)).astype(np.float64) * 2.0**-53


def due_s(warehouse: WarehouseView) -> NDArray[np.float64]:
    """Return when each order of the backlog is due; infinite where it has no due time."""
    return np.array([np.inf if order.due_s is None else order.due_s for order in warehouse.backlog], np.float64)


def late(warehouse: WarehouseView) -> NDArray[np.bool_]:
    """Return which orders of the backlog are late."""
    return due_s(warehouse) < warehouse.now_s
