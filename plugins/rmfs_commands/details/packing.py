"""Orders after their last pick: rows of packing.csv, and metrics of the same."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator
from typing import Any

from attrs import Factory, define

from rmfs_commands.details.spans import (
    Count,
    Handlers,
    Number,
    Span,
    goes_on,
    length,
    open_spans,
    overlap,
    percentile,
    ratio,
    within,
)
from rmfs_commands.processes.events import OrderPacked, PackingAssigned, PackingStarted, PartArrived, PartPut, PartSent
from rmfs_core.clock import TICKS_PER_S, to_seconds
from rmfs_core.events import DecisionMade, OrderArrived, OrderCancelled, OrderCompleted
from rmfs_core.info import RunInfo

COLUMNS = ("order", "packing_station", "box", "parts", "first_part_s", "last_part_s", "packing_s", "packed_s")


@define
class _Order:
    """State of an order: its packing station, its box, and ticks, -1 for one that is not known yet."""

    station: int
    box: int | None
    parts: list[int] = Factory(list)
    """When they came."""
    ready: int = -1
    """When it could be packed."""
    begun: int = -1
    packed: int = -1


class Packing:
    """Follows orders, boxes and packers.

    Parameters
    ----------
    run
        The run.
    begin
        The time from which on is counted.
    """

    def __init__(self, run: RunInfo, begin: int) -> None:
        section = run.scenario.packing
        self.on, self._begin, self._data = section is not None, begin, run.instance.orders
        self._goes_on, self._began, self._since = goes_on(run, begin), run.began or 0, run.since
        known = run.scenario.instance.arrivals.backlog is None
        self._arrived = {i: order.arrival_tick for i, order in enumerate(self._data)} if known else {}
        self._orders: dict[int, _Order] = {}
        self._last_pick: dict[int, int] = {}  # of orders, in the run
        self._boxes, self._unpacked, self.refused, self._totes = Count(), Count(), 0, 0
        self._open: dict[int, int] = {}  # when those arrived that are not packed
        self._busy: dict[int, list[Span]] = defaultdict(list)  # of packers, by packing station
        self._hourly: Counter[int] = Counter()
        self._cancelled: set[int] = set()
        self.handlers: Handlers = {}
        if section is not None:
            self._stations = run.warehouse.packing_stations
            self._section, self._all = section, section.boxes * len(self._stations)
            self.handlers = {
                DecisionMade: self._decided,
                OrderArrived: self._comes,
                OrderCompleted: self._picked,
                OrderCancelled: self._leaves,
                PackingAssigned: self._bound,
                PartSent: self._sent,
                PartArrived: self._part,
                PartPut: self._put,
                PackingStarted: self._started,
                OrderPacked: self._done,
            }

    def _comes(self, event: OrderArrived) -> None:
        self._arrived[event.order] = self._open[event.order] = event.tick
        self._unpacked.add(event.tick, 1)

    def _leaves(self, event: OrderCancelled) -> None:
        self._cancelled.add(event.order)
        self._open.pop(event.order, None)
        self._unpacked.add(event.tick, -1)

    def _decided(self, event: DecisionMade) -> None:
        self.refused += event.decides.assigns and event.tick >= self._begin and self._boxes.number >= self._all

    def _bound(self, event: PackingAssigned) -> None:
        self._orders[event.order] = _Order(event.packing, event.box)
        self._boxes.add(event.tick, event.box is not None)

    def _sent(self, event: PartSent) -> None:
        self._totes += event.tick >= self._begin

    def _part(self, event: PartArrived) -> None:
        order = self._orders[event.order]
        order.parts.append(event.tick)
        order.ready = event.tick

    def _put(self, event: PartPut) -> None:
        self._orders[event.order].ready = event.tick
        if not self._section.sorters:
            self._busy[event.packing].append((event.start_tick, event.tick))

    def _started(self, event: PackingStarted) -> None:
        self._orders[event.order].begun = event.tick

    def _picked(self, event: OrderCompleted) -> None:
        if event.tick > self._began:
            self._last_pick[event.order] = event.tick
        if self._section.packing_from == "picked":
            self._free(event)

    def _done(self, event: OrderPacked) -> None:
        self._orders[event.order].packed = event.tick
        self._open.pop(event.order, None)
        self._busy[event.packing].append((event.start_tick, event.tick))
        self._unpacked.add(event.tick, -1)
        self._hourly[event.tick // (3600 * TICKS_PER_S)] += event.tick >= self._since
        if self._section.packing_from == "packed":
            self._free(event)

    def _free(self, event: OrderCompleted | OrderPacked) -> None:
        self._boxes.add(event.tick, -(self._orders[event.order].box is not None))

    def rows(self) -> Iterator[dict[str, Any]]:
        """Yield a row for each order that has come to a packing station, in the order in which that was decided."""
        for i, order in self._orders.items():
            first, last = (order.parts[0], order.parts[-1]) if order.parts else (-1, -1)
            times = zip(COLUMNS[4:], (first, last, order.begun, order.packed), strict=True)
            box = None if order.box is None else order.box + 1
            told = {"order": self._data[i].name, "packing_station": order.station + 1, "box": box}
            told |= {"parts": len(order.parts)}
            yield told | {name: None if tick < 0 else to_seconds(tick) for name, tick in times}

    def hourly(self, rows: list[dict[str, Any]], end: int) -> None:
        """Add to the rows of hours how many orders were packed, and how many boxes were reserved, a mean over time.

        Where packers come and go, how many were on duty, too.
        """
        for row in rows if self.on else ():
            begin = max(row["hour"] * 3600 * TICKS_PER_S, self._began)
            until = max(min((row["hour"] + 1) * 3600 * TICKS_PER_S, end), begin)
            row |= {"orders_packed": self._hourly[row["hour"]], "boxes": round(self._boxes.mean(begin, until), 3)}
            if self._section.open is not None:
                open_ticks = sum(length(open_spans(station.hours, begin, until)) for station in self._stations)
                row["packers_on_duty"] = round(self._section.packers * open_ticks / max(until - begin, 1), 3)

    def values(self, end: int) -> dict[str, Number]:
        """Return the metrics by name; none where nothing is packed."""
        if not self.on:
            return {}
        packed = {i: order for i, order in self._orders.items() if order.packed >= 0}
        counted = {i: order for i, order in packed.items() if order.packed >= self._begin}
        own = {i: order for i, order in counted.items() if self._in_time(i)}
        timed = [order.packed - self._arrived[i] for i, order in own.items()]
        together = [order.parts[-1] - order.parts[0] for order in own.values() if order.box is not None]
        waits = [order.begun - order.ready for order in own.values()]
        last = max([order.packed for order in packed.values()], default=0)
        every = len(packed) + len(self._cancelled) == len(self._data)
        return {
            "orders_packed": len(counted),
            "packed_s": ratio(sum(timed), len(timed) * TICKS_PER_S),
            "packed_median_s": percentile(timed, 0.5),
            "packed_p95_s": percentile(timed, 0.95),
            "packed_makespan_s": to_seconds(last) if every else None,
            "consolidation_s": ratio(sum(together), len(together) * TICKS_PER_S),
            "consolidation_p95_s": percentile(together, 0.95),
            "packing_wait_s": ratio(sum(waits), len(waits) * TICKS_PER_S),
            "boxes_max": self._boxes.largest(self._begin, end),
            "boxes_mean": self._boxes.mean(self._begin, end),
            **self._packers(end),
            "splits_refused": self.refused,
            "totes": self._totes,
            "parts_per_order": ratio(sum(len(order.parts) for order in counted.values()), len(counted)),
            **self._late(end),
        }

    @property
    def after_s(self) -> float | None:
        """Mean time from the last pick to packed, of the orders counted whose last pick is in the run."""
        counted = (i for i, order in self._orders.items() if order.packed >= self._begin)
        after = [self._orders[i].packed - self._last_pick[i] for i in counted if i in self._last_pick]
        return ratio(sum(after), len(after) * TICKS_PER_S)

    @property
    def off_duty_percent(self) -> float:
        """Share of the time in which the packed orders waited for a packer at a closed packing station."""
        own = (order for i, order in self._orders.items() if order.packed >= self._begin and self._in_time(i))
        waits = [(order.station, order.ready, order.begun) for order in own]
        there = sum(length(open_spans(self._stations[at].hours, ready, begun)) for at, ready, begun in waits)
        whole = sum(begun - ready for _, ready, begun in waits)
        return 100 * (whole - there) / whole if whole else 0.0

    @property
    def packed_ticks(self) -> dict[int, int]:
        """When orders were packed."""
        return {i: order.packed for i, order in self._orders.items() if order.packed >= 0}

    def paid_ticks(self, end: int) -> int:
        """Return the time in which packers are there, or finish a task, and sorters are, summed over them."""
        open_ticks = sum(length(open_spans(station.hours, self._begin, end)) for station in self._stations)
        return self._ticks(end)[0] + self._section.sorters * open_ticks

    def left(self, tick: int) -> dict[str, Number]:
        """Return the metrics of the orders that are not packed when the run is over; none where nothing is packed."""
        ages = [tick - arrived for arrived in self._open.values()]
        return {"unpacked_end": len(ages), "unpacked_age_sum_h": sum(ages) / (3600 * TICKS_PER_S)} if self.on else {}

    def _packers(self, end: int) -> dict[str, Number]:
        """Return what share of the packers' time they were busy, and without a task though orders were not packed."""
        there, busy, starved = self._ticks(end)
        return {
            "packer_utilisation_percent": ratio(100 * busy, there),
            "packer_starved_percent": ratio(100 * starved, there),
        }

    def _ticks(self, end: int) -> tuple[int, int, int]:
        """Return the packers' time, and what of it they were busy, and without a task though orders were not packed."""
        packers, orders_wait = self._section.packers, self._unpacked.above_zero(self._begin, end)
        there = busy = starved = 0
        for station in self._stations:
            is_open = open_spans(station.hours, self._begin, end)
            here = [order for order in self._orders.values() if order.station == station.id]
            packing = [(order.begun, end) for order in here if order.packed < 0 <= order.begun]
            spans = within([*self._busy[station.id], *packing], self._begin, end)
            in_hours = sum(overlap([span], is_open) for span in spans)
            there += packers * length(is_open) + length(spans) - in_hours
            busy += length(spans)
            starved += packers * overlap(is_open, orders_wait) - in_hours
        return there, busy, starved

    def _late(self, end: int) -> dict[str, Number]:
        due = {i: order.due_tick for i, order in enumerate(self._data) if order.due_tick is not None}
        if not due:
            return {}
        done = {i: order.packed for i, order in self._orders.items() if order.packed >= 0}
        known = [i for i in due if self._in_time(i) and i not in self._cancelled and (i in done or due[i] < end)]
        late = sum(due[i] < done.get(i, end) for i in known)
        return {"late_packed": late, "late_packed_percent": ratio(100 * late, len(known))}

    def _in_time(self, order: int) -> bool:
        """Whether an order arrived from the time on from which is counted, or was there and not packed at a state's."""
        packed = self._orders[order].packed if order in self._orders else -1
        there = self._goes_on and not 0 <= packed < self._begin
        return (arrived := self._arrived.get(order, -1)) >= self._begin or (there and arrived >= 0)
