"""Code shared by observers: spans of time, in ticks, percentiles, and functions called at events."""

from __future__ import annotations

import math
from array import array
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rmfs_core.clock import TICKS_PER_S, to_seconds
from rmfs_core.events import Event
from rmfs_core.info import RunInfo
from rmfs_core.timetable import Timetable

TICKS_PER_HOUR = 3600 * TICKS_PER_S
Span = tuple[int, int]
Number = int | float | None
Handlers = Mapping[type[Event], Callable[[Any], None]]
"""Functions called at each kind of event."""


def goes_on(run: RunInfo, begin: int) -> bool:
    """Whether a run goes on from a state, and counts from there: then also orders that arrived before."""
    began = run.began
    return began is not None and begin <= began + 1


def ratio(part: float, whole: float) -> float | None:
    """``part / whole``, or None when there is no whole."""
    return part / whole if whole else None


def percentile(values: Sequence[int], share: float) -> float | None:
    """Return the percentile of ticks in seconds, interpolated between the two nearest as numpy does; None of none."""
    if not values:
        return None
    ordered = sorted(values)
    place = share * (len(ordered) - 1)
    below = math.floor(place)
    above = min(below + 1, len(ordered) - 1)
    return to_seconds(ordered[below]) + (place - below) * to_seconds(ordered[above] - ordered[below])


def merged(spans: Iterable[Span]) -> list[Span]:
    """Return spans in the order of time, joined where they overlap or touch."""
    found: list[Span] = []
    for begin, end in sorted(spans):
        if found and begin <= found[-1][1]:
            found[-1] = (found[-1][0], max(end, found[-1][1]))
        elif begin < end:
            found.append((begin, end))
    return found


def open_spans(hours: Timetable, begin: int, end: int) -> list[Span]:
    """Return when a timetable is open between two times."""
    spans, tick = [], begin
    while tick < end:
        change = hours.next_change(tick)
        until = end if change is None else min(change, end)
        if hours.at(tick):
            spans.append((tick, until))
        tick = until
    return merged(spans)


def within(spans: Iterable[Span], begin: int, end: int) -> list[Span]:
    """Return what of spans lies between two times."""
    return [(max(a, begin), min(b, end)) for a, b in spans if a < end and b > begin]


def length(spans: Iterable[Span]) -> int:
    """Sum of the lengths of spans that do not overlap."""
    return sum(end - begin for begin, end in spans)


def overlap(ours: Sequence[Span], theirs: Sequence[Span]) -> int:
    """Time that lies in spans of both, each merged."""
    total = i = j = 0
    while i < len(ours) and j < len(theirs):
        total += max(min(ours[i][1], theirs[j][1]) - max(ours[i][0], theirs[j][0]), 0)
        if ours[i][1] < theirs[j][1]:
            i += 1
        else:
            j += 1
    return total


def outside(ours: Sequence[Span], theirs: Sequence[Span]) -> list[Span]:
    """Return what of our spans lies in none of theirs, each merged."""
    found: list[Span] = []
    for start, end in ours:
        begin = start
        for span in theirs:
            if span[0] < end and span[1] > begin:
                found.append((begin, span[0]))
                begin = span[1]
        found.append((begin, end))
    return merged(found)


class Count:
    """A number that goes up and down: when it is above 0, its mean over time and its maximum."""

    def __init__(self) -> None:
        self.number = 0
        self._ticks, self._numbers = array("q", [0]), array("q", [0])  # a run of days has very many

    def add(self, tick: int, change: int) -> None:
        """Change the number at a time."""
        self.number += change
        if self._ticks[-1] == tick:
            self._numbers[-1] = self.number
        else:
            self._ticks.append(tick)
            self._numbers.append(self.number)

    def _spans(self, begin: int, end: int) -> list[tuple[int, int, int]]:
        """Return begin, end and number of each time with one number."""
        ends, steps = [*self._ticks[1:], end], zip(self._ticks, self._numbers, strict=True)
        found = ((max(a, begin), min(b, end), number) for (a, number), b in zip(steps, ends, strict=True))
        return [(a, b, number) for a, b, number in found if a < b]

    def at(self, ticks: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the numbers from some times on. Shape of ``ticks``."""
        return np.array(self._numbers)[np.searchsorted(np.array(self._ticks), ticks, side="right") - 1]

    @property
    def ticks(self) -> NDArray[np.int64]:
        """When the number changed."""
        return np.array(self._ticks)

    def above_zero(self, begin: int, end: int) -> list[Span]:
        """Return when it is above 0, between two times."""
        return merged((a, b) for a, b, number in self._spans(begin, end) if number > 0)

    def mean(self, begin: int, end: int) -> float:
        """Mean over time."""
        return sum((b - a) * number for a, b, number in self._spans(begin, end)) / max(end - begin, 1)

    def largest(self, begin: int, end: int) -> int:
        """Return the largest number that lasted."""
        return max((number for _, _, number in self._spans(begin, end)), default=0)
