"""Which orders the stock could serve, worked out anew from a trace; and the check that no other was assigned."""

from __future__ import annotations

import math
from collections import defaultdict

from rmfs_commands.trace.reader import Trace
from rmfs_commands.trace.writer import EVENTS
from rmfs_commands.validation.case import Case, Handlers
from rmfs_commands.validation.state import State
from rmfs_core.events import BundleStored, Event, OrderArrived, OrderAssigned, OrderCancelled, OrderInStock


def lets_wait(trace: Trace) -> bool:
    """Whether orders may wait for stock in a run; without replenishment there is enough for all of them."""
    asked = trace.scenario.get("rules", {}).get("wait_for_stock", True)
    return asked is not False and trace.instance.restocked


class Claims:
    """Items that no order has claimed, by SKU, and the orders that wait for more.

    Parameters
    ----------
    trace
        Its header says what the pods hold at first.
    """

    def __init__(self, trace: Trace) -> None:
        self._orders = trace.instance.orders
        self.left: defaultdict[int, float] = defaultdict(float)
        self.waiting: dict[int, int] = {}
        """By id, how many orders waited before it."""
        self._waited = 0
        self._wanting: defaultdict[int, defaultdict[int, set[int]]] = defaultdict(lambda: defaultdict(set))
        for pod in trace.instance.pods:
            for sku, items in pod.contents:
                self.left[sku] += math.inf if items is None else items

    def arrives(self, order: int) -> None:
        """Let an order claim what it wants, or wait."""
        if self._served(order):
            self.claim(order)
        else:
            self.wait(order)

    def wait(self, order: int) -> None:
        """Let an order wait for what it wants."""
        self.waiting[order] = self._waited
        self._waited += 1
        for sku, quantity in self._orders[order].lines:
            self._wanting[sku][quantity].add(order)

    def claim(self, order: int) -> None:
        """Let an order claim what it wants, whether or not that is there, and wait no more."""
        for sku, quantity in self._orders[order].lines:
            self.left[sku] -= quantity
        if self.waiting.pop(order, None) is not None:
            for sku, quantity in self._orders[order].lines:
                self._wanting[sku][quantity].remove(order)

    def cancelled(self, order: int) -> list[int]:
        """Let an order leave; return the orders that wait no more."""
        lines = self._orders[order].lines
        if self.waiting.pop(order, None) is None:
            return self.stored(*lines)
        for sku, quantity in lines:
            self._wanting[sku][quantity].remove(order)
        return []

    def stored(self, *lines: tuple[int, int]) -> list[int]:
        """Take in items of SKUs; return the orders that wait no more."""
        for sku, items in lines:
            self.left[sku] += items
        served, wanting = [], ((sku, self._wanting[sku]) for sku, _ in lines)
        enough = {
            order for sku, those in wanting for n, orders in those.items() if n <= self.left[sku] for order in orders
        }
        for order in sorted(enough, key=self.waiting.__getitem__):
            if all(self.left[sku] <= 0 for sku, _ in lines):
                break
            if self._served(order):
                self.claim(order)
                served.append(order)
        return served

    def _served(self, order: int) -> bool:
        return all(self.left[sku] >= quantity for sku, quantity in self._orders[order].lines)


def joined_at(trace: Trace) -> dict[int, int]:
    """Return when each order joined the backlog: with its arrival, or when there was enough in stock.

    What a floor counted is in no event: of a day with corrections the trace says which orders waited to its end.
    """
    if trace.floor is not None and trace.floor["corrected_s"] is not None:
        left = frozenset(trace.floor.get("waiting", ()))
        told = [event for event in trace.events if isinstance(event, OrderArrived | OrderInStock)]
        return {event.order: event.tick for event in told if event.order not in left}
    claims = Claims(trace) if lets_wait(trace) else None
    found: dict[int, int] = {}
    for event in trace.events:
        if isinstance(event, OrderArrived):
            if claims is not None:
                claims.arrives(event.order)
            if claims is None or event.order not in claims.waiting:
                found.setdefault(event.order, event.tick)
        elif isinstance(event, BundleStored) and claims is not None:
            found |= dict.fromkeys(claims.stored((event.sku, event.items)), event.tick)
        elif isinstance(event, OrderCancelled) and claims is not None:
            found |= dict.fromkeys(claims.cancelled(event.order), event.tick)
    return found


class StockCheck:
    """No order is assigned that the stock cannot serve, and each that waited is told of when it can.

    ``state`` learns which orders wait.
    """

    def __init__(self, case: Case, state: State) -> None:
        self.case, self.state = case, state
        self.claims = Claims(case.trace)
        self.served: list[int] = []  # orders that are to be told of next
        self.tick = 0
        self.handlers: Handlers = {OrderInStock: self.in_stock}
        if lets_wait(case.trace):
            self.handlers = dict.fromkeys(EVENTS.values(), self.other) | {
                OrderArrived: self.arrived,
                OrderAssigned: self.assigned,
                OrderCancelled: self.cancelled,
                BundleStored: self.stored,
                OrderInStock: self.in_stock,
            }

    def other(self, event: Event) -> None:  # noqa: ARG002
        """Check that all orders have been told of that a bundle was enough for."""
        if self.served:
            self.at_end()

    def at_end(self) -> None:
        """Check the same when the trace is over."""
        for order in self.served:
            told = f"{self.case.order(order)} waited for stock, and there is enough for it; nothing tells of that"
            self.case.add("in-stock", self.tick, told)
        self.served = []

    def arrived(self, event: OrderArrived) -> None:
        """Let an order claim its items, or wait."""
        self.other(event)
        self.claims.arrives(event.order)
        self.state.orders[event.order].waits = event.order in self.claims.waiting

    def assigned(self, event: OrderAssigned) -> None:
        """Check that an order does not wait."""
        self.other(event)
        order = self.state.orders[event.order]
        if order.waits:
            assigns = f"{self.case.order(event.order)} is assigned to {self.case.station(event.station)}"
            self.case.add("assigned-without-stock", event.tick, f"{assigns}, but the pods hold too little for it")
            self.claims.claim(event.order)
            order.waits = False

    def cancelled(self, event: OrderCancelled) -> None:
        """Expect to be told of the orders that what it leaves is enough for."""
        self._serve(event, self.claims.cancelled(event.order))

    def stored(self, event: BundleStored) -> None:
        """Expect to be told of the orders that a bundle is enough for."""
        self._serve(event, self.claims.stored((event.sku, event.items)))

    def _serve(self, event: Event, served: list[int]) -> None:
        self.other(event)
        self.served, self.tick = served, event.tick
        for order in self.served:
            self.state.orders[order].waits = False

    def in_stock(self, event: OrderInStock) -> None:
        """Check that an order waited, and that a bundle has come for it."""
        if self.served[:1] == [event.order] and event.tick == self.tick:
            del self.served[0]
            return
        told = f"{self.case.order(event.order)} is said to be in stock"
        why = "what was stored, or left by a cancelled order, then is enough for others first, or for none"
        self.case.add("in-stock", event.tick, f"{told}, but {why}")
        if event.order in self.served:
            self.served.remove(event.order)
