"""Numbers that wait for their time."""

from __future__ import annotations

import heapq


class Calendar:
    """Numbers by time. Many that are added at once are sorted once; few are put into a heap."""

    def __init__(self) -> None:
        self._heap: list[tuple[float, int]] = []
        self._sorted: list[list[tuple[float, int]]] = []  # latest first

    def add(self, entries: list[tuple[float, int]]) -> None:
        """Take in times and numbers."""
        if len(entries) > 256:
            self._sorted.append(sorted(entries, reverse=True))
        else:
            for entry in entries:
                heapq.heappush(self._heap, entry)

    def before(self, time: float) -> list[int]:
        """Take out and return the numbers whose time is earlier than one."""
        found = []
        while self._heap and self._heap[0][0] < time:
            found.append(heapq.heappop(self._heap)[1])
        for entries in self._sorted:
            while entries and entries[-1][0] < time:
                found.append(entries.pop()[1])
        return found
