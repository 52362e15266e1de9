"""Days drawn from the orders of a file: whole orders, as often as a day of their kind would have them, by a seed."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from contextlib import suppress
from typing import Any

import numpy as np
from attrs import evolve, frozen
from numpy.typing import NDArray

from rmfs_commands.instances.calendar import Calendar
from rmfs_core.clock import TICKS_PER_S
from rmfs_core.errors import InputError
from rmfs_core.randomness import stream
from rmfs_core.scenario.model import MOST_ORDERS, Scale, Scenario
from rmfs_core.timetable import DAY, read_spans
from rmfs_core.wording import shown_short
from rmfs_core.world import Instance, OrderData

HOUR = 3600 * TICKS_PER_S
MOST_TIMES = 1000
"""How often an order may come in the mean."""

_PEAK = re.compile(r"(\d\d:\d\d)-(\d\d:\d\d)=(\d{1,6}(?:\.\d{1,6})?)", re.ASCII)

Ints = NDArray[np.int64]


@frozen
class Peak:
    """A part of the day, in ticks from midnight, in which so many times as many orders come; it may pass midnight."""

    begin: int
    end: int
    times: float

    def holds(self, ticks: Ints) -> NDArray[np.bool_]:
        """Return whether each of some ticks of the day is in it."""
        return np.asarray((ticks - self.begin) % DAY < ((self.end - self.begin) % DAY or DAY))


def read_peaks(texts: Iterable[str], place: str) -> tuple[Peak, ...]:
    """Read peaks such as ``17:00-20:00=2``; an InputError names the place."""
    return tuple(_peak(text, place) for text in texts)


def _peak(text: str, place: str) -> Peak:
    found = _PEAK.fullmatch(text)
    if found is not None and float(found[3]) <= MOST_TIMES:
        with suppress(ValueError):
            ((begin, end, _),) = read_spans([(found[1], found[2])])
            return Peak(begin, end, float(found[3]))
    expected = f'expected two times of the day and a factor up to {MOST_TIMES:,}, such as "17:00-20:00=2"'
    raise InputError(place, f"{expected}; found {shown_short(text)}")


def drawn(instance: Instance, scenario: Scenario) -> Instance:
    """Return an instance with a day that the scenario's seed draws from its orders, as ``instance.scale`` says."""
    section = scenario.instance
    scale = section.scale or Scale()
    peaks, zero = read_peaks(scale.peaks, "instance.scale.peaks"), Calendar(section.start).time_of_day()
    rng = stream(scenario.seed, "drawn day")
    return evolve(instance, orders=draw_day(instance.orders, scale.by, peaks, rng, zero, "instance.scale"))


def draw_day(
    orders: Sequence[OrderData], by: float, peaks: Sequence[Peak], rng: np.random.Generator, zero: int, place: str
) -> tuple[OrderData, ...]:
    """Draw a day from orders (a Poisson bootstrap).

    Each order comes a number of times that is Poisson with the mean ``by``, times the factors of the peaks in which it
    arrives. Whatever it has comes with it: its lines and priority, and how long after its arrival it is due or
    cancelled. Each time it arrives at another moment, uniform from halfway to the arrival before its own to halfway to
    the one after it, within the same hour of the day and the same peak. Orders that arrive together still do.

    Parameters
    ----------
    orders
        In order of arrival.
    by
        How often each comes in the mean.
    peaks
        Parts of the day.
    rng
        Stream of random numbers.
    zero
        Ticks from midnight to time 0.
    place
        Its name in errors.

    Returns
    -------
    tuple
        In order of arrival. The first of each has its name, others ``NAME/2``, ``NAME/3``, ....
    """
    arrival = np.array([order.arrival_tick for order in orders], dtype=np.int64)
    weight = np.full(len(arrival), float(by))
    for peak in peaks:
        weight[peak.holds((arrival + zero) % DAY)] *= peak.times
    if weight.sum() > MOST_ORDERS:
        found = f"found factors that draw about {weight.sum():,.0f} orders"
        raise InputError(place, f"{found}; expected at most {MOST_ORDERS:,}")
    times = rng.poisson(weight)
    row = np.repeat(np.arange(len(arrival)), times)
    number = np.arange(len(row)) - np.repeat(np.cumsum(times) - times, times) + 1
    first, last = _moments(arrival, peaks, zero)
    tick = first[row] + np.floor(rng.random(len(row)) * (last - first + 1)[row]).astype(np.int64)
    order = np.lexsort((row, tick))
    sign = "/"
    while any(sign in one.name for one in orders):
        sign += "/"
    return tuple(
        _moved(orders[at], when, f"{orders[at].name}{sign}{n}" if n > 1 else orders[at].name)
        for at, when, n in zip(row[order].tolist(), tick[order].tolist(), number[order].tolist(), strict=True)
    )


def _moments(arrival: Ints, peaks: Sequence[Peak], zero: int) -> tuple[Ints, Ints]:
    """Return the first and the last tick at which each order may arrive."""
    if not len(arrival):
        return arrival, arrival
    middle = (arrival[:-1] + arrival[1:]) // 2
    first, last = np.append(arrival[:1], middle), np.append(middle, arrival[-1:])
    tied = np.diff(arrival) == 0
    together = np.append(tied, False) | np.append(False, tied)
    edges = {edge % DAY for peak in peaks for edge in (peak.begin, peak.end)} | {hour * HOUR for hour in range(24)}
    of_day = np.array([*sorted(edges), DAY], dtype=np.int64)
    now = (arrival + zero) % DAY
    at = np.searchsorted(of_day, now, side="right")
    first = np.maximum(first, arrival - (now - of_day[at - 1]))
    last = np.minimum(last, arrival + (of_day[at] - 1 - now))
    return np.where(together, arrival, np.maximum(first, 0)), np.where(together, arrival, last)


def _moved(order: OrderData, tick: int, name: str) -> OrderData:
    """Return an order that arrives at another time, with what counts from that."""
    later, more = tick - order.arrival_tick, dict[str, Any]()
    for key in ("due_tick", "cancelled_tick"):
        if (given := getattr(order, key)) is not None:
            more[key] = max(given + later, min(given, 0))  # no time is before 0 that was not
    return evolve(order, name=name, arrival_tick=tick, **more)
