"""Opening hours of stations and duty of robots: what the timetables of a scenario say, and a run that follows them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

from rmfs_commands.instances.calendar import Calendar
from rmfs_core.errors import InputError
from rmfs_core.events import RobotsOnDuty
from rmfs_core.scenario import Scenario
from rmfs_core.scenario.service import Speed, speeds_of
from rmfs_core.simulation.applying import tell_open
from rmfs_core.simulation.driving.base import Process
from rmfs_core.simulation.going import Going
from rmfs_core.timetable import ALWAYS, DAY, Timetable, read_spans


class Hours:
    """Stations that open and close, and robots that come and go, in a run (`Simulation`)."""

    @staticmethod
    def timetables(scenario: Scenario, stations: int) -> dict[int | None, Timetable]:
        """Return the timetables of a scenario, as `hours_of` does."""
        return hours_of(scenario, stations)

    def __init__(self, run: Any) -> None:
        self._run = run

    def follow(self) -> Process:
        """Run a round whenever stations or robots come or go; end when a whole day has brought nothing else."""
        run, hours = self._run, self._run.hours.values()
        alone, most = 0, 2 * sum(len(timetable.spans) for timetable in hours)
        while alone <= most and (ticks := [tick for one in hours if (tick := one.next_change(run.now))]):
            yield run.context.after(min(ticks) - run.now, Going("hours"))
            self.keep()
            run.decisions.round(by_clock=True)
            alone = alone + 1 if run.env.peek() == math.inf else 0
            if run.outages is not None:
                run.outages.check()

    def keep(self) -> None:
        """Open and close stations, and send robots on and off duty, as the timetables have it now."""
        warehouse, now, tell = self._run.warehouse, self._run.now, self._run.context.tell
        for whose, timetable in self._run.hours.items():
            if whose is not None:
                station = warehouse.stations[whose]
                was_open = station.open
                warehouse.staff(station, *self.staffed(whose))
                tell_open(warehouse, station, was_open, tell)
            elif (number := timetable.at(now)) != sum(robot.on_duty for robot in warehouse.robots):
                warehouse.put_on_duty(number)
                tell(RobotsOnDuty(tick=now, number=number))

    def staffed(self, station: int) -> tuple[bool, int | None]:
        """Return whether a station with a timetable is open now, and the tick at which that changes."""
        timetable, now = self._run.hours[station], self._run.now
        return bool(timetable.at(now)), timetable.next_change(now)


def hours_of(scenario: Scenario, stations: int) -> dict[int | None, Timetable]:
    """Return the timetables of a scenario with so many picking stations; InputError where they make no sense."""
    hours = timetables(scenario, "stations.open", scenario.stations.open, stations)
    if hours and not any(hours[number].spans if number in hours else True for number in range(stations)):
        raise InputError("stations.open", "found no span for any station; expected one that opens")
    robots, available = scenario.robots.count, scenario.robots.available
    zero = Calendar(scenario.instance.start).time_of_day()
    return hours if available is None else hours | {None: Timetable(read_spans(available, robots), zero)}


def timetables(scenario: Scenario, place: str, given: Any, stations: int) -> dict[int | None, Timetable]:
    """Return the timetables of stations by id, given one for all of them or some by name."""
    zero, ids = Calendar(scenario.instance.start).time_of_day(), [str(number) for number in range(1, stations + 1)]
    spans = given if isinstance(given, Mapping) else {} if given is None else dict.fromkeys(ids, given)
    for name in spans:
        if name not in ids:
            raise InputError(f"{place}.{name}", f"no station {name}; expected 1 to {stations}")
    return {ids.index(name): Timetable(read_spans(of), zero) for name, of in spans.items()}


def shifts_of(hours: Mapping[int | None, Timetable], stations: int) -> tuple[list[Timetable], list[Timetable]]:
    """Return the timetables of all picking stations, and that of the robots, given the result of `hours_of`."""
    return [hours.get(number, ALWAYS) for number in range(stations)], [hours.get(None, ALWAYS)]


def first_common(*groups: Iterable[Timetable]) -> int | None:
    """Return the first tick of a run at which one of each group has a number above 0; None: there is never one."""
    given = [list(group) for group in groups]
    begins = {(begin - one.zero) % DAY for group in given for one in group for begin, *_ in one.spans}
    for tick in sorted({0, *begins}):
        if all(any(one.at(tick) for one in group) for group in given):
            return tick
    return None


def mean_speed(speed: Speed) -> float:
    """Return the mean speed of the shifts, or that of all day."""
    _, (other, *shifts) = speeds_of(speed)
    return sum(shifts) / len(shifts) if shifts else other
