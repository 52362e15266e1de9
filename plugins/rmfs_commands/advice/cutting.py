"""The part of a scenario's time that is simulated."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence

from attrs import evolve, frozen

from rmfs_commands.instances.calendar import Calendar
from rmfs_commands.states.beginning import begins_at, read
from rmfs_core.clock import TICKS_PER_S
from rmfs_core.errors import InputError
from rmfs_core.scenario import Scenario
from rmfs_core.timetable import DAY
from rmfs_core.wording import counted
from rmfs_core.world import make_instance

HOUR = 3600 * TICKS_PER_S
USUAL_ORDERS = 300
"""Orders that a cut has, where no one says for how many hours it is; fewer than half as many more are not cut off."""
MORE = 1.1
"""The busiest hour is mentioned where it has so many times the orders of the busiest hour of the cut."""


@frozen
class Cut:
    """A scenario that may end earlier.

    Parameters
    ----------
    scenario
        The scenario that is simulated.
    told
        Sentences: which orders it is about.
    """

    scenario: Scenario
    told: tuple[str, ...]


def cut(scenario: Scenario, hours: float | None) -> Cut:
    """Return a scenario that ends some hours after its first order that counts.

    Parameters
    ----------
    scenario
        The whole. Times of arrival are those of its own seed.
    hours
        How many; None: as many half hours as bring `USUAL_ORDERS`, and on to the last truck of that day.

    Raises
    ------
    InputError
        When there are no orders, or none that counts arrives in these hours.
    """
    orders, begun = make_instance(scenario).orders, scenario.instance.state_file is not None
    ticks = sorted(order.arrival_tick for order in orders)
    if begun and not any(tick > begins_at(scenario) for tick in ticks):
        return Cut(scenario, (f"Simulated: {counted(len(read(scenario)[0].orders), 'order')}, those of the state.",))
    if not ticks:
        place = "instance.orders" if scenario.instance.orders_file is None else "instance.orders_file"
        raise InputError(place, "found no orders; expected at least one, to compare rule sets")
    begin = max(ticks[0], round((scenario.run.warmup_s or 0) * TICKS_PER_S), begins_at(scenario))
    zero = Calendar(scenario.instance.start).time_of_day()
    trucks = [order.due_tick for order in orders if order.due_tick is not None and order.arrival_tick >= begin]
    trucks = trucks if scenario.instance.departures is not None else []
    chosen = hours is None
    if hours is None:
        counting = [tick for tick in ticks if tick >= begin]
        whole = len(counting) <= 1.5 * USUAL_ORDERS or ticks[0] == ticks[-1]
        least = begin if whole else counting[USUAL_ORDERS - 1]
        hours = math.inf if whole else _half_hours(max(least, _last_of_day(trucks, least, zero)) + 1 - begin)
    end, until_s = begin + hours * HOUR, scenario.run.until_s
    refilled = scenario.instance.arrivals.process == "refill"  # orders arrive as others are assigned
    if not refilled and not any(begin <= tick < end for tick in ticks):
        place = "run.warmup_s" if ticks[-1] < begin else "--hours"
        raise InputError(place, "no order arrives between the warm-up and the end; expected some, to compare rule sets")
    if end >= (math.inf if until_s is None else until_s * TICKS_PER_S) or ticks[0] < ticks[-1] < end:
        shown = counted(len(ticks), "order")
        whole_of = (
            f"Simulated: all {shown}." if until_s is None else f"Simulated: {until_s:,.10g} s, as in the scenario."
        )
        return Cut(scenario, (whole_of, *_left_trucks(trucks, math.inf if until_s is None else until_s * TICKS_PER_S)))
    shorter = evolve(scenario, run=evolve(scenario.run, until_s=end / TICKS_PER_S))
    arrived = sum(tick < end and not (begun and tick <= begin) for tick in ticks)  # those of the state arrived before
    lasts = f"{hours:,g} {'hour' if hours == 1 else 'hours'}"
    given = scenario.instance.orders_file is not None and scenario.instance.scale is None
    told = [f"Simulated: {lasts}, in which {arrived:,} of {counted(len(ticks), 'order')} arrive."]
    if not given:
        told.append(f"{'Hours and numbers' if chosen else 'Numbers'} of orders are those of the first seed.")
    by_hour = Counter((tick + zero) // HOUR for tick in ticks if tick >= begin)
    within = max(Counter((tick + zero) // HOUR for tick in ticks if begin <= tick < end).values(), default=0)
    hour, most = max(by_hour.items(), key=lambda found: found[1], default=(0, 0))
    ends = (hour + 1) * HOUR - zero
    if ends > end and most > MORE * within:
        day = f" on day {hour // 24 + 1}" if ticks[-1] + zero >= DAY else ""
        told.append(
            f"The busiest hour, from {hour % 24:02}:00{day}, is not among them: it has {most:,} orders, the busiest of "
            f"these {within:,}; --hours {_half_hours(ends - begin):g} includes it."
        )
    return Cut(shorter, (*told, *_left_trucks(trucks, end)))


def _half_hours(ticks: int) -> float:
    """Return the hours that ticks take, rounded up to half ones."""
    return math.ceil(2 * ticks / HOUR) / 2


def _last_of_day(trucks: Sequence[int], tick: int, zero: int) -> int:
    """Return when the last truck leaves of the day that has a tick; the first one after it, where none is left."""
    later = [truck for truck in trucks if truck >= tick]
    same_day = [truck for truck in later if (truck + zero) // DAY == (tick + zero) // DAY]
    return max(same_day, default=min(later, default=tick))


def _left_trucks(trucks: Sequence[int], end: float) -> list[str]:
    """Say how many trucks leave after the end, as orders that miss these do not count as such."""
    left = [truck for truck in trucks if truck > end]
    if not left:
        return []
    number, orders = counted(len({*left}), "departure"), counted(len(left), "order")
    return [f"Left out: {number} after the end, of {orders}; `missed_percent` tells nothing of them."]
