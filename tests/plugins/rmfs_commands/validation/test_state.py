"""Where everything is: at the start of a run, and when pods change hands."""

from __future__ import annotations

import pytest
from attrs import evolve

from rmfs_commands.trace.reader import Trace
from rmfs_commands.validation.state import State

HERE, THERE = 27, 30
"""Where P0 stands at the start of the day, and a free storage location."""


@pytest.fixture
def state(day: Trace) -> State:
    """Return the state at the start of the day, with a second robot."""
    return State(evolve(day, robots=(*day.robots, {"cell": 0, "heading": 2})))


def test_a_run_begins_as_its_header_says(day: Trace) -> None:
    """Pods stand, robots rest, nobody waits; nothing of an order is assigned, let alone picked."""
    state = State(evolve(day, blocked=(29,)))
    assert state.stored == {29: None, HERE: 0, 26: 1}
    assert [(robot.cell, robot.pod, robot.task) for robot in state.robots] == [(43, None, None)]
    assert state.orders[0].unassigned == state.orders[0].unpicked == {0: 1, 1: 2}
    assert state.pods[0].stock == {0: None, 1: 5, 2: None}
    assert state.stations[0].line == []


def test_pods_may_be_at_a_station_from_the_start(day: Trace) -> None:
    """Who stands at the station is first in line, then who waits in the queue; a pod that is carried is not stored."""
    at_station, in_queue = {"cell": 39, "heading": 0}, {"cell": 38, "heading": 0}
    pods = ({"cell": 38, "robot": 0, "bound_for": [0]}, {"cell": 39, "robot": 1, "bound_for": [0]})
    state = State(evolve(day, robots=(in_queue, at_station), pods=pods))
    assert state.stations[0].line == [1, 0]
    assert state.stored == {}
    assert [(robot.pod, robot.task) for robot in state.robots] == [(0, 0), (1, 1)]
    assert [(pod.bound, pod.next_station) for pod in state.pods] == [([(0, 0)], 0)] * 2


def test_taking_and_putting_a_pod(state: State) -> None:
    """A pod is in one place: on its robot, then where that has put it."""
    state.take(0, 0)
    assert (state.pods[0].robot, state.pods[0].location, state.robots[0].pod) == (0, None, 0)
    assert HERE not in state.stored
    state.put(0, THERE)
    assert (state.pods[0].robot, state.pods[0].location, state.robots[0].pod) == (None, THERE, None)
    assert state.stored == {THERE: 0, 26: 1}


def test_the_newer_statement_counts(state: State) -> None:
    """Whoever takes a pod has it, whoever had it before has none; who takes another one has lost the first."""
    state.take(0, 0)
    state.take(1, 0)
    assert (state.robots[0].pod, state.robots[1].pod, state.pods[0].robot) == (None, 0, 1)
    state.take(1, 1)
    assert (state.pods[0].robot, state.pods[1].robot, state.robots[1].pod) == (None, 1, 1)
    state.take(1, None)
    assert (state.pods[1].robot, state.robots[1].pod) == (None, None)


def test_a_pod_taken_leaves_another_one_where_it_stands(state: State) -> None:
    """Where a pod was put upon another, taking the lower one leaves the place to the upper one."""
    state.put(1, HERE)
    state.take(0, 0)
    assert state.stored[HERE] == 1
