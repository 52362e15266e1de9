"""Robots, stations and chargers that fail or are maintained: when, what they finish, what rules and files tell."""

import csv
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from PIL import ImageColor

import rmfs_core
from bad_rules import write_rule
from cases import cases
from damage import assert_found, change, drop
from rmfs_commands.details.loading import load_result
from rmfs_commands.processes.events import ChargerDown, ChargerUp, RobotDown, RobotUp, StationDown, StationUp
from rmfs_commands.replay.frames import Camera, palette
from rmfs_commands.replay.reading import read_replay
from rmfs_commands.states import read_recording
from rmfs_commands.states.rebuilding import open_state
from rmfs_commands.trace import Trace, read_trace
from rmfs_commands.validation import validate_trace
from rmfs_core import hookimpl
from rmfs_core.errors import InputError, RuleError, StandstillError
from rmfs_core.events import Event, RobotSent

ROBOTS, STATIONS = "robots.failures={mtbf_h=0.1,mttr_s=60}", "stations.outages={mtbf_h=0.1,mttr_s=60}"
MAINTAINED = 'robots.maintenance={1=[["00:00","00:02"]], 2=[["00:01","00:04"],["00:06","00:07"]]}'


CHARGERS = (
    "layout.chargers=2",
    "layout.maintenance_cells=1",
    "rules.idle=charge-when-low",
    "robots.battery={capacity_wh=90, loaded_w=900, charging_w=9000, charger_outages={mtbf_h=0.05, mttr_s=90}}",
)


class Told:
    """Keeps what happens, and runs a look at each event."""

    def __init__(self, look: Callable[[Any, Event], None] = lambda *_: None) -> None:
        self.events: list[Any] = []
        self.look = look

    @hookimpl
    def run_started(self, run: Any) -> None:
        self.view = run.warehouse

    @hookimpl
    def on_event(self, event: Event) -> None:
        self.events.append(event)
        self.look(self.view, event)


TO_ANYONE = "return [TaskAssignment(0, pod.id) for pod in warehouse.waiting_pods[:1]]"
TO_BROKEN_CHARGER = """
        down = {*warehouse.travel.layout.chargers} - {*warehouse.chargers}
        return [RobotMove(robot.id, min(down)) for robot in warehouse.resting_robots[:1] if down]
"""
FOR_A_MINUTE = """
        pairs = zip(warehouse.idle_robots, warehouse.waiting_pods)
        return [TaskAssignment(robot.id, pod.id) for robot, pod in pairs if warehouse.now_s < 60]
"""
ONLY_TOGETHER = """
        able = [robot for robot in warehouse.idle_robots if robot.id == 0 and warehouse.stations[0].in_service]
        return [TaskAssignment(robot.id, pod.id) for robot, pod in zip(able, warehouse.waiting_pods)]
"""
"""It gives tasks to the first robot alone, while the first station is in service."""


@pytest.fixture
def ruled(tmp_path: Path) -> Callable[[str, str], str]:
    """Return a function that writes a rule for a key, and returns the override that takes it."""
    return lambda key, body: f"rules.{key}={tmp_path}/{write_rule(tmp_path, key, body)[2:]}"


def told(*overrides: str, name: str = "examples/small", look: Callable[[Any, Event], None] = lambda *_: None) -> Told:
    observer = Told(look)
    rmfs_core.run(name, overrides=overrides, observers=[observer])
    return observer


def test_maintenance_is_planned_and_what_is_down_takes_no_task() -> None:
    found = told(MAINTAINED).events
    downs = [(e.tick, e.robot, e.planned) for e in found if isinstance(e, RobotDown)]
    assert downs[0] == (0, 0, True)
    assert all(planned for *_, planned in downs)
    assert next((e.tick, e.robot) for e in found if isinstance(e, RobotUp)) == (120_000, 0)
    late = 'robots.maintenance={1=[["00:00","24:00"]]}'
    with pytest.raises(StandstillError, match="1 robot out of service"):
        told(late, "robots.count=1")


def test_what_fails_while_all_have_tasks_is_repaired() -> None:
    """All that fails next does so when a robot has ended its task: nothing is to happen at a time that is known."""
    events = told("robots.count=1", "robots.failures={mtbf_h=0.01,mttr_s=30}").events
    assert sum(isinstance(event, RobotUp) for event in events) > 3


HOURS = ('stations.open=[["00:00","12:00"]]', 'robots.available=[["00:00","16:00"]]')
SHIFTS = 'robots.maintenance={1=[["00:00","12:00"]], 2=[["12:00","24:00"]]}'
RESTING = ("rules.idle=rest-middle", "layout.maintenance_cells=1", "rules.move=utility")


@cases(
    "overrides",
    (ROBOTS, STATIONS),
    (ROBOTS, STATIONS, *HOURS),
    (SHIFTS,),
    (ROBOTS, 'robots.maintenance={1=[["00:00","24:00"]]}'),
    (ROBOTS, STATIONS, SHIFTS, *HOURS),
    ("robots.count=30", "robots.failures={mtbf_h=2,mttr_s=3600}", STATIONS, *HOURS),
    ("robots.failures={mtbf_h=1000,mttr_s=9}", *HOURS),
    (ROBOTS, STATIONS, *RESTING),
    (*CHARGERS, STATIONS, *HOURS),
    ("stations.outages={mtbf_h=0.001,mttr_s=3600}",),
)
def test_a_run_that_cannot_go_on_ends_soon(overrides: tuple[str, ...], ruled: Callable[[str, str], str]) -> None:
    """Hours, maintenance and outages wake nobody who could do anything: the same error as without them, in days."""
    with pytest.raises(StandstillError, match=r"The run stands still at .*asked last: .*bad\.py:Bad") as found:
        told(*overrides, ruled("ta", FOR_A_MINUTE), "run.until_s=1000000")
    assert float(str(found.value).split()[5]) < 3 * 86_400


def test_a_run_waits_for_the_part_of_the_day_in_which_it_goes_on() -> None:
    """On each day the robot is in service and the station open together for 15 minutes only, and both fail."""
    day = ('robots.maintenance={1=[["12:15","12:00"]]}', 'stations.open={1=[["12:00","13:00"]], 2=[]}')
    often = ("robots.failures={mtbf_h=0.2,mttr_s=600}", "stations.outages={mtbf_h=0.2,mttr_s=600}", "robots.count=1")
    result = rmfs_core.run("examples/small", overrides=[*day, *often, "instance.orders=30"])
    assert result.status == "complete"
    assert result.metrics["simulated_s"] > 86_400


def test_a_run_waits_for_a_robot_and_a_station_that_are_seldom_in_service_together(ruled) -> None:
    seldom = ("robots.failures={mtbf_h=0.005,mttr_s=1800}", "stations.outages={mtbf_h=0.005,mttr_s=1800}")
    over = [*seldom, ruled("ta", ONLY_TOGETHER), "instance.orders=8"]
    result = rmfs_core.run("examples/small", overrides=over)
    assert result.status == "complete"
    assert result.metrics["simulated_s"] > 86_400


def test_all_rules_meet_the_same_failures_and_see_them_only_when_they_happen() -> None:
    """A robot that never has a task fails at the same times under other rules; ``in_service`` follows the events."""
    down: set[tuple[str, int]] = set()

    def look(view: Any, event: Event) -> None:
        match event:
            case RobotDown() | StationDown():
                kind = "robot" if isinstance(event, RobotDown) else "station"
                down.add((kind, getattr(event, kind)))
            case RobotUp() | StationUp():
                kind = "robot" if isinstance(event, RobotUp) else "station"
                down.discard((kind, getattr(event, kind)))
        now = {("robot", one.id) for one in view.robots if not one.in_service}
        assert now | {("station", one.id) for one in view.stations if not one.in_service} == down
        assert not {robot.id for robot in (*view.idle_robots, *view.resting_robots)} & {n for k, n in now}
        assert not any(one.open or one.free_capacity for one in view.stations if not one.in_service)

    found = []
    for rule in ("pod-match", "first-come"):
        down.clear()
        events = told(ROBOTS, STATIONS, f"rules.poa={rule}", look=look).events
        found.append([(e.tick, e.station) for e in events if isinstance(e, StationDown | StationUp)])
    least = min(map(len, found))
    assert least >= 4
    assert found[0][:least] == found[1][:least]


@cases(
    "overrides key body sentence",
    (['robots.maintenance={1=[["00:00","01:00"]]}'], "ta", TO_ANYONE, "to robot 1 .*, which is out of service"),
    (CHARGERS, "idle", TO_BROKEN_CHARGER, "a charger that is out of service"),
)
def test_what_is_out_of_service_is_no_decision(overrides, key, body, sentence, ruled) -> None:
    with pytest.raises(RuleError, match=sentence):
        rmfs_core.run("examples/small", overrides=[*overrides, ruled(key, body)])


@cases(
    "override sentence",
    ("robots.failures={mtbf_h=0,mttr_s=1}", "robots.failures.mtbf_h: expected a number from 0.001 to 1e+06"),
    ("robots.failures={mtbf_h=1}", "robots.failures.mttr_s: this part is missing"),
    ("stations.outages={mtbf_h=1,mttr_s=1,where='anywhere'}", "stations.outages.where: unknown key"),
    ('robots.maintenance={9=[["00:00","00:01"]]}', "robots.maintenance.9: no robot 9; expected 1 to 4"),
    ('robots.maintenance={1=[["00:00"]]}', ": expected spans of two times of the day"),
    ("robots.failures={mtbf_h=1,mttr_s=1,where='anywhere'}", "where: unknown key; what fails ends its task first"),
    ("robots.battery.charger_outages={mtbf_h=1,mttr_s=0}", "charger_outages.mttr_s: expected a number from 0.001"),
    ("layout.maintenance_cells=999", "layout.maintenance_cells=999: found 999; expected fewer than the"),
    ("layout.maintenance_cells=0", "layout.maintenance_cells=0: expected"),
)
def test_wrong_failures_are_said(override: str, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence.replace("+", r"\+").replace(".", r"\.")):
        rmfs_core.run("examples/small", overrides=[override])


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("run")
    rmfs_core.run("examples/small", overrides=[ROBOTS, STATIONS, MAINTAINED], out=folder, record=["trace", "decisions"])
    return folder


def test_tables_and_metrics_tell_of_it(run: Path) -> None:
    assert validate_trace(run) == []
    result = json.loads((run / "result.json").read_text())
    trace = read_trace(run / "trace.jsonl.gz")
    down = [event for event in trace.events if isinstance(event, RobotDown)]
    assert result["metrics"]["robot_failures"] == sum(not event.planned for event in down) > 0
    with (run / "robots.csv").open() as file:
        seconds = [float(row["down_s"]) for row in csv.DictReader(file)]
    share = 100 * sum(seconds) / 4 / result["metrics"]["simulated_s"]
    assert result["metrics"]["robots_down_percent"] == pytest.approx(share)
    with (run / "hours.csv").open() as file:
        assert {"robots_down", "stations_down"} <= next(csv.DictReader(file)).keys()
    assert "orders waited for them; " in result["summary"]["outages"]


@pytest.mark.parametrize("how", [ROBOTS, MAINTAINED])
def test_the_way_to_a_maintenance_cell_is_part_of_a_robots_time(tmp_path: Path, how: str) -> None:
    given = [how, "layout.maintenance_cells=1"]
    result = rmfs_core.run("examples/small", overrides=given, out=tmp_path, record=["trace"])
    with (tmp_path / "robots.csv").open() as file:
        rows = [{key: float(value) for key, value in row.items() if key.endswith("_s")} for row in csv.DictReader(file)]
    assert [sum(row.values()) for row in rows] == pytest.approx([result.metrics["simulated_s"]] * 4)
    assert sum(row["to_rest_s"] for row in rows) > 0 < result.metrics["resting_distance_m"]
    assert validate_trace(tmp_path) == []


def test_who_charges_where_a_charger_fails_goes_on_or_waits() -> None:
    sent, low = list[tuple[int, bool]](), set[int]()

    def look(view: Any, event: Event) -> None:
        if isinstance(event, ChargerDown | ChargerUp):
            assert (event.cell in view.chargers) is isinstance(event, ChargerUp)
        if isinstance(event, ChargerDown):
            assert event.cell not in view.free_rest_cells
            low.update(robot.id for robot in view.robots if robot.cell == event.cell and robot.low)
        if isinstance(event, RobotSent) and event.cell in view.travel.layout.chargers:
            assert event.cell in view.chargers
            sent.append((event.robot, view.robots[event.robot].cell == event.cell))

    told(*CHARGERS, look=look)
    assert any(stays for _, stays in sent)
    assert any(robot in low for robot, stays in sent if not stays)


def test_a_robot_is_repaired_in_a_maintenance_cell_if_one_is_free() -> None:
    downs = []

    def look(view: Any, event: Event) -> None:
        if isinstance(event, RobotDown):
            (cell,) = view.travel.layout.maintenance
            others = {robot.cell for robot in view.robots if robot.id != event.robot}
            others |= {robot.goal for robot in view.robots if robot.id != event.robot}
            downs.append((view.robots[event.robot].cell == cell, cell in others))

    told(ROBOTS, "layout.maintenance_cells=1", look=look)
    assert {(True, False), (False, True)} == set(downs)


def test_pictures_mark_what_is_out_of_service(charged: Path) -> None:
    """A line in a colour of its own crosses robots and chargers that are down, and nothing before one is."""
    camera, events = Camera(read_replay(charged), 600), read_trace(charged / "trace.jsonl.gz").events
    line = ImageColor.getrgb(palette()["wait"])

    def marked(tick: int) -> bool:
        return any(colour == line for _, colour in camera.take(tick).getcolors(1 << 20) or ())

    down = {kind: next(e.tick for e in events if isinstance(e, kind)) for kind in (ChargerDown, RobotDown)}
    assert not marked(min(down.values()) - 1)
    for tick in sorted(down.values()):
        assert marked(tick)


@pytest.fixture(scope="module")
def charged(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run whose chargers and robots fail, its trace and its decisions."""
    folder = tmp_path_factory.mktemp("charged")
    rmfs_core.run("examples/small", overrides=[ROBOTS, *CHARGERS], out=folder, record=["trace", "decisions"])
    return folder


def test_times_of_robots_that_wait_for_a_charger_add_up(charged: Path) -> None:
    assert validate_trace(charged) == []
    result = load_result(charged)
    assert result.metrics["charger_failures"]
    assert "Chargers failed" in result.summary["outages"]
    assert "chargers_down" in (charged / "hours.csv").read_text().splitlines()[0]
    with (charged / "robots.csv").open() as file:
        rows = [{name: float(text) for name, text in row.items()} for row in csv.DictReader(file)]
    assert min(row["idle_s"] for row in rows) >= 0
    whole = sum(seconds for row in rows for name, seconds in row.items() if name.endswith("_s"))
    low = sum(row["low_s"] for row in rows)
    assert whole == pytest.approx(len(rows) * result.metrics["simulated_s"])
    assert low > 0
    assert 100 * low / whole == pytest.approx(result.summary["bottleneck"]["robots_percent"]["low"], abs=0.01)


@cases(
    "of damage kind",
    ("charged", drop(ChargerDown), "outage"),
    ("charged", drop(ChargerUp), "outage"),
    ("charged", change(ChargerUp, lambda t, e: {"tick": e.tick + 1}), "outage"),
    ("charged", change(ChargerDown, lambda t, e: {"cell": 0}), "outage"),
    ("charged", change(RobotSent, lambda t, e: {"cell": t.layout.maintenance[0]}), "outage"),
    ("run", drop(RobotDown), "outage"),
    ("run", drop(RobotUp), "out-of-service"),
    ("run", drop(StationDown), "outage"),
    ("run", drop(StationUp), "out-of-service"),
    ("run", change(RobotDown, lambda t, e: {"planned": not e.planned}), "outage"),
    ("run", change(RobotUp, lambda t, e: {"tick": e.tick + 1}), "outage"),
    ("run", change(StationUp, lambda t, e: {"tick": e.tick + 1}), "outage"),
)
def test_the_validator_draws_for_itself(of: str, damage: Callable[[Trace], Trace], kind: str, request: Any) -> None:
    assert_found(damage(read_trace(request.getfixturevalue(of) / "trace.jsonl.gz")), kind)


@pytest.mark.parametrize("of", ["run", "charged"])
def test_decision_states_keep_what_is_down(of: str, request: Any) -> None:
    seen = {"robots": 0, "chargers": 0}
    for recorded in list(read_recording(request.getfixturevalue(of)))[::5]:
        state = recorded.state()
        down = [name for name, robot in (state.robots or {}).items() if not robot.in_service]
        view = open_state(state).view
        assert [robot.name for robot in view.robots if not robot.in_service] == down
        assert {*state.chargers_down} == {*view.travel.layout.chargers} - {*view.chargers}
        seen = {"robots": seen["robots"] + len(down), "chargers": seen["chargers"] + len(state.chargers_down)}
    assert seen["robots"]
    assert bool(seen["chargers"]) is (of == "charged")
