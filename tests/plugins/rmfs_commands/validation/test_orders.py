"""Orders arrive, are assigned within capacity, are complete with their last pick; decisions report what they did."""

from __future__ import annotations

from typing import Any

import pytest
from attrs import evolve

from damage import (
    Damage,
    assert_found,
    at,
    change,
    drop,
    earlier,
    find,
    put,
    repeat,
    told,
    told_before,
    twice,
    without,
)
from rmfs_commands.trace.reader import Trace
from rmfs_commands.validation import faults_of
from rmfs_commands.validation.orders import misreported
from rmfs_core.events import DecisionMade, OrderArrived, OrderAssigned, OrderCompleted
from rmfs_core.roles import Role

ARRIVED, ASSIGNED, POA, PPS, JAM, COMPLETE = 0, 1, 2, 4, 14, 16
"""Places of events in `day`."""


def less_capacity(trace: Trace) -> Trace:
    """Give the stations less capacity than they used, in scenario and header."""
    stations = {**trace.scenario["stations"], "item_capacity": 2}
    return evolve(
        trace,
        scenario={**trace.scenario, "stations": stations},
        stations=tuple({**station, "capacity": 2} for station in trace.stations),
    )


def arrive_late(trace: Trace) -> Trace:
    """Tell of an order's arrival after its assignment."""
    at = find(trace, OrderArrived)
    event = trace.events[at]
    after = max(
        i
        for i, e in enumerate(trace.events)
        if isinstance(e, OrderAssigned) and e.order == event.order  # type: ignore[attr-defined]
    )
    changed = put(trace, after, trace.events[after], evolve(event, tick=trace.events[after].tick))
    return put(changed, at)


def partial_though_complete(trace: Trace) -> Trace:
    """Call a complete run partial."""
    return evolve(trace, status="partial")


def one_item(event: OrderAssigned) -> bool:
    """Whether a whole order of several lines is assigned."""
    return len(event.skus) > 1


DAMAGES: list[tuple[str, Damage, str]] = [
    (
        "an assignment to the other station",
        change(OrderAssigned, lambda t, e: {"station": 1 - e.station}),
        "not-assigned",
    ),
    ("an assignment dropped", drop(OrderAssigned), "not-assigned"),
    ("an assignment twice", repeat(OrderAssigned), "line-assigned"),
    ("an assignment of other lines", change(OrderAssigned, lambda t, e: {"skus": e.skus[1:]}, where=one_item), "items"),
    ("an assignment said to be partial", change(OrderAssigned, lambda t, e: {"complete": False}), "complete-flag"),
    ("an assignment in another period", change(OrderAssigned, lambda t, e: {"period": 99}), "period"),
    ("too much assigned", less_capacity, "capacity-exceeded"),
    ("an arrival too late", change(OrderArrived, lambda t, e: {"tick": e.tick + 1}), "arrival"),
    ("an arrival twice", repeat(OrderArrived), "arrival"),
    ("an assignment before the arrival", arrive_late, "assigned-before-arrival"),
    ("an order complete too early", earlier(OrderCompleted, by=2), "completed-early"),
    ("an order complete too late", change(OrderCompleted, lambda t, e: {"tick": e.tick + 5}), "completed-late"),
    ("an order complete twice", repeat(OrderCompleted), "completed-twice"),
    ("an order never complete", drop(OrderCompleted), "order-left"),
    ("a period too far", change(DecisionMade, lambda t, e: {"period": e.period + 1}), "period"),
    ("a decision with more trips", change(DecisionMade, lambda t, e: {"trips": e.trips + 1}), "decision-size"),
    ("a decision with another backlog", change(DecisionMade, lambda t, e: {"backlog": e.backlog + 1}), "backlog"),
    ("a decision on tasks", change(DecisionMade, lambda t, e: {"decides": Role.TA}), "unknown-id"),
    ("a decision of another rule", change(DecisionMade, lambda t, e: {"rule": "somebody"}), "rule"),
    ("a bound too high", change(DecisionMade, lambda t, e: {"objective": 3.0, "bound": 3.1}), "bound"),
    ("a complete run called partial", partial_though_complete, "status"),
]


@pytest.mark.parametrize(("damage", "kind"), [pytest.param(d, k, id=name) for name, d, k in DAMAGES])
def test_damage_to_a_run_is_found(recorded: Trace, damage: Damage, kind: str) -> None:
    """Whatever is wrong in a run of many orders is among its faults."""
    assert_found(damage(recorded), kind)


@pytest.mark.parametrize(
    ("damage", "faults"),
    [
        (
            twice(ARRIVED),
            [
                "arrival: order A arrives again; expected once, at 0.000 s",
                "backlog: the POA decision of period 1 saw 1 orders in the backlog; there were 2",
                "backlog: the PPS decision of period 1 saw 0 orders in the backlog; there were 1",
            ],
        ),
        (
            at(ASSIGNED, skus=(0, 1, 2)),
            [
                "line-assigned: order A is assigned to station 1 with SKU rye, which is no line of it",
            ],
        ),
        (
            at(ASSIGNED, items=2),
            [
                "items: order A is assigned to station 1 with 3 items, but 2 are reported",
            ],
        ),
        (
            at(ASSIGNED, complete=False),
            [
                "complete-flag: order A is assigned to station 1 with `complete` false; 0 of its lines are left",
                "backlog: the PPS decision of period 1 saw 0 orders in the backlog; there were 1",
            ],
        ),
        (
            at(ASSIGNED, period=2),
            [
                "period: order A is assigned in period 2; expected 1",
            ],
        ),
        (
            told_before(COMPLETE, JAM),
            [
                "completed-early: order A is complete, but 2 of its items are not picked",
            ],
        ),
        (
            twice(COMPLETE),
            [
                "completed-twice: order A is complete again",
            ],
        ),
        (
            without(COMPLETE),
            [
                "order-left: order A is not complete at the end (0 of its items are not picked)",
            ],
        ),
        (
            at(POA, period=2),
            [
                "period: the POA decision has period 2; expected 1",
                "period: the PPS decision has period 1; expected 2",
            ],
        ),
        (
            at(PPS, period=2),
            [
                "period: the PPS decision has period 2; expected 1",
            ],
        ),
        (
            at(POA, assignments=2),
            [
                "decision-size: the POA decision of period 1 reports 2 assignments and 0 trips; it had 1 and 0",
            ],
        ),
        (
            at(PPS, trips=0),
            [
                "decision-size: the PPS decision of period 1 reports 0 assignments and 0 trips; it had 0 and 1",
            ],
        ),
        (
            at(POA, backlog=2),
            [
                "backlog: the POA decision of period 1 saw 2 orders in the backlog; there were 1",
            ],
        ),
        (
            at(PPS, decides=Role.TA),
            [
                "unknown-id: a decision on TA; expected POA, PPS, POA+PPS, ROA, RPS or ROA+RPS",
            ],
        ),
    ],
)
def test_a_damaged_day_is_told(day: Trace, damage: Damage, faults: list[str]) -> None:
    """Each fault of one order or decision has its sentence."""
    assert told(damage(day)) == faults


@pytest.mark.parametrize("arrival", [0, 5])
def test_an_order_arrives_when_its_instance_says(day: Trace, arrival: int) -> None:
    """The tick is that of the instance in the header."""
    order = evolve(day.instance.orders[0], arrival_tick=arrival)
    faults = told(evolve(day, instance=evolve(day.instance, orders=(order,))))
    assert faults == ([] if arrival == 0 else ["arrival: order A arrives; expected once, at 0.005 s"])


@pytest.mark.parametrize(("unit", "fits", "too_small", "holds"), [("items", 3, 2, 3), ("orders", 1, 0, 1)])
def test_capacity_is_counted_in_items_or_orders(day: Trace, unit: str, fits: int, too_small: int, holds: int) -> None:
    """An order of three items takes three items' capacity, or that of one order."""
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
    """With filters a rule may have seen fewer orders than there were, never more."""
    filtered = evolve(day, scenario={**day.scenario, "rules": {"filters": ["some-filter"]}})
    for seen, count in ((0, 0), (1, 0), (2, 1)):
        assert len(told(at(POA, backlog=seen)(filtered))) == count
    assert len(told(at(POA, backlog=0)(day))) == 1


@pytest.mark.parametrize(
    ("status", "completed", "kinds"),
    [
        ("complete", True, []),
        ("partial", True, ["status"]),
        ("failed", True, []),
        ("complete", False, ["order-left"]),
        ("partial", False, ["order-left"]),
        ("failed", False, []),
    ],
)
def test_the_status_is_that_of_the_orders(day: Trace, status: str, completed: bool, kinds: list[str]) -> None:
    """A complete run completed all, a partial one not; a failed one may end anywhere."""
    trace = evolve(day if completed else without(COMPLETE)(day), status=status)
    assert [fault.partition(":")[0] for fault in told(trace)] == kinds


@pytest.mark.parametrize(
    ("told", "problem"),
    [
        ({"status": "nearly"}, "the status 'nearly'; expected 'decided': P"),
        ({"objective": 3.0}, "the objective 3.0; expected none from a rule that reports nothing"),
        ({"bound": 3.0}, "the bound 3.0; expected none"),
        ({"stopped_early": True}, "the solve ended early; expected none"),
    ],
)
def test_what_a_decision_on_orders_cannot_report(recorded: Trace, told: dict[str, Any], problem: str) -> None:
    """A rule that assigns orders alone has no model; neither has one whose status is that of no report."""
    damaged = change(DecisionMade, lambda _trace, _event: told)(recorded)
    (fault,) = [fault for fault in faults_of(damaged) if fault.kind == "report"]
    assert problem in fault.sentence


@pytest.mark.parametrize(
    ("rule", "told", "problem"),
    [
        ("integrated", {"status": "optimal", "objective": 2.0, "bound": 2.0}, None),
        ("integrated", {"status": "effort", "objective": 2.0, "bound": 1.0, "stopped_early": True}, None),
        ("integrated", {"status": "finished"}, "'finished'; expected one of optimal, effort, stopped, heuristic, dec"),
        ("somebodys", {"status": "finished", "bound": 1.0}, None),
        ("integrated", {"status": "optimal", "stopped_early": True}, "the status optimal, and was stopped early"),
        ("somebodys", {"status": "effort"}, "the status effort, and was not stopped early"),
        ("pod-match-joint", {"status": "heuristic", "objective": 2.0}, None),
        (
            "pod-match-joint",
            {"status": "heuristic", "bound": 2.0},
            "the bound 2.0; expected none from a rule",
        ),
        ("somebodys", {"status": "decided", "objective": 1.0}, "the objective 1.0; expected none"),
    ],
)
def test_what_a_joint_decision_reports(rule: str, told: dict[str, Any], problem: str | None) -> None:
    """Rules of rmfs have the statuses that are documented, others any; a status says whether there may be a bound."""
    whole = {"objective": None, "bound": None, "stopped_early": False} | told
    event = DecisionMade(0, 1, Role.POA_PPS, rule, 1, 0, 0, wall_s=0.0, **whole)
    found = misreported(event)
    assert (found is None) if problem is None else (found is not None and problem in found)
