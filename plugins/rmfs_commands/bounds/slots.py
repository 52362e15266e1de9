"""When orders can be complete at the earliest, from what pickers and robots can do in a time.

Who serves items does so one after the other: the starts of two of them are at least ``spacing`` apart, and an item is
done, which is picked or handled, ``lasts`` after its start. All times are ticks.
"""

from __future__ import annotations

from heapq import heappop, heappush

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

Ticks = NDArray[np.int64]


@frozen(eq=False)
class Servers:
    """Who serves items side by side: pickers, or robots that hold pods.

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
