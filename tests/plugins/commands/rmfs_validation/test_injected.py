"""A good recorded run is damaged in one place, and the validation names the damage."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import pytest
from attrs import evolve

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
from rmfs_core.roles import Role
from rmfs_trace.reader import Trace
from rmfs_validation import KINDS, faults_of

Kind = TypeVar("Kind", bound=Event)
Damage = Callable[[Trace], Trace]


def find(trace: Trace, kind: type[Kind], number: int = 3, where: Callable[[Kind], bool] = lambda _: True) -> int:
    """Return the place of the event with this number among those of a kind."""
    places = [i for i, event in enumerate(trace.events) if isinstance(event, kind) and where(event)]
    return places[min(number, len(places) - 1)]


def put(trace: Trace, at: int, *events: Event, instead_of: int = 1) -> Trace:
    """Return the trace with events put in place of as many as said."""
    return evolve(trace, events=(*trace.events[:at], *events, *trace.events[at + instead_of :]))


def change(kind: type[Kind], by: Callable[[Trace, Any], dict[str, Any]], **where: Any) -> Damage:
    """Return the damage that changes fields of one event."""

    def damage(trace: Trace) -> Trace:
        at = find(trace, kind, **where)
        return put(trace, at, evolve(trace.events[at], **by(trace, trace.events[at])))

    return damage


def drop(kind: type[Kind], **where: Any) -> Damage:
    """Return the damage that leaves out one event."""
    return lambda trace: put(trace, find(trace, kind, **where))


def repeat(kind: type[Kind], **where: Any) -> Damage:
    """Return the damage that tells one event twice."""

    def damage(trace: Trace) -> Trace:
        at = find(trace, kind, **where)
        return put(trace, at, trace.events[at], trace.events[at])

    return damage


def earlier(kind: type[Kind], by: int = 1, **where: Any) -> Damage:
    """Return the damage that tells one event before so many others."""

    def damage(trace: Trace) -> Trace:
        at = find(trace, kind, **where)
        moved = evolve(trace.events[at], tick=trace.events[at - by].tick)
        rest = put(trace, at)
        return put(rest, at - by, moved, instead_of=0)

    return damage


def other(count: int, value: int) -> int:
    """Return another id."""
    return (value + 1) % count


def shift_run(trace: Trace, event: RobotMoved) -> dict[str, int]:
    """Begin and end a run a second too early."""
    return {"start_tick": event.start_tick - 1000, "tick": event.tick - 1000}


def swap_robots(trace: Trace) -> Trace:
    """Exchange two robots from the middle of the run on."""
    half = len(trace.events) // 2
    names = {0: 1, 1: 0}
    changed = [
        evolve(event, robot=names.get(event.robot, event.robot)) if hasattr(event, "robot") else event
        for event in trace.events[half:]
    ]
    return evolve(trace, events=(*trace.events[:half], *changed))


def other_sku(trace: Trace) -> Trace:
    """Pick a SKU that the pod has and the order does not want."""
    for at, event in enumerate(trace.events):
        if isinstance(event, ItemPicked):
            held, wanted = trace.instance.pods[event.pod].contents, trace.instance.orders[event.order].lines
            spare = {sku for sku, _ in held} - {sku for sku, _ in wanted}
            if spare:
                return put(trace, at, evolve(event, sku=min(spare)))
    raise AssertionError("every pod holds only what is wanted")


def without_stock(number: int | None) -> Damage:
    """Return the damage that leaves so many items of a SKU on the pod it is picked from; None: not even the SKU."""

    def damage(trace: Trace) -> Trace:
        event = trace.events[find(trace, ItemPicked)]
        assert isinstance(event, ItemPicked)
        pod = trace.instance.pods[event.pod]
        contents = tuple(
            (sku, number if sku == event.sku else held)
            for sku, held in pod.contents
            if sku != event.sku or number is not None
        )
        pods = list(trace.instance.pods)
        pods[event.pod] = evolve(pod, contents=contents)
        return evolve(trace, instance=evolve(trace.instance, pods=tuple(pods)))

    return damage


def less_capacity(trace: Trace) -> Trace:
    """Give the stations less capacity than they used, in scenario and header."""
    stations = {**trace.scenario["stations"], "item_capacity": 2}
    return evolve(
        trace,
        scenario={**trace.scenario, "stations": stations},
        stations=tuple({**station, "capacity": 2} for station in trace.stations),
    )


def other_header_capacity(trace: Trace) -> Trace:
    """Give the stations another capacity than the scenario says."""
    return evolve(trace, stations=tuple({**station, "capacity": 99} for station in trace.stations))


def faster_robots(trace: Trace) -> Trace:
    """Let the robots be faster than the scenario says."""
    return evolve(trace, motion=evolve(trace.motion, lift_s=1.0))


def short_queue(trace: Trace) -> Trace:
    """Leave no place but the station, and let two robots be in line for it."""
    at = find(trace, QueueJoined)
    changed = put(trace, at, trace.events[at], evolve(trace.events[at], robot=other(len(trace.robots), 0)))
    return evolve(changed, scenario={**trace.scenario, "stations": {**trace.scenario["stations"], "queue_length": 0}})


def blocked_goal(trace: Trace) -> Trace:
    """Let an empty pod stand where a pod is set down."""
    event = trace.events[find(trace, PodStored)]
    assert isinstance(event, PodStored)
    homes = {pod["cell"] for pod in trace.pods}
    free = next(e for e in trace.events if isinstance(e, PodStored) and e.cell not in homes)
    return evolve(trace, blocked=(*trace.blocked, free.cell))


def pods_on_one_another(trace: Trace) -> Trace:
    """Let two pods start in one storage location."""
    return evolve(trace, pods=(trace.pods[0], {**trace.pods[1], "cell": trace.pods[0]["cell"]}, *trace.pods[2:]))


def pod_on_floor(trace: Trace) -> Trace:
    """Let a pod start on the floor."""
    return evolve(trace, pods=({**trace.pods[0], "cell": 0}, *trace.pods[1:]))


def lift_while_loaded(trace: Trace) -> Trace:
    """Lift a second pod."""
    at = find(trace, PodLifted)
    event = trace.events[at]
    assert isinstance(event, PodLifted)
    return put(trace, at, event, evolve(event, pod=other(len(trace.pods), event.pod)))


def lift_of_another(trace: Trace) -> Trace:
    """Let another robot lift a pod that is carried already."""
    at = find(trace, PodLifted)
    event = trace.events[at]
    assert isinstance(event, PodLifted)
    return put(trace, at, event, evolve(event, robot=other(len(trace.robots), event.robot)))


def queue_jumper(trace: Trace) -> Trace:
    """Exchange two robots in a line."""
    for i, first in enumerate(trace.events):
        if not isinstance(first, QueueJoined):
            continue
        for j in range(i + 1, len(trace.events)):
            second = trace.events[j]
            if isinstance(second, VisitEnded) and second.station == first.station:
                break
            if isinstance(second, QueueJoined) and second.station == first.station:
                return put(put(trace, i, evolve(second, tick=first.tick)), j, evolve(first, tick=second.tick))
    raise AssertionError("no two robots were in a line at once")


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


def move_in_visit(trace: Trace) -> Trace:
    """Let the robot at a station drive off and come back before the visit has ended."""
    at = find(trace, VisitEnded)
    ended = trace.events[at]
    assert isinstance(ended, VisitEnded)
    began = next(e for e in trace.events if isinstance(e, VisitStarted) and e.visit == ended.visit)
    cell = trace.layout.stations[ended.station].station
    wait = RobotMoved(ended.tick, ended.tick - 500, began.robot, cell, cell, 0, 500, 0, 0, ended.pod)
    return put(trace, at, wait, ended)


def pick_of_complete_order(trace: Trace) -> Trace:
    """Tell of the last pick twice, a handling time later."""
    at = find(trace, ItemPicked, number=10**6)
    event = trace.events[at]
    assert isinstance(event, ItemPicked)
    again = evolve(
        event,
        start_tick=event.picker_free_tick,
        tick=event.picker_free_tick + 7000,
        picker_free_tick=event.picker_free_tick + 13_000,
    )
    return evolve(put(trace, at, event, again), tick=again.tick)


def partial_though_complete(trace: Trace) -> Trace:
    """Call a complete run partial."""
    return evolve(trace, status="partial")


def ends_early(trace: Trace) -> Trace:
    """Let the run end before its last event."""
    return evolve(trace, tick=trace.tick - 1)


def lane_visit(trace: Trace) -> Trace:
    """Leave out that a pod joined a line and what it did there."""
    at = find(trace, QueueJoined)
    joined = trace.events[at]
    assert isinstance(joined, QueueJoined)
    begun = next(i for i in range(at, len(trace.events)) if getattr(trace.events[i], "visit", None) is not None)
    visit = getattr(trace.events[begun], "visit", None)
    kept = [e for i, e in enumerate(trace.events) if i != at and getattr(e, "visit", None) != visit]
    return evolve(trace, events=tuple(kept))


def long_first(event: RobotMoved) -> bool:
    """Whether a run has some cells."""
    return event.distance_m > 3


def one_item(event: OrderAssigned) -> bool:
    """Whether a whole order of several lines is assigned."""
    return len(event.skus) > 1


DAMAGES: list[tuple[str, Damage, str]] = [
    ("a run a second earlier", change(RobotMoved, shift_run, where=long_first), "time-overlap"),
    ("a run that ends early", change(RobotMoved, lambda t, e: {"tick": e.tick - 400}, where=long_first), "too-fast"),
    ("a run that starts early", change(RobotMoved, lambda t, e: {"wait_ticks": -9}, where=long_first), "negative-time"),
    ("a run that ends late", change(RobotMoved, lambda t, e: {"tick": e.tick + 400}, where=long_first), "too-slow"),
    ("a run with fewer metres", change(RobotMoved, lambda t, e: {"distance_m": e.distance_m - 1}), "distance"),
    ("a turn for nothing", change(RobotMoved, lambda t, e: {"turn_ticks": e.turn_ticks + 1}), "turn-time"),
    ("a robot that drives backwards", change(RobotMoved, lambda t, e: {"heading": (e.heading + 2) % 4}), "heading"),
    ("a run dropped", drop(RobotMoved, number=5), "teleport"),
    ("two robots exchanged", swap_robots, "teleport"),
    (
        "a run to beside its end",
        change(RobotMoved, lambda t, e: {"to": e.to + (1 if e.heading % 2 else t.layout.width)}, where=long_first),
        "not-straight",
    ),
    ("a run to the edge of the world", change(RobotMoved, lambda t, e: {"to": 10**6}), "unknown-id"),
    (
        "a load that nobody lifted",
        change(RobotMoved, lambda t, e: {"pod": 0}, where=lambda e: e.pod is None),
        "pod-mismatch",
    ),
    ("a lift dropped", drop(PodLifted), "pod-mismatch"),
    ("a lift elsewhere", change(PodLifted, lambda t, e: {"cell": 0}), "pod-not-there"),
    ("a lift where the robot is not", change(PodLifted, lambda t, e: {"cell": 0}), "robot-elsewhere"),
    ("a lift of another pod", change(PodLifted, lambda t, e: {"pod": other(len(t.pods), e.pod)}), "no-task"),
    ("a lift of two pods", lift_while_loaded, "robot-loaded"),
    ("a lift by two robots", lift_of_another, "pod-in-use"),
    ("a lift too short", change(PodLifted, lambda t, e: {"start_tick": e.start_tick + 100}), "lift-time"),
    ("a setting down too long", change(PodStored, lambda t, e: {"start_tick": e.start_tick - 100}), "lift-time"),
    ("a pod set down by another robot", change(PodStored, lambda t, e: {"robot": other(4, e.robot)}), "pod-in-use"),
    ("a pod set down on the floor", change(PodStored, lambda t, e: {"cell": 0}), "no-storage-location"),
    ("a pod set down on another", blocked_goal, "location-taken"),
    ("two pods in one place", pods_on_one_another, "location-taken"),
    ("a pod that starts on the floor", pod_on_floor, "no-storage-location"),
    ("a task dropped", drop(TaskAssigned), "no-task"),
    ("a second task", change(TaskAssigned, lambda t, e: {"robot": other(4, e.robot)}, number=9), "robot-busy"),
    ("a trip dropped", drop(TripDecided), "not-bound"),
    ("a trip to two stations", change(TripDecided, lambda t, e: {"station": 1 - e.station}), "not-bound"),
    ("a trip twice", repeat(TripDecided), "bound-twice"),
    ("a line joined twice", repeat(QueueJoined), "queue-order"),
    ("a line not joined", drop(QueueJoined), "queue-order"),
    ("a robot before its turn", queue_jumper, "queue-order"),
    ("a line too long", short_queue, "queue-too-long"),
    ("a queue used as a shortcut", lane_visit, "queue-lane"),
    ("a visit dropped", drop(VisitStarted), "visit-number"),
    ("a visit at another station", change(VisitStarted, lambda t, e: {"station": 1 - e.station}), "robot-elsewhere"),
    ("a visit by another pod", change(VisitStarted, lambda t, e: {"pod": other(len(t.pods), e.pod)}), "pod-mismatch"),
    ("a visit twice", repeat(VisitStarted), "station-busy"),
    ("a visit's end dropped", drop(VisitEnded), "station-busy"),
    ("a visit's end twice", repeat(VisitEnded), "visit-end"),
    ("a visit with other picks", change(VisitEnded, lambda t, e: {"picks": e.picks + 1}), "visit-picks"),
    ("a visit without its robot", move_in_visit, "moved-in-visit"),
    (
        "a pod that goes elsewhere",
        change(VisitEnded, lambda t, e: {"next_station": 1 - e.station}),
        "next-station",
    ),
    ("a pod that leaves too early", earlier(VisitEnded, by=2, where=lambda e: e.picks > 1), "left-early"),
    ("a pick dropped", drop(ItemPicked), "completed-early"),
    ("a pick twice", repeat(ItemPicked), "picker-busy"),
    ("a pick too many", pick_of_complete_order, "picked-twice"),
    ("a pick in another visit", change(ItemPicked, lambda t, e: {"visit": e.visit + 1}), "no-visit"),
    ("a pick before the visit", change(ItemPicked, lambda t, e: {"start_tick": 0}), "no-visit"),
    ("a pick too short", change(ItemPicked, lambda t, e: {"start_tick": e.start_tick + 10}), "pick-time"),
    ("a pick handled too fast", change(ItemPicked, lambda t, e: {"picker_free_tick": e.tick}), "handle-time"),
    ("a pick for nobody", other_sku, "not-ordered"),
    ("a pick from a pod without the SKU", without_stock(None), "sku-not-on-pod"),
    ("a pick from an empty pod", without_stock(0), "stock-negative"),
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
    ("events out of order", change(OrderCompleted, lambda t, e: {"tick": e.tick - 1}), "time-order"),
    ("a run's end before its last event", ends_early, "time-order"),
    ("a complete run called partial", partial_though_complete, "status"),
    ("a header with another capacity", other_header_capacity, "header"),
    ("a header with faster robots", faster_robots, "header"),
]


@pytest.mark.parametrize(("damage", "kind"), [pytest.param(d, k, id=name) for name, d, k in DAMAGES])
def test_damage_is_found_and_named(recorded: Trace, damage: Damage, kind: str) -> None:
    """Whatever is wrong is among the faults, each of a known kind and with a sentence."""
    faults = faults_of(damage(recorded))
    assert kind in {fault.kind for fault in faults}
    assert all(fault.kind in KINDS and len(fault.sentence) > 20 for fault in faults)
    assert [fault.tick for fault in faults] == sorted(fault.tick for fault in faults)


def test_one_damage_is_not_a_thousand_faults(recorded: Trace) -> None:
    """After a fault the validation goes on from what the trace says, so that a single slip shows as a few faults."""
    numbers = [len(faults_of(damage(recorded))) for _, damage, _ in DAMAGES if damage is not swap_robots]
    assert sorted(numbers)[len(numbers) // 2] <= 3


ELSEWHERE = {"wall", "one-way", "collision", "swap", "through-stored-pod", "storage-crossed", "metric", "other-run"}
"""Kinds that the traces written by hand show, and those that need a result."""


def test_every_kind_of_fault_is_injected() -> None:
    """No kind of fault is without a test."""
    assert {kind for _, _, kind in DAMAGES} | ELSEWHERE == KINDS.keys()
