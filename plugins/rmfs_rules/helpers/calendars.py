"""Numbers that wait for their time."""

from __future__ import annotations

import heapq
from typing import Any

import numpy as np
from numpy.typing import NDArray


class Calendar:
    """Numbers by time. Many that are added at once are sorted once; few are put into a heap."""

    def __init__(self) -> None:
        self._heap: list[tuple[float, int]] = []
        self._sorted: list[list[Any]] = []  # times and numbers, earliest first, and how many are taken out

    def add(self, entries: list[tuple[float, int]]) -> None:
        """Take in times and numbers."""
        if len(entries) > 256:
            times, numbers = (np.array(of) for of in zip(*sorted(entries), strict=True))
            self._sorted.append([times, numbers, 0])
        else:
            for entry in entries:
                heapq.heappush(self._heap, entry)

    def before(self, time: float) -> NDArray[np.int64]:
        """Take out and return the numbers whose time is earlier than one."""
        few = []
        while self._heap and self._heap[0][0] < time:
            few.append(heapq.heappop(self._heap)[1])
        found = [np.array(few, np.int64)]
        for entries in self._sorted:
            times, numbers, begin = entries
            entries[2] = end = int(times.searchsorted(time))
            found.append(numbers[begin:end])
        return np.concatenate(found)
