"""The charge of the robots' batteries, as it is shown."""

from __future__ import annotations

from pathlib import Path

import pytest
from attrs import define, field

import rmfs_core
from rmfs_commands.replay.charges import WHOLE, Line
from rmfs_commands.replay.reading import Replay, read_replay
from rmfs_commands.replay.telling import told
from rmfs_core import hookimpl
from rmfs_core.events import Event
from rmfs_core.info import RunInfo
from rmfs_core.scenario import load_scenario


@define
class Seen:
    """Observer that notes what rules see of the charge of each robot, after the events of each time."""

    run: RunInfo | None = None
    charges: dict[int, list[float | None]] = field(factory=dict)

    @hookimpl
    def run_started(self, run: RunInfo) -> None:
        """Keep the view."""
        self.run = run

    @hookimpl
    def on_event(self, event: Event) -> None:
        """Note the charges."""
        assert self.run is not None
        self.charges[event.tick] = [robot.charge for robot in self.run.warehouse.robots]  # the last of a time counts


@pytest.fixture(scope="module")
def seen(charged: Path, batteries: tuple[str, ...]) -> tuple[Replay, Seen]:
    """Return the run in which robots charge, and what was seen of their charges."""
    rmfs_core.run(load_scenario("examples/small", batteries), observers=[(seen := Seen())])
    return read_replay(charged), seen


def test_charges_are_what_rules_see(seen: tuple[Replay, Seen]) -> None:
    """At each event, of each robot that does not drive or lift then; batteries run low, and are filled again."""
    replay, observed = seen
    lines = replay.columns.charges.lines(replay.tick)
    compared, lowest = 0, 1.0
    for tick, charges in observed.charges.items():
        for line, charge in zip(lines, charges, strict=True):
            assert charge is not None
            if tick in line.ticks:  # else it may be on its way, and what that takes is counted when it is there
                assert line.at(tick) == pytest.approx(charge, abs=1.5 / WHOLE)
                compared, lowest = compared + 1, min(lowest, charge)
    assert compared > 200
    assert lowest < 0.8
    assert any(b - a > 0.1 * WHOLE for line in lines for a, b in zip(line.charges, line.charges[1:], strict=False))


def test_the_page_is_told_them(seen: tuple[Replay, Seen]) -> None:
    """Robot by robot; a run without batteries has none."""
    replay, _ = seen
    found = told(replay)["charges"]
    lines = replay.columns.charges.lines(replay.tick)
    assert found["n"] == [len(line.ticks) for line in lines]
    assert sum(found["tick"][: found["n"][0]]) == replay.tick
    assert len(found["charge"]) == sum(found["n"])


def test_without_batteries_there_is_nothing(replay: Replay) -> None:
    """Nothing is counted."""
    assert replay.columns.charges.lines(replay.tick) == []
    assert told(replay)["charges"] == {"n": [], "tick": [], "charge": []}


def test_a_line_is_straight_between_points() -> None:
    """And goes on as it ended."""
    line = Line()
    line.ticks.extend([100, 200])
    line.charges.extend([5000, 6000])
    assert [line.at(tick) for tick in (0, 50, 100, 150, 300)] == [1, 0.75, 0.5, 0.55, 0.6]
