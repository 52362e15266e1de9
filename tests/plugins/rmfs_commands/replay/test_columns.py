"""The columns of a trace: nothing is lost, and what names nothing is refused."""

from __future__ import annotations

from collections import Counter
from itertools import accumulate
from pathlib import Path
from typing import Any

import attrs
import pytest

from rmfs_commands.replay.columns import KINDS, Columns, ColumnsBuilder, whole_run
from rmfs_commands.replay.reading import Replay, read_replay
from rmfs_commands.trace import read_trace
from rmfs_core import InputError
from rmfs_core.clock import to_seconds
from rmfs_core.events import Event, PodLifted, RobotMoved
from rmfs_core.motion import Motion
from rmfs_core.roles import Role

TIMES = {"start_tick": -1, "picker_free_tick": 1}


def field_of(columns: Columns, name: str, field: str, i: int, tick: int) -> Any:
    """Return what a column says of an event at a tick."""
    own, texts = columns.events[name], list(columns.texts)
    if field in ("tick", "wall_s"):
        return tick if field == "tick" else 0.0
    if field == "skus":
        begin = sum(own["skus_n"][:i])
        return tuple(own["skus"][begin : begin + own["skus_n"][i]])
    value = own[field][i]
    if field in TIMES:
        return tick + TIMES[field] * value
    if field in ("decides", "rule", "status"):
        return Role.labelled(texts[value]) if field == "decides" else texts[value]
    if field in ("complete", "stopped_early"):
        return bool(value)
    return None if field == "next_station" and value < 0 else value


def events_of(columns: Columns) -> list[Event]:
    """Return the events of columns, but for those of robots that moved."""
    kinds = list(KINDS.items())
    ticks = {name: list(accumulate(columns.events[name]["tick"])) for _, name in kinds}
    taken = Counter[str]()
    found = []
    for code in columns.order:
        kind, name = kinds[code]
        i = taken[name]
        taken[name] += 1
        told = [field_of(columns, name, field.name, i, ticks[name][i]) for field in attrs.fields(kind)]
        found.append(kind(*told))
    return found


def test_no_event_is_lost(day: Path, replay: Replay) -> None:
    """The columns hold every event in its place, with every field."""
    told = read_trace(day / "trace.jsonl.gz").events
    assert events_of(replay.columns) == [event for event in told if not isinstance(event, RobotMoved)]


def test_no_leg_is_lost(day: Path, replay: Replay) -> None:
    """The legs of each robot are those of the trace, times and cells included."""
    trace = read_trace(day / "trace.jsonl.gz")
    steps = (1, -trace.layout.width, -1, trace.layout.width)
    for robot, legs in enumerate(replay.columns.legs):
        tick, cell, found = 0, legs.cell, []
        for gap, wait, turn, run, towards, metres, jump in zip(
            legs.gap, legs.wait, legs.turn, legs.run, legs.towards, legs.metres, legs.jump, strict=True
        ):
            start, origin = tick + gap, cell + jump
            tick, cell = start + wait + turn + run, origin + steps[towards] * metres
            found.append((tick, start, origin, cell, towards, wait, turn, metres))
        assert found == [
            (e.tick, e.start_tick, e.origin, e.to, e.heading, e.wait_ticks, e.turn_ticks, e.distance_m)
            for e in trace.events
            if isinstance(e, RobotMoved) and e.robot == robot
        ]


@pytest.mark.parametrize("metres", [1, 2, 5, 20])
def test_a_leg_that_was_cut_off_was_on_its_way_farther(metres: int) -> None:
    """It has passed its last cell by its end, and not the next; a whole leg goes no farther than it says."""
    motion = Motion()
    assert whole_run(motion, metres, motion.run_ticks(metres)) == metres
    passed_at_speed = next(t for t in range(60_000) if motion.position_m(metres + 4, to_seconds(t)) >= metres)
    whole = whole_run(motion, metres, passed_at_speed + 10)
    assert whole > metres
    assert metres <= motion.position_m(whole, to_seconds(passed_at_speed + 10)) < metres + 1


def test_a_run_that_ends_on_the_way_has_such_legs(short: Path) -> None:
    """Their robots drive on as if there was no end."""
    found = read_replay(short)
    assert any(legs.whole[-1] > legs.metres[-1] for legs in found.columns.legs if legs.whole)
    assert all(list(legs.whole[:-1]) == list(legs.metres[:-1]) for legs in found.columns.legs)


@pytest.mark.parametrize(
    ("event", "named"),
    [
        (PodLifted(5, 0, robot=99, pod=0, cell=0), "PodLifted names robot 99"),
        (PodLifted(5, 0, robot=0, pod=-1, cell=0), "PodLifted names pod -1"),
        (RobotMoved(5, 0, 0, 10**6, 3, 0, 0, 0, 1, None), "RobotMoved names origin 1000000"),
    ],
)
def test_what_is_not_there_is_refused(replay: Replay, event: Event, named: str) -> None:
    """An event that names what the header does not have would show something else."""
    with pytest.raises(InputError, match=named):
        ColumnsBuilder(replay.start).add(event)
