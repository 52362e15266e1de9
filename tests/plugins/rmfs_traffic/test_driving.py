"""Ways of driving with reservations: paths in full, for all robots at once, and in windows."""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, ClassVar

import pytest
from attrs import define

import rmfs_core
from cases import cases
from corridor import CORRIDOR, CORRIDOR_MAP, INSTANCE, inline
from reserving import occupy
from rmfs_commands.details.loading import load_result
from rmfs_commands.layouts import parse_map
from rmfs_commands.testing import small_instance, small_layout
from rmfs_commands.validation import validate_trace
from rmfs_core import events, hookimpl
from rmfs_core.decisions import Leg
from rmfs_core.decisions import Path as Way
from rmfs_core.errors import InputError, RuleError, StandstillError
from rmfs_core.events import Event
from rmfs_core.info import Question
from rmfs_core.scenario.model import RuleChoice, RunSection
from rmfs_core.simulation.engine import Simulation
from rmfs_core.warehouse import Robot
from rmfs_core.world import NORTH, check_layout
from rmfs_rules.sipp import Pbs, Sipp
from rmfs_traffic import FOREVER, FleetTraffic, Occupancy, Query, Traffic, occupancy, timed_path
from rmfs_traffic.reserved import Course
from rmfs_traffic.windowed import WindowedDriving
from told import Prepare


@pytest.mark.parametrize("pp", ["sipp", "pbs"])
def test_robots_pass_a_corridor_for_one(tiny_run: Prepare, pp: str) -> None:
    check_layout(CORRIDOR, "corridor")
    tiny = tiny_run(INSTANCE, capacity=3, robots=3, layout=CORRIDOR, queue_length=1, pp=pp).done()
    assert len(tiny.of(events.OrderCompleted)) == 16


STRAIGHT = """
#####@@@@...
.....@......
.→→→{}O>>....
.....@......
............
"""


@pytest.mark.parametrize(("sign", "least_ticks"), [("→", 1415 + 2000), ("⇒", 2829)])
def test_the_next_pod_rolls_in_over_a_clear_cell(tiny_run: Prepare, sign: str, least_ticks: int) -> None:
    layout = parse_map(STRAIGHT.format(sign), "straight")
    check_layout(layout, "straight")
    tiny = tiny_run(INSTANCE, capacity=3, robots=3, layout=layout, queue_length=3, pp="sipp").done()
    begins = [event.tick for event in tiny.of(events.VisitStarted)][1:]
    ends = [event.tick for event in tiny.of(events.VisitEnded)]
    assert min(begin - end for begin, end in zip(begins, ends, strict=False)) == least_ticks


def test_a_full_path_ends_at_the_goal(tiny_run: Prepare, tmp_path: Path) -> None:
    tiny = tiny_run(INSTANCE, capacity=3, robots=1, pp=inline(tmp_path, "full paths", "legs[:-1]"))
    with pytest.raises(RuleError, match=r"gave robot 1 a path that ends at row .*, not at its goal row|an empty path"):
        tiny.simulation.run()


FLEET = """
from attrs import define
from rmfs_core import Leg, Path, hookimpl
@define
class Mine:
    reserves = "fleet"
    @hookimpl
    def {hook}(self, warehouse, queries, traffic):
        found = {{}}
        for query in queries:
            loaded = query.loaded
            found[query.robot] = Path(warehouse.travel.fastest_path(query.cell, query.heading, query.goal, loaded))
        return {answer}
"""


def mine(folder: Path, answer: str = "found", hook: str = "plan_paths") -> RuleChoice:
    (folder / "mine.py").write_text(FLEET.format(answer=answer, hook=hook), encoding="utf-8")
    return RuleChoice("./mine.py:Mine")


@cases(
    "answer problem",
    ("{}", r"left out robot \d, which needs a path"),
    ("list(found.values())", r"returned list .*; expected dict"),
    ("{robot: path.legs for robot, path in found.items()}", r"returned tuple .*; expected Path"),
    ("{**found, 17: Path(())}", "answered for 17, a robot that it was not asked for"),
    ("{robot: Path(one.legs[:1]) for robot, one in found.items()}", "a path that ends at row .*, not at its goal"),
)
def test_answers_that_cannot_be_driven_are_refused(answer, problem, tiny_run, tmp_path) -> None:
    tiny = tiny_run(INSTANCE, capacity=3, robots=1, pp=mine(tmp_path, answer))
    with pytest.raises(RuleError, match=rf"mine.py.*, plan_paths, at 0\.000 s: .*{problem}"):
        tiny.simulation.run()


def test_fleets_plan_as_their_rule_says(tiny_run: Prepare, tmp_path: Path) -> None:
    tiny = tiny_run(INSTANCE, capacity=3, robots=4, layout=CORRIDOR, queue_length=1, pp=mine(tmp_path))
    with pytest.raises(RuleError, match=r"plan_paths, .* a path that hits a reservation: robot \d has row \d+"):
        tiny.simulation.run()
    (tmp_path / "mine.py").write_text(FLEET.format(answer="found", hook="plan_path").replace("queries, ", ""))
    expected = r"rules.pp: rule .* has reserves = 'fleet' and no hook `plan_paths`; expected both"
    with pytest.raises(InputError, match=expected):
        tiny_run(INSTANCE, capacity=3, robots=1, pp=RuleChoice("./mine.py:Mine"))


@define
class LetsOthersWait:
    """Plans as `pbs`, and lets robots that may keep their paths wait a second longer each time."""

    reserves: ClassVar[str] = "fleet"
    put_off: ClassVar[dict[int, int]] = {}
    most: ClassVar[list[int]] = []

    @hookimpl
    def plan_paths(self, queries: Sequence[Query], traffic: FleetTraffic) -> dict[int, Path]:
        table, paths = traffic.table.copy(), Pbs(most_nodes=0).plan_paths(queries, traffic)

        def take(robot: int, cells: Occupancy) -> None:
            table.release(robot)
            if robot in traffic.under_way:
                table.add(robot, traffic.under_way[robot])
            table.add(robot, cells)

        for query in queries:
            if query.robot in paths:
                self.put_off[query.robot] = 0
                path = Sipp().search(traffic.roads, table, query)
                assert path is not None
                take(query.robot, occupancy(traffic.roads, path))
        for query in queries:
            if query.robot in traffic.arrives:
                later = Sipp().search(traffic.roads, table, query)
                assert later is not None
                first, *rest = later.legs
                waits = Way((Leg(first.to, first.wait_ticks + 1000), *rest))
                taken = occupancy(traffic.roads, timed_path(traffic.roads, query, waits.legs))
                if table.is_free(query.robot, taken):
                    paths[query.robot] = waits
                    take(query.robot, taken)
                    self.put_off[query.robot] += 1
                    self.most.append(self.put_off[query.robot])
        return paths


def test_nobody_is_put_off_for_ever() -> None:
    LetsOthersWait.put_off.clear()
    LetsOthersWait.most.clear()
    overrides = ["robots.count=3", "stations.pick_s=1"]
    result = rmfs_core.run("examples/small", rules={"pp": LetsOthersWait()}, overrides=overrides)
    assert (result.status, max(LetsOthersWait.most)) == ("complete", 3)


@pytest.fixture(params=["sipp", "whca-n"])
def pp(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def test_pods_are_served_in_line(tiny_run: Prepare, pp: str) -> None:
    tiny = tiny_run(INSTANCE, capacity=3, robots=4, pp=pp).done()
    joined = [event.pod for event in tiny.of(events.QueueJoined)]
    assert [event.pod for event in tiny.of(events.VisitStarted)] == joined
    tiny = tiny_run(INSTANCE, capacity=3, robots=4, pp=pp, at_stations={"1": ("2", "3")}).done()
    assert [event.pod for event in tiny.of(events.VisitStarted)][:2] == [1, 2]
    assert len(tiny.of(events.OrderCompleted)) == 16


def moved_without_a_task(told: list[Event]) -> bool:
    busy: set[int] = set()
    for event in told:
        if isinstance(event, events.TaskAssigned):
            busy.add(event.robot)
        elif isinstance(event, events.PodStored):
            busy.discard(event.robot)
        elif isinstance(event, events.RobotMoved) and event.robot not in busy:
            return True
    return False


@pytest.mark.parametrize("seed", range(4))
def test_idle_robots_step_aside(tiny_run: Prepare, pp: str, seed: int) -> None:
    layout = small_layout(1, block_columns=1, queue_length=1)
    tiny = tiny_run(
        INSTANCE, capacity=3, robots=len(layout.storage_locations) - 1, queue_length=1, layout=layout, pp=pp, seed=seed
    ).done()
    assert len(tiny.of(events.OrderCompleted)) == 16
    assert moved_without_a_task(tiny.events)


@pytest.mark.parametrize("reserves", ["full paths", "windows"])
def test_a_path_that_hits_a_reservation_is_refused(tiny_run: Prepare, tmp_path: Path, reserves: str) -> None:
    tiny = tiny_run(INSTANCE, capacity=3, robots=4, layout=CORRIDOR, queue_length=1, pp=inline(tmp_path, reserves))
    with pytest.raises(RuleError, match=r"mine.py.*a path that hits a reservation: robot \d has row \d+, column \d+"):
        tiny.simulation.run()


def test_one_location_is_left_for_who_steps_aside(tiny_run: Prepare, pp: str) -> None:
    layout = small_layout(1, block_columns=1, queue_length=1)
    count = len(layout.storage_locations)
    with pytest.raises(InputError, match=rf"robots.count: found {count} robots and {count} storage locations"):
        tiny_run(INSTANCE, capacity=3, robots=count, queue_length=1, layout=layout, pp=pp)


@pytest.mark.parametrize("pp", ["sipp", "whca-n", "free-flow"])
def test_who_finds_nobody_in_line_takes_the_shortcut(pp: str) -> None:
    def visits_and_metres(queue: str) -> tuple[float, float]:
        settings = [f"rules.pp={pp}", f"layout.queue={queue}", "robots.count=1", "stations.queue_length=12"]
        # At a pick the robot is at the station in both, so that the same is decided; 6 s later it would not be.
        metrics = rmfs_core.run("examples/small", overrides=[*settings, "stations.release=picked"]).metrics
        return metrics["pod_station_visits"], metrics["loaded_distance_m"]

    (visits, plain), (same, short) = visits_and_metres("plain"), visits_and_metres("shortcut")
    assert visits == same
    assert 6 * visits <= plain - short <= 8 * visits


@cases("motion seconds waiting", ("", r"5\d\d", 2), (", top_speed_m_per_s = 0.01", r"6\d{4}", 1))
def test_a_standstill_says_who_waits_for_whom(tmp_path: Path, motion: str, seconds: str, waiting: int) -> None:
    (tmp_path / "map.txt").write_text(CORRIDOR_MAP + "\n")
    (tmp_path / "s.toml").write_text(
        'rules = { poa = "pod-match", pps = "demand", pp = "whca-n" }\n'
        "instance = { orders = 20, skus = 4, pods = 4, skus_per_pod = 1 }\n"
        'layout = { map_file = "map.txt", pod_fill = 0.1 }\nrobots = { count = 3'
        f"{motion} }}\n"
        "stations = { queue_length = 1, item_capacity = 4 }\nrun = { standstill_s = 300.0 }\n"
    )
    message = rf"The run stands still at .* for {seconds} s \(longer than run\.standstill_s and than 10 crossings"
    with pytest.raises(StandstillError, match=message) as caught:
        rmfs_core.run(tmp_path / "s.toml", out=tmp_path / "out")
    text = str(caught.value)
    assert text.count(" waits for row 1, column ") >= waiting
    assert "which robot " in text
    assert 'rule "whca-n" (rmfs' in text
    kept = load_result(tmp_path / "out")
    assert (kept.status, kept.error) == ("failed", text)
    assert kept.metrics["distance_m"] > 0


def test_a_standstill_names_a_robot_that_is_leaving_the_cell_it_wants(tiny_run: Prepare) -> None:
    simulation = tiny_run(INSTANCE, layout=CORRIDOR, queue_length=1, pp="whca-n").simulation
    driving = simulation.driving
    course = driving.courses[0]
    simulation.start()
    while course.under_way is None:
        simulation.warehouse.advance(int(simulation.env.peek()))
        simulation.env.step()
    left, reached = course.robot.cell, course.under_way[1].cell
    course.goal = left
    sentence = driving.who_waits_for_whom(course)
    assert f"robot 1 at {CORRIDOR.where(reached)} waits for " in sentence
    assert f"on its way to {CORRIDOR.where(left)}" in sentence


@pytest.mark.parametrize("robots", [8, 32])
def test_windows_are_planned_once_a_second_and_no_two_robots_meet(robots: int, tmp_path: Path) -> None:
    asked_ms = set()

    class Watch:
        @hookimpl
        def rule_asked(self, question: Question) -> None:
            if question.hook == "plan_path":
                asked_ms.add(round(question.warehouse.now_s * 1000))

    settings = ["rules.pp=whca-n", f"robots.count={robots}", "instance.orders=60", "stations.pick_s=1.0"]
    result = rmfs_core.run("paper-250", overrides=settings, out=tmp_path, record=["trace"], observers=[Watch()])
    assert result.status == "complete"
    assert validate_trace(tmp_path) == []
    assert min(later - one for one, later in pairwise(sorted(asked_ms))) == 1000


def blocked(simulation: Simulation) -> tuple[Course, int]:
    driving = simulation.driving
    assert isinstance(driving, WindowedDriving)
    first, last = driving.courses[0], driving.courses[-1]
    ahead = driving.roads.layout.neighbour(first.robot.cell, 1)
    assert ahead is not None
    driving.registered.hold(last.robot.id, ahead, 0)
    return first, ahead


def test_who_had_reserved_the_cell_of_a_refused_robot_plans_anew(tiny_run: Prepare) -> None:
    simulation = tiny_run(INSTANCE, robots=3, queue_length=1, layout=CORRIDOR, pp="whca-n").simulation
    driving, table = simulation.driving, simulation.driving.table
    first, ahead = blocked(simulation)
    second = driving.courses[1]
    table.commit(first.robot.id, occupy((first.robot.cell, 0, 100)))
    table.commit(second.robot.id, occupy((second.robot.cell, 0, FOREVER), (first.robot.cell, 500, 600)))
    assert not driving.register(first, ahead)
    assert [owner for owner, _, _ in table.reserved(first.robot.cell)] == [first.robot.id]
    assert [owner for owner, _, _ in table.reserved(second.robot.cell)] == [second.robot.id]
    assert set(driving.asking) == {first.robot.id, second.robot.id}
    sentence = driving.waits_for(first)
    assert f"waits for {CORRIDOR.where(ahead)}, which robot {driving.courses[-1].robot.name} has" in sentence


class Ghost:
    """Observer that reserves the cell ahead of a robot for the other, idle robot; the planner does not see it."""

    simulation: Simulation
    cell: int | None = None

    @rmfs_core.hookimpl
    def on_event(self, event: Event) -> None:
        if isinstance(event, events.TaskAssigned):
            driving, robot = self.simulation.driving, self.simulation.warehouse.robots[event.robot]
            location = self.simulation.warehouse.pods[event.pod].location
            self.cell = driving.ahead(Query(robot.id, robot.cell, robot.heading, 0, location))
            driving.registered.hold(1 - robot.id, self.cell, 0)


def test_who_is_refused_for_long_steps_aside(tiny_run: Prepare) -> None:
    tiny = tiny_run(small_instance({"1": ["a"]}, {"1": ["a"]}), robots=2, pp="whca-n", run=RunSection(until_s=600.0))
    ghost = Ghost()
    ghost.simulation = tiny.simulation
    tiny.simulation.rules.register_observer(ghost)
    tiny.simulation.run()
    assert len(tiny.of(events.OrderCompleted)) == 1
    moves = tiny.of(events.RobotMoved)
    assert 30_000 <= moves[0].start_tick < 33_000
    assert moves[0].distance_m == 1
    assert ghost.cell not in {move.to for move in moves}


def test_who_is_shut_in_is_not_planned_for(tiny_run: Prepare, monkeypatch: pytest.MonkeyPatch) -> None:
    simulation = tiny_run(INSTANCE, robots=2, pp="whca-n").simulation
    driving, layout, asked = simulation.driving, simulation.driving.roads.layout, []
    course, other = driving.courses[0], driving.courses[1].robot.id
    course.goal = next(cell for cell in layout.storage_locations if cell != course.robot.cell)
    beside = [cell for heading in range(4) if (cell := layout.neighbour(course.robot.cell, heading)) is not None]

    def path(robot: Robot, goal: int, traffic: Traffic, start: int, *, needed: bool) -> Any:
        assert (robot, goal, start, needed) == (course.robot, course.goal, course.robot.cell, False)
        asked.append(traffic.query.start_tick)
        return []

    monkeypatch.setattr(driving, "path", path)
    for first_from, plans in ((0, {1999: True, 2000: False, 4000: False}), (4001, {4000: True, 4001: False})):
        driving.table.release(other)
        for cell in beside:
            driving.table.hold(other, cell, first_from if cell == beside[0] else 0)
        for tick, asks in plans.items():
            asked.clear()
            simulation.warehouse.advance(tick)
            driving.plan(course)
            assert asked == [tick] * asks


def on_its_way(tiny: Any, legs: int) -> tuple[WindowedDriving, Course]:
    """Run until the first robot is on a leg with so many more to come, and return it."""
    simulation = tiny.simulation
    driving, course = simulation.driving, simulation.driving.courses[0]
    simulation.start()
    while course.under_way is None or len(course.legs) < legs:
        simulation.warehouse.advance(int(simulation.env.peek()))
        simulation.env.step()
    return driving, course


def test_a_robot_that_would_pass_its_new_goal_stops_there(tiny_run: Prepare) -> None:
    tiny = tiny_run(INSTANCE, robots=2, pp="whca-n")
    driving, course = on_its_way(tiny, legs=1)
    end, other = course.under_way[1], driving.courses[1]
    leaves = next(until for who, _, until in driving.table.reserved(end.cell) if who == course.robot.id)
    driving.table.hold(other.robot.id, end.cell, leaves)
    driving.own(course, end.cell)
    driving.plan(course)
    assert not course.legs
    assert [who for who, _, _ in driving.table.reserved(end.cell)] == [course.robot.id]
    arrived = course.arrived
    tiny.simulation.env.run(until=arrived)
    assert (course.robot.cell, tiny.simulation.env.now) == (end.cell, end.start_tick)


def test_a_robot_that_has_just_left_a_cell_has_not_arrived_there(tiny_run: Prepare) -> None:
    driving, course = on_its_way(tiny_run(INSTANCE, robots=2, pp="whca-n"), legs=1)
    driving.stop(course)
    assert next(driving.to_location(course.robot, course.robot.cell)) is course.arrived


@cases(
    "settings",
    ["robots.top_speed_m_per_s=0.001"],
    ["robots.acceleration_m_per_s2=0.001"],
    ["robots.full_turn_s=3600.0"],
    ["robots.lift_s=3600.0"],
    ["stations.pick_s=3600.0", "stations.handle_s=3600.0"],
    ['robots.available=[["06:00", "06:01"]]'],
)
@pytest.mark.parametrize("pp", ["whca-n", "free-flow"])
def test_what_takes_long_is_no_standstill(settings: list[str], pp: str) -> None:
    result = rmfs_core.run("examples/small", overrides=[*settings, f"rules.pp={pp}", "instance.orders=20"])
    assert result.status == "complete"
    assert max(row["completed_s"] for row in result.orders) > 3600


SHORTCUT = parse_map("..........\n.v........\n.→→→→→↓...\n.↓←←←←╗...\n.→→→→→→O..\n.##.##....\n..........", "shortcut")


def test_nobody_gets_ahead_of_those_ahead_in_line(tiny_run: Prepare) -> None:
    simulation = tiny_run(INSTANCE, robots=2, queue_length=3, layout=SHORTCUT, pp="whca-n").simulation
    driving, station = simulation.driving, simulation.warehouse.stations[0]
    first, second = driving.courses
    slots = (station.cell, *station.cells.queue)

    def stand(course: Course, cell: int) -> None:
        simulation.warehouse.move(course.robot, cell, 3)
        course.station = station
        driving.registered.release(course.robot.id)
        driving.registered.hold(course.robot.id, cell, 0)

    driving.lines[0] = [first, second]
    stand(second, SHORTCUT.neighbour(slots[1], NORTH))
    for place in (2, 7, 16):
        stand(first, slots[place])
        assert not driving.register(second, slots[1])
    stand(first, station.cell)
    assert driving.register(second, slots[1])


@pytest.mark.slow
def test_nobody_joins_a_line_ahead_of_one_who_came_into_the_lane_past_it() -> None:
    """At 1,624 s a robot enters by the second entrance while another, still on its way to the first, would be ahead."""
    settings = ["instance.orders=150", "instance.pods=50", "run.standstill_s=200.0", "run.until_s=2500.0"]
    assert rmfs_core.run("paper-250-integrated", overrides=settings).status == "complete"
