"""The trace as it is written: equal runs have equal bytes, and metrics can be recomputed from it."""

from pathlib import Path

import pytest
from attrs import evolve

import rmfs_core
from rmfs_commands.details.metrics import Metrics
from rmfs_commands.trace import TraceWriter, read_trace
from rmfs_core.events import DecisionMade, Event, OrderArrived, OrderAssigned, RobotMoved
from rmfs_core.hookspecs import hookimpl
from rmfs_core.info import RunInfo
from rmfs_core.roles import Role

SCENARIO = """
[instance]
orders = 12
skus = 10
pods = 8
skus_per_pod = 3
[layout]
block_rows = 5
block_columns = 2
stations_east = 2
[robots]
count = 3
[stations]
item_capacity = 6
[rules]
poa = "pod-match"
pps = "demand"
"""

EVENTS = (
    OrderArrived(0, 0),
    OrderAssigned(0, 0, 1, skus=(0, 1), items=2, period=1, complete=True),
    RobotMoved(5000, 1000, 0, origin=3, to=4, heading=2, wait_ticks=0, turn_ticks=625, distance_m=1, pod=None),
    DecisionMade(5000, 1, Role.POA, "rule", 2, 1, 0, "optimal", 1.5, None, False, wall_s=0.25),
)


class Recorder:
    """Observer that keeps the events."""

    def __init__(self) -> None:
        self.events: list[Event] = []

    @hookimpl
    def on_event(self, event: Event) -> None:
        """Keep it."""
        self.events.append(event)


def write(folder: Path, run: RunInfo) -> Path:
    """Write a trace of hand-made events into a folder; return its file."""
    writer = TraceWriter()
    writer.run_started(evolve(run, out=folder))
    for event in EVENTS:
        writer.on_event(event)
    writer.run_ended(6000, "partial")
    return folder / writer.file


@pytest.fixture
def trace_file(tmp_path: Path, tiny: RunInfo) -> Path:
    """Return a trace of hand-made events."""
    return write(tmp_path, tiny)


def test_what_is_written_is_read_back(trace_file: Path, tiny: RunInfo) -> None:
    """Events, instance, layout and motion come back as they were; only a decision's wall-clock time is left out."""
    trace = read_trace(trace_file)
    assert trace.events[:-1] == EVENTS[:-1]
    assert isinstance(trace.events[-1], DecisionMade)
    assert (trace.events[-1].objective, trace.events[-1].bound, trace.events[-1].wall_s) == (1.5, None, 0.0)
    assert trace.instance == tiny.instance
    assert trace.motion == tiny.motion
    assert (trace.layout.kind == tiny.layout.kind).all()
    assert (trace.layout.moves == tiny.layout.moves).all()
    assert trace.layout.stations == tiny.layout.stations
    assert [pod["cell"] for pod in trace.pods] == [pod.cell for pod in tiny.warehouse.pods]
    assert [robot["cell"] for robot in trace.robots] == [robot.cell for robot in tiny.warehouse.robots]
    assert (trace.tick, trace.status) == (6000, "partial")
    assert trace.scenario["seed"] == 7


def test_equal_runs_have_equal_bytes(tmp_path: Path, tiny: RunInfo) -> None:
    """Neither the time of writing nor the file's name is in the file."""
    (tmp_path / "one").mkdir()
    (tmp_path / "two").mkdir()
    assert write(tmp_path / "one", tiny).read_bytes() == write(tmp_path / "two", tiny).read_bytes()


def test_there_is_no_file_until_the_run_has_ended(tmp_path: Path, tiny: RunInfo) -> None:
    """A trace that is being written has no name yet, and one whose run never ends leaves nothing."""
    writer = TraceWriter()
    writer.run_started(evolve(tiny, out=tmp_path))
    assert not (tmp_path / "trace.jsonl.gz").exists()
    del writer
    assert list(tmp_path.iterdir()) == []


def test_metrics_of_a_run_can_be_recomputed_from_its_trace(tmp_path: Path) -> None:
    """A trace read back has every event of the run, and metrics that observe it get the same numbers."""
    file = tmp_path / "small.toml"
    file.write_text(SCENARIO, encoding="utf-8")
    recorder = Recorder()
    result = rmfs_core.run(file, out=tmp_path / "out", record=["trace"], observers=[recorder])
    trace = read_trace(tmp_path / "out" / "trace.jsonl.gz")
    metrics = Metrics()
    metrics.begin(trace.instance, len(trace.stations))
    for event in trace.events:
        metrics.on_event(event)
    metrics.run_ended(trace.tick, trace.status)
    assert result.status == "complete"
    assert metrics.measured().items() <= result.metrics.items()
    assert len(trace.events) == len(recorder.events)
