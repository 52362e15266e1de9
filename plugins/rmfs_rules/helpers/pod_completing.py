"""How many orders of the backlog pods complete: changed where orders, or what a pod has free, change."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rmfs_rules.helpers.pair_scores import PairScores

if TYPE_CHECKING:
    from rmfs_core.warehouse import WarehouseView
    from rmfs_rules.helpers.pod_sending import KeptPods

Ints = NDArray[np.int64]


class KeptCompleted:
    """The orders of the backlog that pods complete."""

    def __init__(self) -> None:
        self._orders = PairScores()
        self._of: tuple[object, object] = (None, None)

    def load(self) -> None:
        """Load what is compiled, or compile it."""
        from rmfs_rules.helpers import completing  # compiled: imported when needed, for it takes its time

        self._orders.load()
        self.one_after_another(1, *np.zeros((3, 1), np.int64))
        none, one = np.zeros(0, np.int64), np.zeros(1, np.int64)
        shown = one.copy()
        shown.setflags(write=False)
        recount: Any = completing.recount
        recount(0, 0, none, *self._arrays(), none, np.zeros(2, np.int64), shown, shown, one)

    def alone(self, warehouse: WarehouseView, pods: KeptPods) -> Ints:
        """Return how many orders each pod completes if all its free items are for that order; shape (pods,).

        The backlog is whole here, whatever filters leave of it.
        """
        from rmfs_rules.helpers import completing  # as above

        log, free, orders = warehouse.backlog_log(), pods.items, self._orders
        if self._of != (log, pods.log):
            orders.update(warehouse)
            self._of, self._seen = (log, pods.log), 0
            self._left = len(log.left())
            self._numbers = np.zeros(len(pods.cells), np.int64)
        before, left = orders._number, log.left(self._left)
        self._left += len(left)
        orders.update(warehouse)
        assert pods.log is not None
        changed = pods.log.changed(self._seen)
        self._seen += len(changed)
        recount: Any = completing.recount
        recount(
            before, orders._number, np.sort(np.array(left, np.int64)), *self._arrays(),
            pods.by_sku, pods.first, free.pod, free.number, self._numbers,
        )  # fmt: skip
        if len(changed):
            some = np.unique(free.pod[changed])
            entries, rank = pods.entries_of(some)
            self._numbers[some] = np.bincount(
                orders.completed_by(rank, free.sku[entries], free.number[entries])[0], minlength=len(some)
            )
        return self._numbers

    def one_after_another(
        self, number: int, pod: Ints, sku: Ints, items: Ints, shown: Collection[int] | None = None
    ) -> Ints:
        """Return how many orders pods complete one after another, the oldest first: no item counts for two.

        Parameters
        ----------
        number
            How many pods there are: 0, 1, ...
        pod, sku, items
            How many items of a SKU a pod has, sorted by pod, each SKU of a pod once.
        shown
            Ids of the orders that count. Left out: all of the backlog, as it was when `alone` was asked last.
        """
        from rmfs_rules.helpers import completing  # as above

        found = self._orders.completed_by(pod, sku, items)
        by_age = np.lexsort(found[::-1])
        pods, places = found[0][by_age], found[1][by_age]
        if shown is not None:
            there = np.array([self._orders.order_at(place) in shown for place in places.tolist()], np.bool_)
            pods, places = pods[there], places[there]
        kept = completing.while_stock_lasts(pods, places, pod, sku, items, *self._arrays())
        numbers: Ints = np.bincount(pods[kept], minlength=number)
        return numbers

    def _arrays(self) -> tuple[Any, ...]:
        orders = self._orders
        return orders._starts, orders._lines, orders._shelves, orders._pool, orders._orders
