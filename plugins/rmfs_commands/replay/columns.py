"""A trace as columns of small whole numbers: what the page of a replay is made from.

The events of a kind are columns of equal length, one for each field. Times are differences: ``tick`` to the event of
that kind before, ``start_tick`` to its own ``tick``, ``picker_free_tick`` likewise. None is -1, a text its index in
``texts``. ``order`` has the kind of each event in the order in which they happened. The legs of robots stand apart,
robot by robot, and tell no cell: each begins where the last one ended, unless ``jump`` says otherwise.
"""

from __future__ import annotations

from array import array
from collections.abc import Mapping, Sequence
from typing import Any

import attrs
from attrs import define, field, frozen

from rmfs_commands.instances.tables import finite
from rmfs_commands.replay.charges import Charges
from rmfs_commands.trace import KnownIds, Trace
from rmfs_commands.trace.writer import EVENTS, NOT_TRACED
from rmfs_core.clock import to_seconds
from rmfs_core.errors import InputError
from rmfs_core.events import Event, RobotMoved
from rmfs_core.motion import Motion
from rmfs_core.roles import Role

KINDS = {kind: name for name, kind in EVENTS.items() if kind is not RobotMoved}
FLOATS = frozenset({"objective", "bound"})
EARLIER, LATER = "start_tick", "picker_free_tick"
"""Times told as differences to the event's own: before it, and after it."""


def _numbers() -> array[int]:
    return array("q")


@define
class Legs:
    """The legs of one robot, in the order of time.

    Parameters
    ----------
    cell, heading
        Where it stands at the start.
    gap, wait, turn, run
        Ticks between the leg before and this one, of standing, of turning, and of driving.
    towards, metres
        Heading while driving, and how far.
    whole
        How far it was to drive: farther than it did when the end of the run cut the leg off.
    jump
        Origin less the cell where the leg before ended; 0 in a sound trace.
    """

    cell: int
    heading: int
    gap: array[int] = field(factory=_numbers)
    wait: array[int] = field(factory=_numbers)
    turn: array[int] = field(factory=_numbers)
    run: array[int] = field(factory=_numbers)
    towards: array[int] = field(factory=_numbers)
    metres: array[int] = field(factory=_numbers)
    whole: array[int] = field(factory=_numbers)
    jump: array[int] = field(factory=_numbers)
    _rests: int = field(init=False)
    _free: int = field(init=False, default=0)

    def __attrs_post_init__(self) -> None:
        self._rests = self.cell

    def add(self, event: RobotMoved, motion: Motion) -> None:
        """Append a leg."""
        run = event.tick - event.start_tick - event.wait_ticks - event.turn_ticks
        self.gap.append(event.start_tick - self._free)
        self.wait.append(event.wait_ticks)
        self.turn.append(event.turn_ticks)
        self.run.append(run)
        self.towards.append(event.heading)
        self.metres.append(event.distance_m)
        self.whole.append(whole_run(motion, event.distance_m, run))
        self.jump.append(event.origin - self._rests)
        self._rests, self._free = event.to, event.tick


COLUMNS_OF_LEGS = tuple(one.name for one in attrs.fields(Legs) if str(one.type) == "array[int]")


def whole_run(motion: Motion, metres: int, ticks: int) -> int:
    """Return how far a run was to go that took ``ticks`` for its first ``metres``.

    A run that the end has cut off was on its way to a cell farther on: the nearest with which it has passed the last
    cell that is told by then.
    """
    if metres <= 0 or ticks == motion.run_ticks(metres):
        return metres
    return next(
        (whole for whole in range(metres + 1, metres + 100) if motion.position_m(whole, to_seconds(ticks)) >= metres),
        metres,
    )


@frozen(eq=False)
class Columns:
    """Events of a run as columns.

    Parameters
    ----------
    legs
        Of each robot.
    events
        For each kind its columns by field, and how many there are.
    order
        Kind of each event.
    texts
        Meaning of the texts in columns.
    charges
        Of the robots' batteries.
    """

    legs: Sequence[Legs]
    events: Mapping[str, Mapping[str, Any]]
    order: array[int]
    texts: Mapping[str, int]
    charges: Charges

    def bundles(self) -> Sequence[str]:
        """Return the names of the bundles by their ids."""
        texts = list(self.texts)
        return [texts[text] for text in self.events["bundle_arrived"]["name"]]


class ColumnsBuilder:
    """Takes events one at a time.

    Parameters
    ----------
    start
        The trace they belong to; its own events are not read.
    """

    def __init__(self, start: Trace) -> None:
        self._start = start
        self._legs = [Legs(robot["cell"], robot["heading"]) for robot in start.robots]
        self._texts: dict[str, int] = {}
        self._order = array("b")
        self._last: dict[str, int] = {}
        self._bundles: dict[int, int] = {}  # by the ids of events, in the order of their arrival
        self._codes = {kind: code for code, kind in enumerate(KINDS)}
        self._ids = KnownIds(start)
        self._charges = Charges(start)
        self._columns: dict[str, dict[str, Any]] = {}
        for kind, name in KINDS.items():
            fields = [one.name for one in attrs.fields(kind) if one.name not in NOT_TRACED]
            self._columns[name] = {one: [] if one in FLOATS else array("q") for one in fields}
            if "skus" in fields:
                self._columns[name]["skus_n"] = array("q")

    def add(self, event: Event) -> None:
        """Append an event.

        Raises
        ------
        InputError
            When it names what the header does not have.
        """
        if (unknown := self._ids.unknown(event)) is not None:
            raise InputError("the trace", f"{type(event).__name__} names {unknown}, which does not exist")
        self._charges.add(event)
        if isinstance(event, RobotMoved):
            self._legs[event.robot].add(event, self._start.motion)
            return
        kind = type(event)
        self._order.append(self._codes[kind])
        name = KINDS[kind]
        for column, values in self._columns[name].items():
            if column == "bundle":  # of a run that begins in a state, others may have been stored before
                values.append(self._bundles.setdefault(getattr(event, column), len(self._bundles)))
            elif column != "skus_n":
                self._put(name, column, values, getattr(event, column), event.tick)
        self._last[name] = event.tick

    def _put(self, name: str, column: str, values: Any, value: Any, tick: int) -> None:
        if column in FLOATS:
            values.append(finite(value))
        elif column == "tick":
            values.append(tick - self._last.get(name, 0))
        elif column == EARLIER:
            values.append(tick - value)
        elif column == LATER:
            values.append(value - tick)
        elif isinstance(value, tuple):
            values.extend(value)
            self._columns[name]["skus_n"].append(len(value))
        elif isinstance(value, str):
            text = value.label if isinstance(value, Role) else value
            values.append(self._texts.setdefault(text, len(self._texts)))
        else:
            values.append(-1 if value is None else int(value))

    def columns(self) -> Columns:
        """Return what was added."""
        return Columns(self._legs, self._columns, self._order, self._texts, self._charges)
