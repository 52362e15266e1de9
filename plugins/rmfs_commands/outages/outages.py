"""Robots, stations and chargers out of service for a time. Why no run stands still: docs/explanation/traffic.md."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Generator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import simpy
from attrs import define

from rmfs_commands.instances.calendar import Calendar
from rmfs_commands.processes.events import ChargerDown, ChargerUp, RobotDown, RobotUp, StationDown, StationUp
from rmfs_core.clock import to_seconds, to_ticks
from rmfs_core.errors import InputError
from rmfs_core.randomness import keyed_stream
from rmfs_core.scenario import located
from rmfs_core.scenario.model import FailuresSection
from rmfs_core.simulation.applying import tell_open
from rmfs_core.simulation.going import Going
from rmfs_core.timetable import DAY, Timetable, read_spans
from rmfs_core.warehouse import Robot, Station

if TYPE_CHECKING:
    from rmfs_core.simulation.engine import Simulation

CLOCKS = "hours", "outages"
"""Kinds of what is going on that may come to nothing, as often as it comes."""


@define(eq=False)
class _Charger:
    """A charger: its number in the order of cells, and its cell."""

    id: int
    cell: int
    in_service: bool = True


_One = Robot | Station | _Charger
_KINDS: Mapping[type, str] = {Robot: "robot", Station: "station", _Charger: "charger"}


@define(eq=False)
class _State:
    """When something fails next and how long that lasts, when it is maintained; how often it was out of service, and
    until when it is, and whether that is planned, None while it works; and what happens when it fails or works again.
    """

    failures: FailuresSection | None
    hours: Timetable
    turned: simpy.Event
    fails: float = math.inf
    repair: int = 0
    number: int = 0
    until: float | None = None
    planned: bool = False


class Outages:
    """Takes robots, stations and chargers out of service and back.

    How long one works, and how long the repair takes that follows, are drawn when it begins to work: by the seed, by
    which one it is, and by how often it has been out of service before. A robot first drives to the maintenance cell
    that is nearest, if the layout has one that is free; not one that is low, which might reach no charger then.

    Parameters
    ----------
    run
        The run.

    Raises
    ------
    InputError
        When ``robots.maintenance`` names another robot.
    """

    def __init__(self, run: Simulation) -> None:
        scenario, warehouse = run.scenario, run.warehouse
        self._run, self._warehouse, self._env, self._tell = run, warehouse, run.env, run.context.tell
        self._states, self._changed = dict[_One, _State](), run.env.event()
        zero, given = Calendar(scenario.instance.start).time_of_day(), scenario.robots.maintenance or {}
        names = {robot.name for robot in warehouse.robots}
        if unknown := next((name for name in given if name not in names), None):
            with located(scenario):
                raise InputError(f"robots.maintenance.{unknown}", f"no robot {unknown}; expected 1 to {len(names)}")
        for robot in warehouse.robots:
            self._add(robot, scenario.robots.failures, Timetable(read_spans(given.get(robot.name, ())), zero))
        for station in warehouse.picking:
            self._add(station, scenario.stations.outages, Timetable(()))
        battery = scenario.robots.battery
        self._chargers = [_Charger(i, cell) for i, cell in enumerate(warehouse.travel.layout.chargers)]
        for charger in self._chargers:
            self._add(charger, None if battery is None else battery.charger_outages, Timetable(()))
        self._hours = [*run.hours.values(), *(state.hours for state in self._states.values())]
        changes = {(tick - hours.zero) % DAY for hours in self._hours for span in hours.spans for tick in span[:2]}
        self._parts = {tuple(hours.at(tick) for hours in self._hours) for tick in changes or {0}}  # of the day
        self._held: dict[Station, Going] = {}
        self._tried: defaultdict[tuple[int, bool], defaultdict[Any, set[_One | None]]]
        self._tried, self._done = defaultdict(lambda: defaultdict(set)), tuple[int, ...]()

    def _add(self, one: _One, failures: FailuresSection | None, hours: Timetable) -> None:
        if failures is not None or hours.spans:
            self._states[one] = _State(failures, hours, self._env.event())
            self._begin(one)

    def follow(self) -> Generator[simpy.Event, Any, None]:
        """Let failures, repairs and maintenance happen."""
        for one in self._states:  # whose maintenance may have begun
            self.update(one)
        tick, timer = -1.0, self._changed
        while True:
            before, tick = tick, min(map(self._next, self._states.values()), default=math.inf)
            if tick == math.inf:  # whatever changes does so when a robot has ended its task
                yield self._changed
                continue
            if tick != before:
                timer = self._env.timeout(int(tick) - self._warehouse.now, Going("outages"))
            yield timer | self._changed
            if self._warehouse.now == tick:
                for one in self._states:
                    self.update(one)
                self._charge_on()
                self._run.decisions.round(by_clock=True)
                self.check()

    def check(self) -> None:
        """End a run that cannot go on, after rules were asked: in each part of the day, by the hours, nothing is under
        way while each robot works together with each station and with each charger, and rules decide nothing.

        No run ends that can go on, if a decision depends on one robot, and one station or charger, in service. Say
        rules would decide something for robot r and station s in a part of the day. Orders, pods and requests are the
        same since the last progress, so rules would decide it whenever r and s are in service in that part, whatever
        else is not. They were asked at such a time, and decided nothing. A low robot does nothing that another cannot
        do, but charge, so it is enough that r was asked for while it was not low. Where r has never been that with
        all of them, it has been low since, together with each charger, and nobody let it charge: it stays low.

        Raises
        ------
        StandstillError
            When that is so.
        """
        run, states, warehouse = self._run, self._states, self._warehouse
        load = sum(station.load + len(station.bundles) for station in warehouse.stations)
        done = run.visits, run.completed, len(warehouse.arrived), load, len(warehouse.waiting), len(warehouse.bundles)
        if done != self._done:
            self._done = done
            self._tried.clear()
        for robot in warehouse.robots:
            if not robot.low:
                self._tried.pop((robot.id, True), None)
        if any(robot.task is not None for robot in warehouse.robots):
            return
        if any(getattr(event.value, "kind", "") not in CLOCKS for _, event in run.env.upcoming):
            return
        others = [None, *(one for one in states if not isinstance(one, Robot))]
        works = [one for one in others if one is None or one.in_service]
        part = tuple(hours.at(warehouse.now) for hours in self._hours)
        for robot in warehouse.robots:
            if robot.in_service or states[robot].planned:
                self._tried[robot.id, robot.low][part].update(works)
        full = {key for key, tried in self._tried.items() if all(len(tried[one]) == len(others) for one in self._parts)}
        if all((robot.id, False) in full or (robot.id, True) in full for robot in warehouse.robots):
            raise run.standstill()

    def repaired(self, station: Station, going: Going) -> simpy.Event:
        """Return what happens when a station works again, where a visit goes on then."""
        self._held[station], turned = going, self._states[station].turned
        turned.callbacks.append(lambda _: self._held.pop(station) and None)
        return turned

    @property
    def held(self) -> list[Going]:
        """Visits that go on when their stations work again, and robots at chargers that do not work."""
        found = [*self._held.values()]
        chargers = {one.cell for one in self._chargers if not one.in_service}
        robots = [robot for robot in self._warehouse.robots if robot.goal == robot.cell and robot.cell in chargers]
        return found + [Going("charge", robot.id) for robot in robots]

    def memory(self) -> list[dict[str, Any]]:
        """Return when each robot, station and charger fails next, or works again, as a state has it."""
        return [
            {
                "of": _KINDS[type(one)],
                "id": one.id,
                "number": state.number,
                "planned": state.planned,
                **({"fails_s": to_seconds(int(state.fails))} if state.fails < math.inf else {}),
                "repair_s": to_seconds(state.repair),
                **({"until_s": to_seconds(int(state.until))} if state.until not in (None, math.inf) else {}),
            }
            for one, state in self._states.items()
        ]

    def remember(self, told: Sequence[Mapping[str, Any]]) -> None:
        """Take back what a state has; what is out of service and of which it tells nothing has failed just now."""
        known, now = {(one["of"], one["id"]): one for one in told}, self._warehouse.now
        for charger in self._chargers:
            charger.in_service = charger.cell in self._warehouse.chargers
        for one, state in self._states.items():
            if (kept := known.get((_KINDS[type(one)], one.id))) is not None:
                state.number, state.planned, state.repair = kept["number"], kept["planned"], to_ticks(kept["repair_s"])
                state.fails = math.inf if kept["fails_s"] is None else to_ticks(kept["fails_s"])
            if not one.in_service:
                ends = None if kept is None else kept["until_s"]
                state.until = now + max(state.repair, 1) if kept is None else math.inf
                state.until = state.until if ends is None else to_ticks(ends)

    def charge(self, robot: Robot, share: float, going: Going | None = None) -> Generator[simpy.Event, Any, None]:
        """Let a robot charge; end when its charger fails, unless it might reach no other one."""
        left = None if going is None else going.tick and going.tick - self._warehouse.now
        warehouse, charger = self._warehouse, next((one for one in self._chargers if one.cell == robot.cell), None)
        state = None if charger is None else self._states.get(charger)
        while True:
            if ticks := warehouse.ticks_to_charge(robot, share) if left is None else left:
                charged = self._env.timeout(ticks, Going("charge", robot.id))
                yield charged if state is None else charged | state.turned
                if charged.processed:
                    return
            battery = warehouse.battery_of(robot)
            if charger is None or charger.in_service or battery is None or battery.may_go_on:
                return
            assert state is not None
            yield state.turned
            left = None

    def _charge_on(self) -> None:
        """Let robots charge that are low and stand at chargers which work again."""
        warehouse = self._warehouse
        for robot in warehouse.robots:
            stands = robot.resting and robot.cell in warehouse.chargers and robot.id not in self._run.driving.under_way
            if stands and robot.low and all(other.goal != robot.cell for other in warehouse.robots):
                self._run.send(robot, robot.cell)

    def _next(self, state: _State) -> float:
        """Return the tick at which something may change; infinite where that is when a robot has ended its task."""
        if state.until is not None:
            return state.until
        now = self._warehouse.now
        return min(state.fails if state.fails > now else math.inf, state.hours.next_change(now) or math.inf)

    def update(self, one: _One) -> None:
        """Take something out of service or back if it is time; a robot only when it has ended its task."""
        if (state := self._states.get(one)) is None:
            return
        now = self._warehouse.now
        if state.until is not None and state.until <= now:
            state.until, state.planned, state.number = None, False, state.number + 1
            self._begin(one)
            self._change(one, in_service=True)
            self._turn(state)
        if state.until is None and not (isinstance(one, Robot) and not one.resting):
            failed = state.fails <= now
            if not (failed or state.hours.at(now)):
                return
            if isinstance(one, Robot) and (cell := self._repaired_in(one)) is not None:
                self._run.send(one, cell)
                return
            state.planned = not failed
            state.until = now + state.repair if failed else state.hours.next_change(now) or math.inf
            self._change(one, in_service=False, planned=state.planned)
            self._turn(state)
            self._changed = self._told(self._changed)  # its repair may come next

    def _turn(self, state: _State) -> None:
        """Let those go on who wait for something to fail, or to work again."""
        state.turned = self._told(state.turned)

    def _told(self, event: simpy.Event) -> simpy.Event:
        """Let those go on who wait for an event; return the one to wait for from now on."""
        if not event.callbacks:
            return event
        event.succeed()
        return self._env.event()

    def _repaired_in(self, robot: Robot) -> int | None:
        """Return the maintenance cell that a robot drives to; None where it stays."""
        warehouse, cells = self._warehouse, self._warehouse.travel.layout.maintenance
        if not cells or robot.low or robot.cell in cells:
            return None
        ticks = warehouse.travel.times_from(robot.cell, robot.heading, False)
        free = [cell for cell in cells if cell not in warehouse.taken_cells()]
        return min(free, key=lambda cell: (int(ticks[cell]), cell), default=None)

    def _begin(self, one: _One) -> None:
        """Draw how long something works from now on, and how long it is repaired then."""
        kind = "robots" if isinstance(one, Robot) else "stations" if isinstance(one, Station) else "chargers"
        state, purpose = self._states[one], f"failures of {kind}"
        if state.failures is not None:
            rng = keyed_stream(self._run.scenario.seed, purpose, one.id, state.number)
            works_s, repair_s = rng.exponential((3600 * state.failures.mtbf_h, state.failures.mttr_s)).tolist()
            state.fails = self._warehouse.now + max(to_ticks(works_s), 1)
            state.repair = max(to_ticks(repair_s), 1)

    def _change(self, one: _One, *, in_service: bool, planned: bool = False) -> None:
        warehouse, tell = self._warehouse, self._tell
        if isinstance(one, _Charger):
            one.in_service = in_service
            warehouse.put_charger_in_service(one.cell, in_service, self._run.driving.under_way)
            tell((ChargerUp if in_service else ChargerDown)(warehouse.now, one.cell))
            return
        was_open = isinstance(one, Station) and one.open
        warehouse.put_in_service(one, in_service)
        if isinstance(one, Station):
            tell((StationUp if in_service else StationDown)(warehouse.now, one.id))
            tell_open(warehouse, one, was_open, tell)
        else:
            up = RobotUp(warehouse.now, one.id)
            tell(up if in_service else RobotDown(warehouse.now, one.id, planned))
