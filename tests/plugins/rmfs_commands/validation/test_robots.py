"""Faults of robots: how they drive, meet, rest, come and go."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from attrs import evolve

import rmfs_core
from damage import Damage, assert_found, change, drop, find, put, repeat, told
from rmfs_commands.trace import Trace, read_trace
from rmfs_commands.validation import faults_of, validate_trace
from rmfs_commands.validation.collisions import reached_s
from rmfs_core.events import (
    Event,
    OrderAssigned,
    PodMoveDecided,
    RobotMoved,
    RobotRested,
    RobotSent,
    RobotsOnDuty,
    StationClosed,
    StationOpened,
    TaskAssigned,
    TripDecided,
)
from rmfs_core.motion import Motion

ONE_WAY = "\n".join(["........", ".>>>>>>.", "...@....", "..##.##.", "......qO", "........"])


def kinds(script: Any) -> list[str]:
    return [fault.kind for fault in faults_of(script.trace())]


UNDER_PODS = ((3, 0), (3, 3), "lift")
"""To the pod under the other one, and lift it."""
MISTAKES: list[tuple[str, str, tuple[Any, ...]]] = [
    ("along no row and no column", "not-straight", ((0, 3), (2, 5))),
    ("a one-way aisle the wrong way", "one-way", ((1, 0), (1, 4), (1, 2))),
    ("through a wall", "wall", ((2, 0), (2, 5))),
    ("a pod through another one's storage location", "through-stored-pod", (*UNDER_PODS, (3, 0))),
    ("a pod across free storage locations", "storage-crossed", (*UNDER_PODS, (4, 3), (4, 4), (3, 4), (3, 7))),
    ("a pod to a free storage location and on again", "storage-crossed", (*UNDER_PODS, (3, 5), (3, 4))),
    ("into a queue without a pod", "queue-lane", ((4, 0), (4, 6))),
    ("a pod through a queue and past the station", "queue-lane", (*UNDER_PODS, (4, 3), (4, 7), (5, 7))),
    ("four cells in 3 s", "too-fast", ((0, 4, {"tick": 3000}),)),
    ("four cells in 9 s", "too-slow", ((0, 4, {"tick": 9000}),)),
    ("sideways", "heading", ((3, 0, {"heading": 0, "turn_ticks": 0, "tick": Motion().run_ticks(3)}),)),
    ("a turn in no time", "turn-time", ((3, 0, {"turn_ticks": 0, "tick": Motion().run_ticks(3)}),)),
    ("a run that begins before the last one has ended", "time-overlap", ((0, 7), "early", (3, 7))),
    ("a run that begins two cells off", "teleport", ((0, 4), "jump", (0, 7))),
    ("more metres than there are", "distance", ((0, 4, {"distance_m": 5}),)),
    ("a wait of less than no time", "negative-time", ((0, 4, {"wait_s": -1}),)),
]


def drive(script: Any, steps: tuple[Any, ...]) -> None:
    """Let the robot drive to cells, a step each, with changes to the event; or lift a pod, begin early, jump."""
    for step in steps:
        match step:
            case "lift":
                script.fetch(0, 0)
            case "early":
                script.rest(0, -1)
            case "jump":
                script.cells[0] += 2
            case row, column, *changes:
                script.drive(0, row, column, **(changes[0] if changes else {}))


@pytest.mark.parametrize(("kind", "steps"), [row[1:] for row in MISTAKES], ids=[row[0] for row in MISTAKES])
def test_each_mistake_is_found_alone(new_script: Any, kind: str, steps: tuple[Any, ...]) -> None:
    """A single mistake in a hand-written trace is that one kind of fault, and the robot is named."""
    script = new_script(ONE_WAY, robots=[(0, 0)], pods=[(3, 3), (3, 2)])
    drive(script, steps)
    faults = faults_of(script.trace())
    assert {fault.kind for fault in faults} == {kind}
    assert all("robot 1" in fault.sentence for fault in faults)


def test_a_pod_may_be_carried_from_its_start_to_its_goal(new_script: Any) -> None:
    script = new_script(ONE_WAY, robots=[(0, 0)], pods=[(3, 3), (3, 2)], blocked=[(3, 6)])
    drive(script, UNDER_PODS)
    script.drive(0, 4, 3)
    script.drive(0, 4, 5, wait_s=1)
    script.drive(0, 3, 5)
    script.store(0)
    script.drive(0, 3, 6)
    assert kinds(script) == []


HALL = "........\n" * 5
REACHED_S = reached_s(Motion(), 3, 1)
"""When the first cell of three is reached."""
MEETINGS: list[tuple[str, list[tuple[int, int]], tuple[tuple[int, int, int, float], ...], list[str]]] = [
    ("one after the other", [(0, 1), (0, 0)], ((0, 0, 7, 0), (1, 0, 5, 2)), []),
    ("into a cell as soon as the next one is reached", [(0, 3), (0, 2)], ((0, 0, 6, 0), (1, 0, 3, REACHED_S)), []),
    ("10 ms earlier", [(0, 3), (0, 2)], ((0, 0, 6, 0), (1, 0, 3, REACHED_S - 0.01)), ["collision"]),
    ("into a robot at rest", [(0, 0), (0, 5)], ((0, 0, 7, 0), (1, 4, 5, 30)), ["collision"]),
    ("ways that cross at once", [(2, 1), (0, 3)], ((0, 2, 6, 0), (1, 4, 3, 0)), ["collision"]),
    ("ways that cross one after the other", [(2, 1), (0, 3)], ((0, 2, 6, 0), (1, 4, 3, 10)), []),
    ("side by side in one cell for long", [(0, 0), (0, 0)], ((0, 0, 7, 0), (1, 0, 7, 0)), ["collision"]),
    (
        "two meetings",
        [(0, 0), (0, 4)],
        ((0, 0, 7, 0), (1, 4, 4, 10), (0, 0, 0, 20), (1, 0, 4, 60), (0, 0, 7, 90)),
        ["collision"] * 2,
    ),
    # where an idle robot rests is known for as long as it can be on its way to a parking place, not at the end
    ("into a robot without a task", [(0, 0), (0, 5)], ((0, 0, 7, 0),), ["collision"]),
    ("to where a robot without a task may have parked", [(0, 0), (4, 5)], ((0, 0, 7, 0),), []),
]


@pytest.mark.parametrize("waits", [True, False], ids=["waits", "rests"])
@pytest.mark.parametrize(
    ("robots", "drives", "expected"), [row[1:] for row in MEETINGS], ids=[row[0] for row in MEETINGS]
)
def test_robots_that_hold_a_cell_at_once_collide(new_script, waits, robots, drives, expected) -> None:
    script = new_script(HALL, robots=robots)
    for robot, row, column, wait_s in drives:
        script.rest(robot, 0 if waits else wait_s)
        script.drive(robot, row, column, wait_s=wait_s if waits else 0)
    assert kinds(script) == expected
    assert all(fault.sentence.startswith("robot 1 and robot 2 both hold row") for fault in faults_of(script.trace()))


def test_driving_through_each_other_is_a_swap(new_script: Any) -> None:
    script = new_script(HALL, robots=[(0, 0), (0, 7)])
    script.headings[1] = 0
    script.drive(0, 0, 7)
    script.drive(1, 0, 0)
    assert kinds(script) == ["swap"]


@pytest.mark.parametrize("metres", [1, 2, 3, 7, 20])
def test_points_are_reached_when_the_formulas_say(metres: int) -> None:
    motion = Motion()
    for at in range(metres + 1):
        assert motion.position_m(metres, reached_s(motion, metres, at)) == pytest.approx(at)


OVERRIDES = (
    "instance.orders=12",
    "instance.arrivals={process='poisson', orders_per_hour=150}",
    "rules.idle=rest-middle",
    "robots.count=3",
)


@pytest.fixture(scope="module")
def resting(tmp_path_factory: pytest.TempPathFactory) -> Trace:
    folder = tmp_path_factory.mktemp("resting")
    rmfs_core.run("examples/small", overrides=OVERRIDES, out=folder, record=["trace"])
    return read_trace(Path(folder) / "trace.jsonl.gz")


def kinds_with(resting: Trace, kind: type[Event], change: Callable[[Event], Event | None]) -> set[str]:
    """Return the faults of a trace whose first event of a kind is another one, or missing."""
    events = list(resting.events)
    at = next(i for i, event in enumerate(events) if isinstance(event, kind))
    changed = change(events[at])
    events[at : at + 1] = [] if changed is None else [changed]
    return {fault.kind for fault in faults_of(evolve(resting, events=tuple(events)))}


def test_robots_rest_where_and_when_they_may(resting: Trace) -> None:
    assert any(isinstance(event, RobotRested) for event in resting.events)
    assert faults_of(resting) == []
    assert "rested" in kinds_with(resting, RobotSent, lambda _: None)
    assert "rested" in kinds_with(
        resting, RobotRested, lambda event: evolve(event, cell=resting.layout.storage_locations[0])
    )
    busy = 0
    for at, event in enumerate(resting.events):
        if isinstance(event, RobotRested):
            events = (*resting.events[:at], *resting.events[at + 1 :])
            busy += any(fault.kind == "robot-busy" for fault in faults_of(evolve(resting, events=events)))
    assert busy


def test_where_nobody_may_rest(resting: Trace) -> None:
    floor = next(cell for cell in range(len(resting.layout.kind)) if resting.layout.kind[cell] == 1)
    assert "no-rest" in kinds_with(resting, RobotSent, lambda event: evolve(event, cell=floor))
    sent = next(event for event in resting.events if isinstance(event, RobotSent))
    others = {i: robot["cell"] for i, robot in enumerate(resting.robots) if i != sent.robot}
    for event in resting.events[: resting.events.index(sent)]:
        if isinstance(event, RobotMoved) and event.robot != sent.robot:
            others[event.robot] = event.to
    taken = next(cell for cell in others.values() if resting.layout.kind[cell] == 2)
    assert "no-rest" in kinds_with(resting, RobotSent, lambda event: evolve(event, cell=taken))


def test_a_pod_that_is_carried_elsewhere_stands_where_it_was_to(tmp_path: Path) -> None:
    overrides = (*OVERRIDES, "rules.move=utility")
    rmfs_core.run("examples/small", overrides=overrides, out=tmp_path, record=["trace"])
    resting = read_trace(tmp_path / "trace.jsonl.gz")
    assert faults_of(resting) == []
    events = list(resting.events)
    decided = next(event for event in events if isinstance(event, PodMoveDecided))
    bound = events.copy()
    bound.insert(events.index(decided), TripDecided(tick=decided.tick, pod=decided.pod, station=0))
    assert "moved-bound" in {fault.kind for fault in faults_of(evolve(resting, events=tuple(bound)))}
    others = (cell for cell in resting.layout.storage_locations if cell != decided.cell)
    assert any(
        "moved-elsewhere" in kinds_with(resting, PodMoveDecided, lambda event, to=other: evolve(event, cell=to))  # type: ignore[misc]
        for other in others
    )


HOURS = (
    "instance.orders=24",
    "instance.arrivals={process='poisson', orders_per_hour=300}",
    "rules.pp=free-flow",
    'stations.open={1 = [["00:00", "00:02"]], 2 = [["00:01", "24:00"]]}',
    'robots.available=[["00:00", "00:03"], ["00:03", "24:00", 1]]',
)
BY_LOAD = "rules.activate={rule='backlog-threshold', open_above=2, timeout_s=60}"

Recorded = Callable[[bool], Trace]


@pytest.fixture(scope="module")
def with_hours(tmp_path_factory: pytest.TempPathFactory) -> Recorded:
    """Return what gives the trace of a run with opening hours, with or without an activation rule, once each."""
    made: dict[bool, Trace] = {}

    def trace(by_load: bool) -> Trace:
        if by_load not in made:
            out: Path = tmp_path_factory.mktemp("hours")
            rmfs_core.run(
                "examples/small", overrides=[*HOURS, *([BY_LOAD] if by_load else [])], out=out, record=["trace"]
            )
            assert validate_trace(out) == []
            made[by_load] = read_trace(out / "trace.jsonl.gz")
        return made[by_load]

    return trace


def to_closed(trace: Trace) -> Trace:
    at = find(trace, OrderAssigned, number=99)
    return put(trace, at, evolve(trace.events[at], station=0))  # type: ignore[call-arg]


def to_who_left(trace: Trace) -> Trace:
    at = find(trace, TaskAssigned, number=99)
    return put(trace, at, evolve(trace.events[at], robot=1))  # type: ignore[call-arg]


def later(trace: Trace, event: Any) -> dict[str, Any]:
    return {"tick": event.tick + 1000}


HOURS_DAMAGED: list[tuple[str, Damage, str]] = [
    ("an order for a closed station", to_closed, "station-closed"),
    ("a task for a robot off duty", to_who_left, "off-duty"),
    ("an opening left out", drop(StationOpened), "station-hours"),
    ("a closing left out", drop(StationClosed), "station-hours"),
    ("an opening twice", repeat(StationOpened), "station-hours"),
    ("a closing twice", repeat(StationClosed), "station-hours"),
    ("an opening too late", change(StationOpened, later), "station-hours"),
    ("a closing too late", change(StationClosed, later), "station-hours"),
    ("robots that stay", drop(RobotsOnDuty), "robot-hours"),
    ("robots told of twice", repeat(RobotsOnDuty), "robot-hours"),
    ("another number of robots", change(RobotsOnDuty, lambda t, e: {"number": 0}), "robot-hours"),
    ("robots that leave too late", change(RobotsOnDuty, later), "robot-hours"),
]


@pytest.mark.parametrize(("damage", "kind"), [row[1:] for row in HOURS_DAMAGED], ids=[row[0] for row in HOURS_DAMAGED])
def test_damage_to_the_hours_is_found(with_hours: Recorded, damage: Damage, kind: str) -> None:
    assert_found(damage(with_hours(False)), kind)


def test_hours_and_rules_that_close(with_hours: Recorded) -> None:
    trace = with_hours(True)
    closed = StationClosed(trace.tick, 1)
    at = len(trace.events)
    assert not any("station-hours" in fault for fault in told(put(trace, at, closed, instead_of=0)))
    opened = StationOpened(trace.tick, 0)
    sentence = "station-hours: station 1 opens, which `stations.open` does not say"
    assert sentence in told(put(trace, at, opened, instead_of=0))
    trace = with_hours(False)
    scenario = {**trace.scenario, "stations": {k: v for k, v in trace.scenario["stations"].items() if k != "open"}}
    scenario["robots"] = {k: v for k, v in trace.scenario["robots"].items() if k != "available"}
    faults = told(evolve(trace, scenario=scenario))
    assert "station-hours: station 2 closes, which `stations.open` does not say" in faults
    assert "robot-hours: robots on duty from now on: 1; the scenario says 4" in faults
