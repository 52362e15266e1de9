"""Faults of orders, pods, visits, robots, bundles and packing, each made in a trace; and capacity given back late."""

import json
from pathlib import Path
from typing import Any

import pytest
from attrs import evolve

import rmfs_core
from cases import cases
from damage import Damage, at, drop, find, put, told, told_before, twice, without
from replenished import RULES, scenario_of
from rmfs_commands.processes.events import PackingStarted, PartPut
from rmfs_commands.trace import Trace, read_trace
from rmfs_commands.validation import check_trace, faults_of, validate_trace
from rmfs_commands.validation.collisions import reached_s
from rmfs_commands.validation.orders import misreported
from rmfs_commands.validation.stock import joined_at, lets_wait
from rmfs_core.events import (
    BundleArrived,
    BundleStored,
    DecisionMade,
    OrderInStock,
    QueueJoined,
    RobotMoved,
    StationClosed,
    StationOpened,
    VisitEnded,
    VisitStarted,
)
from rmfs_core.motion import Motion
from rmfs_core.roles import Role

ASSIGNED, POA, TRIP, PPS, TASK, LIFT, JOIN, VISIT = 1, 2, 3, 4, 5, 7, 10, 12
TEA, JAM, LAST, COMPLETE, LEAVE, STORE = 13, 14, 15, 16, 17, 21
"""Numbers of events in `day`."""


def turn_in_visit(trace: Trace) -> Trace:
    end = trace.events[LEAVE]
    return put(trace, LEAVE, RobotMoved(end.tick, end.tick - 500, 0, 39, 39, 0, 500, 0, 0, 0), end)


def test_a_line_of_one_too_many_is_told(day: Trace) -> None:
    for length, faults in ((0, []), (-1, ["queue-too-long"])):
        stations = {**day.scenario["stations"], "queue_length": length}
        found = told(evolve(day, scenario={**day.scenario, "stations": stations}))
        assert [fault.partition(":")[0] for fault in found] == faults


def test_a_pod_that_can_still_serve_stays(day: Trace) -> None:
    """Only what never runs out is held against a pod that leaves: an item may be promised by another one."""
    early = told_before(LEAVE, 14)(day)
    assert not any(fault.startswith("left-early") for fault in told(early))
    (first, *others) = day.instance.pods
    endless = evolve(first, contents=((0, None), (1, None)))
    early = evolve(early, instance=evolve(day.instance, pods=(endless, *others)))
    assert "left-early: pod P0 leaves station 1, where SKU jam is still wanted" in told(early)


def test_a_robot_keeps_behind_its_place_in_line(new_script: Any) -> None:
    yard = ".........\n.....v...\n..qqqqqO.\n..##.##..\n........."
    script = new_script(yard, robots=[(4, 2), (4, 5)], pods=[(3, 2), (3, 5)])
    for robot, way in ((0, [(4, 1), (2, 1), (2, 2)]), (1, [(4, 8), (0, 8), (0, 5), (2, 5)])):
        script.drive(robot, 3, script.cells[robot] % 9)
        script.fetch(robot, robot)
        script.drive(robot, 4, script.cells[robot] % 9)
        for row, column in way:
            script.drive(robot, row, column)
        script.events.append(QueueJoined(script.now[robot], robot, robot, 0))
    assert not [fault for fault in told(script.trace()) if fault.startswith("queue-passed")]
    script.drive(1, 2, 7)
    assert [fault for fault in told(script.trace()) if fault.startswith("queue-passed")] == [
        "queue-passed: robot 2 drives to row 3, column 8 in the queue of station 1, "
        "position 0 there; robots ahead in line: 1"
    ]
    assert faults_of(script.trace(), collisions=False) == []  # robots pass through each other, in queues, too


def test_who_waits_in_a_queue_is_in_its_line(new_script: Any) -> None:
    script = new_script("........\n...@....\n..##.##.\n.....qqO\n........", robots=[(4, 3)], pods=[(2, 3)])
    script.drive(0, 2, 3)
    script.fetch(0, 0)
    script.drive(0, 3, 3)
    script.drive(0, 3, 5)
    script.events.append(QueueJoined(script.now[0], 0, 0, 0))
    script.drive(0, 3, 7, wait_s=3)
    script.events.append(VisitStarted(script.now[0], 1, 0, 0, 0))
    trace = script.trace()
    assert told(trace) == []
    at, late = find(trace, QueueJoined), find(trace, RobotMoved)
    joined = evolve(trace.events[at], tick=trace.events[late].tick)
    assert told(put(put(trace, late, trace.events[late], joined), at)) == [
        "joined-late: robot 1 with pod P0 starts a visit at station 1, in whose queue it waited; "
        "it joined the line just now"
    ]


def test_who_has_waited_to_leave_may_come_again_at_once(new_script: Any) -> None:
    script = new_script("........\n...@....\n..##.##.\n.....qqO\n........", robots=[(2, 3)], pods=[(2, 3)])
    for visit in (1, 2):
        script.fetch(0, 0)
        script.drive(0, 3, 3)
        script.drive(0, 3, 7)
        script.events += [QueueJoined(script.now[0], 0, 0, 0), VisitStarted(script.now[0], visit, 0, 0, 0)]
        script.events.append(VisitEnded(script.now[0], visit, 0, 0, 0, None))
        script.drive(0, 4, 7, wait_s=3)
        script.drive(0, 4, 3)
        script.drive(0, 2, 3)
        script.store(0)
    assert told(script.trace()) == []


def test_an_order_arrives_when_its_instance_says(day: Trace) -> None:
    order = evolve(day.instance.orders[0], arrival_tick=5)
    faults = told(evolve(day, instance=evolve(day.instance, orders=(order,))))
    assert faults == ["arrival: order A arrives; expected once, at 0.005 s"]


@pytest.mark.parametrize(("unit", "fits", "too_small", "holds"), [("items", 3, 2, 3), ("orders", 1, 0, 1)])
def test_capacity_is_counted_in_items_or_orders(day: Trace, unit: str, fits: int, too_small: int, holds: int) -> None:
    for capacity in (fits, too_small):
        key = "item_capacity" if unit == "items" else "order_capacity"
        changed = evolve(
            day,
            stations=({**day.stations[0], "capacity": capacity, "counts_orders": unit == "orders"},),
            scenario={**day.scenario, "stations": {**day.scenario["stations"], key: capacity, "oversize": "refuse"}},
        )
        sentence = f"order A is assigned to station 1, which has {holds} {unit} then; its capacity is {capacity}"
        assert told(changed) == ([] if capacity == fits else [f"capacity-exceeded: {sentence}"])


def test_filters_may_hide_orders_but_add_none(day: Trace) -> None:
    filtered = evolve(day, scenario={**day.scenario, "rules": {"filters": ["some-filter"]}})
    for seen, count in ((0, 0), (1, 0), (2, 1)):
        assert len(told(at(POA, backlog=seen)(filtered))) == count
    assert len(told(at(POA, backlog=0)(day))) == 1


@cases(
    "status completed kinds",
    ("complete", True, []),
    ("partial", True, ["status"]),
    ("horizon", True, ["end", "status"]),
    ("failed", True, []),
    ("complete", False, ["order-left"]),
    ("partial", False, ["order-left"]),
    ("failed", False, []),
)
def test_the_status_is_that_of_the_orders(day: Trace, status: str, completed: bool, kinds: list[str]) -> None:
    trace = evolve(day if completed else without(COMPLETE)(day), status=status)
    assert [fault.partition(":")[0] for fault in told(trace)] == kinds


@cases(
    "rule told problem",
    ("integrated", {"status": "optimal", "objective": 2.0, "bound": 2.0}, None),
    ("integrated", {"status": "effort", "objective": 2.0, "bound": 1.0, "stopped_early": True}, None),
    ("integrated", {"status": "finished"}, "'finished'; expected one of optimal, effort, stopped, heuristic, dec"),
    ("somebodys", {"status": "finished", "bound": 1.0}, None),
    ("integrated", {"status": "optimal", "stopped_early": True}, "the status optimal, and was stopped early"),
    ("somebodys", {"status": "effort"}, "the status effort, and was not stopped early"),
    ("pod-match-joint", {"status": "heuristic", "objective": 2.0}, None),
    ("pod-match-joint", {"status": "heuristic", "bound": 2.0}, "the bound 2.0; expected none from a rule"),
    ("somebodys", {"status": "decided", "objective": 1.0}, "the objective 1.0; expected none"),
    ("first-come", {"status": "nearly"}, "the status 'nearly'; expected 'decided': POA reports nothing"),
    (
        "first-come",
        {"status": "decided", "objective": 3.0},
        "the objective 3.0; expected none from a rule that reports",
    ),
    ("first-come", {"status": "decided", "bound": 3.0}, "the bound 3.0; expected none"),
    ("first-come", {"status": "decided", "stopped_early": True}, "the solve ended early; expected none"),
)
def test_what_a_decision_reports(rule: str, told: dict[str, Any], problem: str | None) -> None:
    whole = {"objective": None, "bound": None, "stopped_early": False} | told
    decides = Role.POA if rule == "first-come" else Role.POA_PPS
    event = DecisionMade(0, 1, decides, rule, 1, 0, 0, wall_s=0.0, **whole)
    found = misreported(event)
    assert (found is None) if problem is None else (found is not None and problem in found)


JAM_PICKED = "SKU jam of order A is picked from pod P0 at station 1"


def jam_on_pod(number: int) -> Damage:
    """Return the damage that leaves so many items of jam on the pod that the day is served from."""

    def damage(trace: Trace) -> Trace:
        pod, *others = trace.instance.pods
        pods = (evolve(pod, contents=((0, None), (1, number))), *others)
        return evolve(trace, instance=evolve(trace.instance, pods=pods))

    return damage


def never_stored(trace: Trace) -> Trace:
    """Let the run go on for a minute after the robot has brought the pod to its place."""
    return evolve(without(STORE)(trace), tick=trace.tick + 60_000, status="failed")


@cases(
    "damage faults",
    (twice(JOIN), ["queue-order: robot 1 with pod P0 joins the line of station 1, but is in it already"]),
    (twice(LEAVE), ["visit-end: pod P0 leaves station 1 after visit 1, but no pod is there"]),
    (at(LEAVE, picks=2), ["visit-picks: pod P0 leaves station 1 after 3 picks, but reports 2"]),
    (without(LEAVE), ["moved-in-visit: robot 1 left row 5, column 8 during visit 1, which has no end"]),
    (turn_in_visit, ["moved-in-visit: pod P0 leaves station 1, but robot 1 moved during the visit"]),
    (
        at(ASSIGNED, skus=(0, 1, 2)),
        ["line-assigned: order A is assigned to station 1 with SKU rye, which is no line of it"],
    ),
    (at(ASSIGNED, items=2), ["items: order A is assigned to station 1 with 3 items, but 2 are reported"]),
    (at(ASSIGNED, period=2), ["period: order A is assigned in period 2; expected 1"]),
    (told_before(COMPLETE, JAM), ["completed-early: order A is complete, but 2 of its items are not picked"]),
    (twice(COMPLETE), ["completed-twice: order A is complete again"]),
    (without(COMPLETE), ["order-left: order A is not complete at the end (0 of its items are not picked)"]),
    (at(PPS, period=2), ["period: the PPS decision has period 2; expected 1"]),
    (at(POA, backlog=2), ["backlog: the POA decision of period 1 saw 2 orders in the backlog; there were 1"]),
    (at(PPS, decides=Role.TA), ["unknown-id: a decision on TA; expected POA, PPS, POA+PPS, ROA, RPS or ROA+RPS"]),
    (at(JAM, visit=2), [f"no-visit: {JAM_PICKED} in visit 2, but pod P0 with visit 1 is there"]),
    (jam_on_pod(1), [f"stock-negative: {JAM_PICKED}, which has none left"]),
    (jam_on_pod(2), []),
    (without(TASK), ["no-task: robot 1 lifts pod P0 at row 4, column 4, but was not told to fetch it"]),
    (told_before(TASK, 3), ["no-trip: robot 1 shall fetch pod P0, which is bound for no station"]),
    (
        never_stored,
        ["not-stored: robot 1 with pod P0 stands at row 4, column 4 since 58.898 s and does not set it down"],
    ),
    (twice(TASK), ["robot-busy: robot 1 shall fetch pod P0, but is still busy with pod P0"]),
    (at(STORE, pod=1), ["pod-in-use: robot 1 sets down pod P1 at row 4, column 4, but carries pod P0"]),
)
def test_a_damaged_day_is_told(day: Trace, damage: Damage, faults: list[str]) -> None:
    assert told(damage(day)) == faults


@cases(
    "damage kinds",
    (twice(TRIP), {"bound-twice", "decision-size"}),
    (without(JOIN), {"queue-order", "queue-lane"}),
    (at(JOIN, pod=1), {"pod-mismatch", "not-bound"}),
    (twice(VISIT), {"visit-number", "station-busy"}),
    (at(ASSIGNED, complete=False), {"complete-flag", "backlog"}),
    (twice(LAST), {"picker-busy", "picked-twice", "visit-picks"}),
    (at(TEA, start_tick=15_000), {"no-visit", "pick-time", "handle-time"}),
    (at(JAM, sku=2), {"not-ordered", "completed-early"}),
    (at(JAM, pod=1), {"no-visit", "sku-not-on-pod"}),
    (at(LIFT, pod=1), {"no-task", "pod-not-there", "pod-mismatch"}),
    (at(LIFT, start_tick=3452), {"time-overlap", "lift-time"}),
    (at(STORE, cell=26), {"robot-elsewhere", "location-taken"}),
    (at(LEAVE, next_station=0), {"not-bound", "next-station"}),
)
def test_all_that_follows_from_one_damage_is_found(day: Trace, damage: Damage, kinds: set[str]) -> None:
    assert {fault.kind for fault in faults_of(damage(day))} == kinds


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


def traced(folder: Path, scenario: Any, *overrides: str) -> Trace:
    rmfs_core.run(scenario, overrides=overrides, out=folder, record=["trace"])
    return read_trace(folder / "trace.jsonl.gz")


def kinds_of(trace: Trace) -> set[str]:
    return {fault.kind for fault in faults_of(trace)}


HOURS = (
    "instance.orders=24",
    "instance.arrivals={process='poisson', orders_per_hour=300}",
    "rules.pp=free-flow",
    'stations.open={1 = [["00:00", "00:02"]], 2 = [["00:01", "24:00"]]}',
    'robots.available=[["00:00", "00:03"], ["00:03", "24:00", 1]]',
)
BY_LOAD = "rules.activate={rule='backlog-threshold', open_above=2, timeout_s=60}"


def test_hours_and_rules_that_close(tmp_path: Path) -> None:
    trace = traced(tmp_path, "examples/small", *HOURS, BY_LOAD)
    assert validate_trace(tmp_path) == []
    closed, opened = (
        told(put(trace, len(trace.events), event))
        for event in (StationClosed(trace.tick, 1), StationOpened(trace.tick, 0))
    )
    assert not any("station-hours" in fault for fault in closed)
    assert "station-hours: station 1 opens, which `stations.open` does not say" in opened
    trace = traced(tmp_path, "examples/small", *HOURS)
    assert validate_trace(tmp_path) == []
    scenario = {**trace.scenario, "stations": {k: v for k, v in trace.scenario["stations"].items() if k != "open"}}
    scenario["robots"] = {k: v for k, v in trace.scenario["robots"].items() if k != "available"}
    faults = told(evolve(trace, scenario=scenario))
    assert "station-hours: station 2 closes, which `stations.open` does not say" in faults
    assert "robot-hours: robots on duty from now on: 1; the scenario says 4" in faults


SUPPLY = {"process": "reorder-point", "reorder_point": 3, "order_up_to": 8, "bundle_items": 4, "lead_s": 30.0}
INSTANCE = {
    "orders": 12,
    "skus": 4,
    "pods": 4,
    "skus_per_pod": 1,
    "items_per_sku": 4,
    "pod_capacity": 9,
    "replenishment": SUPPLY,
}


def test_a_run_with_replenishment_has_no_fault(tmp_path: Path) -> None:
    replenished = traced(tmp_path, scenario_of(SUPPLY, instance=INSTANCE))
    assert sum(isinstance(event, BundleStored) for event in replenished.events) > 4
    assert kinds_of(replenished) == set()
    assert (replenished.instance.levels, replenished.layout.replenishing) == (((3, 8),) * 4, 1)
    assert [station.get("bundle_capacity") for station in replenished.stations] == [None, 10]
    instance = evolve(replenished.instance, levels=((10**15, 10**16),) * 4)
    assert "bundle-arrival" in kinds_of(evolve(replenished, instance=instance))
    assert "pod-capacity" in kinds_of(evolve(replenished, instance=evolve(replenished.instance, sizes=(99,) * 4)))


def test_bundles_of_a_file(tmp_path: Path) -> None:
    (tmp_path / "bundles.csv").write_text("bundle,arrival_s,sku,items\nB,5,new,3\nA,1,1,2\n", encoding="utf-8")
    supply = {"process": "file", "file": str(tmp_path / "bundles.csv")}
    scenario = scenario_of(supply, instance=INSTANCE | {"orders": 6, "replenishment": supply}, run={"until_s": 90.0})
    trace = traced(tmp_path / "out", scenario)
    assert [(bundle.name, bundle.arrival_tick) for bundle in trace.instance.bundles] == [("A", 1000), ("B", 5000)]
    assert trace.instance.skus[-1] == "new"
    assert kinds_of(trace) == set()
    assert "bundle-arrival" in kinds_of(drop(BundleArrived, number=1)(trace))


def test_bundles_while_pickers_are_away_and_stations_activated(tmp_path: Path) -> None:
    instance = INSTANCE | {"items_per_sku": 1}
    hours = {"open": [["00:10", "24:00"]], "queue_length": 3}
    trace = traced(tmp_path, scenario_of(SUPPLY, instance=instance, stations=hours))
    assert next(event for event in trace.events if isinstance(event, BundleStored)).tick < 600_000
    assert kinds_of(trace) == set()
    rules = RULES | {"activate": "backlog-threshold"}
    rmfs_core.run(scenario_of(SUPPLY, instance=INSTANCE, rules=rules), out=tmp_path, record=["trace"])
    assert check_trace(tmp_path).faults == []


SHORT = ("instance.replenishment.lead_s=1800", "instance.orders=60", "rules.pp=free-flow")


def test_orders_that_wait(tmp_path: Path) -> None:
    short = traced(tmp_path, "examples/replenished", *SHORT)
    assert check_trace(tmp_path).faults == []
    told = {event.order: event.tick for event in short.events if isinstance(event, OrderInStock)}
    assert len(told) > 5
    assert told.items() <= joined_at(short).items()
    assert lets_wait(short)
    rules = {**short.scenario["rules"], "wait_for_stock": False}
    trace = evolve(short, scenario={**short.scenario, "rules": rules})
    assert not lets_wait(trace)
    assert joined_at(trace) == {i: order.arrival_tick for i, order in enumerate(trace.instance.orders)}
    assert "in-stock" in kinds_of(trace)


def test_a_place_that_is_still_kept_is_not_taken(tmp_path: Path) -> None:
    settings = ("stations.order_capacity=1", "stations.release=picked", "rules.pp=free-flow")
    trace = traced(tmp_path, "examples/small", *settings)
    handled = {**trace.scenario, "stations": {**trace.scenario["stations"], "release": "handled"}}
    assert "capacity-exceeded" in kinds_of(evolve(trace, scenario=handled))


FEW = ("instance.orders=24", "packing={stations=2, boxes=2, packers=1, conveyor_s=20.0}", "rules.pp=free-flow")
STORING = "instance.replenishment={process='poisson', bundles_per_hour=400, bundle_items=1}"
PODS = ("instance.items_per_sku=20", "instance.pod_capacity=99")
STORED = ("stations.also_replenish=true", "rules.roa=first-bundle", "rules.rps=emptiest-pod", STORING, *PODS)
KINDS_OF_RUN = {
    "parts": (),
    "visits, counted until picked": ("packing.tote=visit", "packing.packing_from=picked"),
    "visits that store, too": ("packing.tote=visit", *STORED),
    "sorters, places free with the pick": ("packing.sorters=1", "stations.release=picked"),
    "hours, split over time": ('packing.open=[["00:05", "24:00"]]', "rules.poa_pps=split-over-time", "run.warmup_s=99"),
    "cut off": ("run.until_s=400", 'packing.open={1=[["00:02", "00:05"]]}', 'instance.start="2024-03-01T00:01:00"'),
}


@pytest.mark.parametrize("changes", KINDS_OF_RUN.values(), ids=KINDS_OF_RUN)
def test_a_recorded_run_has_no_fault(changes: tuple[str, ...], tmp_path: Path) -> None:
    rmfs_core.run("examples/packing", overrides=[*FEW, *changes], out=tmp_path, record=["trace"])
    assert check_trace(tmp_path).faults == []
    result = json.loads((tmp_path / "result.json").read_text())
    for name in ("packer_utilisation_percent", "packer_starved_percent"):
        result["metrics"][name] += 1
    (tmp_path / "result.json").write_text(json.dumps(result))
    assert [fault.kind for fault in check_trace(tmp_path).faults] == ["metric"] * 2


@pytest.mark.parametrize("change", [{"packers": 0}, {"open": {"1": [["12:00", "13:00"]]}}])
def test_more_packers_than_there_are_show(tmp_path: Path, change: dict[str, Any]) -> None:
    packed = traced(tmp_path, "examples/packing", *FEW)
    section = packed.scenario["packing"] | change
    begun = next(at for at, one in enumerate(packed.events) if isinstance(one, PackingStarted) and one.packing == 0)
    events = tuple(event for event in packed.events[: begun + 1] if not isinstance(event, PartPut))
    for part in (packed, evolve(packed, events=events, status="horizon")):
        found = faults_of(evolve(part, scenario={**packed.scenario, "packing": section}))
        assert {fault.kind for fault in found} >= {"packers"}
