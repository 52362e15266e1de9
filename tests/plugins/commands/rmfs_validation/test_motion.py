"""Faults of motion and of robots that meet, in traces written by hand."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from rmfs_core.motion import Motion
from rmfs_validation import faults_of
from rmfs_validation.collisions import reached_s

HALL = "........\n" * 5
ONE_WAY = "\n".join(["........", ".>>>>>>.", "...@....", "..##.##.", "......qO", "........"])


def kinds(script: Any, collisions: bool | None = None) -> list[str]:
    """Return the kinds of faults in a script's trace, in the order of time."""
    return [fault.kind for fault in faults_of(script.trace(), collisions=collisions)]


def diagonal(script: Any) -> None:
    """Drive along no row and no column."""
    script.drive(0, 0, 3)
    script.drive(0, 2, 5)


def against(script: Any) -> None:
    """Drive a one-way aisle the wrong way."""
    script.drive(0, 1, 0)
    script.drive(0, 1, 4)
    script.drive(0, 1, 2)


def into_wall(script: Any) -> None:
    """Drive through a wall."""
    script.drive(0, 2, 0)
    script.drive(0, 2, 5)


def under_pods(script: Any) -> None:
    """Drive to the pod under the other one, and lift it."""
    script.drive(0, 3, 0)
    script.drive(0, 3, 3)
    script.lift(0, 0)


def through_pod(script: Any) -> None:
    """Carry a pod through another one's storage location."""
    under_pods(script)
    script.drive(0, 3, 0)


def over_storage(script: Any) -> None:
    """Carry a pod across free storage locations."""
    under_pods(script)
    script.drive(0, 4, 3)
    script.drive(0, 4, 4)
    script.drive(0, 3, 4)
    script.drive(0, 3, 7)


def rest_on_storage(script: Any) -> None:
    """Carry a pod to a free storage location, and on again."""
    under_pods(script)
    script.drive(0, 3, 5)
    script.drive(0, 3, 4)


def without_pod_in_queue(script: Any) -> None:
    """Enter a queue without a pod."""
    script.drive(0, 4, 0)
    script.drive(0, 4, 6)


def through_queue(script: Any) -> None:
    """Carry a pod through a queue and past the station."""
    under_pods(script)
    script.drive(0, 4, 3)
    script.drive(0, 4, 7)
    script.drive(0, 5, 7)


def too_fast(script: Any) -> None:
    """Drive four cells in 3 s."""
    script.drive(0, 0, 4, tick=3000)


def too_slow(script: Any) -> None:
    """Drive four cells in 9 s."""
    script.drive(0, 0, 4, tick=9000)


def wrong_heading(script: Any) -> None:
    """Drive sideways."""
    script.drive(0, 3, 0, heading=0, turn_ticks=0, tick=Motion().run_ticks(3))


def wrong_turn(script: Any) -> None:
    """Turn in no time."""
    script.drive(0, 3, 0, turn_ticks=0, tick=Motion().run_ticks(3))


def early(script: Any) -> None:
    """Begin a run before the last one has ended."""
    script.drive(0, 0, 7)
    script.rest(0, -1)
    script.drive(0, 3, 7)


def jump(script: Any) -> None:
    """Begin a run two cells off."""
    script.drive(0, 0, 4)
    script.cells[0] += 2
    script.drive(0, 0, 7)


def longer_than_it_is(script: Any) -> None:
    """Report more metres than there are."""
    script.drive(0, 0, 4, distance_m=5)


def waits_backwards(script: Any) -> None:
    """Wait for less than no time."""
    script.drive(0, 0, 4, wait_s=-1)


@pytest.mark.parametrize(
    ("mistake", "kind"),
    [
        (diagonal, "not-straight"),
        (against, "one-way"),
        (into_wall, "wall"),
        (through_pod, "through-stored-pod"),
        (over_storage, "storage-crossed"),
        (rest_on_storage, "storage-crossed"),
        (without_pod_in_queue, "queue-lane"),
        (through_queue, "queue-lane"),
        (too_fast, "too-fast"),
        (too_slow, "too-slow"),
        (wrong_heading, "heading"),
        (wrong_turn, "turn-time"),
        (early, "time-overlap"),
        (jump, "teleport"),
        (longer_than_it_is, "distance"),
        (waits_backwards, "negative-time"),
    ],
)
def test_each_mistake_is_found_alone(new_script: Any, mistake: Callable[[Any], None], kind: str) -> None:
    """A single mistake in a hand-written trace is that one kind of fault, and the robot is named."""
    script = new_script(ONE_WAY, robots=[(0, 0)], pods=[(3, 3), (3, 2)])
    mistake(script)
    faults = faults_of(script.trace())
    assert {fault.kind for fault in faults} == {kind}
    assert all("robot 1" in fault.sentence for fault in faults)


def test_a_pod_may_be_carried_from_its_start_to_its_goal(new_script: Any) -> None:
    """Under stored pods without one, out of one storage location and into another one with it: no fault."""
    script = new_script(ONE_WAY, robots=[(0, 0)], pods=[(3, 3), (3, 2)], blocked=[(3, 6)])
    under_pods(script)
    script.drive(0, 4, 3)
    script.drive(0, 4, 5, wait_s=1)
    script.drive(0, 3, 5)
    script.store(0)
    script.drive(0, 3, 6)
    assert kinds(script) == []


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


def test_a_rule_that_ignores_other_robots_is_not_held_to_it(new_script: Any) -> None:
    """Collisions are checked unless the PP rule is free-flow; the argument overrides."""
    script = new_script(HALL, robots=[(0, 0), (0, 5)])
    script.drive(0, 0, 7)
    script.drive(1, 4, 5, wait_s=30)
    assert faults_of(script.trace("free-flow")) == []
    assert [fault.kind for fault in faults_of(script.trace("free-flow"), collisions=True)] == ["collision"]
    assert kinds(script, collisions=False) == []


@pytest.mark.parametrize("metres", [1, 2, 3, 7, 20])
def test_points_are_reached_when_the_formulas_say(metres: int) -> None:
    """The times at which the cells of a run are reached are the inverse of the position over time."""
    motion = Motion()
    for at in range(metres + 1):
        assert motion.position_m(metres, reached_s(motion, metres, at)) == pytest.approx(at)
