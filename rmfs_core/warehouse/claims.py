"""Which orders the stock can serve, and which wait for it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from heapq import heappop, heappush
from operator import attrgetter

from rmfs_core.warehouse.parts import Order, Pod

by_age = attrgetter("arrival_tick", "id")
"""Key by which the older order comes first."""


_Aged = tuple[int, int, Order]
"""An order with its age before it, so that a heap has the oldest first."""


class Claims:
    """Items that no order has claimed, and the orders that wait for more of them.

    An order claims its open lines when it joins the backlog. Assigning turns claims into requests, and a pick takes an
    item and its request away alike, so what is unclaimed changes when an order joins or leaves, or a bundle is stored::

        unclaimed = items on all pods - open requests - open lines of the backlog

    Each order that waits watches one SKU that it lacks, and is looked at again only when there is enough of that. So a
    bundle costs no look at orders that want more than there is, however many wait.

    Parameters
    ----------
    pods
        All pods.
    """

    def __init__(self, pods: Iterable[Pod]) -> None:
        self.unclaimed: defaultdict[int, int] = defaultdict(int)
        self.waiting: dict[int, Order] = {}
        """By id, the oldest first."""
        self._watching: defaultdict[int, dict[int, list[_Aged]]] = defaultdict(dict)
        """By SKU and number of items, heaps of orders that lack them."""
        for pod in pods:
            for sku, items in pod.contents.items():
                self.unclaimed[sku] += items

    def claim(self, sku: int, items: int) -> None:
        """Claim items, whether or not they are there."""
        self.unclaimed[sku] -= items

    def lacking(self, order: Order) -> int | None:
        """Return the first SKU of which there is too little for an order's open lines; None: there is enough of all."""
        unclaimed = self.unclaimed
        return next((sku for sku, quantity in order.open_lines if unclaimed[sku] < quantity), None)

    @property
    def missing(self) -> list[int]:
        """SKUs of which there is too little for an order that waits, ascending."""
        lines = (line for order in self.waiting.values() for line in order.lines)
        return sorted({sku for sku, quantity in lines if self.unclaimed[sku] < quantity})

    def serve(self, order: Order) -> bool:
        """Let an order claim all its open lines, if there is enough; else it waits."""
        if (sku := self.lacking(order)) is not None:
            self.wait(order, sku)
            return False
        for line in order.open_lines:
            self.claim(*line)
        return True

    def wait(self, order: Order, sku: int) -> None:
        """Let an order wait until there is more of a SKU."""
        order._waits = True
        self.waiting[order.id] = order
        heappush(self._watching[sku].setdefault(order._open[sku].quantity, []), (*by_age(order), order))

    def give(self, *lines: tuple[int, int]) -> Sequence[Order]:
        """Take in items of SKUs that nobody has claimed; return the orders that wait no more, the oldest first."""
        for sku, items in lines:
            self.unclaimed[sku] += items
        watched, served = [(sku, self._watching[sku]) for sku, _ in lines], []
        while fitting := [(heaps, n) for sku, heaps in watched for n in heaps if n <= self.unclaimed[sku]]:
            heaps, quantity = min(fitting, key=lambda one: one[0][one[1]][0])
            order = heappop(heaps[quantity])[-1]
            if not heaps[quantity]:
                del heaps[quantity]
            if order.id in self.waiting and self.serve(order):  # it is not if it was cancelled
                self.leave(order)
                served.append(order)
        return served

    def leave(self, order: Order) -> None:
        """Let an order wait no more; whatever watches a SKU for it finds that out."""
        order._waits = False
        del self.waiting[order.id]
