"""A decision round: who is asked when, what becomes of the answers, and what the parts of a run share."""

import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bad_rules import prepare_bad
from cases import cases
from rmfs_commands.layouts import parse_map
from rmfs_commands.results.endings import standstill
from rmfs_commands.testing import small_instance, small_world
from rmfs_core.decisions import JointDecision, OrderAssignment, PodTrip, SolveReport, TaskAssignment
from rmfs_core.errors import RuleError, StandstillError
from rmfs_core.events import DecisionMade, Event, OrderAssigned, TaskAssigned, TripDecided
from rmfs_core.roles import Role
from rmfs_core.scenario.model import RuleChoice, RunSection
from rmfs_core.simulation import engine
from rmfs_core.simulation.applying import apply_assignments
from rmfs_core.simulation.asking import ImpossibleError
from rmfs_core.simulation.context import RunContext
from rmfs_core.simulation.rounds import Decisions
from rmfs_core.warehouse import Pod, Robot, Warehouse
from saying import said
from scripted import run_of, scripted, until_nothing_happens
from told import Prepare


def test_observers_are_told_nothing_of_a_decision_that_is_half_impossible(tiny_run: Prepare, tmp_path: Path) -> None:
    run = prepare_bad(tiny_run, tmp_path, "poa", "return [OrderAssignment(0, 0), OrderAssignment(99, 0)]")
    with pytest.raises(RuleError, match="named order 99"):
        run.simulation.run()
    assert not run.of(OrderAssigned)


def decisions(run: RunContext) -> tuple[Decisions, list[Any], list[tuple[Robot, Pod]]]:
    """Return the decisions of a run, the events that they tell, and the tasks that they start."""
    events: list[Any] = []
    run.tell = events.append
    started: list[tuple[Robot, Pod]] = []

    def start(robot: Robot, pod: Pod) -> None:
        started.append((robot, pod))

    def go(*_: object) -> None:
        """Nobody drives."""

    return Decisions(run, start, go, go, go), events, started


def hooks(rule: Any) -> list[str]:
    return [hook for hook, _ in rule.asked]


def test_a_round_goes_from_orders_to_pods_to_robots(tmp_path: Path) -> None:
    world = small_world({"1": ["a"], "2": ["b"]}, {"p": ["a"], "q": ["b"]}, capacities=[5])
    run, rule = run_of(world, tmp_path)
    deciding, events, started = decisions(run)
    rule.answers = {
        "assign_orders": [[OrderAssignment(0, 0)], []],
        "select_pods": [[PodTrip(0, 0)]],
        "assign_tasks": [[TaskAssignment(1, 0)]],
    }
    deciding.round()
    assert hooks(rule) == ["assign_orders", "assign_orders", "select_pods", "assign_tasks"]
    assert [type(event) for event in events] == [
        OrderAssigned, DecisionMade, DecisionMade, TripDecided, DecisionMade, TaskAssigned,
    ]  # fmt: skip
    made = [event for event in events if isinstance(event, DecisionMade)]
    assert [(event.decides, event.period) for event in made] == [(Role.POA, 1), (Role.POA, 2), (Role.PPS, 2)]
    assert [(event.assignments, event.trips) for event in made] == [(1, 0), (0, 0), (0, 1)]
    assert started == [(world.robots[1], world.pods[0])]


def test_nobody_is_asked_what_there_is_no_choice_in(tmp_path: Path) -> None:
    world = small_world({"1": {"a": 2}, "2": {"a": 2}}, {"p": ["a"]}, capacities=[3], robots=0)
    run, rule = run_of(world, tmp_path)
    deciding, events, _ = decisions(run)
    world.bind(world.pods[0], world.stations[0])
    world.assign(world.orders[0], world.stations[0], [0])
    deciding.round()
    assert (rule.asked, events) == ([], [])


def test_pods_are_asked_for_as_many_as_robots_can_start(tmp_path: Path) -> None:
    orders, pods = {"1": ["a"], "2": ["b"]}, {"p": ["a"], "q": ["b"], "r": ["b"]}
    world = small_world(orders, pods, capacities=[5], robots=3)
    world.bind(world.pods[0], world.stations[0])
    run, rule = run_of(world, tmp_path)
    deciding, _, _ = decisions(run)
    rule.answers = {"assign_orders": [[OrderAssignment(0, 0), OrderAssignment(1, 0)]]}
    deciding.round()
    (asked,) = (told for hook, told in rule.asked if hook == "select_pods")
    assert asked["max_fetches"] == 2
    rule.asked.clear()
    for pod in world.pods[1:]:
        world.bind(pod, world.stations[0], promise=False)
    deciding.round()
    assert "select_pods" not in hooks(rule)


def test_a_joint_rule_leaves_nothing_for_pods(tmp_path: Path) -> None:
    world = small_world({"1": ["a"]}, {"p": ["a"]}, capacities=[5])
    run, _ = run_of(world, tmp_path, poa_pps=scripted("Joint"))
    joint = run.rules.poa_pps
    assert joint is not None
    report = SolveReport("stopped", objective=4, bound=3.5, stopped_early=True)
    decision = JointDecision((OrderAssignment(0, 0),), (PodTrip(0, 0),), report)
    joint.instance.answers = {"assign_orders_and_pods": [decision]}
    deciding, events, _ = decisions(run)
    deciding.round()
    (made,) = (event for event in events if isinstance(event, DecisionMade))
    assert (made.decides, made.rule, made.backlog) == (Role.POA_PPS, "./scripted_rules.py:Joint", 1)
    assert (made.assignments, made.trips, made.status) == (1, 1, "stopped")
    assert (made.objective, made.bound, made.stopped_early) == (4, 3.5, True)
    assert list(world.waiting) == [0]


def test_filters_show_the_rule_what_they_leave(tmp_path: Path) -> None:
    world = small_world({name: ["a"] for name in "123"}, {"p": ["a"]}, capacities=[5])
    one, two, three = world.orders
    run, rule = run_of(world, tmp_path, filters=(scripted("First"), scripted("Second")))
    first, second = (bound.instance for bound in run.rules.filters)
    first.answers = {"filter_backlog": [lambda _: time.sleep(0.02) or [three, one, three]]}
    second.answers = {"filter_backlog": [[three]]}
    deciding, events, _ = decisions(run)
    deciding.round()
    assert second.asked[0][1]["orders"] == (one, three)
    assert rule.asked[0][1]["warehouse"].backlog == (three,)
    assert (events[0].backlog, events[0].status) == (1, "decided")
    assert events[0].wall_s >= 0.02
    assert world.backlog.orders == (one, two, three)


def test_what_filters_leave(tmp_path: Path) -> None:
    world = small_world({"1": ["a"], "2": ["a"]}, {"p": ["a"]}, capacities=[5])
    run, _ = run_of(world, tmp_path, filters=(scripted("First"), scripted("Second")))
    first, second = (bound.instance for bound in run.rules.filters)
    first.answers = {"filter_backlog": [world.orders[:1]]}
    second.answers = {"filter_backlog": [world.orders]}
    with pytest.raises(RuleError, match=r"py:Second.*filter_backlog.*: returned order 2, which it was not given\.$"):
        decisions(run)[0].round()
    world = small_world({"1": ["a"]}, {"p": ["a"]}, capacities=[5])
    run, rule = run_of(world, tmp_path, filters=(scripted("First"),))
    run.rules.filters[0].instance.answers = {"filter_backlog": [[]]}
    decisions(run)[0].round()
    assert (rule.asked, run.asker.period) == ([], 0)
    assert 'asked last: rule "./scripted_rules.py:First"' in standstill(world, run.rules, "a")


def test_a_storage_location_is_kept_free_for_its_pod(tmp_path: Path) -> None:
    world = small_world({"1": ["a"]}, {"p": ["a"]}, capacities=[5])
    run, rule = run_of(world, tmp_path)
    chosen = world.free_locations[2]
    rule.answers = {"choose_storage_location": [chosen, chosen]}
    deciding, _, _ = decisions(run)
    assert deciding.storage_location(world.pods[0]) == chosen
    assert (world.reserved, chosen in world.free_locations) == ({chosen}, False)
    with pytest.raises(RuleError, match=r"choose_storage_location, .*which is taken\.$"):
        deciding.storage_location(world.pods[0])


def waking(folder: Path, *answers: list[object]) -> tuple[RunContext, Decisions, list[Any]]:
    """Return a run without orders, its decisions, and its filters, which answer so when they are asked to wake up."""
    world = small_world({}, {"p": ["a"]}, capacities=[5])
    chosen = tuple(RuleChoice(scripted("Waking").rule, {"also": i}) for i in range(len(answers)))
    run, _ = run_of(world, folder, filters=chosen)
    filters = [bound.instance for bound in run.rules.filters]
    for rule, own in zip(filters, answers, strict=True):
        rule.answers = {"wake_at": own}
    return run, decisions(run)[0], filters


def asked_at(rule: Any) -> list[float]:
    return [told["now_s"] for hook, told in rule.asked if hook == "wake_at"]


def test_when_rules_wake_up(tmp_path: Path) -> None:
    run, deciding, (one, other) = waking(tmp_path, [7, None, np.int64(9)], [5.0001, np.float32(8), None])
    deciding.round()
    until_nothing_happens(run)
    assert asked_at(one) == asked_at(other) == [0.0, 5.001, 8.0, 9.0]
    run, deciding, (rule,) = waking(tmp_path, [100, 30, 30, None])
    deciding.round()
    for tick in (10_000, 20_000):
        run.env.run(until=tick)
        run.warehouse.advance(tick)
        deciding.round()
    until_nothing_happens(run)
    assert asked_at(rule) == [0.0, 10.0, 20.0, 30.0]
    world = small_world({}, {"p": ["a"]}, capacities=[5])
    rules = dict.fromkeys(("poa", "pps", "pr", "ta", "pp"), scripted("Waking"))
    run, rule = run_of(world, tmp_path, **rules)
    decisions(run)[0].round()
    assert asked_at(rule) == [0.0]


WAKING = """
import time
from attrs import define
from rmfs_core import hookimpl
@define
class Waking:
    @hookimpl
    def filter_backlog(self, warehouse, orders):
        {released}
    @hookimpl
    def wake_at(self, warehouse):
        {wakes}
"""


def waking_run(tiny_run: Prepare, folder: Path, released: str, wakes: str, **options: object) -> Any:
    (folder / "waking.py").write_text(WAKING.format(released=released, wakes=wakes), encoding="utf-8")
    arrivals = {"soon": 5, "later": 700, "last": 2500}
    orders = {"now": ["a"], "soon": ["a"], "later": ["b"], "last": ["a"]}
    instance = small_instance(orders, {"p": ["a", "b"]}, arrivals_s=arrivals)
    return tiny_run(instance, filters=["./waking.py:Waking"], **options)


def test_orders_are_released_in_waves(tiny_run: Prepare, tmp_path: Path) -> None:
    """A whole run: each is assigned at the first multiple of 1,000 s after it came, whatever else happens or not."""
    run = waking_run(
        tiny_run,
        tmp_path,
        "return [order for order in orders if order.arrival_s <= warehouse.now_s // 1000 * 1000]",
        "return (warehouse.now_s // 1000 + 1) * 1000 if warehouse.backlog else None",
    ).done()
    assigned = {event.order: event.tick for event in run.of(OrderAssigned)}
    assert assigned == {0: 0, 1: 1_000_000, 2: 1_000_000, 3: 3_000_000}


def test_waking_up_for_nothing_stands_still(tiny_run: Prepare, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(engine, "MOST_ALARMS", 50)
    run = waking_run(tiny_run, tmp_path, "return []", "return warehouse.now_s + 60")
    with pytest.raises(StandstillError, match=r"stands still at 5560\.000 s: 4 orders are not complete"):
        run.simulation.run()


FINITE = "; expected seconds after now, below 1e12, or None"


@cases(
    "wakes problem",
    ("return warehouse.now_s", f"wants to wake at 0.0{FINITE}"),
    ("return -5", f"wants to wake at -5{FINITE}"),
    ("return float('nan')", f"wants to wake at nan{FINITE}"),
    ("return 1e18", f"wants to wake at 1e+18{FINITE}"),
    ("return 10 ** 400", "wants to wake at 1000"),  # too large for a float
    ("return True", f"wants to wake at True{FINITE}"),
    ("return 'soon'", f"wants to wake at 'soon'{FINITE}"),
    ("raise RuntimeError('no idea')", "raised RuntimeError: no idea ("),
    ("time.sleep(0.35)", "took "),
)
def test_no_time_to_wake_up_at_ends_the_run(tiny_run: Prepare, tmp_path: Path, wakes: str, problem: str) -> None:
    run = waking_run(tiny_run, tmp_path, "return orders", wakes, run=RunSection(decision_limit_s=0.3))
    assert said(RuleError, run.simulation.run).startswith(
        f'rule "./waking.py:Waking" (waking.py inline), wake_at, at 0.000 s: {problem}'
    )


def assigned(world: Warehouse, answer: object, **more: Any) -> list[Event]:
    events: list[Event] = []
    given = {"joint": False, "shown": None, "period": 1, "packing_capacity": None} | more
    apply_assignments(world, answer, keep=events.append, **given)
    return events


def test_joint_decisions() -> None:
    world = small_world({"1": ["a"], "2": ["a"]}, {"p": ["a"]}, capacities=[5])
    assigned(world, [OrderAssignment(1, 0)], shown={1})
    with pytest.raises(ImpossibleError, match=r"order 1 \(id 0\) .* was not in the backlog it was shown"):
        assigned(world, [OrderAssignment(0, 0)], shown={1})
    world = small_world({"old": ["a"], "new": ["a"]}, {"p": {"a": 1}, "q": {"a": 1}}, capacities=[5])
    station = world.stations[0]
    world.assign(world.orders[0], station, [0])  # uncovered, as other rules may leave it
    decision = JointDecision((OrderAssignment(1, 0),), (PodTrip(1, 0),))
    assert assigned(world, decision, joint=True) == [
        TripDecided(0, pod=1, station=0),
        OrderAssigned(0, order=1, station=0, skus=(0,), items=1, period=1, complete=True),
    ]
    assert [(one.order.name, one.covered) for one in station.open_requests] == [("old", False), ("new", True)]


def test_a_pod_for_several_stations_visits_the_nearer_one_first() -> None:
    orders = {"1": ["a"], "2": ["a"], "3": ["b"]}
    world = small_world(orders, {"p": ["a"], "q": ["b"]}, capacities=[5, 5])
    pod = world.pods[0]
    ticks = [int(world.travel.times_to(station.cell, True)[pod.cell].min()) for station in world.stations]
    near, far = sorted((0, 1), key=lambda station: ticks[station])
    assert ticks[near] < ticks[far]
    assignments = (OrderAssignment(0, 0), OrderAssignment(1, 1), OrderAssignment(2, far))
    trips = (PodTrip(0, far), PodTrip(1, far), PodTrip(0, near))
    events = assigned(world, JointDecision(assignments, trips), joint=True)
    assert [(one.pod, one.station) for one in events if isinstance(one, TripDecided)] == [(0, near), (1, far), (0, far)]
    assert pod.bound_for == (near, far)


def test_split_orders_need_room_at_the_packing_stations() -> None:
    split = [OrderAssignment(order, 0, skus=(0,)) for order in range(2)]

    def assign(capacity: int | None) -> list[Event]:
        world = small_world({"1": ["a", "b"], "2": ["a", "b"]}, {"p": ["a", "b"]}, capacities=[5])
        return assigned(world, split, packing_capacity=capacity)

    assert len(assign(None)) == len(assign(2)) == 2
    with pytest.raises(ImpossibleError, match=r"^left 2 split orders open at once; the packing stations hold 1$"):
        assign(1)


def context(folder: Path, seed: int = 1, **rules: object) -> RunContext:
    """Return a run of scripted rules that answer with a number they have drawn."""
    world = small_world({"1": ["a"]}, {"p": ["a"]})
    run, rule = run_of(world, folder, **rules)
    run = RunContext(run.scenario.with_seed(seed), run.rules, world)
    for each in (rule, *(bound.instance for bound in run.rules.filters)):
        each.answers = {hook: [lambda told: told["rng"].random()] * 9 for hook in ("assign_orders", "filter_backlog")}
    return run


def drawn(run: RunContext) -> list[float]:
    poa = run.rules.poa
    assert poa is not None
    return [run.ask(poa)[0], *(run.ask(rule, orders=())[0] for rule in run.rules.filters)]


def test_streams_of_rules(tmp_path: Path) -> None:
    filters = (scripted("First"), scripted("Second"), scripted("Second"))
    numbers = drawn(context(tmp_path, filters=filters))
    assert (len(set(numbers)), drawn(context(tmp_path, filters=filters))) == (4, numbers)
    assert drawn(context(tmp_path, filters=filters[1:])) == [numbers[0], *numbers[2:]]
    assert not set(drawn(context(tmp_path, seed=2, filters=filters))) & set(numbers)
    run = context(tmp_path, filters=(scripted("First"),))
    (one, _), (two, _) = drawn(run), drawn(run)
    alone = context(tmp_path)
    assert [*drawn(alone), *drawn(alone)] == [one, two]
    assert one != two


def test_the_profile_divides_wall_clock_time(tmp_path: Path) -> None:
    layout = parse_map("#....\n.....\n.qO..\n.....", "a layout that no other test has tables of")
    world = small_world({"1": ["a"]}, {"p": ["a"]}, robots=1, layout=layout)
    goal = world.stations[0].cell
    world.travel.load_searches()
    run, rule = run_of(world, tmp_path)
    rule.answers = {"plan_path": [lambda told: told["warehouse"].travel.times_to(layout.width, True)]}
    assert run.profile == {"tables": 0.0, "queries": 0.0, "rules": 0.0, "observers": 0.0}
    run.ask(run.rules.ta)
    _, seconds = run.ask(run.rules.pp, robot=None, goal=goal, traffic=None)
    profile = run.profile
    assert profile["rules"] == run.asker.seconds["assign_tasks"] > 0
    assert 0 < profile["tables"] < seconds
    assert profile["queries"] == pytest.approx(seconds - profile["tables"])
