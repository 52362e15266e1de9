"""Trucks that leave: an order is due when the first truck leaves that it can still go with."""

from __future__ import annotations

import re
from bisect import bisect_left
from collections.abc import Mapping, Sequence

from attrs import evolve, frozen

from rmfs_commands.instances.calendar import Calendar
from rmfs_core.clock import to_ticks
from rmfs_core.errors import InputError
from rmfs_core.scenario.model import Departures, Scenario
from rmfs_core.timetable import DAY
from rmfs_core.wording import counted, did_you_mean, shown_short
from rmfs_core.world import Instance, OrderData

PLACE = "instance.departures"
TIMES = f"{PLACE}.times"
LATEST_S = 315_619_200  # ten years
_OF_DAY = re.compile(r"([01]\d|2[0-3]):([0-5]\d)", re.ASCII)


@frozen
class Trucks:
    """When the trucks of a route leave, in ascending ticks: of the run for trucks of every day, and once."""

    daily: tuple[int, ...]
    once: tuple[int, ...]

    def first(self, tick: int) -> int | None:
        """Return when the first leaves that does not leave before a tick; None when none does."""
        found = [tick + min((time - tick) % DAY for time in self.daily)] if self.daily else []
        found += self.once[at : at + 1] if (at := bisect_left(self.once, tick)) < len(self.once) else ()
        return min(found, default=None)


def departing(instance: Instance, scenario: Scenario) -> Instance:
    """Return an instance whose orders are due when the trucks of ``instance.departures`` leave.

    Each order goes with the first truck of its route that leaves at least ``cutoff_s`` after it arrives.

    Raises
    ------
    InputError
        When times or routes are wrong, orders are due already, or no truck is left for one.
    """
    section = scenario.instance
    given = section.departures
    if given is None:
        return instance
    if section.arrivals.backlog is not None:
        raise InputError(PLACE, 'expected none with arrivals of process "refill", whose times nobody knows beforehand')
    if dated := [order.name for order in instance.orders if order.due_tick is not None]:
        raise InputError(PLACE, f"found a due time of order {dated[0]}, too; expected one of them")
    if given.column is not None and section.orders_file is None:
        raise InputError(f"{PLACE}.column", "expected it with `instance.orders_file`, where that column is")
    trucks = trucks_of(given, Calendar(section.start).time_of_day())
    wait = to_ticks(given.cutoff_s)
    due = [first_for(order, trucks, wait) for order in instance.orders]
    routed = isinstance(given.times, Mapping)
    drawn = section.scale is not None and given.column is not None  # a day may have no order with a route
    if routed and instance.orders and all(order.route is None for order in instance.orders) and not drawn:
        expected = "`column`, a column of the orders' file" if given.column is None else f"some in `{given.column}`"
        raise InputError(TIMES, f"found routes, but no order has one; expected {expected}")
    left = [
        order
        for order, tick in zip(instance.orders, due, strict=True)
        if tick is None and (not routed or order.route is not None)
    ]
    if left:
        one, more = left[0], f"; so do {counted(len(left) - 1, 'more order')}" if len(left) > 1 else ""
        late = f"{given.cutoff_s:,.10g} s or more " * (given.cutoff_s > 0)
        found = f"order {one.name} arrives at {one.arrival_tick / 1000:,.10g} s, and no truck leaves {late}after that"
        raise InputError(TIMES, f"{found}{more}; expected a later one, or times of the day")
    return evolve(
        instance,
        orders=tuple(evolve(order, due_tick=tick) for order, tick in zip(instance.orders, due, strict=True)),
    )


def before_trucks(
    orders: Sequence[OrderData], given: Departures | None
) -> tuple[tuple[OrderData, ...], Departures | None]:
    """Return orders as their file has them, and what makes them due; None where no order goes with a truck."""
    if given is None:
        return tuple(orders), None
    some = given.column is None or any(order.route is not None for order in orders)
    return tuple(evolve(order, due_tick=None) for order in orders), given if some else None


def trucks_of(given: Departures, zero: int) -> dict[str | None, Trucks]:
    """Return the trucks by route; None where there are no routes. ``zero``: ticks from midnight to time 0."""
    routes: dict[str | None, Sequence[str | float]] = {}
    if isinstance(given.times, Mapping):
        routes.update(given.times.items())
    else:
        routes[None] = given.times
    if isinstance(given.times, Mapping) and not given.times:
        raise InputError(TIMES, 'found no route; expected at least one, such as { north = ["14:00"] }')
    if given.column is not None and None in routes:
        raise InputError(TIMES, f'expected a table of routes with `column` "{given.column}", found a list')
    found = {}
    for route, times in routes.items():
        place = TIMES if route is None else f"{TIMES}.{route}"
        if not times:
            raise InputError(place, 'found no time; expected at least one, such as "14:00"')
        read = [_read(time, place) for time in times]
        daily = sorted({(tick - zero) % DAY for tick, every_day in read if every_day})
        found[route] = Trucks(tuple(daily), tuple(sorted({tick for tick, every_day in read if not every_day})))
    return found


def _read(time: str | float, place: str) -> tuple[int, bool]:
    """Return a time in ticks, of the day or of the run, and whether a truck leaves then every day."""
    if isinstance(time, str) and (found := _OF_DAY.fullmatch(time)):
        return to_ticks(int(found[1]) * 3600 + int(found[2]) * 60), True
    if not isinstance(time, str) and 0 <= time <= LATEST_S:
        return to_ticks(time), False
    expected = 'expected times of the day such as "14:00", or seconds from 0 to ten years'
    raise InputError(place, f"{expected}, found {shown_short(time)}")


def first_for(order: OrderData, trucks: Mapping[str | None, Trucks], wait: int) -> int | None:
    """Return the tick at which an order is due; None when no truck is left, or it has no route where there are routes.

    ``wait``: ticks from the arrival of an order to the first truck that it can go with, at least.
    """
    routed = None not in trucks
    if routed and order.route is None:
        return None
    route = order.route if routed else None
    if route not in trucks:
        near = did_you_mean(str(route), [str(one) for one in trucks])
        raise InputError(TIMES, f"has no route {shown_short(route)}, which order {order.name} goes with{near}")
    return trucks[route].first(order.arrival_tick + wait)
