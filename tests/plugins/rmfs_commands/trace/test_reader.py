"""Reading a trace back: what is accepted, and what is wrong with it, by file and line."""

from __future__ import annotations

import gzip
import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from attrs import evolve

from rmfs_commands.trace import TraceStream, TraceWriter, read_trace
from rmfs_core import InputError
from rmfs_core.events import DecisionMade, OrderArrived, OrderAssigned, RobotMoved
from rmfs_core.info import RunInfo
from rmfs_core.roles import Role

EVENTS = (
    OrderArrived(0, 0),
    OrderAssigned(0, 0, 1, skus=(0, 1), items=2, period=1, complete=True),
    RobotMoved(5000, 1000, 0, origin=3, to=4, heading=2, wait_ticks=0, turn_ticks=625, distance_m=1, pod=None),
    DecisionMade(5000, 1, Role.POA, "rule", 2, 1, 0, "optimal", 1.5, None, False, wall_s=0.0),
)


@pytest.fixture
def trace_file(tmp_path: Path, tiny: RunInfo) -> Path:
    """Return a trace of four events: a header, lines 2 to 5, and the end."""
    writer = TraceWriter()
    writer.run_started(evolve(tiny, out=tmp_path))
    for event in EVENTS:
        writer.on_event(event)
    writer.run_ended(6000, "partial")
    return tmp_path / writer.file


def rewrite(path: Path, change: Callable[[list[str]], list[str]]) -> None:
    """Change the lines of a trace."""
    lines = gzip.decompress(path.read_bytes()).decode().splitlines()
    path.write_bytes(gzip.compress("".join(f"{line}\n" for line in change(lines)).encode()))


def test_every_event_comes_back(trace_file: Path) -> None:
    """In its order and with the types of its fields: lists are tuples again, what is None is None."""
    trace = read_trace(trace_file)
    assert trace.events == EVENTS
    assert (trace.tick, trace.status) == (6000, "partial")


def test_a_stream_reads_as_far_as_it_is_asked(trace_file: Path) -> None:
    """The header at once, then an event at a time: what is wrong further down is found when it is come to."""
    rewrite(trace_file, lambda lines: [*lines[:3], "{}", *lines[4:]])
    stream = TraceStream(trace_file)
    assert len(stream.start.instance.orders) == 2
    events = iter(stream)
    assert [next(events), next(events)] == list(EVENTS[:2])
    with pytest.raises(InputError, match=r"line 4: found the event None; expected one of "):
        next(events)


def test_a_stream_knows_the_end_when_it_is_read(trace_file: Path) -> None:
    """When, and how; the events are those of the whole trace."""
    stream = TraceStream(trace_file)
    assert (tuple(stream), stream.tick, stream.status) == (EVENTS, 6000, "partial")


def test_cells_are_read_by_their_digits(trace_file: Path) -> None:
    """A digit of ``kind`` says what a cell is, a hexadecimal one of ``moves`` where it may be left to."""

    def change(lines: list[str]) -> list[str]:
        header = json.loads(lines[0])
        width = header["layout"]["width"]
        header["layout"]["kind"][0] = "2" * width
        header["layout"]["moves"][0] = "f" * width
        return [json.dumps(header), *lines[1:]]

    before = read_trace(trace_file).layout
    rewrite(trace_file, change)
    after = read_trace(trace_file).layout
    assert set(after.kind[: after.width]) == {2}
    assert set(after.moves[: after.width]) == {15}
    assert np.array_equal(after.kind[after.width :], before.kind[before.width :])


@pytest.mark.parametrize(
    ("change", "line", "problem"),
    [
        (lambda lines: ['{"format":"other"}', *lines[1:]], 1, "no trace"),
        (lambda lines: [lines[0].replace('"version":1', '"version":99'), *lines[1:]], 1, "version 99"),
        (lambda lines: [lines[0].replace('"robots"', '"robot"'), *lines[1:]], 1, "lacks 'robots'"),
        (
            lambda lines: [re.sub(r'"heading":\d', '"heading":true', lines[0]), *lines[1:]],
            1,
            "found true in `heading`; expected a number",
        ),
        (lambda lines: [lines[0].replace('"width":', '"width":1'), *lines[1:]], 1, "cells each"),
        (lambda lines: [lines[0].replace('"width":', '"width":9999'), *lines[1:]], 1, "in a row or column"),
        (lambda lines: [*lines[:2], "{", *lines[2:]], 3, "no valid JSON"),
        (lambda lines: [*lines[:2], "[]", *lines[2:]], 3, "expected a JSON object"),
        (lambda lines: [*lines[:2], '{"e":"flew"}', *lines[2:]], 3, "'flew'"),
        (lambda lines: [lines[0], '{"e":"order_arrived","tick":0}', *lines[1:]], 2, "tick, order"),
        (lambda lines: [lines[0], '{"e":"order_arrived","tick":0,"order":"x"}', *lines[1:]], 2, "'x'"),
        (lambda lines: [line.replace('"POA"', '"lunch"') for line in lines], 5, "'lunch'"),
        (lambda lines: lines[:-1], 5, "cut off"),
        (lambda lines: [*lines, lines[-1]], 7, "behind the end"),
        (lambda lines: [*lines[:-1], '{"e":"end","tick":1,"status":"fine"}'], 6, "status"),
        (lambda lines: [], 1, "no trace"),
    ],
)
def test_a_broken_trace_is_an_input_error(
    trace_file: Path, change: Callable[[list[str]], list[str]], line: int, problem: str
) -> None:
    """The message names the file, the line and what is wrong there."""
    rewrite(trace_file, change)
    with pytest.raises(InputError) as caught:
        read_trace(trace_file)
    assert problem in caught.value.problem
    assert caught.value.place.startswith(str(trace_file))
    assert caught.value.place.endswith(f"line {line}") or line == 1


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ('{"e":"order_arrived","tick":true,"order":0}', "tick of order_arrived is True; expected int"),
        (
            '{"e":"decision_made","tick":0,"period":1,"decides":["POA"],"rule":"a","backlog":1,"assignments":1,"trips":0,'
            '"status":null,"objective":null,"bound":null,"stopped_early":false}',
            "decides of decision_made is ['POA']; expected Role",
        ),
        ('{"e":"order_arrived","tick":0,"order":null}', "order of order_arrived is None; expected int"),
        (
            '{"e":"order_arrived","tick":1000000000000001,"order":0}',
            "tick of order_arrived is 1000000000000001; expected int up to 1,000,000,000,000,000",
        ),
        (
            '{"e":"end","tick":9223372036854775808,"status":"complete"}',
            "found the end {'e': 'end', 'tick': 9223372036854775808, 'status': 'complete'}; expected a tick from 0 to "
            "1,000,000,000,000,000 and a status of complete, partial, failed",
        ),
        (
            '{"e":"visit_ended","tick":1,"visit":1,"pod":0,"station":0,"picks":1,"next_station":"north"}',
            "next_station of visit_ended is 'north'; expected int | None",
        ),
        (
            '{"e":"order_assigned","tick":0,"order":0,"station":0,"skus":[0,"a"],"items":1,"period":1,"complete":true}',
            "skus of order_assigned is [0, 'a']; expected tuple[int, ...]",
        ),
        (
            '{"e":"order_assigned","tick":0,"order":0,"station":0,"skus":[0],"items":1,"period":1,"complete":1}',
            "complete of order_assigned is 1; expected bool",
        ),
    ],
)
def test_a_field_of_another_type_is_named(trace_file: Path, line: str, problem: str) -> None:
    """With the event, what was found there and what would be right; a truth value is no number."""
    rewrite(trace_file, lambda lines: [lines[0], line, *lines[1:]])
    with pytest.raises(InputError) as caught:
        read_trace(trace_file)
    assert str(caught.value) == f"{trace_file}, line 2: {problem}"
