"""What is going on at a moment of a run, as plain data, and a run that goes on from there.

A process that waits for a tick tells what for, as the value of the event that it waits for. So what is going on is what
the clock has, in the order in which it happens, and robots that wait for others. A story of a robot (`Simulation`) is
entered anew with what was going on in it, and waits for the rest.
"""

from __future__ import annotations

from collections.abc import Generator
from typing import Any, NamedTuple

from rmfs_core.errors import InputError

AT_STATION = ("picker", "pick", "stow")
LEGS = ("leg", "wait")


class Going(NamedTuple):
    """Something that ends at a tick; 0: when something else happens. Ids and ticks; ``kind`` says what has a meaning.

    ``leg``: a robot drives ``legs`` (cell and wait of each), on the first since ``since``. ``wait``: it stands before
    the first of them. ``drive``: it goes on when it has a path, or is woken. ``room``: it waits beneath a pod for room at
    the station. ``line``: it stands in a line. ``lift``, ``set``: it lifts a pod, or sets it down, since ``since``.
    ``picker``, ``pick``, ``stow``: at a station, in a ``visit`` with so many ``picks`` so far, it waits for the picker,
    or an item of ``sku`` is picked, or a bundle stored. ``charge``: it is charged. ``release``: the item in hand at a
    station is handled. ``bundle``: items are ordered. ``alarm``: rules wake up. ``arrivals``, ``bundles``, ``hours``: the
    next of these happens.
    """

    kind: str
    robot: int | None = None
    station: int | None = None
    sku: int | None = None
    items: int = 0
    visit: int = 0
    picks: int = 0
    since: int = 0
    legs: tuple[tuple[int, int], ...] = ()
    overtaken: int = 0
    tick: int = 0


def going_on(run: Any) -> list[Going]:
    """Return what is going on in a `Simulation` between two ticks: what ends at a tick, in that order; then the rest."""
    found: list[Going] = []
    for tick, event in run.env.upcoming:
        if event.callbacks and (going := run.driving.told(event)) is not None:
            if not isinstance(going, Going):
                raise InputError("run.until_s", f"at {tick} ticks something ends that no state can tell of")
            found.append(going._replace(tick=tick))
    found += [Going("room", robot.id) for waiting in run.waiting_for_slot for _, robot in waiting]
    found += [Going("line", robot.id) for line in run.driving.standing for robot in line]
    busy = {going.robot for going in found}
    robots = run.warehouse.robots
    found += [Going("drive", r.id) for r in robots if r.id not in busy and (r.task is not None or r.goal is not None)]
    return [run.driving.with_place(going) if going.robot is not None else going for going in found]


def resume(run: Any, begun: Any) -> None:
    """Let all go on that was going on, in that order; what a state does not tell of begins now."""
    warehouse, left = run.warehouse, run.clocks
    run.visits, run.stories, run.context.asker.period = begun.visits, dict(begun.stories), begun.periods
    begun.recall(run)
    run.completed = sum(order.complete and (run.packing is None or order.cancelled) for order in warehouse.orders)
    if run.supply is not None:
        run.supply.knows(warehouse, [(one.sku, one.items) for one in begun.going if one.kind == "bundle"])
    run.driving.take_in(begun.going)
    for going in begun.going:
        if going.kind in left:
            left.remove(going.kind)
            run.begin(going.kind)
        elif going.kind == "release":
            run.release_later(warehouse.request_in_hand(warehouse.stations[going.station]), going)
        elif going.kind == "bundle":
            run.bundle_comes(going)
        elif going.kind == "alarm":
            run.decisions.ring_at(going.tick, wanted=going.tick == begun.wakes)
        elif going.robot is not None:
            robot = warehouse.robots[going.robot]
            run.driving.go_on(robot.id)
            if robot.id in run.stories:
                run.env.process(_story(run, robot, going))
    run.driving.begin()
    for kind in left:
        run.begin(kind)


def _story(run: Any, robot: Any, going: Going) -> Generator[Any, Any, None]:
    """Go on with what a robot does."""
    story, *what = run.stories[robot.id]
    serving = going.kind in AT_STATION
    yield from run.driving.finish(robot, going)
    timed = going if serving or going.kind in ("lift", "set", "charge") else None
    if story == "transport" and what[0].location is None:
        yield from run.visit_stations(robot, what[0], timed if serving else None)
    else:
        yield from getattr(run, story)(robot, *what, timed)
