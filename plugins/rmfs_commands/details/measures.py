"""Metrics of orders: percentiles of their times, and lateness."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping

from rmfs_commands.details.catalogue import on_time
from rmfs_commands.details.departures import last_truck
from rmfs_commands.details.spans import Handlers, Number, goes_on, percentile, ratio
from rmfs_core.clock import TICKS_PER_S, to_seconds
from rmfs_core.events import OrderArrived, OrderAssigned, OrderCancelled, OrderCompleted, VisitStarted
from rmfs_core.info import RunInfo
from rmfs_core.world import OrderData


class Measures:
    """Follows the orders.

    Parameters
    ----------
    run
        The run.
    begin
        The time from which on is counted.
    """

    def __init__(self, run: RunInfo, begin: int) -> None:
        self._orders = run.instance.orders
        self._begin, self._goes_on = begin, goes_on(run, begin)
        known = run.scenario.instance.arrivals.backlog is None
        self._arrived = {i: order.arrival_tick for i, order in enumerate(self._orders)} if known else {}
        self._assigned: dict[int, int] = {}
        self._completed: dict[int, int] = {}
        self._cancelled: dict[int, int] = {}
        self._open: dict[int, int] = {}  # when those arrived that are not complete
        self._backlog = 0
        self.visits = 0
        self.handlers: Handlers = {
            OrderArrived: self._note_arrived,
            OrderAssigned: self._note_assigned,
            OrderCompleted: self._note_completed,
            OrderCancelled: self._note_cancelled,
            VisitStarted: self._note_visit,
        }

    def _note_arrived(self, event: OrderArrived) -> None:
        self._arrived[event.order] = self._open[event.order] = event.tick
        self._backlog += 1

    def _note_assigned(self, event: OrderAssigned) -> None:
        self._assigned[event.order] = event.tick
        self._backlog -= event.complete

    def _note_completed(self, event: OrderCompleted) -> None:
        self._completed[event.order] = event.tick
        self._open.pop(event.order, None)

    def _note_cancelled(self, event: OrderCancelled) -> None:
        self._cancelled[event.order] = event.tick
        self._open.pop(event.order, None)
        self._backlog -= 1

    def _note_visit(self, event: VisitStarted) -> None:
        self.visits += event.tick >= self._begin

    @property
    def completed(self) -> int:
        """Orders completed since the time from which on is counted."""
        return sum(tick >= self._begin for tick in self._completed.values())

    def values(self, end: int, until: int | None = None) -> dict[str, Number]:
        """Return the metrics by name."""
        counted = {order: tick for order, tick in self._completed.items() if tick >= self._begin}
        items = sum(self._orders[order].items for order in counted)
        lines = sum(len(self._orders[order].lines) for order in counted)
        timed = {i: tick for i, tick in counted.items() if self._goes_on or self._arrived[i] >= self._begin}
        arrived = self._arrived
        times = {
            "turnover": [tick - arrived[order] for order, tick in timed.items()],
            "turnover_backlog": [self._assigned[order] - arrived[order] for order in timed],
            "turnover_station": [tick - self._assigned[order] for order, tick in timed.items()],
        }
        found: dict[str, Number] = {}
        for name, values in times.items():
            found[f"{name}_median_s"], found[f"{name}_p95_s"] = percentile(values, 0.5), percentile(values, 0.95)
        found["items_per_line"] = ratio(items, lines)
        found["orders_per_visit"] = ratio(len(counted), self.visits)
        if any(order.cancelled_tick is not None for order in self._orders):
            found["orders_cancelled"] = sum(tick >= self._begin for tick in self._cancelled.values())
        return found | self._lateness(end, until)

    def left(self, tick: int) -> dict[str, Number]:
        """Return the metrics of the orders that are open when the run is over."""
        ages = [tick - arrived for arrived in self._open.values()]
        return {
            "open_orders_end": len(ages),
            "backlog_end": self._backlog,
            "open_age_sum_h": sum(ages) / (3600 * TICKS_PER_S),
            "open_age_s": ratio(sum(ages), len(ages) * TICKS_PER_S),
            "open_age_max_s": to_seconds(max(ages)) if ages else None,
        }

    def due(self, done: Mapping[int, int]) -> Iterator[tuple[OrderData, int, int | None]]:
        """Yield each order with a due time that counts, that time, and when it was done; ``done``: ticks by order."""
        for i, order in enumerate(self._orders):
            arrived = self._arrived.get(i, -1) >= self._begin
            there = self._goes_on and done.get(i, self._begin) >= self._begin  # not complete when the run began
            if order.due_tick is not None and i not in self._cancelled and (arrived or there):
                yield order, order.due_tick, done.get(i)

    @property
    def completed_ticks(self) -> Mapping[int, int]:
        """When orders were completed."""
        return self._completed

    def _lateness(self, end: int, until: int | None) -> dict[str, Number]:
        """Return the metrics of orders with a due time; none where no order has one."""
        if all(order.due_tick is None for order in self._orders):
            return {}
        due: Counter[int] = Counter()
        late: Counter[int] = Counter()
        tardiness = []
        orders = list(self.due(self._completed))
        by = last_truck(orders, end, until)
        for order, due_tick, done in orders:
            if done is not None:
                tardiness.append(max(done - due_tick, 0))
            if due_tick <= by and (done is not None or due_tick < end):
                due[order.priority] += 1
                late[order.priority] += done is None or done > due_tick
        return {
            "late_orders": late.total(),
            "late_percent": ratio(100 * late.total(), due.total()),
            "tardiness_s": ratio(sum(tardiness), len(tardiness) * TICKS_PER_S),
            "tardiness_p95_s": percentile(tardiness, 0.95),
            "on_time_percent": ratio(100 * (due - late).total(), due.total()),
            **{on_time(one).name: 100 * (due[one] - late[one]) / due[one] for one in sorted(due)},
        }
