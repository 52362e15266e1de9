"""The part of a scenario's time that is simulated."""

from __future__ import annotations

import math
from collections import Counter

from attrs import evolve, frozen

from rmfs_core.clock import TICKS_PER_S
from rmfs_core.errors import InputError
from rmfs_core.scenario import Scenario
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
        What is simulated.
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
        How many; None: as many half hours as bring `USUAL_ORDERS`.

    Raises
    ------
    InputError
        When there are no orders, or none that counts arrives in these hours.
    """
    ticks = sorted(order.arrival_tick for order in make_instance(scenario).orders)
    if not ticks:
        place = "instance.orders" if scenario.instance.orders_file is None else "instance.orders_file"
        raise InputError(place, "found no orders; expected some, by which rule sets can be compared")
    begin = max(ticks[0], round((scenario.run.warmup_s or 0) * TICKS_PER_S))
    chosen = hours is None
    if hours is None:
        counting = [tick for tick in ticks if tick >= begin]
        whole = len(counting) <= 1.5 * USUAL_ORDERS or ticks[0] == ticks[-1]
        hours = math.inf if whole else math.ceil(2 * (counting[USUAL_ORDERS - 1] - begin + 1) / HOUR) / 2
    end, until_s = begin + hours * HOUR, scenario.run.until_s
    refilled = scenario.instance.arrivals.process == "refill"  # orders arrive as others are assigned
    if not refilled and not any(begin <= tick < end for tick in ticks):
        place = "run.warmup_s" if ticks[-1] < begin else "--hours"
        raise InputError(place, "no order arrives between the warm-up and the end; expected some, to compare rule sets")
    if end >= (math.inf if until_s is None else until_s * TICKS_PER_S) or ticks[0] < ticks[-1] < end:
        shown = counted(len(ticks), "order")
        return Cut(
            scenario,
            (f"Simulated: all {shown}." if until_s is None else f"Simulated: {until_s:,.10g} s, as in the scenario.",),
        )
    shorter = evolve(scenario, run=evolve(scenario.run, until_s=end / TICKS_PER_S))
    arrived = sum(tick < end for tick in ticks)
    lasts = f"{hours:,g} {'hour' if hours == 1 else 'hours'}"
    given = scenario.instance.orders_file is not None and scenario.instance.scale is None
    told = [f"Simulated: {lasts}, in which {arrived:,} of {counted(len(ticks), 'order')} arrive."]
    if not given:
        told.append(f"{'Hours and numbers' if chosen else 'Numbers'} of orders are those of the first seed.")
    by_hour = Counter((tick - begin) // HOUR for tick in ticks if tick >= begin)
    within = max((number for hour, number in by_hour.items() if hour < hours), default=0)
    hour, most = max(by_hour.items(), key=lambda found: found[1], default=(0, 0))
    if hour >= hours and most > MORE * within:
        told.append(
            f"The busiest hour is not among them: it has {most:,} orders, the busiest of these {within:,}; "
            f"--hours {hour + 1} includes it."
        )
    return Cut(shorter, tuple(told))
