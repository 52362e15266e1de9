"""Driving as if each robot were alone."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from corridor import CORRIDOR, INSTANCE
from rmfs_commands.testing import small_world
from rmfs_core.decisions import Leg
from rmfs_core.decisions import Path as Way
from rmfs_core.errors import RuleError
from rmfs_core.events import OrderCompleted, QueueJoined, RobotMoved, VisitStarted
from rmfs_core.scenario.model import RuleChoice, RunSection, Scenario
from rmfs_core.simulation.context import RunContext
from rmfs_core.simulation.driving.base import Process
from rmfs_core.simulation.driving.free import FreeDriving
from rmfs_core.warehouse import Robot, Warehouse
from rmfs_core.world import parse_map
from scripted import run_of, until_nothing_happens

LAYOUT = parse_map("###..\n.....\nqqO..\n.....", "open")
FREE = RuleChoice("free-flow")


def free(world: Warehouse, folder: Path, **rules: Any) -> tuple[RunContext, FreeDriving, list[Any], Any]:
    """Return a run, its driving, the events that are told, and the scripted rule."""
    run, rule = run_of(world, folder, **rules)
    events: list[Any] = []
    run.tell = events.append
    return run, FreeDriving(run), events, rule


def carrying(world: Warehouse, robot: int, pod: int) -> None:
    """Let a robot stand with a pod where the pod is stored."""
    carrier, carried, station = world.robots[robot], world.pods[pod], world.stations[0]
    world.bind(carried, station)
    world.take_task(carrier, carried)
    world.move(carrier, carried.cell, carrier.heading)
    world.lift(carrier, carried)


def test_robots_pass_through_each_other(tiny_run: Callable[..., Any]) -> None:
    """Where only one could pass, they drive as fast as alone: every robot is on its fastest path."""
    tiny = tiny_run(INSTANCE, capacity=3, robots=3, layout=CORRIDOR, queue_length=1, pp="free-flow")
    tiny.simulation.run()
    assert len(tiny.recorder.of(OrderCompleted)) == 16
    assert all(move.wait_ticks == 0 for move in tiny.recorder.of(RobotMoved))


def test_a_drive_takes_the_time_of_the_table(tmp_path: Path) -> None:
    """One event a leg, the last at the goal; nobody drives who is there."""
    world = small_world({}, {"p": ["a"]}, robots=1, layout=LAYOUT)
    run, driving, events, _ = free(world, tmp_path, pp=FREE)
    robot = world.robots[0]
    ticks = world.travel.ticks(robot.cell, robot.heading, 19, loaded=False)
    run.env.process(driving.to_location(robot, 19))
    until_nothing_happens(run)
    assert (robot.cell, world.now, events[-1].to, events[-1].tick) == (19, ticks, 19, ticks)
    told = len(events)
    run.env.process(driving.to_location(robot, 19))
    until_nothing_happens(run)
    assert (len(events), world.now) == (told, ticks)


def test_the_rule_is_asked_again_where_its_path_ends(tmp_path: Path) -> None:
    """With waits in between, which count."""
    world = small_world({}, {"p": ["a"]}, robots=1, layout=LAYOUT)
    run, driving, events, rule = free(world, tmp_path)
    robot = world.robots[0]
    world.move(robot, 5, 0)
    rule.answers = {"plan_path": [Way([Leg(6, 70)]), Way([Leg(6, 30), Leg(7)])]}
    run.env.process(driving.to_location(robot, 7))
    until_nothing_happens(run)
    assert [told["goal"] for _, told in rule.asked] == [7, 7]
    assert [(event.to, event.start_tick, event.tick) for event in events] == [
        (6, 0, 2070),
        (6, 2070, 2100),
        (7, 2100, 4100),
    ]


def test_who_never_arrives_ends_the_run(tmp_path: Path) -> None:
    """The rule is named, with the robot, its goal and how long it has come no nearer."""
    world = small_world({}, {"p": ["a"]}, robots=1, layout=LAYOUT)
    given, _ = run_of(world, tmp_path)
    scenario = Scenario(rules=given.scenario.rules, run=RunSection(standstill_s=60))
    run, rule = run_of(world, tmp_path, scenario)
    robot = world.robots[0]
    rule.answers = {"plan_path": [Way([Leg(robot.cell, 40_000)])] * 9}
    run.env.process(FreeDriving(run).to_location(robot, 19))
    with pytest.raises(
        RuleError,
        match=r"at 120\.000 s: robot 1 has come no nearer to row 4, column 5 for 120 s \(longer than run\.stand",
    ):
        until_nothing_happens(run)


def test_who_comes_nearer_does_not_stand_still(tmp_path: Path) -> None:
    """However long its way takes: 300 s, when 115 s without progress would end the run."""
    world = small_world({}, {"p": ["a"]}, robots=1, layout=LAYOUT)
    given, _ = run_of(world, tmp_path)
    run, rule = run_of(world, tmp_path, Scenario(rules=given.scenario.rules, run=RunSection(standstill_s=60)))
    robot = world.robots[0]
    rule.answers = {"plan_path": [Way([Leg(to, 90_000)]) for to in (7, 8, 9)]}
    run.env.process(FreeDriving(run).to_location(robot, 9))
    until_nothing_happens(run)
    assert (robot.cell, len(rule.asked)) == (9, 3)
    assert run.warehouse.now > 270_000


def test_the_line_is_in_order_of_arrival(tmp_path: Path) -> None:
    """Who sets out first but arrives last is served last; who waits in the queue moves up, and nobody backs up."""
    world = small_world({}, {"p": ["a"], "q": ["a"], "r": ["a"]}, robots=3, layout=LAYOUT)
    run, driving, events, rule = free(world, tmp_path)
    station, (slow, quick, third) = world.stations[0], world.robots
    for number in range(3):
        carrying(world, number, number)
    starts: dict[int, int] = {}

    def plan(told: Any) -> Way:
        robot = told["robot"]
        legs = world.travel.fastest_path(robot.cell, robot.heading, told["goal"], loaded=True)
        return Way([Leg(legs[0].to, 60_000 if robot is slow else 0), *legs[1:]])

    def visit(robot: Robot, set_out: int) -> Process:
        yield run.after(set_out)
        yield from driving.to_station(robot, station)
        starts[robot.id] = world.now
        yield run.after(100_000)
        assert robot.pod is not None
        world.leave(robot, world.pods[robot.pod], station)
        driving.left(station)

    rule.answers = {"plan_path": [plan] * 20}
    for robot, set_out in ((slow, 0), (quick, 0), (third, 30_000)):
        run.env.process(visit(robot, set_out))
    until_nothing_happens(run)
    in_order = [quick.id, third.id, slow.id]
    assert [event.robot for event in events if isinstance(event, QueueJoined)] == list(starts) == in_order
    a_step = starts[third.id] - starts[quick.id] - 100_000
    assert 2000 <= a_step <= 2000 + 1250
    # It set out for the station itself, when nobody was in line yet, and has waited there.
    assert starts[slow.id] == starts[third.id] + 100_000


def test_a_queue_that_is_full_is_waited_in_at_its_end(tiny_run: Callable[..., Any]) -> None:
    """More robots than cells: visits are in the order in which the pods joined, each picked by itself."""
    tiny = tiny_run(INSTANCE, capacity=3, robots=6, queue_length=1, pp="free-flow")
    tiny.simulation.run()
    joined = [event.pod for event in tiny.recorder.of(QueueJoined)]
    assert [event.pod for event in tiny.recorder.of(VisitStarted)] == joined
