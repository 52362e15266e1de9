"""What rules answer, with names, and back."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rmfs_commands.states import state_from_dict
from rmfs_commands.states.answers import answer_from_dict, answer_to_dict, report_to_dict
from rmfs_commands.states.rebuilding import open_state
from rmfs_commands.testing import small_world
from rmfs_core.decisions import JointDecision, OrderAssignment, PodTrip, SolveReport, TaskAssignment
from rmfs_core.roles import Role
from rmfs_core.warehouse import Warehouse, WarehouseView

SKUS = ("milk", "tea", "jam")
REPORT = SolveReport("optimal", 3.0, 3.0, stopped_early=False)
MILK_AND_TEA = {"order": "A", "station": "2", "skus": ["milk", "tea"]}


@pytest.fixture
def world() -> Warehouse:
    """Return a world of two orders, two pods, two robots and two stations; names are not ids."""
    orders = {"A": ["milk", "tea"], "B": {"jam": 2}}
    return small_world(orders, {"P1": ["milk", "tea"], "P2": ["jam"]}, capacities=(4, 4))


def written(world: Warehouse, decides: Role, answer: object) -> dict[str, Any] | None:
    """Return an answer with names."""
    return answer_to_dict(WarehouseView(world), SKUS, decides, answer)


@pytest.mark.parametrize(
    ("decides", "answer", "expected"),
    [
        (Role.POA, [OrderAssignment(0, 1, (1,))], {"assignments": [{"order": "A", "station": "2", "skus": ["tea"]}]}),
        (Role.POA, (), {"assignments": []}),
        (
            Role.PPS,
            (PodTrip(1, 0), PodTrip(0, 0)),
            {"trips": [{"pod": "P2", "station": "1"}, {"pod": "P1", "station": "1"}]},
        ),
        (
            Role.POA_PPS,
            JointDecision([OrderAssignment(1, 0)], [PodTrip(1, 0)]),
            {
                "assignments": [{"order": "B", "station": "1", "skus": ["jam"]}],
                "trips": [{"pod": "P2", "station": "1"}],
            },
        ),
        (Role.PR, np.int64(12), {"cell": 12}),
        (Role.TA, [TaskAssignment(1, 0)], {"tasks": [{"robot": "2", "pod": "P1"}]}),
    ],
)
def test_ids_become_names(world: Warehouse, decides: Role, answer: object, expected: dict[str, Any]) -> None:
    """In the order of the answer."""
    assert written(world, decides, answer) == expected


def test_an_assignment_without_skus_is_of_all_open_lines(world: Warehouse) -> None:
    """Not of those that are at a station, nor of those that the same answer names before."""
    assert written(world, Role.POA, [OrderAssignment(0, 1)]) == {"assignments": [MILK_AND_TEA]}
    twice = written(world, Role.POA, [OrderAssignment(0, 0, (1,)), OrderAssignment(0, 1)])
    assert twice is not None
    assert [given["skus"] for given in twice["assignments"]] == [["tea"], ["milk"]]
    world.assign(world.orders[0], world.stations[0], [0])
    rest = written(world, Role.POA, [OrderAssignment(0, 1)])
    assert rest == {"assignments": [MILK_AND_TEA | {"skus": ["tea"]}]}


@pytest.mark.parametrize(
    ("decides", "answer"),
    [
        (Role.POA, None),
        (Role.POA, [PodTrip(0, 0)]),
        (Role.POA, [OrderAssignment(9, 0)]),
        (Role.POA, [OrderAssignment(-1, 0)]),
        (Role.POA, [OrderAssignment("A", 0)]),  # type: ignore[arg-type]
        (Role.POA, [OrderAssignment(0, 2)]),
        (Role.POA, [OrderAssignment(0, 0, (7,))]),
        (Role.PPS, [PodTrip(2, 0)]),
        (Role.PPS, 3),
        (Role.POA_PPS, [OrderAssignment(0, 0)]),
        (Role.POA_PPS, JointDecision([OrderAssignment(0, 0)], [PodTrip(0, 5)])),
        (Role.POA_PPS, JointDecision(report="optimal")),  # type: ignore[arg-type]
        (Role.PR, "12"),
        (Role.PR, True),
        (Role.TA, [TaskAssignment(2, 0)]),
        (Role.TA, [TaskAssignment(0, -1)]),
    ],
)
def test_what_names_nothing_is_no_answer(world: Warehouse, decides: Role, answer: object) -> None:
    """The run ends with an error; the recording has null."""
    assert written(world, decides, answer) is None


@pytest.mark.parametrize(
    ("decides", "answer"),
    [
        (Role.POA, (OrderAssignment(0, 0, (1, 0)), OrderAssignment(1, 0, (2,)))),
        (Role.PPS, (PodTrip(1, 0),)),
        (Role.POA_PPS, JointDecision((OrderAssignment(1, 0, (2,)),), (PodTrip(1, 0),))),
        (Role.PR, 13),
        (Role.TA, (TaskAssignment(1, 1),)),
    ],
)
def test_an_answer_goes_round(at_work: dict[str, Any], decides: Role, answer: object) -> None:
    """From ids to names and back."""
    opened = open_state(state_from_dict(at_work))
    names = answer_to_dict(opened.view, opened.instance.skus, decides, answer)
    assert names is not None
    assert answer_from_dict(opened.warehouse, opened.names, decides, names) == answer


def test_names_that_are_not_there(at_work: dict[str, Any]) -> None:
    """They are no ids."""
    opened = open_state(state_from_dict(at_work))
    with pytest.raises(KeyError, match="south"):
        answer_from_dict(opened.warehouse, opened.names, Role.PPS, {"trips": [{"pod": "P1", "station": "south"}]})


def test_the_report_of_a_joint_rule_is_written_beside_its_decision(world: Warehouse) -> None:
    """A rule without one has none."""
    with_report = written(world, Role.POA_PPS, JointDecision(report=REPORT))
    assert with_report == {"assignments": [], "trips": [], "report": report_to_dict(REPORT)}
    assert written(world, Role.POA_PPS, JointDecision()) == {"assignments": [], "trips": []}


def test_figures_that_json_has_no_word_for_are_null() -> None:
    """A solve that was stopped before its first bound has none."""
    assert report_to_dict(SolveReport("stopped", 4.0, float("-inf"), stopped_early=True)) == {
        "status": "stopped",
        "objective": 4.0,
        "bound": None,
        "stopped_early": True,
    }
