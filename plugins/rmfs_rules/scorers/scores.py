"""What speaks for a pod: one number for each candidate, all of them at once."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from rmfs_core.clock import TICKS_PER_S
from rmfs_core.warehouse import columns_of, stock_of
from rmfs_rules.helpers import sending
from rmfs_rules.helpers.sending import may_send, send, ticks_from, worth
from rmfs_rules.scorers.wanted import Ids, Requests, Values

if TYPE_CHECKING:
    from rmfs_core import PodTrip
    from rmfs_core.warehouse import Lines, Order, Station, Stock, WarehouseView


@frozen
class Weights:
    """What scores are made of.

    Parameters
    ----------
    count_backlog
        Whether orders of the backlog count among those that a pod completes.
    value
        What an item is worth, one of `VALUES`.
    backlog_weight
        What an item wanted in the backlog counts, as a share of one that the station wants.
    completion_boost
        How many times more an item counts whose order the pod completes.
    time_cost_per_s
        What a second of driving to the station costs.
    """

    count_backlog: bool = False
    value: str = "picks"
    backlog_weight: float = 0.2
    completion_boost: float = 1.0
    time_cost_per_s: float = 1 / 3


class PodScores:
    """Scores of pods for stations in one decision, the higher the better; what is chosen changes those to come.

    Parameters
    ----------
    warehouse
        The warehouse now.
    rng
        Draws lots.
    weights
        What scores are made of.
    """

    def __init__(self, warehouse: WarehouseView, rng: np.random.Generator, weights: Weights) -> None:
        from rmfs_rules.scorers import backlog_search  # compiled: imported when needed, for it takes its time

        self._search: Any = backlog_search
        self._warehouse, self._rng, self._weights = warehouse, rng, weights
        self._requests: dict[int, Requests] = {}

    def send(self, max_fetches: int, scores: Sequence[str]) -> list[PodTrip]:
        """Send the pods with the best scores to the stations that lack one."""
        if not may_send(self._warehouse, max_fetches):
            return []
        return send(self._warehouse, max_fetches, lambda at, pods: self.choose(scores, at, pods))

    def choose(self, scores: Sequence[str], station: Station, pods: Ids) -> int:
        """Return the pod with the best first score, ties by the next one and at last by the lowest id; it is taken."""
        left = pods
        for name in scores:
            if len(left) == 1:
                break
            values = SCORES[name](self, station, left)
            left = left[values == values.max()]
        chosen = int(left[0])
        self._take(chosen, station)
        return chosen

    # Scores

    def completes(self, station: Station, pods: Ids) -> Values:
        """Orders of which the pod fulfils all requests at the station that are uncovered.

        And those of the backlog, if they count, that what is left on it completes one after another, oldest first.
        """
        number: Values = self._completed(station, pods).sum(axis=0).astype(np.float64)
        if self._weights.count_backlog:
            number += self._search.completed(self._lines, self._stock, pods, self._wanted_by_sku(station))
        return number

    def picks(self, station: Station, pods: Ids) -> Values:
        """Uncovered items of the station that the pod has."""
        wanted = self._wanted(station)
        picks: Values = np.minimum(self._on(pods, wanted.skus), wanted.needs.sum(axis=0)).sum(axis=1).astype(np.float64)
        return picks

    def work(self, station: Station, pods: Ids) -> Values:
        """What the items are worth that the pod serves, less the time that it drives."""
        wanted, weights = self._wanted(station), self._weights
        now_s = self._warehouse.now_s
        each = wanted.worth(lambda order: _worth(weights.value, order, now_s))
        total = weights.time_cost_per_s * self.nearest(station, pods)
        items = self._on(pods, wanted.skus)
        for column in range(len(wanted.skus)):
            of_sku = wanted.column == column
            number, sums = (
                np.concatenate(([0], np.cumsum(values[of_sku]))) for values in (wanted.items, each * wanted.items)
            )
            total += np.interp(items[:, column], number, sums)  # of a request that it serves in part, a part
        if weights.completion_boost:
            of_order = np.bincount(wanted.row, weights=each * wanted.items, minlength=len(wanted.needs))
            total += weights.completion_boost * (of_order @ self._completed(station, pods))
        if weights.backlog_weight:
            lines, stock, wanted_by_sku = self._lines, self._stock, self._wanted_by_sku(station)
            since_s = lines.due_s if weights.value == "lateness" else lines.arrival_s
            total += weights.backlog_weight * self._search.worth(
                lines, stock, pods, wanted_by_sku, since_s, self._unpicked, now_s, weights.value != "picks"
            )
        return total

    def demand(self, station: Station, pods: Ids) -> Values:  # noqa: ARG002
        """Items wanted in the whole system, assigned or not, that the pod has free."""
        return worth(self._stock, pods, self._warehouse.open_demand()).astype(np.float64)

    def nearest(self, station: Station, pods: Ids) -> Values:
        """Seconds of loaded driving to the station, with a minus in front."""
        seconds: Values = ticks_from(self._warehouse, self._stock.cell[pods], station) / -TICKS_PER_S
        return seconds

    def random(self, station: Station, pods: Ids) -> Values:  # noqa: ARG002
        """A lot drawn for each pod."""
        return self._rng.random(len(pods))

    # What they are made of

    @cached_property
    def _lines(self) -> Lines:
        return self._warehouse.lines

    @cached_property
    def _stock(self) -> Stock:
        return self._warehouse.stock

    @cached_property
    def _unpicked(self) -> Ids:
        """Items of each order that are not yet picked, by place: the open ones, and others of orders that are begun."""
        if self._weights.value == "picks" or not self._warehouse.split_orders_open:
            return self._lines.items
        unpicked = self._lines.items.copy()
        for place in self._lines.begun.tolist():
            unpicked[place] = self._warehouse.order(int(self._lines.order_id[place])).unpicked_items
        unpicked.setflags(write=False)  # as the columns: one type for compiled code
        return unpicked

    def _wanted(self, station: Station) -> Requests:
        if station.id not in self._requests:
            uncovered = station.uncovered_requests
            self._requests[station.id] = Requests.of(uncovered, [request.items for request in uncovered])
        return self._requests[station.id]

    def _take(self, pod: int, station: Station) -> None:
        """Let the items of a chosen pod go to the oldest requests, as they will."""
        wanted = self._wanted(station)
        left = Counter(dict(zip(wanted.skus.tolist(), self._on(np.array([pod]), wanted.skus)[0].tolist(), strict=True)))
        still = []
        for request, items in zip(wanted.requests, wanted.items.tolist(), strict=True):
            taken = min(items, left[request.sku])
            left[request.sku] -= taken
            if taken < items:
                still.append((request, items - taken))
        self._requests[station.id] = Requests.of([request for request, _ in still], [items for _, items in still])

    def _on(self, pods: Ids, skus: Ids) -> NDArray[np.int64]:
        """Return the free items of SKUs on pods, shape (pods, SKUs)."""
        items: NDArray[np.int64] = self._search.items_on(self._stock, pods, skus)
        return items

    def _completed(self, station: Station, pods: Ids) -> NDArray[np.bool_]:
        """Return which orders of a station the pods complete, shape (orders, pods), if the oldest take first."""
        wanted = self._wanted(station)
        left = self._on(pods, wanted.skus)
        completed = np.zeros((len(wanted.needs), len(pods)), np.bool_)
        for order, needs in enumerate(wanted.needs):
            completed[order] = (left >= needs).all(axis=1)
            left -= completed[order][:, None] * needs
        return completed

    def _wanted_by_sku(self, station: Station) -> Ids:
        """Return how many items of each SKU the station wants, shape (n_skus,)."""
        wanted = np.zeros(self._warehouse.n_skus, np.int64)
        wanted[self._wanted(station).skus] = self._wanted(station).needs.sum(axis=0)
        return wanted


VALUES = ("picks", "age", "lateness")
"""What an item is worth: 1, or its share of the seconds since its order arrived or was due."""


def _worth(value: str, order: Order, now_s: float) -> float:
    """Return what an item of an order is worth."""
    if value == "picks":
        return 1.0
    since_s = order.arrival_s if value == "age" else order.due_s
    return 0.0 if since_s is None else max(now_s - since_s, 0.0) / order.unpicked_items


def load() -> None:
    """Load what is compiled, or compile it."""
    from rmfs_rules.scorers import backlog_search as search  # as above

    sending.load()
    lines, stock, none, one = columns_of((), 1), stock_of((), 1), np.zeros(0, np.int64), np.zeros(1, np.int64)
    search.items_on(stock, none, none)
    search.completed(lines, stock, none, one)
    search.worth(lines, stock, none, one, lines.due_s, lines.items, 0.0, True)


Score = Callable[[PodScores, "Station", Ids], Values]

SCORES: Mapping[str, Score] = MappingProxyType(
    {
        "completes": PodScores.completes,
        "picks": PodScores.picks,
        "work": PodScores.work,
        "demand": PodScores.demand,
        "nearest": PodScores.nearest,
        "random": PodScores.random,
    }
)
"""The scores by name."""
