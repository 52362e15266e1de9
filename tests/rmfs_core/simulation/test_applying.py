"""Carrying out decisions: the warehouse changes, and each part of a decision is an event."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from rmfs_commands.testing import small_world
from rmfs_core.decisions import JointDecision, OrderAssignment, PodTrip, TaskAssignment
from rmfs_core.events import Event, OrderAssigned, TaskAssigned, TripDecided
from rmfs_core.simulation.applying import apply_assignments, apply_selection, apply_tasks
from rmfs_core.simulation.asking import ImpossibleError
from rmfs_core.warehouse import Warehouse


def assigned(
    world: Warehouse, answer: object, *, joint: bool = False, period: int = 1, packing_capacity: int | None = None
) -> list[Event]:
    """Carry out a decision on orders; return its events."""
    events: list[Event] = []
    apply_assignments(
        world,
        answer,
        joint=joint,
        shown=None,
        period=period,
        packing_capacity=packing_capacity,
        keep=events.append,
    )
    return events


def selected(world: Warehouse, trips: Sequence[PodTrip], max_fetches: int) -> list[Event]:
    """Carry out a decision on pods; return its events."""
    events: list[Event] = []
    apply_selection(world, trips, max_fetches=max_fetches, keep=events.append)
    return events


def test_an_order_is_assigned_whole_or_line_by_line() -> None:
    """The event has what was assigned, the period, and whether anything is left in the backlog."""
    world = small_world({"1": {"a": 2, "b": 1}, "2": ["b"]}, {"p": ["a", "b"]}, capacities=[5])
    world.advance(70)
    events = assigned(world, [OrderAssignment(0, 0, skus=(1,)), OrderAssignment(1, 0)], period=4)
    assert events == [
        OrderAssigned(70, order=0, station=0, skus=(1,), items=1, period=4, complete=False),
        OrderAssigned(70, order=1, station=0, skus=(1,), items=1, period=4, complete=True),
    ]
    assert assigned(world, [OrderAssignment(0, 0)], period=5) == [
        OrderAssigned(70, order=0, station=0, skus=(0,), items=2, period=5, complete=True)
    ]
    assert not world.backlog
    assert world.stations[0].load == 4


def test_what_came_before_the_impossible_has_been_done() -> None:
    """Who asked keeps the events from the observers then: the run is over."""
    world = small_world({"1": ["a"]}, {"p": ["a"]}, capacities=[5])
    events: list[Event] = []
    with pytest.raises(ImpossibleError, match="named order 9"):
        apply_assignments(
            world,
            [OrderAssignment(0, 0), OrderAssignment(9, 0)],
            joint=False,
            shown=None,
            period=1,
            packing_capacity=None,
            keep=events.append,
        )
    assert [type(event) for event in events] == [OrderAssigned]


def test_only_orders_that_were_shown_may_be_assigned() -> None:
    """A prefilter may have left the others out."""
    world = small_world({"1": ["a"], "2": ["a"]}, {"p": ["a"]}, capacities=[5])
    arguments = {"joint": False, "period": 1, "packing_capacity": None, "keep": [].append}
    apply_assignments(world, [OrderAssignment(1, 0)], shown={1}, **arguments)  # type: ignore[arg-type]
    with pytest.raises(ImpossibleError, match=r"order 1 \(id 0\) .* was not in the backlog it was shown"):
        apply_assignments(world, [OrderAssignment(0, 0)], shown={1}, **arguments)  # type: ignore[arg-type]


def test_a_joint_decisions_trips_come_before_its_orders() -> None:
    """Pods are bound first, and their items are promised to what the decision itself assigns."""
    world = small_world({"old": ["a"], "new": ["a"]}, {"p": {"a": 1}, "q": {"a": 1}}, capacities=[5])
    station = world.stations[0]
    world.assign(world.orders[0], station, [0])  # uncovered, as other rules may leave it
    decision = JointDecision((OrderAssignment(1, 0),), (PodTrip(1, 0),))
    assert assigned(world, decision, joint=True) == [
        TripDecided(0, pod=1, station=0),
        OrderAssigned(0, order=1, station=0, skus=(0,), items=1, period=1, complete=True),
    ]
    assert [(request.order.name, request.covered) for request in station.open_requests] == [
        ("old", False),
        ("new", True),
    ]


def test_a_pod_for_several_stations_visits_the_nearer_one_first() -> None:
    """Whatever the order of the trips; the trips of other pods keep their places among them."""
    orders = {"1": ["a"], "2": ["a"], "3": ["b"]}
    world = small_world(orders, {"p": ["a"], "q": ["b"]}, capacities=[5, 5])
    pod = world.pods[0]
    ticks = [int(world.travel.times_to(station.cell, True)[pod.cell].min()) for station in world.stations]
    near, far = sorted((0, 1), key=lambda station: ticks[station])
    assert ticks[near] < ticks[far]
    assignments = (OrderAssignment(0, 0), OrderAssignment(1, 1), OrderAssignment(2, far))
    trips = (PodTrip(0, far), PodTrip(1, far), PodTrip(0, near))
    events = assigned(world, JointDecision(assignments, trips), joint=True)
    assert [(event.pod, event.station) for event in events if isinstance(event, TripDecided)] == [
        (0, near),
        (1, far),
        (0, far),
    ]
    assert pod.bound_for == (near, far)


@pytest.mark.parametrize("capacity", [None, 2])
def test_split_orders_need_room_at_the_packing_stations(capacity: int | None) -> None:
    """Each split order takes a place until it is picked; None is room for any number."""
    world = small_world({"1": ["a", "b"], "2": ["a", "b"]}, {"p": ["a", "b"]}, capacities=[5])
    split = [OrderAssignment(order, 0, skus=(0,)) for order in range(2)]
    assert len(assigned(world, split, packing_capacity=capacity)) == 2
    again = small_world({"1": ["a", "b"], "2": ["a", "b"]}, {"p": ["a", "b"]}, capacities=[5])
    with pytest.raises(ImpossibleError, match=r"^left 2 split orders open at once; the packing stations hold 1$"):
        assigned(again, split, packing_capacity=1)


def test_only_stored_pods_need_robots() -> None:
    """A pod that leaves a station goes on with the robot that carries it: it is no fetch."""
    world = small_world(
        {"1": ["a"], "2": ["a"], "3": ["b"]}, {"p": ["a"], "q": ["b"], "r": ["a"]}, capacities=[5, 5], robots=1
    )
    world.place_at_station(world.robots[0], world.pods[0], world.stations[0])
    assigned(world, [OrderAssignment(1, 1), OrderAssignment(2, 1)])
    events = selected(world, [PodTrip(0, 1), PodTrip(1, 1)], max_fetches=1)
    assert events == [TripDecided(0, pod=0, station=1), TripDecided(0, pod=1, station=1)]
    assert (world.pods[0].bound_for, list(world.waiting)) == ((0, 1), [1])
    assert all(request.covered for request in world.stations[1].open_requests)


def test_no_more_stored_pods_are_sent_than_robots_can_start() -> None:
    """The number is in the sentence."""
    world = small_world({"1": ["a", "b"]}, {"p": ["a"], "q": ["b"]}, capacities=[5])
    assigned(world, [OrderAssignment(0, 0)])
    with pytest.raises(ImpossibleError) as caught:
        selected(world, [PodTrip(0, 0), PodTrip(1, 0)], max_fetches=1)
    assert str(caught.value) == "sent 2 stored pods on their way; at most 1 robots can start"


def test_tasks_are_given_told_and_begun_one_by_one() -> None:
    """The robot is busy and the pod waits no more when the robot sets off."""
    world = small_world({"1": ["a", "b"]}, {"p": ["a"], "q": ["b"]}, capacities=[5])
    for pod in world.pods:
        world.bind(pod, world.stations[0])
    happened: list[object] = []
    answer = [TaskAssignment(1, 0), TaskAssignment(0, 1)]
    apply_tasks(
        world, answer, happened.append, lambda robot, pod: happened.append((robot.id, pod.id, robot.task, pod.robot))
    )
    assert happened == [TaskAssigned(0, robot=1, pod=0), (1, 0, 0, 1), TaskAssigned(0, robot=0, pod=1), (0, 1, 1, 0)]
    assert world.waiting == {}
