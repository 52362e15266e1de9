"""Where robots are: what the validator says."""

from __future__ import annotations

from pathlib import Path

import pytest

from rmfs_commands.replay.positions import ways
from rmfs_commands.replay.reading import Replay, read_replay
from rmfs_commands.trace import read_trace
from rmfs_commands.validation.collisions import reached_s
from rmfs_core.clock import TICKS_PER_S
from rmfs_core.events import RobotMoved


def test_every_cell_is_reached_when_the_validator_says(day: Path, replay: Replay) -> None:
    """At each cell of each leg, and at rest before and after."""
    trace = read_trace(day / "trace.jsonl.gz")
    found = ways(replay)
    width = trace.layout.width
    legs = [event for event in trace.events if isinstance(event, RobotMoved) and event.distance_m]
    assert len(legs) > 100
    for event in legs:
        begin = event.start_tick + event.wait_ticks + event.turn_ticks
        across, down = ((1, 0), (0, -1), (-1, 0), (0, 1))[event.heading]
        for metres in range(event.distance_m + 1):
            tick = begin + reached_s(trace.motion, event.distance_m, metres) * TICKS_PER_S
            place = found[event.robot].at(round(tick))
            assert place.column == pytest.approx(event.origin % width + across * metres, abs=2e-3)
            assert place.row == pytest.approx(event.origin // width + down * metres, abs=2e-3)
        rests = found[event.robot].at(event.tick)
        assert (rests.column, rests.row) == (event.to % width, event.to // width)
        assert rests.heading == event.heading


def test_a_robot_turns_the_shorter_way(replay: Replay) -> None:
    """Half way through a turn it looks half way, and it stands meanwhile."""
    turned = 0
    for legs, way in zip(replay.columns.legs, ways(replay), strict=True):
        tick, heading = 0, legs.heading
        for i in range(len(legs.gap)):
            start = tick + legs.gap[i] + legs.wait[i]
            quarters = (legs.towards[i] - heading) % 4
            if quarters in (1, 3):
                place = way.at(start + legs.turn[i] // 2)
                half = 0.5 if quarters == 1 else -0.5
                assert place.heading == pytest.approx(heading + half, abs=0.01)
                assert place.moving
                turned += 1
            tick, heading = start + legs.turn[i] + legs.run[i], legs.towards[i]
    assert turned > 10


def test_before_the_first_leg_and_while_it_waits(replay: Replay) -> None:
    """It stands where the header says."""
    for legs, way, robot in zip(replay.columns.legs, ways(replay), replay.start.robots, strict=True):
        place = way.at(0)
        assert place.row * replay.start.layout.width + place.column == robot["cell"] == legs.cell
        assert not place.moving or legs.turn[0] or legs.run[0]


def test_at_the_end_a_robot_under_way_is_between_cells(short: Path) -> None:
    """Beyond the last cell that it has passed, and before the next."""
    found = read_replay(short)
    cut = [i for i, legs in enumerate(found.columns.legs) if legs.whole and legs.whole[-1] > legs.metres[-1]]
    assert cut
    for robot in cut:
        legs, way = found.columns.legs[robot], ways(found)[robot]
        end, last = way.at(found.tick), way.at(found.tick - legs.run[-1])
        driven = abs(end.column - last.column) + abs(end.row - last.row)
        assert legs.metres[-1] <= driven < legs.metres[-1] + 1
