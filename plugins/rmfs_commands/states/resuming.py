"""Things that are going on at a moment of a run, and a run that goes on from there."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator, Iterable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
import simpy
from attrs import asdict

from rmfs_commands.cli.single_rule import reserving_way
from rmfs_commands.states.packed import KINDS, begin_tasks, go_on, in_totes, resume_packing
from rmfs_core.clock import to_seconds
from rmfs_core.errors import InputError, RuleError, RunError
from rmfs_core.simulation.going import Going
from rmfs_traffic import ReservedError
from rmfs_traffic.paths import Stop

if TYPE_CHECKING:
    from rmfs_core.simulation.engine import Simulation
    from rmfs_core.warehouse import Order, Robot

NO_PATH = "returned None; expected Path."
AT_STATION = ("picker", "pick", "stow")


def going_on(run: Simulation) -> list[Going]:
    """Return what is going on in a run between two ticks: what ends at a tick, in that order, and then the rest."""
    driving: Any = run.driving
    _check_way(run)
    found = [one for tick, event in run.env.upcoming if event.callbacks and (one := _told(driving, tick, event))]
    found += [Going("room", robot.id) for waiting in run.waiting_for_slot for _, robot in waiting]
    found += [] if run.outages is None else run.outages.held
    found += in_totes(run)
    found += [Going("line", robot.id) for line in driving.standing for robot in line]
    busy, robots = {going.robot for going in found}, run.warehouse.robots
    found += [Going("drive", r.id) for r in robots if r.id not in busy and (r.task is not None or r.goal is not None)]
    if not hasattr(driving, "courses"):
        return found
    overtaken = {course.robot.id: course.overtaken for course in driving.courses}
    return [going._replace(overtaken=overtaken.get(going.robot, 0)) for going in found]


def _told(driving: Any, tick: int, event: simpy.Event) -> Going | None:
    """Return what an event is for; None where nothing comes of it: robots that wait for a round ask anew."""
    going = event.value
    if not isinstance(going, Going):
        if hasattr(driving, "registered"):
            return None
        raise InputError("run.until_s", f"at {to_seconds(tick)} s something ends that a state cannot hold")
    robot = going.robot or 0
    legs = tuple((cell, wait) for cell, wait in _legs_left(driving, robot)) if going.kind in ("leg", "wait") else ()
    if going.kind == "leg":
        _, to, wait, _, start, _ = driving.under_way[robot]
        going = going._replace(since=start, legs=((to, wait), *legs))
    elif going.kind == "wait":
        course = driving.courses[robot]
        if course.waits is not event:  # it has other legs now
            return None
        going = going._replace(since=course.since, legs=legs)
    return going._replace(tick=tick)


def _legs_left(driving: Any, robot: int) -> Iterable[Sequence[int]]:
    left: Iterable[Sequence[int]] = (
        driving.courses[robot].legs if hasattr(driving, "courses") else driving.next_legs[robot]
    )
    return left


def resume(run: Simulation, begun: Any) -> None:
    """Let all go on that was going on, in that order; what a state does not tell of begins now."""
    warehouse, left = run.warehouse, run.clocks
    _recall(run, begun)
    driving: Any = run.driving
    if any(one.kind in ("leg", "wait") for one in begun.going):
        _check_way(run)
    driving.path = _blaming_the_state(driving.path)
    _take_in(driving, begun.going)
    for going in begun.going:
        if going.kind in left:
            run.env.process(left.pop(going.kind)())
        elif going.kind == "release":
            held = warehouse.request_in_hand(warehouse.stations[going.station or 0])
            assert held is not None  # it was looked at
            run.env.process(_once(partial(run.release_later, held, going)))
        elif going.kind == "bundle" and run.supply is not None:  # it is looked at
            run.env.process(_once(partial(run.supply.comes, going)))
        elif going.kind == "alarm":
            run.env.process(_once(partial(run.decisions.ring_at, going.tick, wanted=going.tick == begun.wakes)))
        elif going.kind in KINDS:
            if (process := go_on(run, going)) is not None:
                run.env.process(_once(process) if callable(process) else process)
        elif going.robot is not None:
            robot = warehouse.robots[going.robot]
            if hasattr(driving, "courses"):
                driving.go_on(robot.id)
            if robot.id in run.stories:
                run.env.process(_story(run, robot, going))
    run.driving.begin()
    begin_tasks(run, begun.going)
    for clock in left.values():
        run.env.process(clock())


def _check_way(run: Simulation) -> None:
    reserving_way(run.rules.pp, "rules.pp", "of whose robots on their legs a state tells nothing")


def _blaming_the_state(path: Callable[..., Any]) -> Callable[..., Any]:
    """Return what asks for paths; without one, the state is to blame, which has robots in each other's way."""

    def asked(*given: Any, **named: Any) -> Any:
        try:
            return path(*given, **named)
        except RuleError as error:
            if error.problem != NO_PATH:
                raise
            found = "found no path from where the state has the robots, some of which stand in aisles"
            expected = "expected rules.pp=whca-n or free-flow, which go on from there"
            raise RunError(f"{found}; {expected}", "instance.state_file") from error

    return asked


def _recall(run: Simulation, begun: Any) -> None:
    """Let a run know what was so far."""
    warehouse = run.warehouse
    run.visits, run.stories, run.context.asker.period = begun.visits, dict(begun.stories), begun.periods
    begun.recall(run)
    run.completed = sum(map(_done, warehouse.orders))
    resume_packing(run, begun)
    if run.outages is not None:
        run.outages.remember([] if begun.state.run is None else [asdict(one) for one in begun.state.run.outages])
    if run.supply is not None:
        run.supply.knows(warehouse, [(one.sku, one.items) for one in begun.going if one.kind == "bundle"])


def _done(order: Order) -> bool:
    """Whether nothing is left to do of an order: it is packed where it is bound for a packing station, or complete."""
    return order.complete if order.packing is None else order.packing.packed


def _once(act: Callable[[], object]) -> Generator[Any, Any, None]:
    """Do something when those have begun that are told of before: what ends together does so in that order."""
    act()
    return
    yield


def _story(run: Simulation, robot: Robot, going: Going) -> Generator[Any, Any, None]:
    """Go on with what a robot does."""
    story, *what = run.stories[robot.id]
    serving = going.kind in AT_STATION
    driving: Any = run.driving
    if going.kind == "leg" and not hasattr(driving, "courses"):
        yield from driving.follow(robot, deque([*leg] for leg in going.legs), going.since)
        if story == "transport" and robot.pod is not None:
            station = run.warehouse.stations[what[0].bound_for[0]]
            if robot not in station.line:
                driving.join(robot, station)
    timed = going if serving or going.kind in ("lift", "set", "charge") else None
    if story == "transport" and what[0].location is None:
        yield from run.visit_stations(robot, what[0], timed if serving else None)
    else:
        yield from getattr(run, story)(robot, *what, timed)


def _take_in(driving: Any, going: Sequence[Going]) -> None:
    """Let robots that keep out of each other's way be where a state has them: on their legs, and in their lines."""
    if not hasattr(driving, "courses"):
        return
    warehouse, windows = driving.run.warehouse, hasattr(driving, "registered")
    told = {one.robot: one for one in going if one.kind in ("leg", "wait")}
    starts = [_on_legs(driving, course, told.get(course.robot.id)) for course in driving.courses]
    _reserve(driving, driving.table, starts)
    if windows:
        runs = [
            (course.under_way[0], ends[:1]) if course.under_way else (driving.next_stop(course), [])
            for course, (_, ends) in zip(driving.courses, starts, strict=True)
        ]
        _reserve(driving, driving.registered, runs)
    for course, (_, ends) in zip(driving.courses, starts, strict=True):
        course.goal = ends[-1][0] if ends else course.robot.cell
    for station in warehouse.stations:
        slots, line = (station.cell, *station.cells.queue), driving.lines[station.id]
        places = {robot.id: place for place, robot in enumerate(station.line)}
        entries = {}
        for course in driving.courses:
            pod = None if course.robot.pod is None else warehouse.pods[course.robot.pod]
            if pod is None or (course.robot.id not in places and pod.bound_for[:1] != (station.id,)):
                continue
            joined = course.robot.id in places
            if windows and (joined or course.legs or course.under_way):
                entry = _entry(course, station)
                if joined or (entry is not None and course.goal in slots):
                    entries[course.robot.id] = driving.progress_of[course.robot.id].entry = entry or 0
                    line.append(course)
                if joined or entry is not None:
                    course.station, course.joined, course.goal = station, joined, station.cell
            elif not windows and course.goal in slots:
                course.station, course.joined = station, joined
                line.append(course)
        last = len(places)
        line.sort(key=lambda one: (places.get(one.robot.id, last), entries.get(one.robot.id) or 0, _slot(slots, one)))
        for course in driving.courses if windows else ():
            leaves = course.robot.cell == station.cell and course.robot.pod is not None and course not in line
            if leaves and course.under_way is None:
                driving.progress_of[course.robot.id].leaves = station
                line.insert(0, course)
    driving.owner.clear()
    driving.owner.update({course.goal: course for course in driving.courses if course.station is None or not windows})


def _slot(slots: Sequence[int], course: Any) -> int:
    return slots.index(course.goal) if course.goal in slots else len(slots)


def _entry(course: Any, station: Any) -> int | None:
    """Return the tick at which a robot's reserved path enters the queue of a station; None where it does not."""
    if course.reserved is None:
        return None
    cells, since, _ = course.reserved
    enters = since[np.isin(cells, station.cells.queue)]
    return int(enters[0]) if len(enters) else None


def _reserve(driving: Any, table: Any, starts: Sequence[tuple[Stop, list[tuple[int, int]]]]) -> None:
    """Reserve what robots drive, and the cells where the others stand."""
    for course in driving.courses:
        table.release(course.robot.id)
    for course, (start, legs) in sorted(zip(driving.courses, starts, strict=True), key=lambda one: not one[1][1]):
        try:
            if legs:
                rows, end = table.settle(course.robot.id, driving.roads, start, np.array(legs, dtype=np.int64))
                if table is driving.table:
                    course.reserved, course.arrives = rows, end.start_tick
            else:
                table.hold(course.robot.id, start.cell, start.start_tick)
        except ReservedError as error:
            one, other = course.robot.name, driving.run.warehouse.robots[error.owner].name
            problem = f"robots {one} and {other} have {driving.roads.layout.where(error.cell)} at once"
            place = f"{driving.run.scenario.instance.state_file}, robots"
            raise InputError(place, f"{problem}; expected one robot in a cell") from None


def _on_legs(driving: Any, course: Any, told: Going | None) -> tuple[Stop, list[tuple[int, int]]]:
    """Let a robot be on the legs that are told of; return from where and when all of them are driven."""
    robot = course.robot
    if told is None or not told.legs:
        return Stop(robot.cell, robot.heading, driving.run.warehouse.now), []
    legs, course.since, course.overtaken = [*told.legs], told.since, told.overtaken
    if told.kind == "wait":
        start, course.ready = Stop(robot.cell, robot.heading, told.tick - legs[0][1]), told.tick
        course.legs = deque([*leg] for leg in legs)
        return start, legs
    to, wait = legs.pop(0)
    heading, turn, ticks = driving.turn_and_run(robot, to)
    start = Stop(robot.cell, robot.heading, told.since + wait)
    course.under_way, course.legs = (start, Stop(to, heading, start.start_tick + turn + ticks)), deque(map(list, legs))
    return start, [(to, 0), *legs]
