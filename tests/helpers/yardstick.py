"""A fixed piece of work whose CPU time stands for the machine, so that figures of different machines can be compared.

A third of it each: a compiled search over arrays, Python's objects and dictionaries, and simpy's events. It never
changes: figures in yardsticks that are kept would mean something else.
"""

import time
from collections import OrderedDict
from collections.abc import Callable, Iterator
from heapq import heappop, heappush

import numpy as np
import simpy
from attrs import frozen
from numba import njit

SIDE = 60


@frozen
class _Step:
    """Something small, as events and legs are."""

    at: int
    before: int
    time_s: float


@njit(cache=True)
def _search(side, start):  # type: ignore[no-untyped-def]
    """Sum of the least costs from a cell of a square to all others, where cells cost 1 to 7."""
    cells = side * side
    costs = np.full(cells, 1 << 40, np.int64)
    costs[start] = 0
    queue = [(0, start)]
    while queue:
        cost, cell = heappop(queue)
        if cost > costs[cell]:
            continue
        for step in (-side, -1, 1, side):
            other = cell + step
            if 0 <= other < cells and (abs(step) == side or other // side == cell // side):
                reached = cost + 1 + other * 31 % 7
                if reached < costs[other]:
                    costs[other] = reached
                    heappush(queue, (reached, other))
    return costs.sum()


def _objects(number: int) -> int:
    kept: OrderedDict[int, _Step] = OrderedDict()
    total = 0
    for i in range(number):
        step = _Step(i % 997, i, i / 1000)
        kept[step.at] = step
        kept.move_to_end(step.at)
        if i % 7 == 0:
            total += sum(one.before for one in list(kept.values())[:5])
    return total


def _events(number: int) -> float:
    env = simpy.Environment()

    def process(pause: int) -> Iterator[simpy.Event]:
        for _ in range(number):
            yield env.timeout(pause)

    for pause in range(1, 21):
        env.process(process(pause))
    env.run()
    return float(env.now)


def _work() -> None:
    for start in range(320):
        _search(SIDE, start)
    _objects(24_000)
    _events(5_000)


def yardstick_s() -> float:
    """Return the seconds of processor time that the yardstick takes now; what is compiled is loaded before."""
    _search(3, 0)
    start = time.process_time()
    _work()
    return time.process_time() - start


def in_yardsticks(measure: Callable[[], float]) -> float:
    """Return seconds of processor time that are measured, in yardsticks: one is taken before that and one after."""
    before = yardstick_s()
    return 2 * measure() / (before + yardstick_s())
