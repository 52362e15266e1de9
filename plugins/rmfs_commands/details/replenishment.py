"""Bundles stored, and stock: rows of bundles.csv and stock.csv, and metrics of the same."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from attrs import define

from rmfs_commands.details.spans import Count, Handlers, Number, ratio
from rmfs_core.clock import TICKS_PER_S, to_seconds
from rmfs_core.events import (
    BundleArrived,
    BundleAssigned,
    BundleStored,
    Event,
    ItemPicked,
    PodStored,
    TaskAssigned,
    VisitEnded,
)
from rmfs_core.info import RunInfo

BUNDLE_COLUMNS = ("bundle", "sku", "items", "arrival_s", "assigned_s", "stored_s", "station", "pod", "visit")
STOCK_COLUMNS = ("hour", "start_s", "items_in_stock", "skus_in_stock", "items_picked", "items_stored")
_HOUR = 3600 * TICKS_PER_S


@define
class _Bundle:
    """State of a bundle."""

    name: str
    sku: int
    items: int
    arrived: int
    assigned: int | None = None
    stored: BundleStored | None = None


@define
class _Trip:
    """A pod on its way: since when, and whether the last visit stored something and picked nothing."""

    since: int
    stored: bool = False


class Replenishment:
    """Follows bundles and stock.

    Parameters
    ----------
    run
        The run.
    begin
        The time from which on is counted.
    """

    def __init__(self, run: RunInfo, begin: int) -> None:
        self.on = run.instance.restocked
        self._begin, self._skus = begin, run.instance.skus
        self._names = [pod.name for pod in run.instance.pods]
        self._robots = len(run.warehouse.robots)
        self._bundles: dict[int, _Bundle] = {}
        self._since = run.warehouse.now_tick
        self._visits: set[int] = set()
        held: dict[int, int | None] = {}
        for pod in run.instance.pods:
            for sku, items in pod.contents:
                before = held.get(sku, 0)
                held[sku] = None if items is None or before is None else before + items
        self._held = {sku: items for sku, items in held.items() if items is not None}
        self._endless = held.keys() - self._held.keys()
        self._items, self._in_stock, self.stock_outs = Count(), Count(), 0
        self._items.add(0, sum(self._held.values()))
        self._in_stock.add(0, sum(items > 0 for items in self._held.values()) + len(self._endless))
        self._hours: list[list[int]] = []
        self._trips: dict[int, _Trip] = {}
        self._stored_in: dict[int, int] = {}  # pod -> visit in which a bundle was stored last
        self._robot_ticks = 0
        self.handlers: Handlers = {}
        if self.on:
            self.handlers = {
                BundleArrived: self._arrived,
                BundleAssigned: self._assigned,
                BundleStored: self._bundle_stored,
                ItemPicked: self._picked,
                TaskAssigned: self._set_out,
                VisitEnded: self._visited,
                PodStored: self._back,
            }

    def _arrived(self, event: BundleArrived) -> None:
        self._bundles[event.bundle] = _Bundle(event.name, event.sku, event.items, event.tick)

    def _assigned(self, event: BundleAssigned) -> None:
        self._bundles[event.bundle].assigned = event.tick

    def _bundle_stored(self, event: BundleStored) -> None:
        self._bundles[event.bundle].stored = event
        self._stored_in[event.pod] = event.visit
        if event.tick >= self._begin:
            self._visits.add(event.visit)
        self._change(event, event.sku, event.items)

    def _picked(self, event: ItemPicked) -> None:
        if event.tick >= self._since:  # else a run that began in a state knows it
            self._change(event, event.sku, -1)

    def _change(self, event: Event, sku: int, items: int) -> None:
        """Note that there are more or fewer items of a SKU from now on."""
        self._until(event.tick // _HOUR)
        self._hours[-1][3 if items > 0 else 2] += abs(items)
        if sku in self._endless:
            return
        before = self._held.get(sku, 0)
        self._held[sku] = before + items
        self._items.add(event.tick, items)
        self._in_stock.add(event.tick, (before + items > 0) - (before > 0))
        self.stock_outs += before + items == 0 and event.tick >= self._begin

    def _set_out(self, event: TaskAssigned) -> None:
        self._trips[event.pod] = _Trip(event.tick)

    def _visited(self, event: VisitEnded) -> None:
        trip = self._trips.setdefault(event.pod, _Trip(event.tick))
        trip.stored = self._stored_in.get(event.pod) == event.visit and event.picks == 0
        self._pass(trip, event.tick)

    def _back(self, event: PodStored) -> None:
        if (trip := self._trips.pop(event.pod, None)) is not None:
            self._pass(trip, event.tick)

    def _pass(self, trip: _Trip, tick: int) -> None:
        if trip.stored:
            self._robot_ticks += max(tick, self._begin) - max(trip.since, self._begin)
        trip.since = tick

    def _until(self, hour: int) -> None:
        """Begin hours up to one, each with the stock that the one before it has left."""
        while len(self._hours) <= hour:
            if self._hours:
                self._hours[-1][:2] = self._items.number, self._in_stock.number
            self._hours.append([0, 0, 0, 0])

    def bundles(self) -> Iterator[dict[str, Any]]:
        """Yield a row for each bundle that arrived; nothing where it has not come to that."""
        for bundle in self._bundles.values():
            stored = bundle.stored
            told = (bundle.name, self._skus[bundle.sku], bundle.items, to_seconds(bundle.arrived))
            assigned = None if bundle.assigned is None else to_seconds(bundle.assigned)
            where = (stored.time_s, str(stored.station + 1), self._names[stored.pod], stored.visit) if stored else ()
            yield dict.fromkeys(BUNDLE_COLUMNS) | dict(zip(BUNDLE_COLUMNS, (*told, assigned, *where), strict=False))

    def stock(self, end: int) -> Iterator[dict[str, Any]]:
        """Yield a row for each hour that the run has seen; stock is that at the end of the hour."""
        self._until(max(end - 1, 0) // _HOUR)
        self._hours[-1][:2] = self._items.number, self._in_stock.number
        first = self._since // _HOUR  # a run that begins in a state has no hours before
        for hour, numbers in enumerate(self._hours[first:], first):
            yield dict(zip(STOCK_COLUMNS, (hour, hour * 3600, *numbers), strict=True))

    def values(self, end: int, of_orders: Mapping[str, Number]) -> dict[str, Number]:
        """Return the metrics by name, with those of orders among them; none where there is no replenishment."""
        if not self.on:
            return {}
        done = [(bundle, stored) for bundle in self._bundles.values() if (stored := bundle.stored) is not None]
        done = [(bundle, stored) for bundle, stored in done if stored.tick >= self._begin]
        timed = [stored.tick - bundle.arrived for bundle, stored in done if bundle.arrived >= self._begin]
        items = sum(bundle.items for bundle, _ in done)
        return {
            "bundles_stored": len(done),
            "items_stored": items,
            "bundle_turnover_s": ratio(sum(timed), len(timed) * TICKS_PER_S),
            "replenishment_visits": len(self._visits),
            "items_per_replenishment_visit": ratio(items, len(self._visits)),
            "stock_outs": self.stock_outs,
            **of_orders,
            "items_in_stock_mean": self._items.mean(self._begin, end),
            "skus_in_stock_mean": self._in_stock.mean(self._begin, end),
            "replenishment_robot_percent": ratio(100 * self._robot_ticks, self._robots * (end - self._begin)),
        }
