"""Opening hours: when stations take orders, and robots tasks."""

from __future__ import annotations

from collections.abc import Mapping

from rmfs_commands.processes.events import StationDown, StationUp
from rmfs_commands.processes.hours import hours_of
from rmfs_commands.validation.case import Case, Handlers, seconds
from rmfs_commands.validation.state import State
from rmfs_core.errors import InputError
from rmfs_core.events import OrderAssigned, RobotsOnDuty, StationClosed, StationOpened, TaskAssigned
from rmfs_core.scenario import scenario_from_dict
from rmfs_core.timetable import Timetable


class ShiftCheck:
    """Stations open and close, and robots come and go, when the scenario says; who is not there gets nothing to do."""

    def __init__(self, case: Case, state: State) -> None:
        self.case = case
        self.state = state
        self.hours = _hours(case)
        self.by_load = bool(case.trace.scenario.get("rules", {}).get("activate"))
        self.told: dict[int | None, list[tuple[int, int]]] = {i: [(-1, 1)] for i in range(len(case.trace.stations))}
        """Of each station when it opened (1) and closed (0); of None, how many robots were on duty from when on."""
        self.told[None] = [(-1, len(case.trace.robots))]
        self.down: list[tuple[int, int, bool]] = []  # stations that failed, or were repaired: tick, station, which
        self.handlers: Handlers = {
            StationDown: lambda event: self.down.append((event.tick, event.station, True)),
            StationUp: lambda event: self.down.append((event.tick, event.station, False)),
            StationOpened: lambda event: self.changed(event, 1),
            StationClosed: lambda event: self.changed(event, 0),
            RobotsOnDuty: self.duty,
            OrderAssigned: self.assigned,
            TaskAssigned: self.task,
        }

    def changed(self, event: StationOpened | StationClosed, opened: int) -> None:
        """Check that a station opens or closes when it may."""
        told, hours = self.told[event.station], self.hours.get(event.station)
        does = f"{self.case.station(event.station)} {'opens' if opened else 'closes'}"
        staffed = 0 if self._fails(event.station, event.tick) else 1 if hours is None else hours.at(event.tick)
        if told[-1][1] == opened:
            self.case.add("station-hours", event.tick, f"{does}, but is {'open' if opened else 'closed'} already")
        elif staffed < opened or (staffed > opened and not self.by_load):
            self.case.add("station-hours", event.tick, f"{does}, which `stations.open` does not say")
        told.append((event.tick, opened))

    def _fails(self, station: int | None, tick: int) -> bool:
        """Whether a station is out of service after the events of a tick."""
        told = [down for at, which, down in self.down if which == station and at <= tick]
        return bool(told) and told[-1]

    def duty(self, event: RobotsOnDuty) -> None:
        """Check that as many robots are on duty as should be."""
        hours, told = self.hours.get(None), self.told[None]
        expected = told[0][1] if hours is None else hours.at(event.tick)
        if event.number != expected or event.number == told[-1][1]:
            is_news = "" if event.number != told[-1][1] else ", as before"
            said = f"robots on duty from now on: {event.number}{is_news}; the scenario says {expected}"
            self.case.add("robot-hours", event.tick, said)
        told.append((event.tick, event.number))

    def assigned(self, event: OrderAssigned) -> None:
        """Check that a station which gets an order is open; a further part of an order there is no new order."""
        order, header = self.state.orders[event.order], self.case.trace.stations[event.station]
        joins = header["counts_orders"] and any(at == event.station and size for (at, _), size in order.size.items())
        if not self.told[event.station][-1][1] and not joins:
            name = self.case.order(event.order)
            closed = f"{name} is assigned to {self.case.station(event.station)}, which is closed"
            self.case.add("station-closed", event.tick, closed)

    def task(self, event: TaskAssigned) -> None:
        """Check that a robot which gets a task is on duty."""
        if event.robot >= self.told[None][-1][1]:
            fetches = f"{self.case.robot(event.robot)} shall fetch {self.case.pod(event.pod)}"
            self.case.add("off-duty", event.tick, f"{fetches}, but is off duty")

    def at_end(self) -> None:
        """Check that whatever the timetables say has been told."""
        for whose, hours in self.hours.items():
            tick: int | None = self.case.trace.began
            while tick is not None and tick < self.case.trace.tick:
                number = next(number for told, number in reversed(self.told[whose]) if told <= tick)
                if self._fails(whose, tick):
                    pass
                elif number > hours.at(tick) or (number < hours.at(tick) and not (self.by_load and whose is not None)):
                    self._missed(whose, tick, hours.at(tick), number)
                    break
                tick = hours.next_change(tick)

    def _missed(self, whose: int | None, tick: int, expected: int, number: int) -> None:
        if whose is None:
            said = f"robots on duty from {seconds(tick)} on: {number}; the scenario says {expected}"
            self.case.add("robot-hours", tick, said)
        else:
            does = f"{self.case.station(whose)} does not {'open' if expected else 'close'} at {seconds(tick)}"
            self.case.add("station-hours", tick, f"{does}, as `stations.open` says")


def _hours(case: Case) -> Mapping[int | None, Timetable]:
    picking = len(case.trace.stations) - case.layout.replenishing
    try:
        return hours_of(scenario_from_dict(case.trace.scenario, name="header of the trace"), picking)
    except InputError:  # which another check finds
        return {}
