"""Robots that hold a cell at once or drive through each other, in traces written by hand."""

from __future__ import annotations

from typing import Any

import pytest

from rmfs_commands.validation import faults_of
from rmfs_commands.validation.collisions import reached_s
from rmfs_core.motion import Motion

HALL = "........\n" * 5


def kinds(script: Any) -> list[str]:
    """Return the kinds of faults in a script's trace, in the order of time."""
    return [fault.kind for fault in faults_of(script.trace())]


def test_one_after_the_other_is_no_collision(new_script: Any) -> None:
    """A robot may enter a cell once the one before has reached the next cell but one."""
    script = new_script(HALL, robots=[(0, 1), (0, 0)])
    script.drive(0, 0, 7)
    script.rest(1, 2)
    script.drive(1, 0, 5)
    assert kinds(script) == []


def test_a_cell_is_held_until_the_next_one_is_reached(new_script: Any) -> None:
    """Who leaves a cell holds it until its next one is reached; to the tick, but for rounding."""
    reached = reached_s(Motion(), 3, 1)
    for gap_s, expected in ((reached, []), (reached - 0.01, ["collision"])):
        script = new_script(HALL, robots=[(0, 3), (0, 2)])
        script.drive(0, 0, 6)
        script.rest(1, gap_s)
        script.drive(1, 0, 3)
        assert kinds(script) == expected


def test_driving_into_a_resting_robot_is_a_collision(new_script: Any) -> None:
    """A robot at rest holds its cell, waits and turns included."""
    script = new_script(HALL, robots=[(0, 0), (0, 5)])
    script.drive(0, 0, 7)
    script.drive(1, 4, 5, wait_s=30)
    faults = faults_of(script.trace())
    assert [fault.kind for fault in faults] == ["collision"]
    assert "robot 1 and robot 2 both hold row 1, column 6" in faults[0].sentence


def test_driving_through_each_other_is_a_swap(new_script: Any) -> None:
    """Two robots that exchange their places are found, though they never rest in one cell."""
    script = new_script(HALL, robots=[(0, 0), (0, 7)])
    script.headings[1] = 0
    script.drive(0, 0, 7)
    script.drive(1, 0, 0)
    assert kinds(script) == ["swap"]


def test_crossing_ways_are_a_collision_only_at_the_same_time(new_script: Any) -> None:
    """Two robots whose ways cross meet when they are there at once, and not when one is later."""
    for delay_s, expected in ((0.0, ["collision"]), (10.0, [])):
        script = new_script(HALL, robots=[(2, 1), (0, 3)])
        script.drive(0, 2, 6)
        script.drive(1, 4, 3, wait_s=delay_s)
        assert kinds(script) == expected


@pytest.mark.parametrize("metres", [1, 2, 3, 7, 20])
def test_points_are_reached_when_the_formulas_say(metres: int) -> None:
    """The times at which the cells of a run are reached are the inverse of the position over time."""
    motion = Motion()
    for at in range(metres + 1):
        assert motion.position_m(metres, reached_s(motion, metres, at)) == pytest.approx(at)


def test_each_meeting_of_two_robots_is_told_once(new_script: Any) -> None:
    """Overlaps in several cells without a break are one fault; meeting again later is another."""
    script = new_script(HALL, robots=[(0, 0), (0, 0)])
    script.drive(0, 0, 7)
    script.drive(1, 0, 7)
    assert kinds(script) == ["collision"]
    script = new_script(HALL, robots=[(0, 0), (0, 4)])
    script.drive(0, 0, 7)
    script.drive(1, 4, 4, wait_s=10)
    script.drive(0, 0, 0, wait_s=20)
    script.drive(1, 0, 4, wait_s=60)
    script.drive(0, 0, 7, wait_s=90)
    assert kinds(script) == ["collision", "collision"]


def test_a_robot_without_a_task_may_have_parked_elsewhere(new_script: Any) -> None:
    """Where an idle robot rests is known for as long as it can be on its way to a parking place, and not at the end."""
    for robots, expected in (([(0, 0), (0, 5)], ["collision"]), ([(0, 0), (4, 5)], [])):
        script = new_script(HALL, robots=robots)
        script.drive(0, 0, 7)
        assert kinds(script) == expected
