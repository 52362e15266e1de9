"""When orders can be complete at the earliest, from what pickers and robots can do in a time.

A server of items serves one after the other: the starts of two of them are at least ``spacing`` apart, and an item is
done, which is picked or handled, ``lasts`` after its start. All times are ticks.
"""

from __future__ import annotations

from collections.abc import Sequence
from heapq import heappop, heappush

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from rmfs_core.clock import TICKS_PER_S, to_ticks
from rmfs_core.scenario import Scenario
from rmfs_core.simulation.services import Services
from rmfs_core.world import OrderData

Ticks = NDArray[np.int64]


@frozen(eq=False)
class Servers:
    """Servers that work side by side: pickers, or robots that hold pods.

    Parameters
    ----------
    opens
        Tick from which on each can start. Ascending, shape (servers,).
    spacing, lasts
        Ticks between two starts, and from a start until the item is done.
    """

    opens: Ticks
    spacing: int
    lasts: int

    def last_done(self, items: Ticks, released: Ticks | int) -> Ticks:
        """Tick at which so many items can be done, all servers at work from ``released`` on. Shape of ``items``.

        The smallest start before which, itself included, there are as many starts as items: a search in halves.
        """
        if self.opens[0] == self.opens[-1]:  # each takes the next item when all have one
            first: Ticks = np.maximum(released, self.opens[0])
            return first + self.spacing * ((items - 1) // len(self.opens)) + self.lasts
        opens = np.maximum(np.asarray(released)[..., None], self.opens)
        low = np.broadcast_to(opens.min(axis=-1), items.shape).copy()
        high = low + self.spacing * (items - 1)
        while (low < high).any():
            middle = (low + high) // 2
            starts = np.maximum((middle[:, None] - opens) // self.spacing + 1, 0).sum(axis=-1)
            enough = starts >= items
            high = np.where(enough, middle, high)
            low = np.where(enough, low, middle + 1)
        return low + self.lasts

    def completions(self, items: Ticks, arrivals: Ticks) -> Ticks:
        """Ticks before which no first, second, ... order can be complete, whatever is served when. Ascending."""
        alone = np.sort(self.last_done(items, arrivals))
        shortest_first = self.last_done(np.cumsum(np.sort(items)), int(arrivals.min()))
        return np.maximum(np.maximum(alone, shortest_first), self._preemptive(items, arrivals))

    def _preemptive(self, items: Ticks, arrivals: Ticks) -> Ticks:
        """Completions by one server as fast as all, who always serves the order with the least left."""
        work = self._work_until(arrivals)
        done = shortest_remaining_first(work, items * self.spacing)
        return self._tick_of(done) - (self.spacing - self.lasts)

    def _work_until(self, ticks: Ticks) -> Ticks:
        """Ticks of work that all together can have done."""
        if self.opens[0] == self.opens[-1]:
            alike: Ticks = len(self.opens) * np.maximum(ticks - self.opens[0], 0)
            return alike
        work: Ticks = np.maximum(ticks[:, None] - self.opens, 0).sum(axis=1)
        return work

    def _tick_of(self, work: Ticks) -> Ticks:
        """First tick at which so much work can be done."""
        before = np.cumsum(self.opens)
        working = np.searchsorted(self._work_until(self.opens), work, side="left").clip(1)
        ticks: Ticks = -((-work - before[working - 1]) // working)
        return ticks


def shortest_remaining_first(released: Ticks, work: Ticks) -> Ticks:
    """Return when jobs are done, ascending, if one server always works on the one with the least left.

    At every time no other way has more jobs done (L. Schrage, A proof of the optimality of the shortest remaining
    processing time discipline, Operations Research 16(3), 687-690, 1968, doi:10.1287/opre.16.3.687).

    Parameters
    ----------
    released, work
        When each job is there, and how long it takes alone. Shape (jobs,).
    """
    if not np.ptp(released):  # all are there at once
        alike: Ticks = released + np.cumsum(np.sort(work))
        return alike
    upcoming = sorted(zip(released.tolist(), work.tolist(), strict=True), reverse=True)
    left: list[int] = []
    done: list[int] = []
    now = 0
    while upcoming or left:
        if not left:
            now = max(now, upcoming[-1][0])
        while upcoming and upcoming[-1][0] <= now:
            heappush(left, upcoming.pop()[1])
        shortest = heappop(left)
        until = upcoming[-1][0] if upcoming else now + shortest
        if now + shortest <= until:
            now += shortest
            done.append(now)
        else:
            heappush(left, shortest - (until - now))
            now = until
    return np.array(done, dtype=np.int64)


def at_work(
    scenario: Scenario, orders: Sequence[OrderData], services: Services, opens: Ticks, robots: int
) -> tuple[tuple[Servers, Ticks], tuple[Servers, Ticks]]:
    """Return pickers and robots, each with the work of every order for them.

    Robots hold a pod while an item is picked. Work is the number of items. To both an item is done when it is picked,
    or handled where orders are complete only then. Where times vary, work is ticks, the least that the draws of an
    order's items come to.

    Parameters
    ----------
    scenario, orders, services
        The work and its duration.
    opens
        Tick from which on each picker can start. Ascending, shape (stations,).
    robots
        Number of robots.
    """
    pick, handle = to_ticks(scenario.stations.pick_s), to_ticks(scenario.stations.handle_s)
    done = handle if scenario.stations.release == "handled" else pick
    items = np.array([order.items for order in orders], dtype=np.int64)
    free = np.full(robots, opens[0])
    if not services.vary:
        return (Servers(opens, handle, done), items), (Servers(free, pick, done), items)
    work = np.array([_least_ticks(services, number, order.lines) for number, order in enumerate(orders)])
    picking, handling, in_hand = work.T
    if scenario.stations.release == "picked":  # each picker may have one of the items in hand yet
        handling = np.maximum(handling - in_hand * np.minimum(items, len(opens)), 1)
    return (Servers(opens, 1, 1), handling), (Servers(free, 1, 1), picking)


def _least_ticks(services: Services, order: int, lines: Sequence[tuple[int, int]]) -> tuple[int, int, int]:
    """Return the least ticks of picking and of handling an order of lines (SKU, items), whatever is decided.

    The third is the most that an item is handled for after it was picked.
    """
    items = np.array([services.item_s(order, sku, n) for sku, quantity in lines for n in range(quantity)])
    begun_s = min(services.begin_order_s(order, station) for station in range(len(services.speeds)))
    speeds = [speed for shifts in services.speeds for speed in shifts]
    begun_s += sum(services.begin_line_s(order, sku) for sku, _ in lines)
    ticks = (items.sum(axis=0) + begun_s) / max(speeds) * TICKS_PER_S - 2 * len(items)  # each is rounded
    in_hand = np.diff(items).max() / min(speeds) * TICKS_PER_S
    return max(int(ticks[0]), 1), max(int(ticks[1]), 1), int(in_hand) + 2
