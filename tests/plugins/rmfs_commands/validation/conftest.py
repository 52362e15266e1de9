"""Runs to validate: a recorded one, robots on a text map that are told what to do, and a day of one order."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest
from attrs import evolve

import rmfs_core
from rmfs_commands.layouts import parse_map
from rmfs_commands.trace import read_trace
from rmfs_commands.trace.reader import Trace
from rmfs_core.events import (
    DecisionMade,
    Event,
    ItemPicked,
    OrderArrived,
    OrderAssigned,
    OrderCompleted,
    PodLifted,
    PodStored,
    QueueJoined,
    RobotMoved,
    TaskAssigned,
    TripDecided,
    VisitEnded,
    VisitStarted,
)
from rmfs_core.motion import Motion
from rmfs_core.roles import Role
from rmfs_core.world import EAST, Instance, OrderData, PodData

SMALL = (
    "instance.orders=24",
    "instance.arrivals.process=poisson",
    "instance.arrivals.orders_per_hour=300",
    "rules.pp=free-flow",
)


@pytest.fixture(scope="session")
def recorded_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recorded")
    rmfs_core.run("examples/small", overrides=SMALL, out=folder, record=["trace"])
    return folder


@pytest.fixture(scope="session")
def recorded(recorded_folder: Path) -> Trace:
    return read_trace(recorded_folder / "trace.jsonl.gz")


@pytest.fixture(scope="session")
def recorded_result(recorded_folder: Path) -> dict[str, Any]:
    content: dict[str, Any] = json.loads((recorded_folder / "result.json").read_text(encoding="utf-8"))
    return content


MOTION = Motion()


class Script:
    """A trace written by hand, in the times that the formulas give.

    Cells are (row, column), counted from 0; robots start facing east.

    Parameters
    ----------
    text
        The map.
    robots
        Where robots start.
    pods
        Where pods stand at the start.
    blocked
        Where empty pods stand.
    """

    def __init__(
        self,
        text: str,
        robots: Sequence[tuple[int, int]],
        pods: Sequence[tuple[int, int]] = (),
        blocked: Sequence[tuple[int, int]] = (),
    ) -> None:
        self.layout = parse_map(text, "map")
        self.events: list[Event] = []
        self.starts = [self.cell(*robot) for robot in robots]
        self.cells = list(self.starts)
        self.headings = [EAST] * len(robots)
        self.now = [0] * len(robots)
        self.carried: list[int | None] = [None] * len(robots)
        self.pods = [self.cell(*pod) for pod in pods]
        self.blocked = tuple(self.cell(*place) for place in blocked)
        self.instance = Instance((), (), tuple(PodData(f"P{i}", ()) for i in range(len(pods))))

    def cell(self, row: int, column: int) -> int:
        return row * self.layout.width + column

    def rest(self, robot: int, seconds: float) -> None:
        self.now[robot] += round(seconds * 1000)

    def drive(self, robot: int, row: int, column: int, wait_s: float = 0.0, **changes: Any) -> None:
        """Let a robot drive straight; ``changes`` are made to the event."""
        origin, to, start = self.cells[robot], self.cell(row, column), self.now[robot]
        across, down = to % self.layout.width - origin % self.layout.width, to // self.layout.width
        down -= origin // self.layout.width
        heading = (0 if across > 0 else 2) if across else (3 if down > 0 else 1)
        turn = MOTION.turn_ticks(self.headings[robot], heading)
        distance = abs(across) + abs(down)
        wait = round(wait_s * 1000)
        self.now[robot] += wait + turn + MOTION.run_ticks(distance)
        event = RobotMoved(
            self.now[robot], start, robot, origin, to, heading, wait, turn, distance, self.carried[robot]
        )
        self.events.append(evolve(event, **changes))
        self.cells[robot], self.headings[robot] = to, heading

    def fetch(self, robot: int, pod: int) -> None:
        if self.layout.stations:
            self.events.append(TripDecided(self.now[robot], pod, 0))
        self.events.append(TaskAssigned(self.now[robot], robot, pod))
        self.lift(robot, pod)

    def lift(self, robot: int, pod: int) -> None:
        start = self.now[robot]
        self.now[robot] += MOTION.lift_ticks
        self.carried[robot] = pod
        self.events.append(PodLifted(self.now[robot], start, robot, pod, self.cells[robot]))

    def store(self, robot: int) -> None:
        start, pod = self.now[robot], self.carried[robot]
        self.now[robot] += MOTION.lift_ticks
        self.carried[robot] = None
        self.events.append(PodStored(self.now[robot], start, robot, pod, self.cells[robot]))

    def trace(self, pp: str = "some-planner") -> Trace:
        """Return the trace; the run goes on until every robot has been at rest for long."""
        scenario: Mapping[str, Any] = {
            "rules": {"pp": pp},
            "stations": {"pick_s": 7.0, "handle_s": 13.0, "queue_length": 2, "item_capacity": 15},
        }
        stations = [
            {"name": str(i + 1), "capacity": 15, "counts_orders": False} for i in range(len(self.layout.stations))
        ]
        return Trace(
            scenario=scenario,
            layout=self.layout,
            motion=MOTION,
            instance=self.instance,
            pods=tuple({"cell": cell, "robot": None, "bound_for": ()} for cell in self.pods),
            robots=tuple({"cell": cell, "heading": EAST} for cell in self.starts),
            stations=tuple(stations),
            blocked=self.blocked,
            events=tuple(sorted(self.events, key=lambda event: event.tick)),
            tick=max((event.tick for event in self.events), default=0) + 200_000,
            status="complete",
        )


@pytest.fixture
def new_script() -> type[Script]:
    return Script


YARD = "\n".join(["........", ".>>>>>>.", "...@....", "..##.##.", "......qO", "........"])


@pytest.fixture
def day() -> Trace:
    """Trace of one order: robot 1 brings pod P0 to the station, where tea and two of jam are picked, and back.

    The robot starts in row 6, column 4; the pod stands two cells north of it, and P1 to the west of that.
    """
    script = Script(YARD, robots=[(5, 3)], pods=[(3, 3), (3, 2)])
    script.instance = Instance(
        ("tea", "jam", "rye"),
        (OrderData("A", arrival_tick=0, lines=((0, 1), (1, 2))),),
        (PodData("P0", ((0, None), (1, 5), (2, None))), PodData("P1", ((2, None),))),
    )
    script.events += [
        OrderArrived(0, 0),
        OrderAssigned(0, 0, 0, (0, 1), 3, 1, True),
        DecisionMade(0, 1, Role.POA, "by-hand", 1, 1, 0, "decided", None, None, False, 0.0),
        TripDecided(0, 0, 0),
        DecisionMade(0, 1, Role.PPS, "by-hand", 0, 0, 1, "decided", None, None, False, 0.0),
        TaskAssigned(0, 0, 0),
    ]
    script.drive(0, 3, 3)
    script.lift(0, 0)
    script.drive(0, 4, 3)
    script.drive(0, 4, 6)
    script.events.append(QueueJoined(script.now[0], 0, 0, 0))
    script.drive(0, 4, 7)
    now = script.now[0]
    script.events.append(VisitStarted(now, 1, 0, 0, 0))
    for number, sku in enumerate((0, 1, 1)):
        start = now + 13_000 * number
        script.events.append(ItemPicked(start + 7000, start, start + 13_000, 1, 0, 0, 0, sku))
    script.now[0] = now + 33_000
    script.events += [OrderCompleted(now + 33_000, 0), VisitEnded(now + 33_000, 1, 0, 0, 3, None)]
    script.drive(0, 5, 7)
    script.drive(0, 5, 3)
    script.drive(0, 3, 3)
    script.store(0)
    return evolve(script.trace(), tick=script.now[0])
