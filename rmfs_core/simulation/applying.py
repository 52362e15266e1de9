"""Carrying out what a rule decided: each part is checked, then changes the warehouse, then becomes an event."""

from __future__ import annotations

from collections.abc import Callable, Container

from rmfs_core import events
from rmfs_core.decisions import (
    BundleAssignment,
    BundleDecision,
    JointDecision,
    OrderAssignment,
    PodMove,
    PodTrip,
    RobotMove,
    SolveReport,
    StoreBundle,
    TaskAssignment,
)
from rmfs_core.roles import Role
from rmfs_core.simulation import checks
from rmfs_core.simulation.asking import ImpossibleError, instance_of, sequence_of
from rmfs_core.warehouse import Pod, Robot, Station, Warehouse

Keep = Callable[[events.Event], None]


def apply_assignments(
    warehouse: Warehouse,
    answer: object,
    *,
    joint: bool,
    shown: Container[int] | None,
    period: int,
    packing_capacity: int | None,
    keep: Keep,
) -> JointDecision:
    """Assign the orders of a POA or joint decision and bind the pods of its trips; return the decision.

    Parameters
    ----------
    warehouse
        The state.
    answer
        The rule's answer.
    joint
        Whether the rule decides POA and PPS together.
    shown
        Ids of the orders that the rule was shown; None: the whole backlog.
    period
        Number of the period.
    packing_capacity
        Split orders that may be open at once; None: any number.
    keep
        Takes the events.

    Raises
    ------
    ImpossibleError
        When the decision cannot be carried out; what came before in it has been.
    """
    decision = instance_of(answer, JointDecision) if joint else JointDecision(sequence_of(answer, OrderAssignment))
    if decision.report is not None:
        instance_of(decision.report, SolveReport)
    # Some may be uncovered before a joint rule is asked: in a state that other rules have led to.
    split, first = warehouse.split_orders_open, warehouse.next_request
    trips = [checks.trip(warehouse, given) for given in sequence_of(decision.trips, PodTrip)]
    trips = _nearer_first(warehouse, trips) if trips else trips
    for pod, station in trips:
        _bind(warehouse, *checks.trip(warehouse, PodTrip(pod.id, station.id)), keep, promise=False)
    for given in sequence_of(decision.assignments, OrderAssignment):
        _assign(warehouse, given, shown, period, keep)
    for pod, station in trips:  # what the decision assigns comes before what was uncovered already
        warehouse.promises.promise_items(pod, station)
    if joint:
        if warehouse.next_request > first:
            checks.covered(warehouse.stations, first)
        checks.wanted(trips)
    checks.packing(warehouse, packing_capacity, split)
    return decision


def apply_selection(warehouse: Warehouse, answer: object, *, max_fetches: int, keep: Keep) -> JointDecision:
    """Bind the pods of a PPS decision; return it."""
    trips = sequence_of(answer, PodTrip)
    leaving: set[int] = set()
    uncovered: dict[int, dict[int, int]] = {}
    fetches = 0
    for given in trips:
        pod, station = checks.selected_trip(warehouse, given, leaving, uncovered)
        fetches += pod.location is not None
        if fetches > max_fetches:
            raise _too_many(fetches, max_fetches)
        _bind(warehouse, pod, station, keep)
    return JointDecision(trips=trips)


def apply_replenishment(
    warehouse: Warehouse, answer: object, *, role: Role, max_fetches: int, keep: Keep
) -> BundleDecision:
    """Assign the bundles of a ROA, RPS or joint decision to stations, bind them to pods; return the decision."""
    match role:
        case Role.ROA:
            decision = BundleDecision(sequence_of(answer, BundleAssignment))
        case Role.RPS:
            decision = BundleDecision(stores=sequence_of(answer, StoreBundle))
        case _:
            decision = instance_of(answer, BundleDecision)
    if decision.report is not None:
        instance_of(decision.report, SolveReport)
    for assigned in sequence_of(decision.assignments, BundleAssignment):
        bundle, at = checks.bundle_assignment(warehouse, assigned)
        warehouse.assign_bundle(bundle, at)
        keep(events.BundleAssigned(tick=warehouse.now, bundle=bundle.id, station=at.id))
    fetches = 0
    for chosen in sequence_of(decision.stores, StoreBundle):
        bundle, pod = checks.store(warehouse, chosen)
        fetches += not pod.bound_for
        if fetches > max_fetches:
            raise _too_many(fetches, max_fetches)
        station = warehouse.bind_bundle(bundle, pod)
        keep(events.BundleBound(tick=warehouse.now, bundle=bundle.id, pod=pod.id))
        if station is not None:
            keep(events.TripDecided(tick=warehouse.now, pod=pod.id, station=station.id))
    return decision


def _too_many(fetches: int, most: int) -> ImpossibleError:
    return ImpossibleError(f"sent too many stored pods ({fetches}); expected at most {most}, the robots that can start")


def apply_tasks(warehouse: Warehouse, answer: object, keep: Keep, start: Callable[[Robot, Pod], None]) -> None:
    """Give the robots of a TA decision their tasks; ``start`` sets each off."""
    for given in sequence_of(answer, TaskAssignment):
        robot, pod = checks.task(warehouse, given)
        warehouse.take_task(robot, pod)
        keep(events.TaskAssigned(tick=warehouse.now, robot=robot.id, pod=pod.id))
        start(robot, pod)


def apply_activation(warehouse: Warehouse, answer: object, keep: Keep) -> None:
    """Activate the picking stations of an answer, and no others."""
    active = {checks.known("station", given, warehouse.picking).id for given in sequence_of(answer, object)}
    for station in warehouse.picking:
        was_open = station.open
        warehouse.activate(station, station.id in active)
        tell_open(warehouse, station, was_open, keep)


def tell_open(warehouse: Warehouse, station: Station, was_open: bool, tell: Keep) -> None:
    """Tell that a station has opened or closed, if it has."""
    if station.open is not was_open:
        tell((events.StationOpened if station.open else events.StationClosed)(tick=warehouse.now, station=station.id))


def apply_moves(
    warehouse: Warehouse, answer: object, max_moves: int, keep: Keep, start: Callable[[Robot, Pod, int], None]
) -> None:
    """Let idle robots carry the pods of a repositioning decision, each the robot that is there first."""
    moves = sequence_of(answer, PodMove)
    if len(moves) > max_moves:
        raise ImpossibleError(f"moves too many pods ({len(moves)}); expected at most {max_moves} now")
    for given in moves:
        pod, cell = checks.move(warehouse, given)
        ticks = warehouse.travel.times_to(pod.cell, False)
        robot = min(warehouse.idle, key=lambda robot: (int(ticks[robot.cell, robot.heading]), robot.id))
        warehouse.waiting[pod.id] = pod
        warehouse.take_task(robot, pod)
        warehouse.reserve(cell)
        keep(events.PodMoveDecided(tick=warehouse.now, robot=robot.id, pod=pod.id, cell=cell))
        start(robot, pod, cell)


def apply_rests(warehouse: Warehouse, answer: object, keep: Keep, start: Callable[[Robot, int, float], None]) -> None:
    """Send robots without a task to where they rest."""
    for given in sequence_of(answer, RobotMove):
        robot, cell, share = checks.rest(warehouse, given)
        warehouse.send(robot, cell)
        keep(events.RobotSent(tick=warehouse.now, robot=robot.id, cell=cell))
        start(robot, cell, share)


def _nearer_first(warehouse: Warehouse, trips: list[tuple[Pod, Station]]) -> list[tuple[Pod, Station]]:
    """Let a pod that is sent to several stations at once visit the nearer ones first (in the trips' positions)."""
    by_pod: dict[int, list[Station]] = {}
    for pod, station in trips:
        by_pod.setdefault(pod.id, []).append(station)
    for pod_id, stations in by_pod.items():
        if len(stations) > 1:
            cell = warehouse.pods[pod_id].cell
            ticks = {s.id: int(warehouse.travel.times_to(s.cell, True)[cell].min()) for s in stations}
            stations.sort(key=lambda s, ticks=ticks: (ticks[s.id], s.id))  # type: ignore[misc]
    return [(pod, by_pod[pod.id].pop(0)) for pod, _ in trips]


def _bind(warehouse: Warehouse, pod: Pod, station: Station, keep: Keep, *, promise: bool = True) -> None:
    warehouse.bind(pod, station, promise=promise)
    keep(events.TripDecided(tick=warehouse.now, pod=pod.id, station=station.id))


def _assign(
    warehouse: Warehouse, given: OrderAssignment, shown: Container[int] | None, period: int, keep: Keep
) -> None:
    order, station, skus = checks.assignment(warehouse, given, shown)
    items = warehouse.assign(order, station, skus, period)
    complete = not order.open_lines
    keep(events.OrderAssigned(warehouse.now, order.id, station.id, tuple(skus), items, period, complete))
