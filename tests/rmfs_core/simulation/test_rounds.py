"""A decision round: who is asked when, and what becomes of the answers."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from attrs import define

from bad_rules import prepare_bad
from rmfs_commands.testing import small_instance, small_world
from rmfs_core import hookimpl
from rmfs_core.decisions import JointDecision, OrderAssignment, PodTrip, SolveReport, TaskAssignment
from rmfs_core.errors import RuleError, StandstillError
from rmfs_core.events import DecisionMade, OrderAssigned, TaskAssigned, TripDecided
from rmfs_core.info import Question
from rmfs_core.roles import Role
from rmfs_core.scenario.model import RuleChoice, RunSection
from rmfs_core.simulation import engine
from rmfs_core.simulation.asking import Asker, Observers
from rmfs_core.simulation.context import RunContext
from rmfs_core.simulation.rounds import Decisions
from rmfs_core.warehouse import Pod, Robot
from scripted import run_of, scripted, until_nothing_happens


def test_observers_are_told_nothing_of_a_decision_that_is_half_impossible(
    tiny_run: Callable[..., Any], tmp_path: Path
) -> None:
    """The first assignment was fine, the second not: results know of neither."""
    run = prepare_bad(tiny_run, tmp_path, "poa", "return [OrderAssignment(0, 0), OrderAssignment(99, 0)]")
    with pytest.raises(RuleError, match="named order 99"):
        run.simulation.run()
    assert not run.recorder.of(OrderAssigned)


def decisions(run: RunContext) -> tuple[Decisions, list[Any], list[tuple[Robot, Pod]]]:
    """Return the decisions of a run, the events that they tell, and the tasks that they start."""
    events: list[Any] = []
    run.tell = events.append
    started: list[tuple[Robot, Pod]] = []

    def start(robot: Robot, pod: Pod) -> None:
        started.append((robot, pod))

    def go(*_: object) -> None:
        """Nobody drives."""

    return Decisions(run, start, go, go, lambda: None), events, started


def hooks(rule: Any) -> list[str]:
    """Return which hooks a scripted rule was asked, in order."""
    return [hook for hook, _ in rule.asked]


def test_a_round_goes_from_orders_to_pods_to_robots(tmp_path: Path) -> None:
    """POA is asked again while it decides something, PPS for what is uncovered then, TA for the pods that wait."""
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
    """No room at any station, nothing uncovered, no robot for the pod that waits."""
    world = small_world({"1": {"a": 2}, "2": {"a": 2}}, {"p": ["a"]}, capacities=[3], robots=0)
    run, rule = run_of(world, tmp_path)
    deciding, events, _ = decisions(run)
    world.bind(world.pods[0], world.stations[0])
    world.assign(world.orders[0], world.stations[0], [0])
    deciding.round()
    assert (rule.asked, events) == ([], [])


def test_pods_are_asked_for_as_many_as_robots_can_start(tmp_path: Path) -> None:
    """Robots that will fetch the pods that wait already do not count; without any, only a pod that leaves may go on."""
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
    """Its trips wait for robots; what it reports of its solve is told."""
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
    """Each gets what the one before left, oldest order first and each once; a filter's time counts with the rule's."""
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


def test_what_a_filter_was_not_given_it_may_not_return(tmp_path: Path) -> None:
    """The filter is named, with the order."""
    world = small_world({"1": ["a"], "2": ["a"]}, {"p": ["a"]}, capacities=[5])
    run, _ = run_of(world, tmp_path, filters=(scripted("First"), scripted("Second")))
    first, second = (bound.instance for bound in run.rules.filters)
    first.answers = {"filter_backlog": [world.orders[:1]]}
    second.answers = {"filter_backlog": [world.orders]}
    with pytest.raises(RuleError, match=r"py:Second.*filter_backlog.*: returned order 2, which it was not given\.$"):
        decisions(run)[0].round()


def test_filters_that_leave_nothing_end_the_orders_part(tmp_path: Path) -> None:
    """The rule is not asked, and no period begins."""
    world = small_world({"1": ["a"]}, {"p": ["a"]}, capacities=[5])
    run, rule = run_of(world, tmp_path, filters=(scripted("First"),))
    run.rules.filters[0].instance.answers = {"filter_backlog": [[]]}
    decisions(run)[0].round()
    assert (rule.asked, run.asker.period) == ([], 0)


def test_a_storage_location_is_kept_free_for_its_pod(tmp_path: Path) -> None:
    """From the answer on nobody else is sent there."""
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
    """Return at what times a scripted rule was asked when to wake up."""
    return [told["now_s"] for hook, told in rule.asked if hook == "wake_at"]


def test_the_earliest_time_makes_a_round(tmp_path: Path) -> None:
    """All are asked after each round. A time between two ticks is rounded up; None is no time; numpy's numbers are."""
    run, deciding, (one, other) = waking(tmp_path, [7, None, np.int64(9)], [5.0001, np.float32(8), None])
    deciding.round()
    until_nothing_happens(run)
    assert asked_at(one) == asked_at(other) == [0.0, 5.001, 8.0, 9.0]


def test_the_latest_answers_count(tmp_path: Path) -> None:
    """A round comes before the alarm: what was answered earlier is forgotten, and what is answered again rings once."""
    run, deciding, (rule,) = waking(tmp_path, [100, 30, 30, None])
    deciding.round()
    for tick in (10_000, 20_000):
        run.env.run(until=tick)
        run.warehouse.advance(tick)
        deciding.round()
    until_nothing_happens(run)
    assert asked_at(rule) == [0.0, 10.0, 20.0, 30.0]


def test_a_rule_of_several_roles_is_asked_once_when_to_wake_up(tmp_path: Path) -> None:
    """One choice for POA, PPS and so on is one rule."""
    world = small_world({}, {"p": ["a"]}, capacities=[5])
    rules = dict.fromkeys(("poa", "pps", "pr", "ta", "pp"), scripted("Waking"))
    run, rule = run_of(world, tmp_path, **rules)
    decisions(run)[0].round()
    assert asked_at(rule) == [0.0]


def test_observers_are_not_told_when_rules_wake_up(tmp_path: Path) -> None:
    """It decides nothing; its time counts as the rules'."""
    run, deciding, _ = waking(tmp_path, [None])
    questions: list[str] = []
    run.rules.register_observer(Listening(questions))
    run.asker = Asker(run.warehouse, None, Observers(run.rules, run.warehouse))
    deciding.asker = run.asker
    deciding.round()
    assert questions == []
    assert run.asker.calls == {"wake_at": 1}


@define
class Listening:
    """Observer that keeps what is asked."""

    hooks: list[str]

    @hookimpl
    def rule_asked(self, question: Question) -> None:
        self.hooks.append(question.hook)


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


def waking_run(tiny_run: Callable[..., Any], folder: Path, released: str, wakes: str, **options: object) -> Any:
    """Prepare a run of four orders with a filter that wakes up."""
    (folder / "waking.py").write_text(WAKING.format(released=released, wakes=wakes), encoding="utf-8")
    arrivals = {"soon": 5, "later": 700, "last": 2500}
    orders = {"now": ["a"], "soon": ["a"], "later": ["b"], "last": ["a"]}
    instance = small_instance(orders, {"p": ["a", "b"]}, arrivals_s=arrivals)
    return tiny_run(instance, filters=["./waking.py:Waking"], **options)


def test_orders_are_released_in_waves(tiny_run: Callable[..., Any], tmp_path: Path) -> None:
    """A whole run: each is assigned at the first multiple of 1,000 s after it came, whatever else happens or not."""
    run = waking_run(
        tiny_run,
        tmp_path,
        "return [order for order in orders if order.arrival_s <= warehouse.now_s // 1000 * 1000]",
        "return (warehouse.now_s // 1000 + 1) * 1000 if warehouse.backlog else None",
    )
    run.simulation.run()
    assigned = {event.order: event.tick for event in run.recorder.of(OrderAssigned)}
    assert assigned == {0: 0, 1: 1_000_000, 2: 1_000_000, 3: 3_000_000}


def test_a_run_of_nothing_but_waking_up_stands_still(
    tiny_run: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every minute, and nothing is released: after so many rounds in a row the run ends."""
    monkeypatch.setattr(engine, "MOST_ALARMS", 50)
    run = waking_run(tiny_run, tmp_path, "return []", "return warehouse.now_s + 60")
    with pytest.raises(StandstillError, match=r"stands still at 5560\.000 s: 4 orders are not complete"):
        run.simulation.run()


FINITE = "; expected seconds after now, below 1e12, or None"


@pytest.mark.parametrize(
    ("wakes", "problem"),
    [
        ("return warehouse.now_s", f"wants to wake at 0.0{FINITE}"),
        ("return -5", f"wants to wake at -5{FINITE}"),
        ("return float('inf')", f"wants to wake at inf{FINITE}"),
        ("return float('nan')", f"wants to wake at nan{FINITE}"),
        ("return 1e18", f"wants to wake at 1e+18{FINITE}"),
        ("return 10 ** 400", "wants to wake at 1000"),
        ("return True", f"wants to wake at True{FINITE}"),
        ("return 'soon'", f"wants to wake at 'soon'{FINITE}"),
        ("raise RuntimeError('no idea')", "raised RuntimeError: no idea ("),
        ("time.sleep(0.35)", "took "),
    ],
)
def test_no_time_to_wake_up_at_ends_the_run(
    tiny_run: Callable[..., Any], tmp_path: Path, wakes: str, problem: str
) -> None:
    """Rule, hook and time are named; the limit of a decision holds for this answer, too."""
    run = waking_run(tiny_run, tmp_path, "return orders", wakes, run=RunSection(decision_limit_s=0.3))
    with pytest.raises(RuleError) as caught:
        run.simulation.run()
    assert str(caught.value).startswith(f'rule "./waking.py:Waking" (waking.py inline), wake_at, at 0.000 s: {problem}')
