"""What makes a decision impossible. Each check raises `ImpossibleError` with one sentence."""

from __future__ import annotations

from collections.abc import Container, Sequence
from typing import Any

from rmfs_core.decisions import Leg, OrderAssignment, PodTrip, TaskAssignment
from rmfs_core.simulation.asking import ImpossibleError
from rmfs_core.warehouse import Order, Pod, Robot, Station, Warehouse


def known(kind: str, identifier: Any, among: Sequence[Any]) -> Any:
    """Return the order, pod, station or robot with an id."""
    if isinstance(identifier, bool) or not isinstance(identifier, int):
        raise ImpossibleError(f"named {kind} {identifier!r}; expected an id, a whole number")
    if not 0 <= identifier < len(among):
        raise ImpossibleError(f"named {kind} {identifier}, which does not exist; ids are 0 to {len(among) - 1}")
    return among[identifier]


def assignment(warehouse: Warehouse, given: OrderAssignment, seen: Container[int]) -> tuple[Order, Station, list[int]]:
    """Check an order assignment; return order, station and the SKUs of the lines to assign."""
    order: Order = known("order", given.order, warehouse.orders)
    station: Station = known("station", given.station, warehouse.stations)
    if order.id not in seen or not order._open:
        why = "was not in the backlog it was shown" if order._open else "has no open line left"
        raise ImpossibleError(f"assigned order {order.name} to station {station.name}, but the order {why}")
    skus = list(order._open) if given.skus is None else list(given.skus)
    if not skus or len(set(skus)) != len(skus):
        raise ImpossibleError(f"assigned SKUs {given.skus} of order {order.name}; expected one or more, each once")
    for sku in skus:
        if sku not in order._open:
            raise ImpossibleError(f"assigned SKU id {sku} of order {order.name}, which is no open line of it")
    size = 1 if station.counts_orders else sum(order._open[sku].quantity for sku in skus)
    if size > station.free_capacity:
        unit = "orders" if station.counts_orders else "items"
        raise ImpossibleError(
            f"assigned order {order.name} to station {station.name}: it takes {size} {unit}, "
            f"but only {station.free_capacity} of {station.capacity} are free"
        )
    return order, station, skus


def trip(warehouse: Warehouse, given: PodTrip) -> tuple[Pod, Station]:
    """Check that a pod can be bound for a station."""
    pod: Pod = known("pod", given.pod, warehouse.pods)
    station: Station = known("station", given.station, warehouse.stations)
    if station.id in pod.bound_for:
        raise ImpossibleError(f"sent pod {pod.name} to station {station.name}, where it already is or is bound for")
    return pod, station


def selected_trip(warehouse: Warehouse, given: PodTrip, leaving: Container[int]) -> tuple[Pod, Station]:
    """Check a trip that PPS decided: the pod is free or leaving, and serves an uncovered request."""
    pod, station = trip(warehouse, given)
    if pod.id not in leaving and (pod.location is None or pod.bound_for):
        raise ImpossibleError(f"sent pod {pod.name} to station {station.name}, but the pod is in use")
    if not any(pod.free_items(request.sku) > 0 for request in station.uncovered_requests):
        raise ImpossibleError(
            f"sent pod {pod.name} to station {station.name}, but it holds no item of any request uncovered there"
        )
    return pod, station


def covered(stations: Sequence[Station]) -> None:
    """Check that no request is left uncovered after a joint decision."""
    for station in stations:
        for request in station.uncovered_requests:
            raise ImpossibleError(
                f"assigned order {request.order.name} to station {station.name}, but no pod there or bound for it "
                f"has an item of SKU id {request.sku} left for it"
            )


def packing(warehouse: Warehouse, capacity: int | None) -> None:
    """Check that the split orders under way find room at the packing stations."""
    if capacity is not None and warehouse.split_orders_open > capacity:
        raise ImpossibleError(
            f"left {warehouse.split_orders_open} split orders open at once; the packing stations hold {capacity}"
        )


def task(warehouse: Warehouse, given: TaskAssignment) -> tuple[Robot, Pod]:
    """Check that a robot can fetch a pod."""
    robot: Robot = known("robot", given.robot, warehouse.robots)
    pod: Pod = known("pod", given.pod, warehouse.pods)
    if not robot.idle:
        raise ImpossibleError(f"gave pod {pod.name} to robot {robot.name}, which is busy")
    if pod.id not in warehouse.waiting:
        raise ImpossibleError(f"gave pod {pod.name} to robot {robot.name}, but the pod does not wait for a robot")
    return robot, pod


def storage_location(warehouse: Warehouse, pod: Pod, cell: int) -> int:
    """Check that a pod can be stored in a cell."""
    layout = warehouse.travel.layout
    if cell not in warehouse.free_locations:
        if not 0 <= cell < layout.width * layout.height:
            what = f"cell {cell}, which is not on the grid"
        elif cell not in layout.storage_locations:
            what = f"{layout.where(cell)} (cell {cell}), which is no storage location"
        else:
            what = f"{layout.where(cell)} (cell {cell}), which is taken"
        raise ImpossibleError(f"stores pod {pod.name} at {what}")
    return cell


def path(warehouse: Warehouse, robot: Robot, goal: int, legs: Sequence[Leg]) -> None:
    """Check that a robot can drive a path, and that the path gets anywhere."""
    travel = warehouse.travel
    loaded = robot.pod is not None
    cells = travel.layout.width * travel.layout.height
    if not legs:
        raise ImpossibleError(f"gave robot {robot.name} an empty path to {travel.layout.where(goal)}")
    at = robot.cell
    for leg in legs:
        if not isinstance(leg, Leg):
            raise ImpossibleError(f"returned a path with {type(leg).__name__} {leg!r:.80} in it; expected Leg only")
        if not 0 <= leg.to < cells:
            raise ImpossibleError(f"sent robot {robot.name} to cell {leg.to}, which is not on the grid")
        if leg.wait_ticks < 0 or (leg.to == at and leg.wait_ticks == 0):
            raise ImpossibleError(f"gave robot {robot.name} a leg that waits {leg.wait_ticks} ticks and goes nowhere")
        if leg.to != at:
            problem = travel.run_problem(robot.cell, at, leg.to, goal, loaded)
            if problem is not None:
                raise ImpossibleError(f"gave robot {robot.name} an impossible path: {problem}")
        at = leg.to
