"""Tests of what all ways of driving share, and of robots that are each alone."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cases import cases
from corridor import CORRIDOR, INSTANCE
from rmfs_commands.cli.single_rule import load_rule
from rmfs_commands.layouts import parse_map
from rmfs_commands.testing import small_world
from rmfs_core.decisions import Leg
from rmfs_core.decisions import Path as Way
from rmfs_core.errors import RuleError
from rmfs_core.events import OrderCompleted, PodLifted, QueueJoined, RobotMoved
from rmfs_core.roles import Role
from rmfs_core.rules.traits import RuleTraits
from rmfs_core.scenario.model import RuleChoice, RunSection, Scenario
from rmfs_core.simulation.context import RunContext
from rmfs_core.simulation.driving.base import CROSSINGS, Driving, Process
from rmfs_core.simulation.driving.free import FreeDriving
from rmfs_core.warehouse import Robot, Warehouse
from rmfs_core.world import EAST, NORTH
from rmfs_traffic.windowed import WindowedDriving
from scripted import run_of, until_nothing_happens
from told import Prepare

Install = Callable[..., None]
LAYOUT = parse_map("#....\n.....\n.qO..\n.....", "open")


@pytest.fixture
def world() -> Warehouse:
    """A robot with the heading north in the only storage location, the north-west corner of an open grid."""
    return small_world({}, {"p": ["a"]}, robots=1, layout=LAYOUT)


def driving(world: Warehouse, folder: Path, *answers: object) -> tuple[Driving, Any]:
    run, rule = run_of(world, folder)
    rule.answers = {"plan_path": list(answers)}
    return Driving(run), rule


def test_paths_are_asked_for(world: Warehouse, tmp_path: Path) -> None:
    """From where a robot stands, or where its leg ends; one that need not exist may be None."""
    answers = (Way([Leg(4), Leg(14)]), Way([Leg(8)]), Way([Leg(8)]), None, Way([Leg(8)]), Way([Leg(-1)]))
    way, rule = driving(world, tmp_path, *answers)
    robot, traffic = world.robots[0], object()
    assert way.path(robot, 14).tolist() == [[4, 0], [14, 0]]
    assert way.path(robot, 8, traffic, 5).tolist() == [[8, 0]]
    asked = [(told["robot"], told["goal"], told["traffic"]) for _, told in rule.asked]
    assert asked == [(robot, 14, None), (robot, 8, traffic)]
    with pytest.raises(RuleError, match="row 1, column 1 to row 2, column 4 is no straight run"):
        way.path(robot, 8)
    assert [way.path(robot, 8, None, 5, needed=False).tolist() for _ in range(2)] == [[], [[8, 0]]]
    with pytest.raises(RuleError, match="to cell -1, which is not on the grid"):
        way.path(robot, 8, None, 5, needed=False)


@cases(
    "tick to",
    (6862, 4),  # at the end of its leg
    (6861, 3),  # at speed in all of these
    (4779, 2),  # 2 m: 1.125 m to the top speed, and 0.875 m at that
    (4778, 1),
    (4100, 0),  # it has passed no cell: nothing is told
    (2695, 0),
    (2000, 0),
)
def test_who_arrives_or_is_cut_off_is_told_from_where_to(world: Warehouse, tmp_path: Path, tick: int, to: int) -> None:
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
    assert (robot.cell, robot.heading, pod.cell) == (to, EAST if to else NORTH, to)
    waited = {"wait_ticks": 70, "turn_ticks": 625}
    moved = RobotMoved(tick, 2000, 0, origin=0, to=to, heading=EAST, distance_m=to, pod=0, **waited)
    assert events == [moved] * (to > 0)


@pytest.mark.parametrize(("standstill_s", "ticks"), [(3600.0, 3_600_000), (1.5, CROSSINGS * (4_833 + 4_167 + 2_500))])
def test_patience_is_the_scenarios(world: Warehouse, tmp_path: Path, standstill_s: float, ticks: int) -> None:
    given, _ = run_of(world, tmp_path)
    scenario = Scenario(rules=given.scenario.rules, run=RunSection(standstill_s=standstill_s))
    assert Driving(run_of(world, tmp_path, scenario)[0]).standstill_ticks == ticks


OPEN = parse_map("###..\n.....\nqqO..\n.....", "open")
FREE = RuleChoice("free-flow")


def free(world: Warehouse, folder: Path, **rules: Any) -> tuple[RunContext, FreeDriving, list[Any], Any]:
    run, rule = run_of(world, folder, **rules)
    events: list[Any] = []
    run.tell = events.append
    return run, FreeDriving(run), events, rule


def carrying(world: Warehouse, robot: int, pod: int) -> None:
    carrier, carried, station = world.robots[robot], world.pods[pod], world.stations[0]
    world.bind(carried, station)
    world.take_task(carrier, carried)
    world.move(carrier, carried.cell, carrier.heading)
    world.lift(carrier, carried)


def test_robots_pass_through_each_other_where_paths_may(tiny_run: Prepare) -> None:
    tiny = tiny_run(INSTANCE, capacity=3, robots=3, layout=CORRIDOR, queue_length=1, pp="free-flow").done()
    assert len(tiny.of(OrderCompleted)) == 16
    assert all(move.wait_ticks == 0 for move in tiny.of(RobotMoved))


def test_free_drives_take_the_time_of_the_table_or_of_the_rules_path(tmp_path: Path) -> None:
    world = small_world({}, {"p": ["a"]}, robots=1, layout=OPEN)
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
    world = small_world({}, {"p": ["a"]}, robots=1, layout=OPEN)
    run, driving, events, rule = free(world, tmp_path)
    robot = world.robots[0]
    world.move(robot, 5, 0)
    rule.answers = {"plan_path": [Way([Leg(6, 70)]), Way([Leg(6, 30), Leg(7)])]}
    run.env.process(driving.to_location(robot, 7))
    until_nothing_happens(run)
    assert [told["goal"] for _, told in rule.asked] == [7, 7]
    assert [(one.to, one.start_tick, one.tick) for one in events] == [(6, 0, 2070), (6, 2070, 2100), (7, 2100, 4100)]


def test_who_never_comes_nearer_ends_the_run(tmp_path: Path) -> None:
    world = small_world({}, {"p": ["a"]}, robots=1, layout=OPEN)
    given, _ = run_of(world, tmp_path)
    scenario = Scenario(rules=given.scenario.rules, run=RunSection(standstill_s=60))
    run, rule = run_of(world, tmp_path, scenario)
    robot = world.robots[0]
    rule.answers = {"plan_path": [Way([Leg(robot.cell, 40_000)])] * 9}
    run.env.process(FreeDriving(run).to_location(robot, 19))
    with pytest.raises(RuleError, match=r"at 120\.000 s: robot 1 has come no nearer to row 4, column 5 for 120 s"):
        until_nothing_happens(run)
    world = small_world({}, {"p": ["a"]}, robots=1, layout=OPEN)
    run, rule = run_of(world, tmp_path, scenario)
    robot = world.robots[0]
    rule.answers = {"plan_path": [Way([Leg(to, 90_000)]) for to in (7, 8, 9)]}
    run.env.process(FreeDriving(run).to_location(robot, 9))
    until_nothing_happens(run)
    assert (robot.cell, len(rule.asked)) == (9, 3)
    assert run.warehouse.now > 270_000


def test_the_line_is_in_order_of_arrival(tmp_path: Path) -> None:
    world = small_world({}, {"p": ["a"], "q": ["a"], "r": ["a"]}, robots=3, layout=OPEN)
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


HOP = """
from rmfs_core.simulation.driving.base import Driving

class Hop(Driving):
    hook = "plan_paths"

    @classmethod
    def prepare_with(cls, travel):
        return "any distance"

    def to_location(self, robot, cell):
        told, _ = self.run.ask(self.rule, queries=(robot.id,), traffic="nobody")
        yield self.run.after(told)
        self.arrive(robot, cell, 0, robot.heading, self.run.warehouse.now, 0)

    def to_station(self, robot, station):
        self.run.warehouse.join_line(robot, station)
        yield from self.to_location(robot, station.cell)
"""

HOPS = """
from attrs import define
from rmfs_core import hookimpl

@define(slots=False)
class Hops:
    reserves = "hop"

    def prepare(self, what):
        self.distance = what

    @hookimpl
    def plan_paths(self, queries, traffic):
        assert (self.distance, traffic) == ("any distance", "nobody")
        return 7
"""


def test_a_way_of_driving_can_come_from_elsewhere(tiny_run: Prepare, install: Install, tmp_path: Path) -> None:
    """The rule that names it is prepared with, and asked for, whatever the two have agreed on."""
    (tmp_path / "hops.py").write_text(HOPS)
    install("acme", {"hop": "acme_hop:Hop"}, "rmfs.driving", acme_hop=HOP)
    tiny = tiny_run(INSTANCE, capacity=3, pp="./hops.py:Hops").done()
    assert len(tiny.of(OrderCompleted)) == 16
    assert tiny.of(PodLifted)[0].start_tick == 7


def test_a_way_is_that_of_the_rules_distribution_or_else_the_shipped_one(install: Install) -> None:
    install("acme", {"windows": "acme_hop:Hop"}, "rmfs.driving", acme_hop=HOP)
    install("bolt", {"windows": "acme_hop:Hop"}, "rmfs.driving")
    ways = [RuleTraits(reserves="windows", distribution=one).way.__name__ for one in ("acme", "mine.py", "rmfs")]
    assert ways == ["Hop", "WindowedDriving", "WindowedDriving"]
    assert load_rule(RuleChoice("whca-n"), (Role.PP,)).traits.way is WindowedDriving
