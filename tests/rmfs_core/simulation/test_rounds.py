"""A decision round: who is asked when, and what becomes of the answers."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from bad_rules import prepare_bad
from rmfs_core.decisions import JointDecision, OrderAssignment, PodTrip, SolveReport, TaskAssignment
from rmfs_core.errors import RuleError
from rmfs_core.events import DecisionMade, OrderAssigned, TaskAssigned, TripDecided
from rmfs_core.simulation.context import RunContext
from rmfs_core.simulation.rounds import Decisions
from rmfs_core.warehouse import Pod, Robot
from rmfs_testing import small_world
from scripted import run_of, scripted


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
    return Decisions(run, lambda robot, pod: started.append((robot, pod))), events, started


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
    assert [(event.decides, event.period) for event in made] == [("POA", 1), ("POA", 2), ("PPS", 2)]
    assert [(event.assignments, event.trips) for event in made] == [(1, 0), (0, 0), (0, 1)]
    assert started == [(world.robots[1], world.pods[0])]


def test_nobody_is_asked_what_there_is_no_choice_in(tmp_path: Path) -> None:
    """No room at any station, nothing uncovered, no robot for the pod that waits."""
    world = small_world({"1": {"a": 3}}, {"p": ["a"]}, capacities=[2], robots=0)
    run, rule = run_of(world, tmp_path)
    deciding, events, _ = decisions(run)
    world.bind(world.pods[0], world.stations[0])
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
    assert (made.decides, made.rule, made.backlog) == ("POA+PPS", "./scripted_rules.py:Joint", 1)
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
    assert world.backlog == (one, two, three)


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
