"""How much work orders bring, and how much stations, robots and chargers can do while these arrive, before any run.

A load is hours wanted over hours there. Above 100 % pickers, packers and replenishment stations cannot do it in that
time, whatever the rules; robots can where trips serve several order lines. The hours are those from the first order to
the last, and, where stations have opening hours, on until they close, but of the last of several openings only as
far as its items need at the rate of those before; and never after the run ends (`run.until_s`).
Where all orders come within `AT_ONCE`, and stations are always open, there are none, and only what is wanted is said;
so it is where orders arrive as others are assigned (process ``refill``). Where things fail or are maintained, hours
there are those in service, on average.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from statistics import fmean
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from attrs import asdict, define, evolve, field, frozen
from numpy.typing import NDArray

from rmfs_commands.cli.screen import say
from rmfs_commands.instances.calendar import Calendar
from rmfs_commands.processes.hours import hours_of, mean_speed, shifts_of
from rmfs_core import hookimpl
from rmfs_core.clock import TICKS_PER_S, UNREACHABLE
from rmfs_core.entrypoints import process
from rmfs_core.scenario.model import FailuresSection, Replenishment, Scenario
from rmfs_core.simulation.setup import motion_of
from rmfs_core.timetable import ALWAYS, DAY, Timetable, read_spans
from rmfs_core.wording import counted
from rmfs_core.world import Instance, Layout
from rmfs_core.world.travel import Travel, travel_on

if TYPE_CHECKING:
    from rich.console import Console

    from rmfs_core.info import RunInfo

T = TypeVar("T")
MINUTE, HOUR = 60 * TICKS_PER_S, 3600 * TICKS_PER_S
AT_ONCE = HOUR
SAMPLE = 5
"""Stations, and storage locations without a pod on the robot, to and from which ways are measured, at most."""
MOST_CHANGES = 10_000
"""Of stations that open and close, after which nobody asks any more when all is done."""


UNITS = {
    "pickers": "station",
    "robots": "robot",
    "replenishment stations": "replenishment station",
    "chargers": "charger",
    "packers": "packer",
}
"""Pickers, robots or packers: those with a load, of which there could be more."""


OF_TRIPS = ("robots", "chargers")
"""Whose load depends on how many order lines a trip serves."""
ASSUMED = ", if each trip serves one order line"


@define
class Demand:
    """Demand of orders, by the minute in which they arrive.

    Parameters
    ----------
    items, lines, orders
        Items, order lines and orders by the number of the minute, from 0.
    first, last
        Ticks of the first and the last arrival; those of no order are of no use.
    """

    items: Counter[int] = field(factory=Counter)
    lines: Counter[int] = field(factory=Counter)
    orders: Counter[int] = field(factory=Counter)
    first: int = 1 << 62
    last: int = 0

    def add(self, tick: int, items: int, lines: int = 1, orders: int = 0) -> None:
        """Add items, lines and orders that arrive at a tick."""
        minute = tick // MINUTE
        self.items[minute] += items
        self.lines[minute] += lines
        self.orders[minute] += orders
        self.first, self.last = min(self.first, tick), max(self.last, tick)


@frozen
class Load:
    """The load of one kind of resource.

    Parameters
    ----------
    who
        One of `UNITS`.
    number
        How many there are.
    work
        Their work, in words.
    wanted_h
        Hours of work.
    there_h
        Hours in which they are there, summed over them; None where orders come at once.
    peak
        When the hour begins, by the clock, in which the orders that arrive while someone is there bring the most work
        for the hours there; None where that is not known.
    peak_wanted_h, peak_there_h
        The same of that hour.
    done_h
        Hours from time 0 before which not all of it can be done; None where that is not known.
    ends_h
        Hours from time 0 at which the run ends; None where it ends with the last order.
    down_percent
        Share of their time in which they are out of service, on average; hours there are without it.
    """

    who: str
    number: int
    work: str
    wanted_h: float
    there_h: float | None
    peak: str | None = None
    peak_wanted_h: float = 0.0
    peak_there_h: float = 0.0
    done_h: float | None = None
    ends_h: float | None = None
    down_percent: float = 0.0

    @property
    def percent(self) -> float | None:
        """Hours wanted over hours there; infinite where there are none, None where orders come at once."""
        return None if self.there_h is None else _percent(self.wanted_h, self.there_h)

    @property
    def peak_percent(self) -> float | None:
        """The same in the peak hour."""
        return None if self.peak is None else _percent(self.peak_wanted_h, self.peak_there_h)

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain values, with the percentages."""
        return {**asdict(self), "percent": self.percent, "peak_percent": self.peak_percent}

    def enough(self, percent: float) -> int | None:
        """Return how many would have a load of at most 100 % instead of so many percent; None: no number would."""
        return math.ceil(self.number * percent / 100) if math.isfinite(percent) else None


def _percent(wanted: float, there: float) -> float:
    return 100 * wanted / there if there else math.inf if wanted else 0.0


def loads(scenario: Scenario, instance: Instance, layout: Layout) -> list[Load]:
    """Return the loads of a scenario: of pickers and robots, and of the others in `UNITS` where there are any.

    Empty where no orders arrive before the run ends.
    """
    until = math.inf if scenario.run.until_s is None else scenario.run.until_s * TICKS_PER_S
    refilled, demand = scenario.instance.arrivals.backlog is not None, Demand()
    for order in instance.orders:
        if (tick := 0 if refilled else order.arrival_tick) < until:
            demand.add(tick, order.items, len(order.lines), 1)
    return loads_of(scenario, layout, demand, _bundles(scenario, instance, until)) if demand.orders else []


def loads_of(scenario: Scenario, layout: Layout, demand: Demand, bundles: int = 0) -> list[Load]:
    """Return the loads that some orders and bundles bring to a warehouse.

    Of the scenario's instance, time 0 and whether orders are refilled count.
    """
    return _Reckoning(scenario, layout, demand, bundles).loads()


class _Reckoning:
    def __init__(self, scenario: Scenario, layout: Layout, demand: Demand, bundles: int) -> None:
        self._scenario, self._layout, self._demand, self._bundles = scenario, layout, demand, bundles
        self._picking = len(layout.stations) - layout.replenishing
        stations, (shift,) = shifts_of(hours_of(scenario, self._picking), self._picking)
        self._stations, self._shift = Counter(stations), Counter({shift: 1})
        self._fleet = scenario.robots.count if scenario.robots.available is None else 1
        """Robots for each that the timetable of shifts has: it counts them where it says when they are on duty."""
        self._zero = Calendar(scenario.instance.start).time_of_day()
        self._refilled, until_s = scenario.instance.arrivals.backlog is not None, scenario.run.until_s
        self._ends_h = None if until_s is None or self._refilled else until_s / 3600
        end = self._end() if self._ends_h is None else min(self._end(), round(self._ends_h * HOUR))
        self._window = None if self._refilled or end - demand.first < AT_ONCE else (demand.first, end)

    def _end(self) -> int:
        """Return when stations close after the last arrival; that itself where one of them is always open.

        Of the opening in which it is handled so much counts as brings as many items per hour as all before did, at most
        all, or until the last arrival: a few late orders do not make the load small. The first opening counts whole.
        """
        demand, last = self._demand, self._demand.last
        any_ = Timetable(tuple(span for one in self._stations for span in one.spans), self._zero)
        if (change := any_.next_change(last)) is None:
            return last
        opens = _last_change(any_, last) if any_.at(last) else change
        closed, closes = _last_change(any_, opens - 1), any_.next_change(opens) or opens
        if closed - demand.first < AT_ONCE:
            return closes
        late = sum(items for minute, items in demand.items.items() if minute >= closed // MINUTE)
        per_hour = (demand.items.total() - late) / _hours_there(self._stations, demand.first, closed)
        share = min(late / per_hour / _hours_there(self._stations, opens, closes), 1.0)
        return max(last, opens + round(share * (closes - opens)))

    def loads(self) -> list[Load]:
        demand, stations = self._demand, self._scenario.stations
        cycle_s, driving_s = self._trip()
        store_s = stations.store_s or 10.0
        own = self._layout.replenishing
        items, lines = demand.items.total(), demand.lines.total()
        begun = ((demand.lines, "line", stations.line_s or 0.0), (demand.orders, "order", stations.order_s or 0.0))
        speed = 1.0 + sum(mean_speed(one) - 1 for one in stations.speed.values()) / max(self._picking, 1)  # a mean
        storing_s = 0.0 if own else self._bundles * store_s / speed
        work = f"{counted(items, 'item')} of {stations.handle_s:g} s"
        work += "".join(f", {counted(which.total(), what)} of {each:.3g} s" for which, what, each in begun if each)
        work += f", {counted(self._bundles, 'bundle')} of {store_s:g} s" if storing_s else ""
        work += f", at a mean speed of {speed:.3g}" if speed != 1 else ""
        arriving = {
            minute: (n * stations.handle_s + sum(which[minute] * each for which, _, each in begun)) / 3600 / speed
            for minute, n in demand.items.items()
        }
        works = _in_service(stations.outages)
        found = [self._load("pickers", self._picking, work, arriving, self._stations, besides_h=storing_s / 3600)]
        found[0] = evolve(found[0], done_h=self._done(arriving, storing_s / 3600, works), ends_h=self._ends_h)
        found[0] = _without_outages(found[0], works)
        of_robots = {
            minute: (demand.lines[minute] * cycle_s + demand.items[minute] * stations.pick_s) / 3600
            for minute in demand.lines
        }
        count, bundles_h = self._scenario.robots.count, self._bundles * (cycle_s + store_s) / 3600
        trips, trip_s = lines + self._bundles, 3600 * math.fsum([*of_robots.values(), bundles_h])
        work = f"{counted(trips, 'trip')} of {trip_s / trips:.0f} s without traffic, one per order line"
        work += " and bundle" if self._bundles else ""
        load = self._load("robots", count, work, of_robots, self._shift, self._fleet, bundles_h, self._stations)
        found.append(_without_outages(load, self._robots_in_service()))
        if own and self._bundles:
            work = f"{counted(self._bundles, 'bundle')} of {store_s:g} s"
            always = Counter({ALWAYS: own})
            found.append(self._load("replenishment stations", own, work, {}, always, 1, self._bundles * store_s / 3600))
        if (battery := self._scenario.robots.battery) is not None and self._window is not None:
            hours = (self._window[1] - self._window[0]) / HOUR
            empty_s, loaded_s = (driving * trips for driving in driving_s)
            lifts_s = 2 * self._scenario.robots.lift_s * trips
            joules = empty_s * battery.empty_w + loaded_s * battery.loaded_w + lifts_s * battery.lifting_w
            joules += max(count * hours * 3600 - empty_s - loaded_s - lifts_s, 0.0) * battery.idle_w
            number = len(self._layout.chargers)
            work = f"{joules / 3.6e6:,.1f} kWh at {battery.charging_w:g} W"
            load = Load("chargers", number, work, joules / battery.charging_w / 3600, number * hours)
            found.append(_without_outages(load, _in_service(battery.charger_outages)))
        return [*found, *self._packers()]

    def _robots_in_service(self) -> float:
        """Return the share of their time in which robots are in service."""
        robots = self._scenario.robots
        tables = [Timetable(read_spans(spans)) for spans in (robots.maintenance or {}).values()]
        maintained = sum(_open(table, 0, DAY, (ALWAYS,)) for table in tables) / (robots.count * DAY)
        return max(1 - maintained, 0.0) * _in_service(robots.failures)

    def _packers(self) -> Iterator[Load]:
        """Yield the load of packers, where there are any: packing alone, as nobody knows yet what has to be put."""
        if (section := self._scenario.packing) is None:
            return
        stations = process("packing", "packing").stations(self._scenario, self._layout)
        demand, hours = self._demand, Counter(one.hours for one in stations)
        orders, items = demand.orders.total(), demand.items.total()
        arriving = {
            minute: (demand.orders[minute] * section.pack_s + demand.items[minute] * section.pack_item_s) / 3600
            for minute in demand.orders
        }
        work = f"{counted(orders, 'order')} of {section.pack_s:g} s, {counted(items, 'item')} of "
        work += f"{section.pack_item_s:g} s{'' if section.sorters else ', putting besides'}"
        yield self._load("packers", section.packers * hours.total(), work, arriving, hours, section.packers)

    def _load(
        self,
        who: str,
        number: int,
        work: str,
        arriving: Mapping[int, float],
        timetables: Mapping[Timetable, int],
        each: int = 1,
        besides_h: float = 0.0,
        within: Collection[Timetable] = (ALWAYS,),
    ) -> Load:
        """Return a load of the hours that the orders of each minute bring and of what comes besides.

        ``each`` of them are there for each that the timetables count, while any of ``within`` holds.
        """
        wanted = math.fsum([*arriving.values(), besides_h])
        if self._window is None:
            return Load(who, number, work, wanted, None)
        there, by_hour = each * _hours_there(timetables, *self._window, within), dict[int, float]()
        for minute, hours in arriving.items():
            if all(any(one.at(minute * MINUTE) for one in some) for some in (timetables, within)):
                hour = minute * MINUTE // HOUR
                by_hour[hour] = by_hour.get(hour, 0.0) + hours
        peak, most = None, (0.0, 0.0, 0.0)
        for hour, hours in sorted(by_hour.items()):
            here = each * _hours_there(timetables, hour * HOUR, (hour + 1) * HOUR, within)
            if here and hours / here > most[0]:
                peak, most = self._clock(hour), (hours / here, hours, here)
        return Load(who, number, work, wanted, there, peak, *most[1:])

    def _clock(self, hour: int) -> str:
        """Return the time of day at which the given hour of the run begins."""
        day, tick = divmod(self._zero + hour * HOUR, DAY)
        begin = f"{tick // HOUR:02d}:{tick % HOUR * 60 // HOUR:02d}"
        return f"{begin} on day {day + 1}" if day or self._demand.last >= DAY else begin

    def _done(self, arriving: Mapping[int, float], besides_h: float, works: float) -> float | None:
        """Return before how many hours the pickers cannot be done, if each hour's orders come at its begin.

        ``works`` is the share of the time in which stations are in service.
        """
        left, now, by_hour = besides_h * HOUR / works, 0.0, dict[int, float]()
        for minute, hours in arriving.items():
            hour = minute * MINUTE // HOUR
            by_hour[hour] = by_hour.get(hour, 0.0) + hours * HOUR / works
        for hour, ticks in sorted(by_hour.items()):
            begin = max(hour * HOUR, self._demand.first)
            left, _ = self._work(left, now, begin)
            left, now = left + ticks, float(begin)
        left, now = self._work(left, now, math.inf)
        return None if left else now / HOUR

    def _work(self, left: float, now: float, until: float) -> tuple[float, float]:
        """Let all pickers who are there work; return what is left at a tick, or 0 and when all was done before it."""
        for _ in range(MOST_CHANGES):
            there = sum(number * one.at(int(now)) for one, number in self._stations.items())
            changes = (one.next_change(int(now)) for one in self._stations)
            end = min([until, *(tick for tick in changes if tick is not None)])
            if left == 0 or (there and there * (end - now) >= left):
                return 0.0, now + (left / there if left else 0.0)
            if there:
                left -= there * (end - now)
            now = end
            if now >= until:
                break
        return left, now

    def _trip(self) -> tuple[float, tuple[float, float]]:
        """Return the mean seconds of a trip without the picking, and of these those of driving without and with a pod.

        To a pod from where another one stands, to a station, and from there to where a pod stands, all of them alike
        often, and each way as if the robot had the heading that takes least, and no other were in its way.
        """
        travel, storage = travel_on(self._layout, motion_of(self._scenario.robots)), self._layout.storage_locations
        cells = np.array(storage)
        stations = [one.station for one in _some(self._layout.stations[: self._picking])]
        there = [travel.times_to(station, loaded=True)[cells].min(axis=1) for station in stations]
        back = [_back(travel, station)[cells] for station in stations]
        empty = [travel.times_to(cell, loaded=False)[cells].min(axis=1) for cell in _some(storage)]
        empty_s, loaded_s = _mean_s(empty), _mean_s(there) + _mean_s(back)
        return empty_s + loaded_s + 2 * self._scenario.robots.lift_s, (empty_s, loaded_s)


def _in_service(failures: FailuresSection | None) -> float:
    """Return the share of its time in which something that fails is in service."""
    return 1.0 if failures is None else 3600 * failures.mtbf_h / (3600 * failures.mtbf_h + failures.mttr_s)


def _without_outages(load: Load, works: float) -> Load:
    """Return a load whose hours there are those in service, a share of them."""
    there_h = None if load.there_h is None else works * load.there_h
    return evolve(load, there_h=there_h, peak_there_h=works * load.peak_there_h, down_percent=100 * (1 - works))


def _some(every: Sequence[T]) -> list[T]:
    """Return at most `SAMPLE` of them, spread evenly."""
    number = min(SAMPLE, len(every))
    return [every[(2 * i + 1) * len(every) // (2 * number)] for i in range(number)]


def _back(travel: Travel, cell: int) -> NDArray[np.int64]:
    """Return the ticks from a station to each cell, with the heading that takes least."""
    times: NDArray[np.int64] = np.min([travel.times_from(cell, heading, loaded=True) for heading in range(4)], axis=0)
    return times


def _mean_s(tables: Sequence[NDArray[np.int64]]) -> float:
    """Return the mean of some ticks in seconds, without those of ways that there are not."""
    known = [int(table[there].mean()) for table in tables if (there := table < UNREACHABLE).any()]
    return fmean(known) / TICKS_PER_S if known else 0.0


def _hours_there(
    timetables: Mapping[Timetable, int], begin: int, end: int, within: Collection[Timetable] = (ALWAYS,)
) -> float:
    """Return for how many hours between two ticks they are there while any of ``within`` holds, summed over them."""
    return sum(number * _open(timetable, begin, end, within) for timetable, number in timetables.items()) / HOUR


def _open(timetable: Timetable, begin: int, end: int, within: Collection[Timetable]) -> int:
    """Return the ticks between two in which a timetable and any of ``within`` hold, as often as its number says."""
    total, now = 0, begin
    while now < end:
        changes = (one.next_change(now) for one in (timetable, *within))
        until = min([end, *(tick for tick in changes if tick is not None)])
        if any(one.at(now) for one in within):
            total += timetable.at(now) * (until - now)
        now = until
    return total


def _last_change(timetable: Timetable, tick: int) -> int:
    """Return the last tick up to another at which a timetable changed that changes every day."""
    found = tick - DAY
    while (change := timetable.next_change(found)) is not None and change <= tick:
        found = change
    return found


def _bundles(scenario: Scenario, instance: Instance, until: float) -> int:
    """Return how many bundles the orders before some tick bring with them, or are to come."""
    given = scenario.instance.replenishment or Replenishment()
    orders = [order for order in instance.orders if order.arrival_tick < until]
    if not instance.levels:
        last = max([order.arrival_tick for order in orders], default=0)
        return len(instance.bundles) + round((given.bundles_per_hour or 0.0) * last / HOUR)
    wanted: Counter[int] = Counter()
    for order in orders:
        for sku, quantity in order.lines:
            wanted[sku] += quantity
    held: Counter[int] = Counter()
    endless = set()
    for pod in instance.pods:
        for sku, items in pod.contents:
            held[sku] += items or 0
            endless |= {sku} if items is None else set()
    found = 0
    for sku, items in wanted.items():
        low, full = instance.levels[sku]
        missing = 0 if sku in endless else max(items - (held[sku] - low), 0)
        found += math.ceil(missing / min(full - low, given.bundle_items or full))
    return found


def load_sentences(found: Sequence[Load]) -> Iterator[str]:
    """Yield a sentence for each load, with its reckoning, and then the warnings."""
    for load in found:
        told = f"{told_hours(load.wanted_h)} ({load.work})"
        down = f", {load.down_percent:.3g} % of the time out of service" if load.down_percent else ""
        if load.percent is None:
            each = f"{told_hours(load.wanted_h / load.number)} for each of {load.number:,}"
            yield f"Load of {load.who}: {told}, {each}{down}."
        else:
            there = f"in {told_hours(load.there_h or 0.0)} of {load.number:,}{down}"
            yield f"Load of {load.who}: {_shown(load.percent)}, {told} {there}{_peak(load)}."
    yield from load_warnings(found)


def load_line(found: Sequence[Load]) -> str:
    """Return all loads in one sentence; nothing where there are none."""
    told = [
        f"{load.who} {told_hours(load.wanted_h / load.number)} each"
        if load.percent is None
        else f"{load.who} {_shown(load.percent)}{_peak(load)}"
        for load in found
    ]
    return f"Load: {', '.join(told)}." if told else ""


def load_warnings(found: Sequence[Load]) -> Iterator[str]:
    """Yield a sentence for each load above 100 %, with what is needed, and for other loads of the peak hour."""
    for load in found:
        unit, trips = UNITS[load.who], load.who in OF_TRIPS
        if (percent := load.percent or 0.0) > 100:
            told = (
                f"{told_hours(load.wanted_h)} of work in {told_hours(load.there_h or 0.0)}{ASSUMED if trips else ''}."
            )
            if (more := load.enough(percent)) is not None:
                peak = load.enough(load.peak_percent or 0.0) or 0
                told += f" At least {_are(more, unit)} needed"
                told += f", {peak:,} in the peak hour" if peak > more else ""
                told += f", unless trips serve {math.ceil(percent / 10) / 10:.1f} order lines each." if trips else "."
            if load.done_h is not None and not _cut_off(load):
                told += f" The last item is handled about {load.done_h:,.1f} h after time 0, or later."
            yield f"Warning: {load.who} have {told}"
        elif (percent := load.peak_percent or 0.0) > 100:
            yield (
                f"Note: the orders of the hour from {load.peak} bring {_shown(percent)} of what {load.who} can do in it"
                f"{ASSUMED if trips else ''}; at least {_are(load.enough(percent) or 0, unit)} needed then."
            )
        if _cut_off(load):
            yield (
                f"Note: the run ends after {load.ends_h:,.1f} h (`run.until_s`), and {load.who} are not done before "
                f"{load.done_h:,.1f} h: orders are left."
            )


def _cut_off(load: Load) -> bool:
    """Whether the run ends before all of it can be done."""
    return load.ends_h is not None and load.done_h is not None and load.ends_h < load.done_h


@define(eq=False)
class ToldLoads:
    """Observer that says the loads before a run, and warns of those above 100 %.

    Parameters
    ----------
    console
        Where to.
    """

    console: Console

    @hookimpl
    def run_started(self, run: RunInfo) -> None:
        """Say them; where nobody reads it, nothing is reckoned."""
        if not self.console.quiet:
            found = loads(run.scenario, run.instance, run.layout)
            for sentence in (load_line(found), *load_warnings(found)):
                if sentence:
                    say(self.console, sentence)


def told_hours(hours: float) -> str:
    """Return hours for a sentence: as minutes or seconds where they are less than one."""
    if hours >= 1 or hours == 0:
        return f"{hours:,.1f} h"
    return f"{hours * 60:.0f} min" if hours * 60 >= 1 else f"{hours * 3600:.0f} s"


def _are(number: int, unit: str) -> str:
    return f"{counted(number, unit)} {'is' if number == 1 else 'are'}"


def _shown(percent: float) -> str:
    return f"{percent:,.0f} %" if math.isfinite(percent) else "none there"


def _peak(load: Load) -> str:
    """Return the load of the peak hour, to be added to the load."""
    return "" if load.peak_percent is None else f" ({_shown(load.peak_percent)} in the hour from {load.peak})"
