"""Events that observers of a run that begins in a state are told first: how things came to be as they are."""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence
from typing import Any

from rmfs_commands.processes.events import ChargerDown, RobotDown, StationDown
from rmfs_commands.states.names import Names
from rmfs_commands.states.packed import packing_events
from rmfs_commands.states.resuming import AT_STATION
from rmfs_commands.states.state import RunState, State
from rmfs_core import events
from rmfs_core.clock import to_ticks
from rmfs_core.simulation.going import Going
from rmfs_core.warehouse import Warehouse


def opening_events(
    warehouse: Warehouse, state: State, names: Names, stories: Mapping[int, tuple[Any, ...]], going: Sequence[Going]
) -> list[events.Event]:
    """Return events of the past, in the order of time.

    Orders come with what is not picked of them, robots that are under way as if they had just begun what they do.
    """
    told = state.run or RunState()
    handled = [*_handled(warehouse, going, told, names)]
    held = {(one.order, one.station) for one in handled}
    found = [*_of_orders(warehouse, told, held, saved=state.run is not None), *_of_bundles(warehouse, told), *handled]
    over = warehouse.now if state.run is not None else warehouse.now - 1  # what is not saved counts from now on
    found += [*packing_events(warehouse, told, going, over), *_of_robots(warehouse, told, stories, going)]
    now = warehouse.now
    found += [events.StationClosed(now, station.id) for station in warehouse.stations if not station.open]
    found += [StationDown(now, station.id) for station in warehouse.stations if not station.in_service]
    planned = {one.id for one in told.outages if one.of == "robot" and one.planned}
    down = [robot.id for robot in warehouse.robots if not robot.in_service]
    found += [RobotDown(now, robot, robot in planned) for robot in down]
    chargers = warehouse.travel.layout.chargers
    found += [ChargerDown(now, cell) for cell in chargers if cell not in warehouse.chargers]
    if (number := sum(robot.on_duty for robot in warehouse.robots)) < len(warehouse.robots):
        found.append(events.RobotsOnDuty(now, number))
    return sorted(found, key=lambda event: event.tick)


def _of_orders(
    warehouse: Warehouse, told: RunState, held: Container[tuple[int, int]], *, saved: bool
) -> Iterator[events.Event]:
    now, assigned_s, completed_s = warehouse.now, told.assigned_s, told.completed_s
    for order in warehouse.arrived.values():
        yield events.OrderArrived(order.arrival_tick, order.id)
        over = max(now if saved else now - 1, order.arrival_tick)  # what is not saved counts from now on
        if order.cancelled:
            at = told.cancelled_s.get(order.name)
            yield events.OrderCancelled(over if at is None else to_ticks(at), order.id)
        last = {part.station: part for part in order.parts}
        at = assigned_s.get(order.name)
        assigned = (over if order.complete else now) if at is None else to_ticks(at)
        for part in order.parts:
            whole = not order.open_lines and part is order.parts[-1]
            items = part.unpicked_items + ((order.id, part.station) in held and part is last[part.station])
            yield events.OrderAssigned(
                assigned if not order.open_lines else now, order.id, part.station, part.skus, items, part.period, whole
            )
        if order.complete and not order.cancelled:
            at = completed_s.get(order.name)
            yield events.OrderCompleted(over if at is None else to_ticks(at), order.id)


def _handled(warehouse: Warehouse, going: Sequence[Going], told: RunState, names: Names) -> Iterator[events.ItemPicked]:
    """Yield the picks of items that are being handled."""
    for given in told.going:
        if given.kind == "handled" and given.station and given.order and given.sku:
            what = names.stations[given.station], 0, names.orders[given.order], names.skus[given.sku]
            yield events.ItemPicked(to_ticks(given.since_s), to_ticks(given.since_s), to_ticks(given.until_s), 0, *what)
    for one in going:
        if one.kind == "release" and one.station is not None:
            held = warehouse.stations[one.station].in_hand
            assert held is not None
            since = min(one.since, warehouse.now - 1) if one.since else warehouse.now - 1
            yield events.ItemPicked(since, since, one.tick, one.visit, one.station, 0, *held)


def _of_bundles(warehouse: Warehouse, told: RunState) -> Iterator[events.Event]:
    for bundle in (*warehouse.bundles.values(), *(b for station in warehouse.storing for b in station.bundles)):
        yield events.BundleArrived(bundle.arrival_tick, bundle.id, bundle.name, bundle.sku, bundle.items)
        if bundle.station is not None:
            at = told.bundles_s.get(bundle.name)
            yield events.BundleAssigned(warehouse.now if at is None else to_ticks(at), bundle.id, bundle.station)


def _of_robots(
    warehouse: Warehouse, told: RunState, stories: Mapping[int, tuple[Any, ...]], going: Sequence[Going]
) -> Iterator[events.Event]:
    now, doing = warehouse.now, {one.robot: one for one in going if one.robot is not None}
    visits = {one.visit: to_ticks(one.visit_since_s) for one in told.going if one.visit}
    line = {robot.id: station for station in warehouse.stations for robot in station.line}
    for robot in warehouse.robots:
        if robot.id not in stories:
            if robot.cell in warehouse.travel.layout.chargers and robot.charge is not None:  # it stays where it charged
                yield events.RobotSent(now, robot.id, robot.cell)
                yield events.RobotRested(now, robot.id, robot.cell)
            continue
        story, *what = stories[robot.id]
        if story == "rest":
            yield events.RobotSent(now, robot.id, what[0])
            if doing[robot.id].kind == "charge":
                yield events.RobotRested(now, robot.id, robot.cell)
            continue
        pod, one = what[0], doing[robot.id]
        if story == "move":
            yield events.PodMoveDecided(now, robot.id, pod.id, what[1])
        elif pod.location is not None:
            yield events.TaskAssigned(now, robot.id, pod.id)
        elif one.kind in AT_STATION:
            began = visits[one.visit]
            yield events.VisitStarted(began, one.visit, robot.id, pod.id, line[robot.id].id)
        elif story == "store":
            yield events.VisitEnded(now, 0, pod.id, 0, 0, None)
        elif robot.id not in line:
            yield events.PodLifted(now, now, robot.id, pod.id, robot.cell)
