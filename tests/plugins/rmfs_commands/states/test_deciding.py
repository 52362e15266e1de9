"""Asking rules in states that no run has recorded."""

from __future__ import annotations

from typing import Any

import pytest

from rmfs_commands.states import Outcome, decide, state_from_dict
from rmfs_commands.states.deciding import decide_instead, outcome_of
from rmfs_core import InputError, RuleError
from rmfs_core.roles import Role
from rmfs_core.scenario import RuleChoice

RULES = """
@define
class Eager:
    "POA: everything to station 0, whether it fits or not."

    @hookimpl
    def assign_orders(self, warehouse):
        return [OrderAssignment(order.id, 0) for order in warehouse.backlog]

    @hookimpl
    def select_pods(self, warehouse):
        return []


@define
class Broken:
    "POA: raises."

    @hookimpl
    def assign_orders(self, warehouse):
        raise ZeroDivisionError("nothing to divide")


@define
class Careless:
    "POA and PPS: the oldest order, and no pod for it."

    @hookimpl
    def assign_orders_and_pods(self, warehouse):
        return JointDecision([OrderAssignment(warehouse.backlog[0].id, 0)])


@define
class Drawing:
    "POA: a random order."

    @hookimpl
    def assign_orders(self, warehouse, rng):
        return [OrderAssignment(int(rng.integers(len(warehouse.backlog))), 0)]


@define
class Endless(Eager):
    "POA: needs unlimited stock."

    needs = ("unlimited stock",)


@define
class Roomy:
    "POA: needs item capacity."

    needs = ("item capacity",)

    @hookimpl
    def assign_orders(self, warehouse):
        return []
"""


@pytest.fixture
def acme(install: Any) -> None:
    """Install the rules above, as another distribution."""
    names = {
        name.lower(): f"acme_rules:{name}" for name in ("Eager", "Broken", "Careless", "Drawing", "Endless", "Roomy")
    }
    install("acme", names, acme_rules=f"from rmfs_core import JointDecision, OrderAssignment\n{RULES}")


def test_a_joint_rule_in_a_state_by_hand(by_hand: dict[str, Any]) -> None:
    """The model needs no places: orders, pods and stations are enough for a proven decision."""
    answer = decide(state_from_dict(by_hand), RuleChoice("split-over-time"))
    assert (answer.decides.label, answer.distribution) == ("POA+PPS", "rmfs")
    assert answer.decision == {
        "assignments": [
            {"order": "A", "station": "north", "skus": ["milk", "tea"]},
            {"order": "B", "station": "north", "skus": ["jam"]},
        ],
        "trips": [{"pod": "P1", "station": "north"}, {"pod": "P2", "station": "north"}],
    }
    assert answer.report == {"status": "optimal", "objective": 2.0, "bound": 2.0, "stopped_early": False}
    assert answer.outcome == Outcome(orders=2, items=4, visits=2, unused=0, uncovered=0)


def test_a_joint_rule_without_effort(by_hand: dict[str, Any]) -> None:
    """It decides all the same, and says that its effort ended the proof."""
    by_hand["stations"]["north"]["item_capacity"] = 2
    by_hand["orders"] = {name: {"lines": {"milk": 1, "jam": 1}} for name in ("A", "B")}
    report = decide(state_from_dict(by_hand), RuleChoice("integrated", {"effort": 0})).report
    assert report is not None
    assert report == {"status": "effort", "objective": 2.0, "bound": 1.0, "stopped_early": True}


def test_a_joint_rule_in_a_state_that_other_rules_left(by_hand: dict[str, Any]) -> None:
    """A request that no pod is on its way for yet is not the joint rule's fault; it is told of as not covered."""
    by_hand["stations"]["north"]["requests"] = [{"order": "B", "sku": "jam"}] * 2
    answer = decide(state_from_dict(by_hand), RuleChoice("integrated"))
    assert answer.decision["trips"] == [{"pod": "P1", "station": "north"}]
    assert answer.outcome == Outcome(orders=1, items=2, visits=1, unused=0, uncovered=2)


def test_a_joint_rule_covers_what_it_assigns(by_hand: dict[str, Any], acme: None) -> None:
    """What was not covered before excuses nothing: an order without a pod for it is an impossible decision."""
    by_hand["stations"]["north"]["requests"] = [{"order": "B", "sku": "jam"}] * 2
    with pytest.raises(RuleError, match=r'"careless" .* assigned order A .* to station north .*, but no pod there'):
        decide(state_from_dict(by_hand), RuleChoice("careless"))


def test_parameters_are_set(by_hand: dict[str, Any]) -> None:
    """A parameter changes what is decided: at less than a pod visit for two places, they stay free."""
    by_hand["orders"]["B"]["lines"]["jam"] = 1
    answer = decide(state_from_dict(by_hand), RuleChoice("integrated", {"unused_capacity_weight": 0.4}))
    assert answer.outcome == Outcome(orders=0, items=0, visits=0, unused=4, uncovered=0)
    assert answer.report is not None
    assert answer.report["objective"] == pytest.approx(1.6)


def test_a_rule_that_asks_for_driving_times(by_hand: dict[str, Any], at_work: dict[str, Any]) -> None:
    """`nearest-pod` goes by driving time: refused where there is no layout, answered where there is."""
    by_hand["stations"]["north"]["requests"] = [{"order": "B", "sku": "jam"}] * 2
    by_hand["pods"]["P3"] = {"contents": {"jam": None}}
    with pytest.raises(InputError, match=r'rule "nearest-pod" .* asks for driving times, but the state has no layout'):
        decide(state_from_dict(by_hand), RuleChoice("nearest-pod"))
    del at_work["orders"]["A"]["parts"]
    at_work["stations"]["north"]["requests"] = [{"order": "B", "sku": "jam"}] * 2
    at_work["stations"]["north"]["inbound"] = ["P1"]
    answer = decide(state_from_dict(at_work), RuleChoice("nearest-pod"))
    assert answer.decision == {"trips": [{"pod": "P2", "station": "north"}]}
    assert answer.outcome == Outcome(orders=0, items=0, visits=1, unused=2, uncovered=0)


def test_pods_to_send(at_work: dict[str, Any]) -> None:
    """How many pods may be fetched is what the state says, or else the idle robots."""
    at_work["stations"]["north"]["requests"] = [{"order": "B", "sku": "jam"}]
    at_work["stations"]["north"]["inbound"] = ["P1"]
    for change, trips in (({}, 1), ({"ask": {"max_fetches": 0}}, 0), ({"robots": {"r1": {"cell": 54}}}, 1)):
        answer = decide(state_from_dict(at_work | change), RuleChoice("nearest-pod"))
        assert len(answer.decision["trips"]) == trips


def test_no_more_pods_are_moved_than_robots_can(at_work: dict[str, Any]) -> None:
    """A state that asks for more moves than it has idle robots is refused."""
    ask = {"decides": "repositioning", "max_moves": 60}
    with pytest.raises(InputError, match=r"ask.max_moves: found 60; expected at most \d, the number of idle robots"):
        decide(state_from_dict(at_work | {"ask": ask}), RuleChoice("cache"))
    assert decide(state_from_dict(at_work | {"ask": ask | {"max_moves": 0}}), RuleChoice("cache")).decision == {
        "moves": []
    }


def test_places_to_store(at_work: dict[str, Any]) -> None:
    """PR is asked where the pod in `ask` goes back to; it must be named, and be carried."""
    at_work["stations"]["north"] = {"item_capacity": 4}
    state = at_work | {"ask": {"decides": "PR", "pod": "P1"}}
    assert decide(state_from_dict(state), RuleChoice("fixed")).decision == {"cell": 12}
    with pytest.raises(InputError, match=r"ask.pod: is missing"):
        decide(state_from_dict(at_work), RuleChoice("fixed"))
    with pytest.raises(InputError, match=r'ask.pod: pod "P2" is stored'):
        decide(state_from_dict(at_work | {"ask": {"pod": "P2"}}), RuleChoice("fixed"))


def test_storing_needs_a_layout(by_hand: dict[str, Any]) -> None:
    """PR without a layout is refused."""
    with pytest.raises(InputError, match=r'rule "nearest" .* decides PR, but the state has no layout'):
        decide(state_from_dict(by_hand), RuleChoice("nearest"))


def test_tasks(at_work: dict[str, Any]) -> None:
    """TA gives the waiting pod to the idle robot."""
    answer = decide(state_from_dict(at_work), RuleChoice("nearest-robot"))
    assert answer.decision == {"tasks": [{"robot": "r2", "pod": "P2"}]}
    assert answer.outcome is None


@pytest.mark.parametrize("closed", [{"staffed": False}, {"active": False}])
def test_a_closed_station_is_assigned_nothing(by_hand: dict[str, Any], acme: None, closed: dict[str, Any]) -> None:
    """By its timetable or by an activation rule; a rule that does is told so."""
    by_hand["version"] = 2
    by_hand["stations"]["north"] |= closed
    assert decide(state_from_dict(by_hand), RuleChoice("first-come")).decision == {"assignments": []}
    with pytest.raises(RuleError, match=r'"eager" .* to station north .*, which is closed'):
        decide(state_from_dict(by_hand), RuleChoice("eager"), decides=Role.POA)


def test_a_robot_off_duty_gets_no_task(at_work: dict[str, Any]) -> None:
    """Though it has nothing to do."""
    at_work["version"] = 2
    at_work["robots"]["r2"]["on_duty"] = False
    assert decide(state_from_dict(at_work), RuleChoice("nearest-robot")).decision == {"tasks": []}


def test_which_stations_are_active(by_hand: dict[str, Any]) -> None:
    """A rule for activation is asked about any state."""
    by_hand["version"] = 2
    by_hand["stations"]["south"] = {"item_capacity": 4, "active": False}
    answer = decide(state_from_dict(by_hand), RuleChoice("all"))
    assert (answer.decides, answer.decision, answer.outcome) == (Role.ACTIVATE, {"active": ["north", "south"]}, None)
    by_hand["stations"]["north"]["staffed"] = False
    assert decide(state_from_dict(by_hand), RuleChoice("constant-ratio")).decision == {"active": ["south"]}


TIMES = """
@define
class Times:
    "POA: raises what it sees of times."

    @hookimpl
    def assign_orders(self, warehouse):
        north = warehouse.stations[0]
        arrivals = [pod.expected_arrival_s for pod in warehouse.pods]
        raise ValueError(f"{north.picker_free_s} {north.opens_s} {north.closes_s} {arrivals}")
"""


def test_times_in_a_state(by_hand: dict[str, Any], install: Any) -> None:
    """What a rule sees in a run it sees in a state; without a layout nobody knows when pods arrive."""
    install("clocks", {"times": "clocks:Times"}, clocks=TIMES)
    by_hand |= {"version": 2, "time_s": 100.0}
    with pytest.raises(RuleError, match=r"100\.0 None None \[None"):
        decide(state_from_dict(by_hand), RuleChoice("times"))
    by_hand["stations"]["north"] |= {"picker_free_s": 106.5, "changes_s": 3600}
    with pytest.raises(RuleError, match=r"106\.5 None 3600\.0"):
        decide(state_from_dict(by_hand), RuleChoice("times"))


@pytest.mark.parametrize("changed", [{"staffed": False}, {"picker_free_s": 3.0}, {"changes_s": 60.0}])
def test_version_1_has_no_hours(by_hand: dict[str, Any], changed: dict[str, Any]) -> None:
    """Nor does it know when a picker is free."""
    by_hand["stations"]["north"] |= changed
    with pytest.raises(InputError, match=r"found opening hours, or a busy picker, in a state of version 1"):
        state_from_dict(by_hand | {"version": 1})


def test_what_a_rule_needs_is_checked(by_hand: dict[str, Any], acme: None) -> None:
    """A state that lacks what a rule declares to need is refused, as a scenario would be."""
    by_hand["pods"]["P1"]["contents"]["milk"] = 5
    with pytest.raises(InputError, match=r'rule "endless" .* needs pods whose SKUs never run out'):
        decide(state_from_dict(by_hand), RuleChoice("endless"), decides=Role.POA)
    by_hand["stations"]["north"] = {"order_capacity": 1}
    with pytest.raises(InputError, match=r'rule "roomy" .* needs stations that count items'):
        decide(state_from_dict(by_hand), RuleChoice("roomy"))


def test_impossible_decisions_and_errors(by_hand: dict[str, Any], acme: None) -> None:
    """The kernel's checks hold, and name rule, order and station; what a rule raises is told."""
    by_hand["stations"]["north"]["item_capacity"] = 3
    with pytest.raises(RuleError, match=r'"eager" .* assigned order B .* to station north .*only 1 of 3 are free'):
        decide(state_from_dict(by_hand), RuleChoice("eager"), decides=Role.POA)
    with pytest.raises(RuleError, match=r'"broken" .* raised ZeroDivisionError: nothing to divide'):
        decide(state_from_dict(by_hand), RuleChoice("broken"))


def test_a_rule_that_decides_several_things(by_hand: dict[str, Any], acme: None) -> None:
    """What to ask it is taken from the state or from the call; else it is an error."""
    state = state_from_dict(by_hand)
    with pytest.raises(InputError, match="decides POA and PPS; say which of them is asked"):
        decide(state, RuleChoice("eager"))
    assert decide(state, RuleChoice("eager"), decides=Role.PPS).decision == {"trips": []}
    asked = state_from_dict({**by_hand, "ask": {"decides": "POA"}})
    assert len(decide(asked, RuleChoice("eager")).decision["assignments"]) == 2


@pytest.mark.parametrize(
    ("name", "decides", "problem"),
    [
        ("free-flow", None, "decides PP; expected a rule for POA"),
        ("first-come", Role.PPS, "decides POA; expected a rule for PPS"),
        ("first-comes", None, "did you mean `first-come`"),
        ("free-flow", Role.PP, "decides: expected POA, PPS, .*, ROA\\+RPS, activation, idle or .*, found 'PP'"),
    ],
)
def test_rules_that_cannot_answer(by_hand: dict[str, Any], name: str, decides: Role | None, problem: str) -> None:
    """A rule that is not there, or decides something else, is refused."""
    with pytest.raises(InputError, match=problem):
        decide(state_from_dict(by_hand), RuleChoice(name), decides=decides)


def test_seeds(by_hand: dict[str, Any], acme: None) -> None:
    """The same seed draws the same numbers; among some seeds, not all draw the same."""
    states = [state_from_dict({**by_hand, "seed": seed}) for seed in (1, 1, 2, 3, 4, 5)]
    first, again, *others = [decide(state, RuleChoice("drawing")).decision for state in states]
    assert first == again
    assert any(other != first for other in others)


def test_instead_of_a_joint_rule(at_work: dict[str, Any]) -> None:
    """POA and PPS rules together answer a joint rule's state: orders first, then the pods for them."""
    for pod in at_work["pods"].values():
        pod["contents"] = dict.fromkeys(pod["contents"])
    at_work["stations"]["north"] = {"item_capacity": 4}
    at_work["pods"]["P1"]["cell"] = 12
    del at_work["orders"]["A"]["parts"], at_work["robots"]
    state = state_from_dict(at_work | {"ask": {"decides": "POA+PPS"}})
    joint = decide(state, RuleChoice("integrated"))
    both = decide_instead(state, [RuleChoice("first-come"), RuleChoice("demand")], Role.POA_PPS)
    assert both.decision.keys() == joint.decision.keys()
    assert both.outcome == joint.outcome == outcome_of(state, Role.POA_PPS, joint.decision)
    alone = decide_instead(state, [RuleChoice("first-come")], Role.POA_PPS)
    assert alone.outcome == Outcome(orders=2, items=4, visits=0, unused=0, uncovered=4)


@pytest.mark.parametrize(
    ("names", "decides", "problem"),
    [
        (["demand"], Role.POA, "decides PPS; expected a rule for POA or POA\\+PPS"),
        (["demand", "nearest-pod"], Role.PPS, "found 2 rules to decide PPS"),
        (["demand", "first-come"], Role.POA, "decides PPS; expected a rule for POA"),
    ],
)
def test_rules_that_are_no_alternative(by_hand: dict[str, Any], names: list[str], decides: Role, problem: str) -> None:
    """Only rules that decide the same are held against each other."""
    with pytest.raises(InputError, match=problem):
        decide_instead(state_from_dict(by_hand), [RuleChoice(name) for name in names], decides)


def test_a_decision_of_another_state(by_hand: dict[str, Any]) -> None:
    """What cannot have been decided in a state has no outcome there."""
    decision = {"assignments": [{"order": "C", "station": "north", "skus": ["milk"]}]}
    with pytest.raises(InputError, match="does not belong to the state"):
        outcome_of(state_from_dict(by_hand), Role.POA, decision)
