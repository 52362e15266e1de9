"""Things that are under way in a state, and whether they can be."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Any

from rmfs_commands.states.names import Names
from rmfs_commands.states.packed import check_packing, on_the_way
from rmfs_commands.states.resuming import AT_STATION
from rmfs_commands.states.state import GoingState, State
from rmfs_core.clock import to_seconds, to_ticks
from rmfs_core.scenario.source import KeyPath
from rmfs_core.simulation.going import Going
from rmfs_core.warehouse import Robot, Warehouse

NEEDS: Mapping[str, tuple[str, ...]] = {
    "leg": ("robot", "legs", "until_s"),
    **dict.fromkeys(("wait", "drive", "room", "line"), ("robot",)),
    **dict.fromkeys(("lift", "set"), ("robot", "until_s")),
    "charge": ("robot",),
    "picker": ("robot", "visit"),
    "pick": ("robot", "visit", "sku", "until_s"),
    "stow": ("robot", "visit", "until_s"),
    "release": ("station", "until_s"),
    "handled": ("station", "order", "sku", "until_s"),
    "bundle": ("sku", "items", "until_s"),
    "alarm": ("until_s",),
    "tote": ("station", "order", "items"),
    "totes": ("station", "until_s"),
    "conveyor": ("order", "items", "tote", "until_s"),
    **dict.fromkeys(("put", "pack"), ("packing", "order", "tote", "until_s")),
    "packers": ("packing", "until_s"),
}
"""Keys that each kind of `rmfs_core.simulation.going.Going` has to have."""

STORIES: Mapping[str, tuple[str, ...]] = {
    **dict.fromkeys((*AT_STATION, "room", "line"), ("transport",)),
    "lift": ("transport", "move"),
    "set": ("store", "move"),
    "charge": ("rest",),
}
"""Stories in which each kind happens, where not in all of them."""


def under_way(
    state: State, names: Names, warehouse: Warehouse, *, restocked: bool
) -> tuple[list[Going], dict[int, tuple[Any, ...]]]:
    """Return what is going on, and the robots' stories.

    Parameters
    ----------
    state, names
        State, and its names.
    warehouse
        The warehouse as the state has it.
    restocked
        Whether bundles arrive in the scenario.

    Raises
    ------
    InputError
        For the first thing that cannot be.
    """
    stories: dict[int, tuple[Any, ...]] = {}
    going: list[Going] = []
    told = () if state.run is None else state.run.going
    if state.run is not None:
        _check_once(state, names, warehouse)
    robots = {robot.name: robot for robot in warehouse.robots}
    reserved = set(warehouse.reserved)  # cells that no story ends in yet
    for i, one in enumerate(told):
        path = ("run", "going", i)
        robot = None if one.robot is None else robots.get(one.robot)
        if one.robot is not None and robot is None:
            names.wrong((*path, "robot"), f'names robot "{one.robot}", which the state does not list')
        if one.kind == "bundle" and not restocked:
            names.wrong((*path, "kind"), 'found "bundle", but the scenario has no replenishment')
        at = None if one.station is None else names.station(one.station, *path, "station")
        going.append(
            Going(
                one.kind,
                None if robot is None else robot.id,
                at if one.packing is None else names.packing(one.packing, *path, "packing"),
                None if one.sku is None else names.sku(one.sku, *path, "sku"),
                *(one.items, one.visit, one.picks, to_ticks(one.since_s)),
                tuple((int(cell), to_ticks(wait)) for cell, wait in one.legs),
                one.overtaken,
                to_ticks(one.until_s),
                None if one.order is None else names.order(one.order, *path, "order"),
                one.tote,
            )
        )
        _check(one, going[-1], robot, warehouse, names, path)
        if robot is not None and one.story is not None:
            stories[robot.id] = _story(one, robot, warehouse, names, path, reserved)
        if robot is not None:
            _check_robot(one, robot, warehouse, names, path)
    if state.run is not None:
        check_packing(state, names, warehouse, going)
    clocks = [] if state.run is not None else [Going("hours"), Going("arrivals"), Going("bundles")]
    cells = iter([*sorted(reserved), *warehouse.free_locations])
    for robot in warehouse.robots:  # of which nothing is told: they set out from where they stand
        if robot.id not in stories and (robot.task is not None or robot.goal is not None):
            stories[robot.id] = _begun_story(robot, warehouse, names, cells)
            going.append(Going("drive", robot.id))
    line = {robot.id: place for station in warehouse.stations for place, robot in enumerate(station.line)}
    if state.run is None:
        going.sort(key=lambda one: (line.get(one.robot or 0, math.inf), one.robot or 0))
        going += [
            Going("release", station=station.id, tick=max(warehouse.picker_free(station), warehouse.now + 1))
            for station in warehouse.stations
            if station.in_hand is not None
        ]
        going += on_the_way(warehouse, names)
    return [*clocks, *going], stories


def _begun_story(robot: Robot, warehouse: Warehouse, names: Names, cells: Iterator[int]) -> tuple[Any, ...]:
    """Return what a robot does of which a state tells task or goal alone; a pod is stored in the next of ``cells``."""
    if robot.task is None:
        return "rest", robot.goal, 1.0
    pod = warehouse.pods[robot.task]
    if pod.bound_for:
        return "transport", pod
    if (cell := next(cells, None)) is None:
        expected = "expected a free or reserved storage location for each pod that is bound for no station"
        names.wrong(("robots", robot.name, "task"), f'found pod "{pod.name}", for which none is left; {expected}')
    if cell not in warehouse.reserved:
        warehouse.reserve(cell)
    return ("store" if pod.location is None else "move"), pod, cell


def _story(
    one: GoingState, robot: Robot, warehouse: Warehouse, names: Names, path: KeyPath, reserved: set[int]
) -> tuple[Any, ...]:
    """Return what a robot does as a state tells it; the cell where that ends leaves ``reserved``."""
    if one.story == "rest":
        if robot.goal is None or one.cell != robot.goal:
            has = "no goal" if robot.goal is None else f"the goal {robot.goal}; expected that in `cell`"
            names.wrong((*path, "story"), f'found "rest" for robot "{robot.name}", which has {has}')
        return "rest", one.cell, one.charge
    if robot.task is None:
        names.wrong((*path, "story"), f'found "{one.story}" for robot "{robot.name}", which has no task')
    pod = warehouse.pods[robot.task]
    if one.story == "transport":
        if not pod.bound_for:
            names.wrong((*path, "story"), f'found "transport", but pod "{pod.name}" is bound for no station')
        return "transport", pod
    if one.cell not in reserved:
        names.wrong((*path, "cell"), f"found {one.cell}; expected a cell that `reserved` names, and no other entry")
    reserved.remove(one.cell)
    return one.story, pod, one.cell


def _check_once(state: State, names: Names, warehouse: Warehouse) -> None:
    """Check that nothing goes on twice, and that every item in hand is released."""
    assert state.run is not None
    known: set[tuple[str, object]] = set()
    for i, one in enumerate(state.run.going):
        there: dict[str, object] = {"robot": one.robot}
        there |= {"visit": one.visit} if one.kind in AT_STATION else {}
        there |= {"station": one.station} if one.kind == "release" else {}
        for key, value in there.items():
            if value and (key, value) in known:
                names.wrong(("run", "going", i, key), f"found {value} in two entries; expected one")
            known.add((key, value))
    most = max((one.visit for one in state.run.going), default=0)
    if most > state.run.visits:
        names.wrong(("run", "visits"), f"found {state.run.visits}; expected at least {most}, the visits in `going`")
    for station in warehouse.stations:
        if station.in_hand is not None and ("station", station.name) not in known:
            expected = 'expected an entry of kind "release" for each station with `in_hand`'
            names.wrong(("run", "going"), f'found none for station "{station.name}"; {expected}')


def _check(
    one: GoingState, going: Going, robot: Robot | None, warehouse: Warehouse, names: Names, path: KeyPath
) -> None:
    """Check that what is going on can be, at this time and place."""
    for key in NEEDS.get(one.kind, ()):
        if not getattr(one, key):
            names.wrong((*path, key), f'is missing; expected in an entry of kind "{one.kind}"')
    if one.until_s and going.tick <= warehouse.now:
        names.wrong((*path, "until_s"), f"found {one.until_s:g}, which is not later than the state's time")
    for key, second in (("since_s", one.since_s), ("visit_since_s", one.visit_since_s)):
        if to_ticks(second) > warehouse.now:
            names.wrong((*path, key), f"found {second:g}, which is later than the state's time")
    if going.kind == "charge" and not one.until_s and (robot is None or robot.cell in warehouse.chargers):
        names.wrong((*path, "until_s"), "is missing; expected it where the charger works")
    if going.kind in AT_STATION:
        at = next((station for station in warehouse.stations if station.line[:1] == (robot,)), None)
        if at is None:
            names.wrong((*path, "kind"), f'found "{going.kind}", but robot "{one.robot}" is first in no line')
        if going.sku is not None and going.sku not in {request.sku for request in at.open_requests}:
            names.wrong((*path, "sku"), f'found "{one.sku}", of which the station has no request')
        if one.until_s and going.tick > (free := warehouse.picker_free(at)):
            expected = f'expected at most {to_seconds(free):g}, when the picker of station "{at.name}" is free'
            names.wrong((*path, "until_s"), f"found {one.until_s:g}; {expected}")
    if going.kind == "release" and (going.station is None or warehouse.stations[going.station].in_hand is None):
        names.wrong((*path, "station"), 'found "release" of a station without `in_hand`')
    if robot is not None and going.legs:
        _check_legs(going, robot, warehouse, names, path)


def _check_legs(going: Going, robot: Robot, warehouse: Warehouse, names: Names, path: KeyPath) -> None:
    """Check that legs follow each other in rows and columns, and that the first is not over yet."""
    travel, size = warehouse.travel, warehouse.travel.layout.kind.size
    cells = [robot.cell, *(cell for cell, _ in going.legs)]
    if not all((b < size and travel.heading(a, b) is not None) or a == b for a, b in pairwise(cells)):
        names.wrong((*path, "legs"), "expected cells that lie in a row or column, one after the other")
    if going.kind == "wait" and not going.tick:
        names.wrong((*path, "until_s"), "is missing; expected it with a wait before legs")
    to, wait = going.legs[0]
    if going.kind == "wait" and not going.since <= going.tick - wait <= warehouse.now:
        span = f"expected {to_seconds(wait):g} s after a time from `since_s` to the state's"
        names.wrong((*path, "until_s"), f"found {to_seconds(going.tick):g}; {span}")
    if going.kind == "leg":
        turn = 0 if to == robot.cell else ((travel.heading(robot.cell, to) or 0) - robot.heading) % 4
        run = int(travel.runs[travel.layout.distance(robot.cell, to)])
        if (ends := going.since + wait + travel.turns.tolist()[turn] + run) <= warehouse.now:
            over = f"a leg since {to_seconds(going.since):g} is over at {to_seconds(ends):g} in this scenario"
            names.wrong((*path, "since_s"), f"{over}, which is not later than the state's time")


def _check_robot(one: GoingState, robot: Robot, warehouse: Warehouse, names: Names, path: KeyPath) -> None:
    """Check that a robot can do in its story what it does, where it stands."""
    if one.story is None and (robot.task is not None or robot.goal is not None):
        names.wrong((*path, "story"), f'is missing; expected the purpose of the task or goal of robot "{robot.name}"')
    if one.story not in STORIES.get(one.kind, (one.story,)):
        wanted = " or ".join(f'"{story}"' for story in STORIES[one.kind])
        names.wrong((*path, "story"), f'found "{one.story}"; expected {wanted} in an entry of kind "{one.kind}"')
    pod = None if robot.task is None else warehouse.pods[robot.task]
    location = None if pod is None else pod.location
    carries, beneath = pod is not None and location is None, location == robot.cell
    at_charger = robot.cell in warehouse.travel.layout.chargers and robot.charge is not None
    lines = [station for station in warehouse.stations if robot in station.line]
    in_line = any(robot.cell in (station.cell, *station.cells.queue) for station in lines)
    first = any(station.line[:1] == (robot,) and station.cell == robot.cell for station in warehouse.stations)
    there = {
        **dict.fromkeys(AT_STATION, (first, "stands at the station where it is first in line")),
        "lift": (beneath, "stands under the stored pod that is its task"),
        "room": (beneath, "stands under the stored pod that is its task"),
        "set": (carries and robot.cell == one.cell, "has a pod, and stands in the cell where its story ends"),
        "charge": (at_charger and robot.cell == one.cell, "stands at the charger where its story ends"),
        "line": (in_line, "stands in the queue of a station whose line it is in"),
    }
    holds, expected = there.get(one.kind, (True, ""))
    if not holds:
        names.wrong((*path, "kind"), f'found "{one.kind}" for robot "{robot.name}"; expected one that {expected}')
    if one.story == "store" and not carries:
        names.wrong((*path, "story"), f'found "store", but robot "{robot.name}" carries no pod')
