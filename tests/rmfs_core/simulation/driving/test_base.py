"""What all ways of driving share: asking for paths, and arriving."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from rmfs_commands.testing import small_world
from rmfs_core.decisions import Leg
from rmfs_core.decisions import Path as Way
from rmfs_core.errors import RuleError
from rmfs_core.events import RobotMoved
from rmfs_core.scenario.model import RunSection, Scenario
from rmfs_core.simulation.driving.base import CROSSINGS, Driving
from rmfs_core.traffic import Query, Reservations, Traffic, roads_on
from rmfs_core.warehouse import Robot, Warehouse
from rmfs_core.world import EAST, NORTH, SOUTH, WEST, parse_map
from scripted import run_of

LAYOUT = parse_map("#....\n.....\n.qO..\n.....", "open")


@pytest.fixture
def world() -> Warehouse:
    """A robot with the heading north in the only storage location, the north-west corner of an open grid."""
    return small_world({}, {"p": ["a"]}, robots=1, layout=LAYOUT)


def driving(world: Warehouse, folder: Path, *answers: object) -> tuple[Driving, Any]:
    """Return the driving of a run whose PP rule gives these answers, and that rule."""
    run, rule = run_of(world, folder)
    rule.answers = {"plan_path": list(answers)}
    return Driving(run), rule


def test_a_path_is_asked_for_with_robot_and_goal(world: Warehouse, tmp_path: Path) -> None:
    """Its legs come back checked."""
    way, rule = driving(world, tmp_path, Way([Leg(4), Leg(14)]))
    robot = world.robots[0]
    assert way.path(robot, 14).tolist() == [[4, 0], [14, 0]]
    ((_, told),) = rule.asked
    assert (told["robot"], told["goal"], told["traffic"]) == (robot, 14, None)


@pytest.mark.parametrize(
    ("answer", "problem"),
    [
        (None, "returned None; expected Path"),
        ([Leg(2)], r"returned list \[Leg\(to=2, wait_ticks=0\)\]; expected Path"),
        (Way([Leg(7)]), "gave robot 1 .* an impossible path: row 1, column 1 to row 2, column 3 is no straight run"),
    ],
)
def test_a_wrong_path_is_the_rules_fault(world: Warehouse, tmp_path: Path, answer: object, problem: str) -> None:
    """The error names it, with what it returned."""
    way, _ = driving(world, tmp_path, answer)
    with pytest.raises(RuleError, match=rf"scripted_rules.*, plan_path, at 0.000 s: {problem}"):
        way.path(world.robots[0], 7)


def traffic_from(world: Warehouse, cell: int) -> Traffic:
    """Return an empty table, and the question of a robot that will stand in a cell."""
    roads = roads_on(world.travel)
    return Traffic(roads, Reservations(roads.cells), Query(0, cell, EAST, 500, 8))


def test_a_robot_on_its_way_is_planned_for_from_where_its_leg_ends(world: Warehouse, tmp_path: Path) -> None:
    """Not from where it was when it began that leg."""
    way, rule = driving(world, tmp_path, Way([Leg(8)]), Way([Leg(8)]))
    traffic = traffic_from(world, cell=5)
    assert way.path(world.robots[0], 8, traffic).tolist() == [[8, 0]]
    assert rule.asked[0][1]["traffic"] is traffic
    with pytest.raises(RuleError, match="row 1, column 1 to row 2, column 4 is no straight run"):
        way.path(world.robots[0], 8)


def test_a_path_that_need_not_exist_may_be_none(world: Warehouse, tmp_path: Path) -> None:
    """One that is given is checked all the same."""
    way, _ = driving(world, tmp_path, None, Way([Leg(8)]), Way([Leg(-1)]))
    traffic = traffic_from(world, cell=5)
    robot = world.robots[0]
    assert way.path(robot, 8, traffic, needed=False).tolist() == []
    assert way.path(robot, 8, traffic, needed=False).tolist() == [[8, 0]]
    with pytest.raises(RuleError, match="to cell -1, which is not on the grid"):
        way.path(robot, 8, traffic, needed=False)


@pytest.mark.parametrize(
    ("to", "heading", "turn", "run"),
    [
        (7, EAST, 625, 2000),  # a metre: 1 s to speed up, 1 s to slow down
        (5, WEST, 625, 2000),
        (1, NORTH, 0, 2000),
        (16, SOUTH, 1250, 2828),  # two metres: 2 sqrt(2) s
        (9, EAST, 625, 3500),  # three: the top speed of 1.5 m/s is reached
        (6, NORTH, 0, 0),  # the cell it stands in
    ],
)
def test_a_leg_is_a_turn_and_a_run(
    world: Warehouse, tmp_path: Path, to: int, heading: int, turn: int, run: int
) -> None:
    """Worked out from 1 m/s^2, 1.5 m/s and 2.5 s for a full turn; the wait is not in it."""
    way, _ = driving(world, tmp_path)
    robot = Robot(0, 6, NORTH)
    assert way.turn_and_run(robot, to) == (heading, turn, run)


@pytest.mark.parametrize(
    ("tick", "to"),
    [
        (6862, 4),  # at the end of its leg
        (6861, 3),  # at speed in all of these
        (4779, 2),  # 2 m: 1.125 m to the top speed, and 0.875 m at that
        (4778, 1),
    ],
)
def test_who_arrives_or_is_cut_off_is_told_where_from_and_how_far(
    world: Warehouse, tmp_path: Path, tick: int, to: int
) -> None:
    """The robot is there with its new heading, and the event has all of the leg, or whole cells of it."""
    way, _ = driving(world, tmp_path)
    robot, pod = world.robots[0], world.pods[0]
    world.bind(pod, world.stations[0])
    world.take_task(robot, pod)
    world.lift(robot, pod)
    events: list[object] = []
    way.run.tell = events.append
    way.set_off(robot, 4, 70, EAST, start=2000, turn_ticks=625, arrival=6862)
    world.advance(tick)
    if tick == 6862:
        way.arrive(*way.under_way.pop(robot.id))
    way.cut_off()
    assert (robot.cell, robot.heading, pod.cell) == (to, EAST, to)
    assert events == [
        RobotMoved(
            tick,
            start_tick=2000,
            robot=0,
            origin=0,
            to=to,
            heading=EAST,
            wait_ticks=70,
            turn_ticks=625,
            distance_m=to,
            pod=0,
        )
    ]


@pytest.mark.parametrize("tick", [2000, 2695, 4100])
def test_who_has_passed_no_cell_is_not_told(world: Warehouse, tmp_path: Path, tick: int) -> None:
    """A robot that waits, turns or has just begun to drive when the run is over stands where it stood."""
    way, _ = driving(world, tmp_path)
    events: list[object] = []
    way.run.tell = events.append
    way.set_off(world.robots[0], 4, 70, EAST, start=2000, turn_ticks=625, arrival=6862)
    world.advance(tick)
    way.cut_off()
    assert events == []


@pytest.mark.parametrize(("standstill_s", "ticks"), [(3600.0, 3_600_000), (1.5, CROSSINGS * (4_833 + 4_167 + 2_500))])
def test_patience_is_the_scenarios(world: Warehouse, tmp_path: Path, standstill_s: float, ticks: int) -> None:
    """In ticks; but others get the time to drive across the layout several times, and to turn."""
    given, _ = run_of(world, tmp_path)
    scenario = Scenario(rules=given.scenario.rules, run=RunSection(standstill_s=standstill_s))
    assert Driving(run_of(world, tmp_path, scenario)[0]).standstill_ticks == ticks
