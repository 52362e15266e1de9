"""From a state's names to the ids and numbers that the kernel makes a warehouse of."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import count

from attrs import frozen

from rmfs_commands.states.names import Names
from rmfs_commands.states.plain import (
    BundleMemento,
    Memento,
    OrderMemento,
    PackingMemento,
    PartMemento,
    PodMemento,
    RequestMemento,
    RobotMemento,
    StationMemento,
    TaskMemento,
)
from rmfs_commands.states.state import InHandState, OrderState, PartState, RequestState, State, TaskState
from rmfs_core.clock import to_seconds, to_ticks
from rmfs_core.scenario.source import KeyPath
from rmfs_core.warehouse import UNLIMITED, OrderPacking
from rmfs_core.world import NORTH, Layout, OrderData, PodData

QUEUE_LENGTH = 12
"""Pods that can wait at a station that does not say how many: the paper's number."""

NOWHERE = -1
"""Cell that a state does not tell: the home of a pod, or where a robot is."""

Requested = dict[str, dict[str, list[str]]]
"""Order -> station -> SKUs that have requests there."""


@frozen
class Before:
    """An earlier state: what did not change since is taken over from it.

    Parameters
    ----------
    state, names
        The state and its names.
    memento
        The warehouse that it describes.
    """

    state: State
    names: Names
    memento: Memento


def memento_of(state: State, names: Names, layout: Layout, before: Before | None = None) -> Memento:
    """Return the warehouse that a state describes, with what it leaves out filled in.

    Parameters
    ----------
    state, names
        The state and its names.
    layout
        The grid.
    before
        An earlier state; objects of ``state`` that are also there have not changed since.

    Raises
    ------
    InputError
        Where it names what it does not list, or gives cells without a layout.
    """
    now = time_of(state)
    if now < to_ticks(latest := _latest(state)):
        names.wrong(("time_s",), f"found {state.time_s}, but an order arrives at {latest}; expected none later")
    if before is not None and before.names.skus != names.skus:
        before = None  # SKUs have other ids
    orders = _orders(state, names, before)
    stations = _stations(state, names, layout, sum(_assigned(order) for order in orders))
    robots = _robots(state, names, layout, stations)
    pods = _pods(state, names, layout, stations, before)
    if state.waiting is None:
        tasks = {robot.task for robot in robots}
        waiting = [i for i, pod in enumerate(pods) if pod.bound_for and pod.cell is not None and i not in tasks]
    else:
        waiting = [names.pod(pod, "waiting", i) for i, pod in enumerate(state.waiting)]
    skus, blocked = tuple(names.skus), tuple(sorted(state.empty_pods))
    bundles, sizes = tuple(_bundles(state, names, now)), _sizes(state, names)
    whole = now, skus, orders, pods, stations, robots, tuple(waiting), blocked, state.reserved, bundles, sizes
    return Memento(*whole, tuple(_packing(state, names, orders)), state.chargers_down)


def time_of(state: State) -> int:
    """Return the time of a state in ticks: the latest arrival, where it does not say."""
    return to_ticks(_latest(state) if state.time_s is None else state.time_s)


def _latest(state: State) -> float:
    return max((order.arrival_s for order in state.orders.values()), default=0.0)


def due_times(state: State, orders: Sequence[str]) -> dict[str, dict[str, float]]:
    """Return due time, priority and slack of those orders that have a due time, by name."""
    now_s = to_seconds(time_of(state))
    given = [(name, state.orders[name]) for name in orders]
    return {
        name: {"due_s": order.due_s, "priority": order.priority, "slack_s": round(order.due_s - now_s, 3)}
        for name, order in given
        if order.due_s is not None
    }


def _orders(state: State, names: Names, before: Before | None) -> tuple[OrderMemento, ...]:
    unchanged, shown = {} if before is None else _unchanged(state, before), {*(state.backlog or ())}
    data = {name: _order_data(state.orders[name], names, name) for name in names.orders if name not in unchanged}
    requested, orders = _requested(state, names), []
    for name in names.orders:
        if name in unchanged:
            orders.append(unchanged[name])
            continue
        order, parts = data[name], []
        given = _parts(state.orders[name], requested.get(name, {}))
        taken = {(part.station, part.period) for part in given}
        for i, part in enumerate(given):
            path = ("orders", name, "parts", i)
            station, period = names.station(part.station, *path, "station"), part.period
            if period is None:
                period = next(number for number in count(1) if (part.station, number) not in taken)
                taken.add((part.station, period))
            parts.append(PartMemento(station, tuple(names.sku(sku, *path, "skus") for sku in part.skus), period))
        waits = _waits(state, names, name, begun=bool(parts), shown=name in shown)
        packing, cancelled = _packing_of(state, names, name), state.orders[name].cancelled
        if cancelled and (parts or waits or name in shown):
            why = "lines of it are assigned" if parts else "it waits for stock" if waits else "`backlog` names it"
            names.wrong(("orders", name, "cancelled"), f"found true for an order that has not left: {why}")
        orders.append(OrderMemento(order, tuple(parts), waits, packing, cancelled))
    return tuple(orders)


def _order_data(order: OrderState, names: Names, name: str) -> OrderData:
    return OrderData(
        name,
        arrival_tick=to_ticks(order.arrival_s),
        lines=tuple((names.sku(sku, "orders", name, "lines", sku), n) for sku, n in order.lines.items()),
        due_tick=None if order.due_s is None else to_ticks(order.due_s),
        priority=order.priority,
    )


def _unchanged(state: State, before: Before) -> dict[str, OrderMemento]:
    """Return the orders that are as they were and that nothing else tells of, by name."""
    if before.state.backlog is not None or state.backlog is not None:
        return {}
    named = {request.order for station in state.stations.values() for request in station.requests}
    named |= {station.in_hand.order for station in state.stations.values() if station.in_hand is not None}
    orders, earlier = state.orders, before.state.orders
    found = {}
    for memento in before.memento.orders:
        name = memento.data.name
        if orders.get(name) is earlier[name] and not (memento.parts or memento.packing or name in named):
            found[name] = memento
    return found


def _packing_of(state: State, names: Names, order: str) -> OrderPacking | None:
    told = state.orders[order].packing
    if told is None:
        return None
    station = names.packing(told.station, "orders", order, "packing", "station")
    return OrderPacking(station, told.box, told.first_part_s, told.items_in_box, told.expected_s, told.packed)


def _packing(state: State, names: Names, orders: Sequence[OrderMemento]) -> Iterator[PackingMemento]:
    if state.packing is None:
        return
    for i, told in enumerate(state.packing.stations):
        path: KeyPath = ("packing", "stations", i)

        def tasks(key: str, given: Sequence[TaskState], path: KeyPath = path) -> tuple[TaskMemento, ...]:
            return tuple(
                TaskMemento(
                    one.kind,
                    names.order(one.order, *path, key, at, "order"),
                    *(one.tote, one.items, one.duration_s, one.since_s, one.until_s),
                )
                for at, one in enumerate(given)
            )

        bound = [
            at for at, order in enumerate(orders) if (one := order.packing) and one.station == i and not one.packed
        ]
        if told.orders is not None:
            bound = [names.order(order, *path, "orders", at) for at, order in enumerate(told.orders)]
        waiting, working = tasks("tasks", told.tasks), tasks("working", told.working)
        yield PackingMemento(state.packing.section, tuple(bound), waiting, working, to_ticks(told.zero_s))


def _waits(state: State, names: Names, name: str, *, begun: bool, shown: bool) -> bool | None:
    """Return whether an order waits for stock; not if the rule is shown it."""
    told = state.orders[name].waits_for_stock
    if told and (begun or shown):
        why = "`backlog` names it" if shown else "lines of it are assigned"
        names.wrong(("orders", name, "waits_for_stock"), f"found true for an order that waits no more: {why}")
    return False if shown else told


def _requested(state: State, names: Names) -> Requested:
    found: Requested = {}
    for station, given in state.stations.items():
        wanted: dict[KeyPath, RequestState | InHandState] = {("requests", i): r for i, r in enumerate(given.requests)}
        if given.in_hand is not None:
            wanted["in_hand",] = given.in_hand
        for within, request in wanted.items():
            path = ("stations", station, *within)
            names.order(request.order, *path, "order")
            names.sku(request.sku, *path, "sku")
            found.setdefault(request.order, {}).setdefault(station, []).append(request.sku)
    return found


def _parts(order: OrderState, requested: dict[str, list[str]]) -> Sequence[PartState]:
    if order.parts is not None:
        return order.parts
    return [PartState(station, tuple(dict.fromkeys(skus))) for station, skus in requested.items()]


def _assigned(order: OrderMemento) -> int:
    """Return how many items of an order were assigned: as many requests have had a number."""
    if not order.parts:
        return 0
    quantities = dict(order.data.lines)
    return sum(quantities.get(sku, 0) for part in order.parts for sku in part.skus)


def _stations(state: State, names: Names, layout: Layout, numbered: int) -> tuple[StationMemento, ...]:
    stations: list[StationMemento] = []
    for i, (name, given) in enumerate(state.stations.items()):
        path = ("stations", name)
        most = None if state.layout is None else layout.stations[i].places
        queue_length = given.queue_length or most or QUEUE_LENGTH
        if most is not None and queue_length > most:
            names.wrong((*path, "queue_length"), f"found {queue_length}; the layout has {most} cells")
        requests = []
        for at, request in enumerate(given.requests):
            number = numbered if request.id is None else request.id
            numbered = max(numbered, number + 1)
            pod = None if request.pod is None else names.pod(request.pod, *path, "requests", at, "pod")
            requests.append(RequestMemento(number, names.orders[request.order], names.skus[request.sku], pod))
        only_stores = len(layout.stations) - layout.replenishing <= i
        if state.layout is not None and given.picks == only_stores:
            found, expected = ("picks orders", "stores bundles") if given.picks else ("stores bundles", "picks orders")
            names.wrong(path, f"found one that {found}; expected one that {expected}, as the layout has it")
        if given.picks and any(not before.picks for before in stations):
            names.wrong(path, "found one that picks orders; expected stations that only store bundles to come last")
        inbound = given.line if given.inbound is None else given.inbound
        station = StationMemento(
            name=name,
            capacity=given.order_capacity or given.item_capacity or 0,
            counts_orders=given.order_capacity is not None,
            queue_length=queue_length,
            requests=tuple(requests),
            inbound=tuple(names.pod(pod, *path, "inbound", at) for at, pod in enumerate(inbound)),
            line=tuple(names.pod(pod, *path, "line") for pod in given.line),
            queue_room=queue_length + 1 - len(given.line) if given.queue_room is None else given.queue_room,
            in_hand=None if (held := given.in_hand) is None else (names.orders[held.order], names.skus[held.sku]),
            picker_free=None if given.picker_free_s is None else to_ticks(given.picker_free_s),
            staffed=given.staffed,
            in_service=given.in_service,
            active=given.active,
            changes=None if given.changes_s is None else to_ticks(given.changes_s),
            bundle_capacity=given.bundle_capacity or 0,
            picks=given.picks,
        )
        stations.append(station)
    return tuple(stations)


def _bundles(state: State, names: Names, now: int) -> Iterator[BundleMemento]:
    named: set[str] = set()
    number = 0
    for i, given in enumerate(state.bundles or ()):
        path = ("bundles", i)
        if given.name in named:
            names.wrong((*path, "name"), f'found "{given.name}" twice; expected each bundle once')
        named.add(given.name)
        if to_ticks(given.arrival_s) > now:
            names.wrong((*path, "arrival_s"), f"found {given.arrival_s}, which is later than now")
        number = number if given.id is None else given.id
        yield BundleMemento(
            number,
            given.name,
            names.sku(given.sku, *path, "sku"),
            given.items,
            to_ticks(given.arrival_s),
            None if given.station is None else names.station(given.station, *path, "station"),
            None if given.pod is None else names.pod(given.pod, *path, "pod"),
        )
        number += 1


def _sizes(state: State, names: Names) -> tuple[int, ...]:
    """Return the space that an item of each SKU takes, by id; nothing where all take 1."""
    if not state.sizes:
        return ()
    sizes = {names.sku(sku, "sizes", sku): size for sku, size in state.sizes.items()}
    return tuple(sizes.get(sku, 1) for sku in range(len(names.skus)))


def _robots(state: State, names: Names, layout: Layout, stations: Sequence[StationMemento]) -> tuple[RobotMemento, ...]:
    """Return the robots of a state, and one for each pod in a line that it tells no robot of: some robot carries it."""
    slots = {
        pod: layout.stations[i].slot(place)
        for i, station in enumerate(stations)
        for place, pod in enumerate(station.line)
    }
    robots = []
    for name, given in (state.robots or {}).items():
        task = None if given.task is None else names.pod(given.task, "robots", name, "task")
        cell = NOWHERE if given.cell is None else given.cell
        if state.layout is None:
            if given.cell is not None:
                names.wrong(("robots", name, "cell"), "found a cell, but the state has no layout")
            cell = 0 if task is None else slots.get(task, 0)
        battery = given.charge, bool(given.low), given.in_service
        robots.append(RobotMemento(name, cell, given.heading, task, given.on_duty, given.goal, *battery))
    tasks = {robot.task for robot in robots}
    for pod, slot in slots.items():
        if pod not in tasks:
            robots.append(RobotMemento(str(len(robots) + 1), slot, NORTH, pod))
    return tuple(robots)


def _pods(
    state: State, names: Names, layout: Layout, stations: Sequence[StationMemento], before: Before | None
) -> tuple[PodMemento, ...]:
    bound: dict[int, list[int]] = {}
    for at, station in enumerate(stations):
        for number in dict.fromkeys(station.inbound):
            bound.setdefault(number, []).append(at)
    in_lines = {number for station in stations for number in station.line}
    earlier = {} if before is None else {pod.data.name: pod.data for pod in before.memento.pods}
    pods = []
    for i, (name, given) in enumerate(state.pods.items()):
        if before is not None and before.state.pods.get(name) is given:
            data = earlier[name]
        else:
            contents = tuple((names.sku(sku, "pods", name, "contents", sku), n) for sku, n in given.contents.items())
            data = PodData(name, contents)
        if given.bound_for is None:
            bound_for = tuple(bound.get(i, ()))
        else:
            bound_for = tuple(names.station(station, "pods", name, "bound_for") for station in given.bound_for)
        cell: int | None
        if state.layout is None:
            if given.cell is not None:
                names.wrong(("pods", name, "cell"), "found a cell, but the state has no layout")
            home = layout.storage_locations[i]
            cell = None if i in in_lines else home
        else:
            cell = given.cell
            home = next((place for place in (given.home, cell) if place is not None), NOWHERE)
        pods.append(PodMemento(data, cell, home, bound_for, given.capacity or UNLIMITED))
    return tuple(pods)
