"""bundles.csv, stock.csv and the metrics of replenishment, worked out anew from a trace."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np

from rmfs_commands.trace.reader import Trace
from rmfs_commands.validation.stock import joined_at, lets_wait
from rmfs_commands.validation.tables import HOUR, Row, measured_from
from rmfs_core.clock import TICKS_PER_S
from rmfs_core.events import (
    BundleArrived,
    BundleAssigned,
    BundleStored,
    ItemPicked,
    OrderArrived,
    OrderCompleted,
    PodStored,
    TaskAssigned,
    VisitEnded,
)


def bundles_of(trace: Trace) -> Iterator[Row]:
    """Yield the rows of bundles.csv."""
    assigned = {e.bundle: e.tick / TICKS_PER_S for e in trace.events if isinstance(e, BundleAssigned)}
    stored = {e.bundle: e for e in trace.events if isinstance(e, BundleStored)}
    for event in trace.events:
        if isinstance(event, BundleArrived):
            done = stored.get(event.bundle)
            yield {
                "bundle": event.name,
                "sku": trace.instance.skus[event.sku],
                "items": event.items,
                "arrival_s": event.tick / TICKS_PER_S,
                "assigned_s": assigned.get(event.bundle),
                "stored_s": None if done is None else done.tick / TICKS_PER_S,
                "station": None if done is None else trace.stations[done.station]["name"],
                "pod": None if done is None else trace.instance.pods[done.pod].name,
                "visit": None if done is None else done.visit,
            }


class _Stock:
    """Items of each SKU on all pods together, which change with the events; None: unlimited."""

    def __init__(self, trace: Trace) -> None:
        self.held: Counter[int] = Counter()
        self.endless = {sku for pod in trace.instance.pods for sku, number in pod.contents if number is None}
        for pod in trace.instance.pods:
            self.held.update({sku: number or 0 for sku, number in pod.contents if sku not in self.endless})
        self.items = sum(self.held.values())

    @property
    def skus(self) -> int:
        """SKUs of which there is an item."""
        return len(self.endless) + sum(number > 0 for number in self.held.values())

    def change(self, event: BundleStored | ItemPicked) -> bool:
        """Take in an event; return whether it has left nothing of a SKU."""
        number = event.items if isinstance(event, BundleStored) else -1
        if event.sku in self.endless:
            return False
        self.held[event.sku] += number
        self.items += number
        return self.held[event.sku] == 0


def stock_of(trace: Trace) -> Iterator[Row]:
    """Yield the rows of stock.csv."""
    stock, counted, hour = _Stock(trace), Counter[str](), 0
    last = max([trace.tick - 1, 0, *(e.tick for e in trace.events if isinstance(e, BundleStored | ItemPicked))]) // HOUR

    def row() -> Row:
        there = {"items_in_stock": stock.items, "skus_in_stock": stock.skus}
        moved = {name: counted[name] for name in ("items_picked", "items_stored")}
        return {"hour": hour, "start_s": hour * 3600, **there, **moved}

    for event in trace.events:
        if isinstance(event, BundleStored | ItemPicked):
            while hour < event.tick // HOUR:
                yield row()
                counted.clear()
                hour += 1
            stock.change(event)
            counted.update({"items_picked": 1} if isinstance(event, ItemPicked) else {"items_stored": event.items})
    while hour <= last:
        yield row()
        counted.clear()
        hour += 1


def recompute_replenishment(trace: Trace) -> dict[str, float | None]:
    """Every metric of replenishment by name."""
    begin = measured_from(trace)
    end = max(trace.tick, begin)
    arrived = {e.bundle: e.tick for e in trace.events if isinstance(e, BundleArrived)}
    stored = [e for e in trace.events if isinstance(e, BundleStored) and e.tick >= begin]
    took = [e.tick - arrived[e.bundle] for e in stored if arrived.get(e.bundle, -1) >= begin]
    items, visits = sum(e.items for e in stored), len({e.visit for e in stored})
    stock, outs = _Stock(trace), 0
    ticks, levels = [0], [(stock.items, stock.skus)]
    for event in trace.events:
        if isinstance(event, BundleStored | ItemPicked) and (trace.state is None or event.tick > trace.began):
            outs += stock.change(event) and event.tick >= begin
            ticks.append(event.tick)
            levels.append((stock.items, stock.skus))
    lasts = np.diff(np.clip([*ticks, end], begin, end))
    means = (lasts @ np.array(levels, dtype=np.int64)) / max(end - begin, 1)
    busy = len(trace.robots) * (end - begin)
    return {
        "bundles_stored": len(stored),
        "items_stored": items,
        "bundle_turnover_s": float(np.mean(took)) / TICKS_PER_S if took else None,
        "replenishment_visits": visits,
        "items_per_replenishment_visit": items / visits if visits else None,
        "stock_outs": outs,
        **_waited(trace, begin),
        "items_in_stock_mean": float(means[0]),
        "skus_in_stock_mean": float(means[1]),
        "replenishment_robot_percent": 100 * _replenishing_ticks(trace, begin) / busy if busy else None,
    }


def _waited(trace: Trace, begin: int) -> dict[str, float | None]:
    """Return how long completed orders waited for stock; nothing where none does."""
    if not lets_wait(trace):
        return {}
    arrived = {e.order: e.tick for e in trace.events if isinstance(e, OrderArrived)}
    joined = joined_at(trace)
    done = [e.order for e in trace.events if isinstance(e, OrderCompleted) and e.tick >= begin]
    waits = [joined.get(order, arrived[order]) - arrived[order] for order in done if arrived.get(order, -1) >= begin]
    return {"turnover_stock_s": float(np.mean(waits)) / TICKS_PER_S if waits else None}


def _replenishing_ticks(trace: Trace, begin: int) -> int:
    """Return the time of trips to visits in which bundles were stored and nothing picked, and of the ways back."""
    storing = {(e.visit, e.pod) for e in trace.events if isinstance(e, BundleStored)}
    since: dict[int, int] = {}
    back: dict[int, bool] = {}
    total = 0
    for event in trace.events:
        match event:
            case TaskAssigned():
                since[event.pod] = event.tick
            case VisitEnded():
                back[event.pod] = (event.visit, event.pod) in storing and not event.picks
                total += back[event.pod] * (max(event.tick, begin) - max(since.get(event.pod, event.tick), begin))
                since[event.pod] = event.tick
            case PodStored():
                if back.pop(event.pod, False):  # else it has picked, or was carried elsewhere without a visit
                    total += max(event.tick, begin) - max(since[event.pod], begin)
            case _:
                pass
    return total
