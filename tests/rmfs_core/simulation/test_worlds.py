"""Invariants of every run, whatever rules and worlds, and that none stands still."""

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from attrs import evolve
from hypothesis import HealthCheck, assume, given, reject, settings
from hypothesis import strategies as st

from rmfs_commands.layouts import block_map, parse_map
from rmfs_commands.layouts.textmap import FLOOR_MOVES, FLOOR_SIGN, QUEUE_MOVES, QUEUE_SIGN
from rmfs_commands.processes.battery import battery_of
from rmfs_commands.testing import validate_trace
from rmfs_commands.trace import TraceWriter
from rmfs_core import hookimpl
from rmfs_core.errors import InputError, StandstillError
from rmfs_core.events import Event, QueueJoined
from rmfs_core.rules import RuleSet
from rmfs_core.scenario import RuleChoice, Scenario, model
from rmfs_core.scenario.service import ServiceTime, Spread
from rmfs_core.simulation.engine import Simulation
from rmfs_core.simulation.setup import Opening, motion_of, open_warehouse
from rmfs_core.world import CellKind, Instance, Layout, check_layout, make_instance
from rmfs_core.world.travel import travel_on
from rmfs_traffic.reserved import ReservedDriving

ONE_WAY = "".join(FLOOR_MOVES).replace(".", "")
RESTLESS, FIRST_FREE = (
    RuleChoice(f"{Path(__file__).resolve().parents[2]}/helpers/restless.py:{name}")
    for name in ("Restless", "FirstFree")
)
ANYTHING_GOES = {"deadline": None, "suppress_health_check": list(HealthCheck)}


@st.composite
def layouts(
    draw: st.DrawFn, queue_length: int, queue: str = "plain", max_stations: int = 8
) -> tuple[model.LayoutSection, Layout]:
    """Block layouts with 1 to 8 stations; their aisles one-way, two-way, or some of either.

    Where queues have shortcuts, they have some more than those of the block layout.
    """
    stations = draw(st.integers(1, max_stations))
    west = draw(st.integers(0, stations))
    section = model.LayoutSection(
        block_rows=2 * max(west, stations - west) + 1 + draw(st.integers(0, 2)),
        block_columns=draw(st.integers(1, 4)),
        block_length=draw(st.integers(1, 4)),
        hall_width=draw(st.integers(1, 2)),
        stations_east=stations - west,
        stations_west=west,
        queue=queue,
        pod_fill=draw(st.floats(0.05, 0.97)),
    )
    signs = block_map(section, queue_length)
    two_way = draw(st.sampled_from(["none", "all", "some"]))
    if two_way == "all":
        signs = "".join("." if sign in ONE_WAY else sign for sign in signs)
    elif two_way == "some":
        chosen = draw(st.lists(st.integers(0, len(signs) - 1), max_size=len(signs) // 3))
        signs = "".join("." if i in chosen and sign in ONE_WAY else sign for i, sign in enumerate(signs))
    if queue == "shortcut":
        signs = draw(more_ways(signs))
    layout = parse_map(signs, "drawn")
    try:
        check_layout(layout, "drawn")
    except InputError:
        reject()
    return section, layout


@st.composite
def more_ways(draw: st.DrawFn, text: str) -> str:
    """Add shortcuts and entrances to the queues of a map, wherever there may be one."""
    layout = parse_map(text, "drawn")
    signs = list(text.replace("\n", ""))
    for own in layout.stations:
        slots = (own.station, *own.queue)
        for place, cell in enumerate(slots):
            for heading in range(4):
                before = layout.neighbour(cell, (heading + 2) % 4)
                if before is None or draw(st.integers(0, 2)):
                    continue
                if before in slots[place + 2 :]:
                    moves = QUEUE_MOVES[signs[before]] | 1 << heading
                    signs[before] = QUEUE_SIGN.get(moves, signs[before])
                elif cell != own.station:
                    moves = FLOOR_MOVES.get(signs[before], 0) | 1 << heading
                    signs[before] = FLOOR_SIGN[moves] if signs[before] in ONE_WAY else signs[before]
    width = layout.width
    return "\n".join("".join(signs[i : i + width]) for i in range(0, len(signs), width))


Attack = tuple[Scenario, Instance, Layout]


@st.composite
def attacks(draw: st.DrawFn, max_robots: int, queue: str = "plain") -> Attack:
    """Any shipped rules but for PP, 1 to ``max_robots`` robots, more work than the stations have places for.

    Orders are there at first or come later, stock is finite or not, stations count items or orders.
    Where queues have shortcuts, they are long, and a few stations have many visits of short picks.
    """
    busy = queue == "shortcut"

    def choose(*names: str) -> RuleChoice:
        return RuleChoice(draw(st.sampled_from(names)))

    queue_length = draw(st.integers(5 if busy else 1, 12))
    section, layout = draw(layouts(queue_length, queue, 2 if busy else 8))
    locations = len(layout.storage_locations)
    pods = draw(st.integers(min(8, locations // 2) if busy else 2, max(2, min(40, int(0.97 * locations)))))
    assume(pods < locations)
    deciders = (
        {"poa_pps": choose("integrated", "split-among-stations", "split-over-time")}
        if draw(st.integers(0, 3)) == 0
        else {
            "poa": choose("pod-match", "common-lines", "first-come", "near-best-pod", "station-queue"),
            "pps": choose("demand", "nearest-pod", "completes", "random"),
        }
    )
    scenario = Scenario(
        rules=model.RulesSection(
            **deciders,
            pr=choose("nearest", "fixed", "random", "turnover-classes", "cache", "utility"),
            ta=choose("nearest-robot", "balanced", "assignment"),
        ),
        seed=draw(st.integers(0, 1000)),
        instance=model.InstanceSection(
            orders=draw(st.integers(20 if busy else 1, 25)),
            skus=draw(st.integers(8 if busy else 2, 8)),
            pods=pods,
            skus_per_pod=2,
            max_lines=3,
            items_per_sku=draw(st.sampled_from([None, 40])),
            arrivals=draw(st.sampled_from([model.Arrivals(), model.Arrivals("poisson", 600.0)])),
        ),
        layout=section,
        robots=model.RobotsSection(
            count=min(draw(st.integers(max_robots // 2 if busy else 1, max_robots)), locations - 1),
            full_turn_s=draw(st.sampled_from([2.5, 0.9])),
            acceleration_m_per_s2=draw(st.sampled_from([1.0, 0.6])),
        ),
        stations=model.StationsSection(
            item_capacity=draw(st.integers(3, 15)),
            order_capacity=draw(st.none() | st.integers(1, 4)),
            queue_length=queue_length,
            pick_s=draw(st.sampled_from([0.5, 7.0, ServiceTime(Spread(mean=3.0, cv=1.0))])),
            handle_s=draw(st.sampled_from([7.0, 13.0, ServiceTime(Spread(mean=9.0, distribution="exponential"))])),
            line_s=draw(st.sampled_from([None, 2.0])),
        ),
        run=model.RunSection(until_s=1_000_000.0),
    )
    try:
        return scenario, make_instance(scenario), layout
    except InputError:  # more is ordered than there is
        reject()


@st.composite
def outages(draw: st.DrawFn) -> tuple[dict[str, Any], dict[str, Any]]:
    """Failures of robots and stations from once in a minute on, maintenance, lifts and shifts: keys of two sections."""

    def failures() -> model.FailuresSection | None:
        often, long = draw(st.sampled_from([0.01, 0.1, 1.0])), draw(st.sampled_from([1.0, 60.0, 3600.0]))
        return model.FailuresSection(often, long) if draw(st.booleans()) else None

    spans = (("00:00", "00:05"), ("00:07", "00:10"))
    shifts = {"1": (("00:00", "00:04", 0.5), ("00:02", "00:20", 2.0))}
    robots = {"failures": failures(), "maintenance": draw(st.sampled_from([None, {"1": spans}]))}
    robots["lift_s"] = draw(st.sampled_from([2.2, ServiceTime(Spread(mean=3.0, cv=1.0))]))
    return robots, {"outages": failures(), "speed": draw(st.sampled_from([{}, shifts]))}


class LinesInOrder:
    """Observer that holds the lines of the driving against those at the stations."""

    def __init__(self, simulation: Simulation) -> None:
        self.simulation = simulation

    @hookimpl
    def on_event(self, event: Event) -> None:
        driving = self.simulation.driving
        if isinstance(event, QueueJoined) and isinstance(driving, ReservedDriving):
            for station in self.simulation.warehouse.stations:
                joined = [course.robot for course in driving.lines[station.id] if course.joined]
                assert joined == [robot for robot in station.line if robot in joined]


def completes(scenario: Scenario, instance: Instance, layout: Layout) -> None:
    """Run to the end; every order is complete, and no two robots ever had one cell."""
    rules = RuleSet.load(scenario.rules, ".")
    with tempfile.TemporaryDirectory() as folder:
        trace = TraceWriter()
        rules.register_observer(trace)
        simulation = Simulation(scenario, instance, layout, rules, Path(folder))
        rules.register_observer(LinesInOrder(simulation))
        simulation.run()
        rules.pm.hook.run_ended(tick=simulation.now, status=simulation.status)
        assert simulation.status == "complete"
        faults = validate_trace(Path(folder))
        assert [str(fault) for fault in faults if fault.kind != "header"] == []  # the layout is not the scenario's


def under(pp: str, attack: Attack) -> Attack:
    scenario, *rest = attack
    return evolve(scenario, rules=evolve(scenario.rules, pp=RuleChoice(pp))), *rest


def completes_under(pp: str, attack: Attack) -> None:
    """Run to the end; under `whca-n` a run may also end with the error that says who waits for whom."""
    scenario, instance, layout = under(pp, attack)
    try:
        completes(evolve(scenario, run=evolve(scenario.run, standstill_s=600.0)), instance, layout)
    except StandstillError as error:
        assert pp == "whca-n"
        assert " waits for row " in str(error)


@given(attack=attacks(max_robots=12), pp=st.sampled_from(["sipp", "pbs", "whca-n"]))
@settings(max_examples=90, **ANYTHING_GOES)
def test_small_fleets(attack: Attack, pp: str) -> None:
    completes_under(pp, attack)


@pytest.mark.slow
@given(attack=attacks(max_robots=60))
@settings(max_examples=100, **ANYTHING_GOES)
def test_large_fleets_that_plan_together(attack: Attack) -> None:
    completes(*under("pbs", attack))


@given(attack=attacks(max_robots=8, queue="shortcut"))
@settings(max_examples=12, **ANYTHING_GOES)
def test_queues_with_shortcuts(attack: Attack) -> None:
    for pp in ("sipp", "whca-n", "pbs"):
        completes(*under(pp, attack))


def completes_from_anywhere(attack: Attack, seed: int) -> None:
    """Run to the end with robots that begin in cells drawn from all but the walls."""
    layout = attack[2]
    cells = np.random.default_rng(seed).permutation(np.flatnonzero(layout.kind != CellKind.WALL))

    def opened(scenario: Scenario, instance: Instance, layout: Layout) -> Opening:
        opening = open_warehouse(scenario, instance, layout)
        for robot, cell in zip(opening.warehouse.robots, cells.tolist(), strict=False):
            opening.warehouse.move(robot, cell, robot.id % 4)
        return opening

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("rmfs_core.simulation.engine.open_warehouse", opened)
        completes(*attack)


@given(attack=attacks(max_robots=40, queue="shortcut"), seed=st.integers(0, 1000))
@settings(max_examples=20, **ANYTHING_GOES)
def test_robots_begin_anywhere(attack: Attack, seed: int) -> None:
    completes_from_anywhere(attack, seed)


@pytest.mark.slow
@given(attack=attacks(max_robots=100), seed=st.integers(0, 1000))
@settings(max_examples=150, **ANYTHING_GOES)
def test_large_fleets_begin_anywhere(attack: Attack, seed: int) -> None:
    completes_from_anywhere(attack, seed)


@given(attack=attacks(max_robots=6, queue="shortcut"), seed=st.integers(0, 1000))
@settings(max_examples=12, **ANYTHING_GOES)
def test_robots_begin_anywhere_under_other_planners(attack: Attack, seed: int) -> None:
    for pp in ("whca-n", "free-flow", "pbs"):
        completes_from_anywhere(under(pp, attack), seed)


@st.composite
def with_batteries(draw: st.DrawFn, max_robots: int) -> Attack:
    """Few chargers, batteries that hold hardly more than the longest task takes, and robots that never rest."""
    scenario, instance, layout = draw(attacks(max_robots))
    locations = layout.storage_locations
    spare = len(locations) - 2 - max(len(instance.pods), scenario.robots.count)
    assume(spare > 0)
    chargers = draw(st.lists(st.sampled_from(locations), min_size=1, max_size=min(spare, 6), unique=True))
    kind = layout.kind.copy()
    kind[chargers] = CellKind.CHARGER
    layout = evolve(layout, kind=kind)
    idle = draw(
        st.sampled_from(
            [RuleChoice("charge-when-low", {"low": 0.0, "full": 0.01}), RuleChoice("charge-when-low"), RESTLESS]
        )
    )
    scenario = evolve(
        scenario,
        rules=evolve(
            scenario.rules,
            idle=idle,
            move=draw(st.sampled_from([None, RuleChoice("utility"), RuleChoice("cache"), RESTLESS])),
        ),
        layout=evolve(scenario.layout, pod_fill=max(0.01, draw(st.floats(0, 1)) * (1 - (spare + 6) / len(locations)))),
        run=model.RunSection(until_s=1_000_000.0),
    )
    watts = {"idle_w": draw(st.sampled_from([0.0, 20.0, 5000.0])), "loaded_w": draw(st.sampled_from([100.0, 1000.0]))}
    battery = model.BatterySection(capacity_wh=1e6, charging_w=20_000.0, **watts)
    with_large = evolve(scenario, robots=evolve(scenario.robots, battery=battery))
    make = battery_of(with_large, travel_on(layout, motion_of(scenario.robots)))
    assert make is not None
    battery = evolve(battery, capacity_wh=make(lambda: 0).low_j / 3600 * draw(st.sampled_from([1.01, 1.5, 4.0])))
    return evolve(scenario, robots=evolve(scenario.robots, battery=battery)), instance, layout


@given(attack=with_batteries(max_robots=10), pp=st.sampled_from(["sipp", "whca-n", "free-flow"]))
@settings(max_examples=40, **ANYTHING_GOES)
def test_no_robot_strands(attack: Attack, pp: str) -> None:
    completes_under(pp, attack)


@pytest.mark.slow
@given(attack=with_batteries(max_robots=40))
@settings(max_examples=100, **ANYTHING_GOES)
def test_no_robot_of_many_strands(attack: Attack) -> None:
    completes(*attack)


@given(attack=attacks(max_robots=8), pp=st.sampled_from(["sipp", "free-flow"]))
@settings(max_examples=15, **ANYTHING_GOES)
def test_robots_rest_where_pods_are_stored(attack: Attack, pp: str) -> None:
    """Robots are sent where PR stores pods at the same moment: pods have the places, and all orders are completed."""
    scenario, instance, layout = attack
    rules = evolve(scenario.rules, pr=FIRST_FREE, idle=FIRST_FREE, pp=RuleChoice(pp))
    completes(evolve(scenario, rules=rules), instance, layout)


@given(attack=attacks(max_robots=12))
@settings(max_examples=25, **ANYTHING_GOES)
def test_moved_pods_leave_room_for_those_that_come_back(attack: Attack) -> None:
    scenario, instance, layout = attack
    often = evolve(RESTLESS, parameters={"often": 1.0})
    full = evolve(scenario, layout=evolve(scenario.layout, pod_fill=0.97), rules=evolve(scenario.rules, move=often))
    completes(evolve(full, run=model.RunSection(until_s=1_000_000.0)), instance, layout)


@given(attack=attacks(max_robots=8), more=outages(), pp=st.sampled_from(["sipp", "pbs", "free-flow", "whca-n"]))
@settings(max_examples=16, **ANYTHING_GOES)
def test_no_run_stands_still_for_what_fails(attack, more, pp) -> None:
    scenario, *rest = attack
    robots, stations = evolve(scenario.robots, **more[0]), evolve(scenario.stations, **more[1])
    completes_under(pp, (evolve(scenario, robots=robots, stations=stations), *rest))
