"""Checks for impossible decisions. Each check raises `ImpossibleError` with one sentence."""

from __future__ import annotations

import operator
from collections.abc import Collection, Container, Sequence
from contextlib import suppress
from typing import Any, TypeVar

import numpy as np

from rmfs_core import decisions
from rmfs_core.clock import to_seconds, to_ticks
from rmfs_core.simulation.asking import ImpossibleError
from rmfs_core.warehouse import Bundle, Order, Pod, Robot, Station, Warehouse
from rmfs_core.wording import counted, shown_short
from rmfs_core.world import Layout

T = TypeVar("T")
LONGEST_WAIT_TICKS = 30 * 86_400_000
"""A leg may wait 30 days: longer than any traffic jam of the slowest robots, short enough for exact sums of ticks."""


def whole(what: str, value: object) -> int:
    """Return a whole number, which numpy's integers are too and True is not."""
    if type(value) is int:
        return value
    with suppress(TypeError):
        if not isinstance(value, (bool, np.bool_)):
            return operator.index(value)  # type: ignore[arg-type]
    raise ImpossibleError(f"named {what} {shown_short(value)}; expected a whole number")


def known(kind: str, identifier: object, among: Sequence[T]) -> T:
    """Return the order, pod, station or robot with an id."""
    index = whole(kind, identifier)
    if not 0 <= index < len(among):
        raise ImpossibleError(f"named {kind} {index}, which does not exist; ids are 0 to {len(among) - 1}")
    return among[index]


def assignment(
    warehouse: Warehouse, given: decisions.OrderAssignment, seen: Container[int] | None
) -> tuple[Order, Station, list[int]]:
    """Check an order assignment; return order, station and the SKUs of the lines to assign.

    ``seen`` has the ids of the orders that the rule was shown; None: the whole backlog.
    """
    order = known("order", given.order, warehouse.orders)
    station = known("station", given.station, warehouse.picking)
    if order not in warehouse.backlog or not (seen is None or order.id in seen):
        why = "was not in the backlog it was shown" if order.open_lines else "has no open line left"
        why = "waits for stock" if order.waits_for_stock else "is cancelled" if order.cancelled else why
        raise ImpossibleError(f"assigned order {order.label} to station {station.label}, but the order {why}")
    skus, size = [line.sku for line in order.open_lines], warehouse.size_at(order, station)
    if given.skus is not None:
        quantities = {line.sku: line.quantity for line in order.open_lines}
        skus = _skus(order, given.skus, quantities)
        if not station.counts_orders and len(skus) < len(quantities):
            size = sum(quantities[sku] for sku in skus)
    if size > station.free_capacity:  # what joins an order there uses none, and is no new order
        if not station.open:
            raise ImpossibleError(f"assigned order {order.label} to station {station.label}, which is closed")
        unit = "orders" if station.counts_orders else "items"
        takes = f"it takes {size} {unit}, but only {station.free_capacity} of {station.capacity} are free"
        raise ImpossibleError(f"assigned order {order.label} to station {station.label}: {takes}")
    return order, station, skus


def _skus(order: Order, given: object, open_skus: Container[int]) -> list[int]:
    if not isinstance(given, Collection) or isinstance(given, str) or getattr(given, "shape", None) == ():
        raise ImpossibleError(f"assigned SKUs {shown_short(given)} of order {order.label}; expected a sequence of ids")
    skus = [whole("SKU id", sku) for sku in given]
    if not skus or len(set(skus)) != len(skus):
        assigned = f"assigned SKUs {shown_short(given)} of order {order.label}"
        raise ImpossibleError(f"{assigned}; expected one or more, each once")
    for sku in skus:
        if sku not in open_skus:
            raise ImpossibleError(f"assigned SKU id {sku} of order {order.label}, which is no open line of it")
    return skus


def trip(warehouse: Warehouse, given: decisions.PodTrip) -> tuple[Pod, Station]:
    """Check that a pod can be bound for a station."""
    pod = known("pod", given.pod, warehouse.pods)
    station = known("station", given.station, warehouse.picking)
    if station.id in pod.bound_for:
        raise ImpossibleError(f"sent pod {pod.label} to station {station.label}, but it is there or bound for it")
    return pod, station


def selected_trip(
    warehouse: Warehouse, given: decisions.PodTrip, leaving: set[int], uncovered: dict[int, dict[int, int]]
) -> tuple[Pod, Station]:
    """Check a trip that PPS decided: the pod is free or leaving, and serves a request that was uncovered when asked.

    ``leaving`` and ``uncovered`` keep what that was then from one trip of the decision to the next: pods that are
    leaving, and items of the uncovered requests by SKU, by station.
    """
    pod, station = trip(warehouse, given)
    if (pod.location is None or pod.bound_for) and pod.id not in leaving:
        if pod not in warehouse.leaving_pods():
            raise ImpossibleError(f"sent pod {pod.label} to station {station.label}, but the pod is in use")
        leaving.add(pod.id)
    if station.id not in uncovered:
        uncovered[station.id] = station.uncovered
    if not any(pod.free_items(sku) > 0 for sku in uncovered[station.id]):
        lacks = "it holds no item of any request uncovered there"
        raise ImpossibleError(f"sent pod {pod.label} to station {station.label}, but {lacks}")
    return pod, station


def covered(stations: Sequence[Station], first: int) -> None:
    """Check that a joint decision leaves no request uncovered that it made: of an id from ``first`` on."""
    for station in stations:
        for request in station.uncovered_requests:
            if request.id >= first:
                lacks = f"no pod there or bound for it has an item of SKU id {request.sku} left for it"
                raise ImpossibleError(f"assigned order {request.order.label} to station {station.label}, but {lacks}")


def wanted(trips: Sequence[tuple[Pod, Station]]) -> None:
    """Check that each pod a joint decision sends holds something that is wanted where it goes."""
    for pod, station in trips:
        if not any(request.sku in pod.contents for request in station.open_requests):
            lacks = "it holds no item of any request open there"
            raise ImpossibleError(f"sent pod {pod.label} to station {station.label}, but {lacks}")


def packing(warehouse: Warehouse, capacity: int | None, before: int) -> None:
    """Check that the split orders under way find a box at the packing stations, or are no more than ``before``."""
    if capacity is not None and warehouse.split_orders_open > max(capacity, before):
        left = f"left {warehouse.split_orders_open} split orders open at once"
        raise ImpossibleError(f"{left}; the packing stations hold {capacity}")
    split = warehouse.split_orders_open - before
    if split > 0 and (free := warehouse.free_boxes) is not None and split > free:
        raise ImpossibleError(f"split {counted(split, 'order')}; free boxes at the packing stations: {free}")


def bundle_assignment(warehouse: Warehouse, given: decisions.BundleAssignment) -> tuple[Bundle, Station]:
    """Check that a bundle waits, and that a station has capacity for it."""
    number = whole("bundle", given.bundle)
    station = known("station", given.station, warehouse.stations)
    if (bundle := warehouse.bundles.get(number)) is None:
        raise ImpossibleError(f"assigned bundle {number} to station {station.label}, but no such bundle waits")
    if station.free_bundle_capacity <= 0:
        has = f"all {station.bundle_capacity} units of capacity are used" if station.stores else "it stores none"
        raise ImpossibleError(f"assigned bundle {bundle.label} to station {station.label}, but {has}")
    return bundle, station


def store(warehouse: Warehouse, given: decisions.StoreBundle) -> tuple[Bundle, Pod]:
    """Check that a bundle at a station needs a pod, and that a pod has space for it and can come."""
    number, pod = whole("bundle", given.bundle), known("pod", given.pod, warehouse.pods)
    at_stations = (bundle for station in warehouse.storing for bundle in station.bundles)
    bundle = next((bundle for bundle in at_stations if bundle.id == number and bundle.pod is None), None)
    if bundle is None:
        why = "no such bundle is at a station without a pod"
        raise ImpossibleError(f"chose pod {pod.label} for bundle {number}, but {why}")
    what = f"chose pod {pod.label} for bundle {bundle.label}"
    if pod.location is None and not pod.bound_for:
        raise ImpossibleError(f"{what}, but the pod is on its way to be stored")
    if pod.free_space < bundle.size:
        raise ImpossibleError(f"{what}, which takes {bundle.size} of space; the pod has {pod.free_space} left")
    return bundle, pod


def task(warehouse: Warehouse, given: decisions.TaskAssignment) -> tuple[Robot, Pod]:
    """Check that a robot can fetch a pod."""
    robot = known("robot", given.robot, warehouse.robots)
    pod = known("pod", given.pod, warehouse.pods)
    if not robot.idle:
        state = "out of service" if not robot.in_service else "busy" if robot.on_duty else "off duty"
        raise ImpossibleError(f"gave pod {pod.label} to robot {robot.label}, which is {state}")
    if pod.id not in warehouse.waiting:
        raise ImpossibleError(f"gave pod {pod.label} to robot {robot.label}, but the pod does not wait for a robot")
    return robot, pod


def rest(warehouse: Warehouse, given: decisions.RobotMove) -> tuple[Robot, int, float]:
    """Check that a robot can be sent to rest in a cell; return how full its battery shall be, too."""
    layout, share = warehouse.travel.layout, given.charge or 0.0
    robot, cell = known("robot", given.robot, warehouse.robots), whole("cell", given.cell)
    if not robot.resting:
        state = "busy" if robot.in_service else "out of service"
        raise ImpossibleError(f"sent robot {robot.label} to rest, which is {state}")
    charges, problem = cell in warehouse.chargers, ""
    if not charges and cell in layout.chargers:
        problem = "a charger that is out of service"
    elif not charges and cell not in layout.storage_locations:
        problem = "no storage location or charger"
    elif cell in warehouse.taken_cells():
        problem = "which a robot or pod occupies or is bound for"
    elif not 0 <= share <= 1:
        problem = f"until its charge is {share}; expected a share from 0 to 1"
    elif not charges and (robot.low or share):
        problem = f"no charger; expected one, at a charge of {robot.charge or 0:.3f}"
    if problem:
        raise ImpossibleError(f"sent robot {robot.label} to rest in cell {cell}, {problem}")
    return robot, cell, share


def move(warehouse: Warehouse, given: decisions.PodMove) -> tuple[Pod, int]:
    """Check that a pod can be carried to another storage location without a visit."""
    pod = known("pod", given.pod, warehouse.pods)
    if pod.location is None or pod.bound_for or pod.robot is not None:
        raise ImpossibleError(f"moves pod {pod.label}, which is in use")
    return pod, storage_location(warehouse, pod, given.cell)


def storage_location(warehouse: Warehouse, pod: Pod, given: object) -> int:
    """Check that a pod can be stored in a cell; return the cell."""
    layout = warehouse.travel.layout
    cell = whole("cell", given)
    if cell not in warehouse.free_locations:
        if not 0 <= cell < layout.width * layout.height:
            what = f"cell {cell}, which is not on the grid"
        elif cell not in layout.storage_locations:
            what = f"{layout.where(cell)} (cell {cell}), which is no storage location"
        else:
            what = f"{layout.where(cell)} (cell {cell}), which is taken"
        raise ImpossibleError(f"stores pod {pod.label} at {what}")
    return cell


def wake_tick(now: int, given: object) -> int | None:
    """Check when a rule wants to wake up; return the first tick that is not before it, None for never."""
    if given is None:
        return None
    number = isinstance(given, int | float | np.integer | np.floating) and given is not True
    if number and to_seconds(now) < given < 1e12:  # type: ignore[operator]
        tick = to_ticks(float(given))  # type: ignore[arg-type]
        return tick + (to_seconds(tick) < given)  # type: ignore[operator]
    raise ImpossibleError(f"wants to wake at {shown_short(given)}; expected seconds after now, below 1e12, or None")


def path(warehouse: Warehouse, robot: Robot, start: int, goal: int, given: decisions.Path) -> decisions.Rows:
    """Check that a robot can drive a path from a cell, and that it gets anywhere; return end and wait of each leg."""
    travel, ends, loaded = warehouse.travel, given.given, robot.pod is not None
    if not len(ends) and start != goal:
        raise ImpossibleError(f"gave robot {robot.label} an empty path to {travel.layout.where(goal)}")
    if not isinstance(ends, tuple) and travel.wrong_leg(start, goal, ends, LONGEST_WAIT_TICKS, loaded) < 0:
        return ends  # type: ignore[no-any-return]
    cells, at = travel.layout.width * travel.layout.height, start
    checked: list[decisions.Leg] = []
    for leg in given.legs:
        if not isinstance(leg, decisions.Leg):
            found = f"{type(leg).__name__} {shown_short(leg)}"
            raise ImpossibleError(f"returned a path with {found} in it; expected Leg only")
        to, wait = leg.to, leg.wait_ticks
        if type(to) is not int or type(wait) is not int:
            to, wait = whole("cell", to), whole("wait_ticks", wait)
            leg = decisions.Leg(to, wait)  # noqa: PLW2901
        if not 0 <= to < cells:
            raise ImpossibleError(f"sent robot {robot.label} to cell {to}, which is not on the grid")
        if not 0 <= wait <= LONGEST_WAIT_TICKS or (to == at and wait == 0):
            waits = f"waits {wait} ticks{' and goes nowhere' if to == at else ''}"
            expected = f"expected 0 to {LONGEST_WAIT_TICKS}, and at least 1 for a leg that only waits"
            raise ImpossibleError(f"gave robot {robot.label} a leg that {waits}; {expected}")
        if to != at:
            problem = travel.run_problem(start, at, to, goal, loaded)
            if problem is not None:
                raise ImpossibleError(f"gave robot {robot.label} an impossible path: {problem}")
        checked.append(leg)
        at = to
    return decisions.ends_of(checked)


def hit(layout: Layout, robot: int, error: Any) -> ImpossibleError:
    """Return what is wrong with a robot's path that hits a reservation, whose owner, cell and start an error has."""
    where = f"robot {error.owner + 1} has {layout.where(error.cell)} from {to_seconds(error.since):.3f} s on"
    return ImpossibleError(f"gave robot {robot + 1} a path that hits a reservation: {where}")
