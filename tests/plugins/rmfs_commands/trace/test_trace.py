import gzip
import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from attrs import evolve

from calling import refusal
from cases import cases
from rmfs_commands.trace import TraceStream, TraceWriter, read_trace
from rmfs_commands.trace.json_lines import JsonLinesFile, beside_results, read_json_lines
from rmfs_core import InputError
from rmfs_core.events import DecisionMade, OrderArrived, OrderAssigned, RobotMoved
from rmfs_core.info import RunInfo
from rmfs_core.roles import Role

EVENTS = (
    OrderArrived(0, 0),
    OrderAssigned(0, 0, 1, skus=(0, 1), items=2, period=1, complete=True),
    RobotMoved(5000, 1000, 0, origin=3, to=4, heading=2, wait_ticks=0, turn_ticks=625, distance_m=1, pod=None),
    DecisionMade(5000, 1, Role.POA, "rule", 2, 1, 0, "optimal", 1.5, None, False, wall_s=0.25),
)


READ = (*EVENTS[:-1], evolve(EVENTS[-1], wall_s=0.0))
"""The result as read back: times of the wall clock are not written."""


def write(folder: Path, run: RunInfo) -> Path:
    writer = TraceWriter()
    writer.run_started(evolve(run, out=folder))
    for event in EVENTS:
        writer.on_event(event)
    writer.run_ended(6000, "partial")
    return folder / writer.file


@pytest.fixture
def trace_file(tmp_path: Path, tiny: RunInfo) -> Path:
    return write(tmp_path, tiny)


def test_what_is_written_is_read_back(trace_file: Path, tiny: RunInfo) -> None:
    trace = read_trace(trace_file)
    assert (trace.events, trace.instance, trace.motion) == (READ, tiny.instance, tiny.motion)
    assert (trace.layout.kind == tiny.layout.kind).all()
    assert (trace.layout.moves == tiny.layout.moves).all()
    assert trace.layout.stations == tiny.layout.stations
    assert [pod["cell"] for pod in trace.pods] == [pod.cell for pod in tiny.warehouse.pods]
    assert [robot["cell"] for robot in trace.robots] == [robot.cell for robot in tiny.warehouse.robots]
    assert (trace.tick, trace.status) == (6000, "partial")
    assert trace.scenario["seed"] == 7


def rewrite(path: Path, change: Callable[[list[str]], list[str]]) -> None:
    lines = gzip.decompress(path.read_bytes()).decode().splitlines()
    path.write_bytes(gzip.compress("".join(f"{line}\n" for line in change(lines)).encode()))


def test_a_stream_reads_as_far_as_it_is_asked(trace_file: Path) -> None:
    rewrite(trace_file, lambda lines: [*lines[:3], "{}", *lines[4:]])
    stream = TraceStream(trace_file)
    assert len(stream.start.instance.orders) == 2
    events = iter(stream)
    assert [next(events), next(events)] == list(READ[:2])
    with pytest.raises(InputError, match=r"line 4: found the event None; expected one of "):
        next(events)


@cases(
    "change line problem",
    (lambda lines: ['{"format":"other"}', *lines[1:]], 1, "no trace"),
    (lambda lines: [lines[0].replace('"version":1', '"version":99'), *lines[1:]], 1, "version 99"),
    (lambda lines: [lines[0].replace('"robots"', '"robot"'), *lines[1:]], 1, "lacks 'robots'"),
    (lambda lines: [re.sub(r'"heading":\d', '"heading":true', lines[0]), *lines[1:]], 1, "true in `heading`; expected"),
    (lambda lines: [lines[0].replace('"width":', '"width":1'), *lines[1:]], 1, "cells each"),
    (lambda lines: [lines[0].replace('"width":', '"width":9999'), *lines[1:]], 1, "in a row or column"),
    (lambda lines: ['{"floor":{},' + lines[0][1:], *lines[1:]], 1, "lacks 'corrected_s'"),
    (lambda lines: ['{"floor":{"corrected_s":-1},' + lines[0][1:], *lines[1:]], 1, "found -1 in `corrected_s`"),
    (lambda lines: ['{"floor":{"corrected_s":1,"waiting":1},' + lines[0][1:], *lines[1:]], 1, "found 1 in `waiting`"),
    (lambda lines: ['{"state":{"tick":0,"content":{}},' + lines[0][1:], *lines[1:]], 1, "`instance.state_file`"),
    (lambda lines: [*lines[:2], "{", *lines[2:]], 3, "no valid JSON"),
    (lambda lines: [*lines[:2], "[]", *lines[2:]], 3, "expected a JSON object"),
    (lambda lines: [*lines[:2], '{"e":"flew"}', *lines[2:]], 3, "'flew'"),
    (lambda lines: [lines[0], '{"e":"order_arrived","tick":0}', *lines[1:]], 2, "tick, order"),
    (lambda lines: [line.replace('"POA"', '"lunch"') for line in lines], 5, "'lunch'"),
    (lambda lines: lines[:-1], 5, "cut off"),
    (lambda lines: [*lines, lines[-1]], 7, "after the event"),
    (lambda lines: [*lines[:-1], '{"e":"end","tick":1,"status":"fine"}'], 6, "status"),
    (lambda lines: [], 1, "no trace"),
)
def test_a_broken_trace_is_an_input_error(trace_file, change, line, problem) -> None:
    rewrite(trace_file, change)
    said = refusal(lambda: read_trace(trace_file))
    assert problem in said
    assert said.startswith(f"{trace_file}, line {line}: " if line > 1 else str(trace_file))


ENDS = f"expected a tick from 0 to {10**15:,} and a status of complete, horizon, partial, failed"


@cases(
    "event changes problem",
    ("order_arrived", {"tick": True}, "tick of order_arrived is True; expected int"),
    ("order_arrived", {"order": None}, "order of order_arrived is None; expected int"),
    ("order_arrived", {"tick": 10**15 + 1}, f"tick of order_arrived is {10**15 + 1}; expected int up to {10**15:,}"),
    ("order_assigned", {"skus": [0, "a"]}, "skus of order_assigned is [0, 'a']; expected tuple[int, ...]"),
    ("order_assigned", {"complete": 1}, "complete of order_assigned is 1; expected bool"),
    ("robot_moved", {"pod": "north"}, "pod of robot_moved is 'north'; expected int | None"),
    ("decision_made", {"decides": ["POA"]}, "decides of decision_made is ['POA']; expected Role"),
    ("end", {"tick": 2**63}, f"found the end {{'e': 'end', 'tick': {2**63}, 'status': 'partial'}}; {ENDS}"),
)
def test_a_field_of_another_type_is_named(
    trace_file: Path, event: str, changes: dict[str, object], problem: str
) -> None:
    def change(lines: list[str]) -> list[str]:
        told = [json.loads(line) for line in lines]
        return [json.dumps(one | changes if one.get("e") == event else one) for one in told]

    rewrite(trace_file, change)
    line = ["order_arrived", "order_assigned", "robot_moved", "decision_made", "end"].index(event) + 2
    assert refusal(lambda: read_trace(trace_file)) == f"{trace_file}, line {line}: {problem}"


def test_lines_are_read_as_written(tmp_path: Path) -> None:
    for name in ("a.gz", "b.gz"):
        file = JsonLinesFile(tmp_path / name)
        file.write({"x": 1})
        file.write({"y": "ä"})
        file.commit()
        file.discard()
    JsonLinesFile(tmp_path / "c.gz").discard()
    assert [line for _, line in read_json_lines(tmp_path / "a.gz")] == [{"x": 1}, {"y": "ä"}]
    assert (tmp_path / "a.gz").read_bytes() == (tmp_path / "b.gz").read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.gz", "b.gz"]


@cases(
    "content problem",
    (b"this is text", "no gzip file"),
    (gzip.compress(json.dumps({"a": "b" * 5000}).encode(), mtime=0)[:-12], "cut off"),
    (None, "cannot be read"),
)
def test_a_file_that_is_no_such_file(tmp_path: Path, content: bytes | None, problem: str) -> None:
    path = tmp_path / "lines.gz"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError, match=problem):
        list(read_json_lines(path))


def test_what_nobody_commits_is_gone(tmp_path: Path) -> None:
    file = JsonLinesFile(tmp_path / "lines.gz")
    file.write({"x": 1})
    assert not (tmp_path / "lines.gz").exists()
    del file
    assert list(tmp_path.iterdir()) == []


def test_recorders_write_beside_the_results(tiny: RunInfo, tmp_path: Path) -> None:
    assert beside_results(evolve(tiny, out=tmp_path), "lines.gz") == tmp_path / "lines.gz"
    told = "lines.gz: is written next to the results; expected a run with a folder for"
    assert refusal(lambda: beside_results(tiny, "lines.gz")).startswith(told)


@pytest.mark.parametrize(("limit", "line"), [("MOST_OF_A_LINE", 2), ("MOST_OF_A_FILE", 3)])
def test_a_file_that_is_larger_than_memory_is_refused(tmp_path, monkeypatch, limit, line) -> None:
    with gzip.open(tmp_path / "large.gz", "wt") as stream:
        stream.write("{}\n" + '{"a": "' + "x" * 90 + '"}\n{"b": 1}\n')
    monkeypatch.setattr(f"rmfs_commands.trace.json_lines.{limit}", {"MOST_OF_A_LINE": 50, "MOST_OF_A_FILE": 105}[limit])
    with pytest.raises(InputError, match=f"large.gz, line {line}: the file is too large to be read; expected at most"):
        list(read_json_lines(tmp_path / "large.gz"))
