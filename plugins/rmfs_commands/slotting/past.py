"""The orders to learn from, and the later days that placements are judged on."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence, Set
from contextlib import suppress
from datetime import datetime, timedelta, timezone
from pathlib import Path

from attrs import evolve, frozen

from rmfs_commands.convert.lines import Sku
from rmfs_commands.instances.calendar import Calendar
from rmfs_commands.instances.csv_files import read_orders
from rmfs_core.clock import TICKS_PER_S, to_seconds
from rmfs_core.errors import InputError
from rmfs_core.scenario.model import Scenario
from rmfs_core.timetable import DAY
from rmfs_core.wording import counted, first_few
from rmfs_core.world import Instance, OrderData
from rmfs_core.world.instance_making import instance_problems, unchecked_instance

_COLUMNS = ("arrival", "due", "cancelled")


@frozen
class Day:
    """A later day: its name, its midnight in ISO 8601 if that is known, and its orders, in ticks from its midnight."""

    name: str
    start: str | None
    orders: tuple[OrderData, ...]


@frozen(eq=False)
class Past:
    """The history that placements are made from, and the later days that they are judged on.

    Parameters
    ----------
    instance
        The scenario's pods and SKUs; its orders are those after the history.
    baskets
        SKU ids of each order of the history that stand on pods, in order of arrival; no order is empty.
    quantities
        Items of an order, mean.
    orders_per_hour
        Orders that arrive in the hour in which an order arrives, mean over the history.
    days
        Days of the history on which orders arrive.
    later
        The days after it.
    strange
        SKUs of the history that stand on no pod.
    dated
        Whether dates tell that the history is earlier than the days after it.
    """

    instance: Instance
    baskets: tuple[tuple[int, ...], ...]
    quantities: float
    orders_per_hour: float
    days: int
    later: tuple[Day, ...]
    strange: int
    dated: bool = True

    def skus(self) -> list[Sku]:
        """Return the SKUs on pods with their order lines in the history, most lines first; others after them."""
        lines = [0] * len(self.instance.skus)
        for basket in self.baskets:
            for sku in basket:
                lines[sku] += 1
        stocked = sorted({sku for pod in self.instance.pods for sku, _ in pod.contents})
        return [Sku(str(sku), lines[sku], 0) for sku in sorted(stocked, key=lambda sku: (-lines[sku], sku))]


def read_past(scenario: Scenario, history: Path | None, until: str | None, most_days: int) -> Past:
    """Return the history, and the days after it.

    Parameters
    ----------
    scenario
        The scenario whose pods are filled; it has orders and pods of files.
    history
        A file of earlier orders; None: those of the scenario before ``until``.
    until
        When the history ends, in ISO 8601, or seconds from time 0.
    most_days
        How many later days are kept, the first ones.

    Raises
    ------
    InputError
        When there is no history, no later order, or an order is both.
    """
    section = scenario.instance
    if section.orders_file is None or section.pods_file is None:
        expected = "expected `orders_file` and `pods_file`; `rmfs generate` writes such files, `rmfs convert` as well"
        raise InputError("instance", f"found a generated instance; {expected}")
    _check_days(scenario)
    instance = unchecked_instance(evolve(scenario, instance=evolve(section, scale=None)))
    file, calendar = Path(scenario.folder) / section.orders_file, _Clock(section.start)
    read_orders(file, calendar, departures=section.departures)  # for the calendar: the times of its dates
    names, dated = {order.name for order in instance.orders}, True
    if history is None:
        end = _tick(until or "", calendar)
        early = [order for order in instance.orders if order.arrival_tick < end]
        past = [(order, {instance.skus[sku]: items for sku, items in order.lines}) for order in early]
        later = instance.orders[len(early) :]
        if not early or not later:
            which = "later than" if not early else "earlier than"
            found = f"all orders of {file} ({len(names):,}) are {which} {until}"
            raise InputError("--history-until", f"{found}; expected a time with orders on both sides")
    else:
        own = _Clock(None)
        past, later = read_orders(history, own), instance.orders
        if not later:
            raise InputError(str(file), "found no order; expected those of the days after the history")
        dated = _check_apart(history, past, own, names, calendar, later[0].arrival_tick)
    zero = calendar.time_of_day() if section.start is not None else 0
    days = _days(later, zero, section.start)
    for problem in (p for day in days for p in instance_problems(evolve(instance, orders=day.orders), scenario)):
        raise problem
    ids = {instance.skus[sku]: sku for pod in instance.pods for sku, _ in pod.contents}
    known = [tuple(ids[sku] for sku in lines if sku in ids) for _, lines in past]
    baskets = tuple(basket for basket in known if basket)
    if not baskets:
        place = str(history or file)
        wrong = f"none of its {counted(len(past), 'order')} has a SKU that stands on a pod" if past else "has no order"
        raise InputError(place, f"{wrong}; expected earlier orders of the same SKUs")
    by_hour = Counter((order.arrival_tick + zero) // (DAY // 24) for order, _ in past)
    return Past(
        evolve(instance, orders=later),
        baskets,
        sum(sum(lines.values()) for _, lines in past) / len(past),
        sum(number**2 for number in by_hour.values()) / len(past),
        len({(order.arrival_tick + zero) // DAY for order, _ in past}),
        days[:most_days],
        len({sku for _, lines in past for sku in lines} - ids.keys()),
        dated,
    )


def _check_days(scenario: Scenario) -> None:
    """Refuse what is about one moment of the whole scenario: each later day is a run of its own, from midnight on."""
    section, replenishment = scenario.instance, scenario.instance.replenishment
    times = () if section.departures is None else section.departures.times
    routes = times.values() if isinstance(times, Mapping) else [times]
    found = {
        "instance.state_file": section.state_file is not None,
        "instance.replenishment.file": replenishment is not None and replenishment.file is not None,
        "instance.departures.times": any(not isinstance(time, str) for of_route in routes for time in of_route),
        "run.until_s": scenario.run.until_s is not None,
        "run.warmup_s": scenario.run.warmup_s is not None,
    }
    for key in (key for key, given in found.items() if given):
        out = "times of the day" if key.endswith("times") else f"none, as with --set {key}="
        raise InputError(key, f"counts from time 0, but each later day is run alone, from midnight on; expected {out}")


class _Clock(Calendar):
    """A calendar that also reads times without an offset, by the clock of time 0."""

    @property
    def dated(self) -> bool:
        """Whether it has read a date."""
        return self._first is not None

    @property
    def aware(self) -> bool:
        """Whether its dates have offsets from UTC."""
        return self._first is not None and self._first.tzinfo is not None

    def since_zero(self, text: str, place: str) -> int:
        """Return a time in ticks from time 0."""
        zero, own = self.zero(_COLUMNS), next(name for name in ("start", *_COLUMNS) if name in self._earliest)
        with suppress(ValueError):
            moment = datetime.fromisoformat(text)
            if self.aware and moment.tzinfo is None:
                ahead = timedelta(milliseconds=self._earliest[own][1])
                text = moment.replace(tzinfo=timezone(ahead)).isoformat()
        return self.tick(text, place, "until") - zero


def _tick(text: str, calendar: _Clock) -> int:
    """Return a time of the option in ticks from time 0."""
    if re.fullmatch(r"[0-9]{1,9}(\.[0-9]+)?", text) and not (calendar.dated and len(text) == 8):
        return round(float(text) * TICKS_PER_S)
    if not calendar.dated:
        expected = "expected seconds from time 0, since the orders have no dates (or set instance.start)"
        raise InputError("--history-until", f'found "{text}"; {expected}')
    return calendar.since_zero(text, "--history-until")


def _check_apart(
    history: Path,
    past: Sequence[tuple[OrderData, Mapping[str, int]]],
    own: _Clock,
    names: Set[str],
    calendar: _Clock,
    first: int,
) -> bool:
    """Refuse a history that has orders which are judged on, or later ones; return whether its times tell that."""
    if both := [order.name for order, _ in past if order.name in names]:
        found = f"{counted(len(both), 'order')} of it {'is' if len(both) == 1 else 'are'} run as well"
        raise InputError(str(history), f"{found} ({first_few(both)}); expected other, earlier orders")
    if not (past and own.dated and calendar.dated):
        return False
    if own.aware != calendar.aware:
        found = "its times have an offset from UTC and those of the scenario have none"
        found = found if own.aware else "its times have no offset from UTC and those of the scenario have one"
        raise InputError(str(history), f"{found}; expected both or neither, to tell which are earlier")
    last = own.zero(("arrival",)) + past[-1][0].arrival_tick
    begin = calendar.zero(_COLUMNS) + first
    if last >= begin:
        late = f"its last order arrives {to_seconds(last - begin) / 3600:,.1f} hours after the first that is run"
        raise InputError(str(history), f"{late}; expected earlier orders only")
    return True


def _days(orders: Sequence[OrderData], zero: int, start: str | None) -> tuple[Day, ...]:
    """Return orders by day, each from midnight on by the clock of time 0."""
    by_day: dict[int, list[OrderData]] = {}
    for order in orders:
        by_day.setdefault((order.arrival_tick + zero) // DAY, []).append(order)
    found = []
    for number, of_day in by_day.items():
        begin = number * DAY - zero
        midnight = None if start is None else datetime.fromisoformat(start) + timedelta(milliseconds=begin)
        name = f"day {number + 1}" if midnight is None else f"{midnight:%Y-%m-%d}"
        shifted = tuple(_shifted(order, begin) for order in of_day)
        found.append(Day(name, None if midnight is None else midnight.isoformat(), shifted))
    return tuple(found)


def _shifted(order: OrderData, begin: int) -> OrderData:
    due, cancelled = order.due_tick, order.cancelled_tick
    return evolve(
        order,
        arrival_tick=order.arrival_tick - begin,
        due_tick=None if due is None else max(due - begin, 0),
        cancelled_tick=None if cancelled is None else cancelled - begin,
    )
