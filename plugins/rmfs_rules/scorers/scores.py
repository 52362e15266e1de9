"""What speaks for a pod: one number for each candidate, all of them at once."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from rmfs_core.clock import TICKS_PER_S
from rmfs_rules.helpers.pod_completing import KeptCompleted
from rmfs_rules.helpers.pod_sending import KeptPods, KeptSums
from rmfs_rules.scorers.wanted import Backlog, Held, Ids, Requests, Since, Values

if TYPE_CHECKING:
    from rmfs_core import PodTrip
    from rmfs_core.warehouse import Order, Station, WarehouseView


@frozen
class Weights:
    """What scores are made of.

    Parameters
    ----------
    count_backlog
        Whether orders of the backlog count among those that a pod completes.
    value
        What an item is worth, one of `SINCE`.
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


class Kept:
    """What is kept from call to call: the pods, how many of their free items are wanted, and the backlog.

    Attributes
    ----------
    pods
        Which can be sent, and what they have free.
    demanded, waited
        Sums of min(items free, items wanted), wanted in the whole system or in the backlog.
    orders
        Which orders of the backlog pods complete.
    by_age
        The same, by SKU and age; made when it is first needed.
    """

    def __init__(self) -> None:
        self.pods, self.demanded, self.waited, self.orders = KeptPods(), KeptSums(), KeptSums(), KeptCompleted()
        self.by_age: Backlog | None = None

    def load(self, *, orders: bool, by_age: bool = False) -> None:
        """Load what is compiled, or compile it; that for ``orders`` and ``by_age`` only if it is needed."""
        self.pods.load()
        self.demanded.load()
        if by_age:
            Backlog.load()
        if orders:
            self.orders.load()


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
    kept
        What is kept from call to call. Left out: nothing.
    """

    def __init__(
        self, warehouse: WarehouseView, rng: np.random.Generator, weights: Weights, kept: Kept | None = None
    ) -> None:
        self._warehouse, self._rng, self._weights = warehouse, rng, weights
        self._kept = kept or Kept()
        self._kept.pods.update(warehouse)
        self._free = self._kept.pods.items
        self._requests: dict[int, Requests] = {}

    def send(self, max_fetches: int, scores: Sequence[str]) -> list[PodTrip]:
        """Send the pods with the best scores to the stations that lack one."""
        return self._kept.pods.send(self._warehouse, max_fetches, lambda at, pods: self.choose(scores, at, pods))

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

        Of the backlog those count that what is left on the pod completes one after another; pods that are not among
        the best may have those that it completes alone with all it has, which are more.
        """
        here: Values = self._completed(station, pods).sum(axis=0).astype(np.float64)
        if not self._weights.count_backlog:
            return here
        total = here + self._kept.orders.alone(self._warehouse, self._kept.pods)[pods]
        if self._warehouse.unlimited_stock and not self._warehouse.filtered:
            return total
        shown = {order.id for order in self._warehouse.backlog} if self._warehouse.filtered else None
        exact = np.zeros(len(pods), np.bool_)
        while not exact[best := np.flatnonzero(total == total.max())].all():
            some = best[~exact[best]]
            rest = self._rest(station, pods[some])
            completed = self._kept.orders.one_after_another(len(some), rest.pod, rest.sku, rest.items, shown)
            total[some], exact[some] = here[some] + completed, True
        return total

    def picks(self, station: Station, pods: Ids) -> Values:
        """Uncovered requests of the station that the pod fulfils."""
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
            sums = np.concatenate(([0.0], np.cumsum(each[wanted.column == column])))
            total += sums[np.minimum(items[:, column], len(sums) - 1)]
        if weights.completion_boost:
            of_order = np.bincount(wanted.row, weights=each, minlength=len(wanted.needs))
            total += weights.completion_boost * (of_order @ self._completed(station, pods))
        if weights.backlog_weight:
            if weights.value == "picks" and not self._warehouse.filtered:
                waiting = self._waiting[wanted.skus]
                rest = np.minimum(np.maximum(items - wanted.needs.sum(axis=0), 0), waiting) - np.minimum(items, waiting)
                work = (self._waited[pods] + rest.sum(axis=1)).astype(np.float64)
            else:
                work = self._backlog.work(self._rest(station, pods), now_s, float(weights.value == "picks"))
            total += weights.backlog_weight * work
        return total

    def demand(self, station: Station, pods: Ids) -> Values:  # noqa: ARG002
        """Items wanted in the whole system, assigned or not, that the pod has free."""
        return self._demand[pods].astype(np.float64)

    def nearest(self, station: Station, pods: Ids) -> Values:
        """Seconds of loaded driving to the station, with a minus in front."""
        seconds: Values = self._kept.pods.ticks(self._warehouse, pods, station) / -TICKS_PER_S
        return seconds

    def random(self, station: Station, pods: Ids) -> Values:  # noqa: ARG002
        """A lot drawn for each pod."""
        return self._rng.random(len(pods))

    # What they are made of

    @cached_property
    def _backlog(self) -> Backlog:
        """The lines of the backlog as it is shown, by SKU and age."""
        since = SINCE[self._weights.value]
        if not self._warehouse.filtered:
            if self._kept.by_age is None:
                self._kept.by_age = Backlog(since)
            self._kept.by_age.update(self._warehouse)
            if self._kept.by_age.whole:
                return self._kept.by_age
        shown = Backlog(since)
        shown.read(self._warehouse)
        return shown

    @cached_property
    def _waiting(self) -> NDArray[np.int64]:
        """Items by SKU that are wanted in the backlog: all that are, but for those assigned."""
        waiting = self._warehouse.open_demand()
        assigned = [request.sku for station in self._warehouse.stations for request in station.open_requests]
        np.subtract.at(waiting, np.array(assigned, np.int64), 1)
        return waiting

    @cached_property
    def _waited(self) -> Ids:
        """Free items by pod that are wanted in the backlog."""
        return self._kept.waited.of_free(self._kept.pods, self._waiting)

    @cached_property
    def _demand(self) -> Ids:
        """Free items by pod that are wanted in the whole system."""
        return self._kept.demanded.of_free(self._kept.pods, self._warehouse.open_demand())

    def _wanted(self, station: Station) -> Requests:
        if station.id not in self._requests:
            self._requests[station.id] = Requests.of(station.uncovered_requests)
        return self._requests[station.id]

    def _take(self, pod: int, station: Station) -> None:
        """Let the items of a chosen pod go to the oldest requests, as they will."""
        wanted = self._wanted(station)
        left = Counter(dict(zip(wanted.skus.tolist(), self._on(np.array([pod]), wanted.skus)[0].tolist(), strict=True)))
        still = []
        for request in wanted.requests:
            if left[request.sku] > 0:
                left[request.sku] -= 1
            else:
                still.append(request)
        self._requests[station.id] = Requests.of(still)

    def _on(self, pods: Ids, skus: Ids) -> NDArray[np.int64]:
        """Return the free items of SKUs on pods, shape (pods, SKUs)."""
        return self._kept.pods.items_on(pods, skus)

    def _completed(self, station: Station, pods: Ids) -> NDArray[np.bool_]:
        """Return which orders of a station the pods complete, shape (orders, pods), if the oldest take first."""
        wanted = self._wanted(station)
        left = self._on(pods, wanted.skus)
        completed = np.zeros((len(wanted.needs), len(pods)), np.bool_)
        for order, needs in enumerate(wanted.needs):
            completed[order] = (left >= needs).all(axis=1)
            left -= completed[order][:, None] * needs
        return completed

    def _rest(self, station: Station, pods: Ids) -> Held:
        """Return what the pods have free besides what the station wants."""
        entries, rank = self._kept.pods.entries_of(pods)
        wanted = np.zeros(self._warehouse.n_skus, np.int64)
        wanted[self._wanted(station).skus] = self._wanted(station).needs.sum(axis=0)
        sku = self._free.sku[entries]
        items = np.maximum(self._free.number[entries] - wanted[sku], 0)
        return Held(len(pods), rank, sku, items)


SINCE: Mapping[str, Since] = MappingProxyType(
    {
        "picks": lambda _order: math.inf,
        "age": lambda order: order.arrival_s,
        "lateness": lambda order: math.inf if order.due_s is None else order.due_s,
    }
)
"""From when on an order is worth more, by what its items are worth: the seconds since then, or 1 each."""


def _worth(value: str, order: Order, now_s: float) -> float:
    """Return what an item of an order is worth."""
    return 1.0 if value == "picks" else max(now_s - SINCE[value](order), 0.0) / order.unpicked_items


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
