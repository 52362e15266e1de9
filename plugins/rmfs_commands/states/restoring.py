"""From plain data to a warehouse as it tells."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Container, Mapping, Sequence
from typing import TypeVar

import numpy as np
from attrs import asdict, evolve

from rmfs_commands.processes.battery import Battery, battery_for_a_moment
from rmfs_commands.states.plain import (
    BundleMemento,
    Memento,
    OrderMemento,
    PackingMemento,
    RequestMemento,
    StationMemento,
    TaskMemento,
)
from rmfs_core.entrypoints import process
from rmfs_core.scenario.model import RuleChoice, RulesSection, Scenario
from rmfs_core.warehouse import Order, PackingStation, PackingTask, Robot, Station, Warehouse
from rmfs_core.warehouse.backlog import Backlog
from rmfs_core.warehouse.claims import Claims, by_age
from rmfs_core.world import CellKind, Instance, OrderData
from rmfs_core.world.travel import Travel

T = TypeVar("T")


class ContradictionError(ValueError):
    """A memento of what no warehouse can be: the path of the value that is wrong (fields and ids), and one sentence."""

    def __init__(self, problem: str, *path: str | int) -> None:
        super().__init__(f"{'.'.join(map(str, path))}: {problem}")
        self.problem = problem
        self.path = path


def restore(
    memento: Memento,
    travel: Travel,
    later: Sequence[OrderData] = (),
    battery: Callable[[Callable[[], int]], Battery] | None = None,
    *,
    wait_for_stock: bool = True,
    restocked: bool | None = None,
    reused: Mapping[int, Order] | None = None,
) -> Warehouse:
    """Return a new warehouse as a memento tells it.

    Parameters
    ----------
    memento
        State of the warehouse.
    travel
        Travel times on the layout.
    later
        Orders that arrive later.
    battery
        Makes a robot's battery; None: only their charge is known.
    wait_for_stock
        Whether orders that the stock cannot serve wait.
    restocked
        Whether bundles may arrive; None: if a station stores some.
    reused
        Orders of an earlier warehouse, which is given up, by the id (`id`) of the memento that each was made from.

    Raises
    ------
    ContradictionError
        Where it contradicts itself or the layout.
    """
    _check_names(memento, travel, reused or {})
    cells = travel.layout.stations
    warehouse = Warehouse(
        Instance(
            memento.skus,
            (),
            tuple(p.data for p in memento.pods),
            memento.sizes,
            restocked=any(s.bundle_capacity for s in memento.stations) if restocked is None else restocked,
        ),
        travel,
        [
            Station(i, cells[i], s.capacity, s.counts_orders, s.queue_length, s.name, s.bundle_capacity, s.picks)
            for i, s in enumerate(memento.stations)
        ],
        [Robot(i, r.cell, r.heading, r.name, r.on_duty) for i, r in enumerate(memento.robots)],
        [p.home if p.cell is None else p.cell for p in memento.pods],
        memento.blocked,
        [p.capacity for p in memento.pods],
        battery,
        wait_for_stock=False,
        packing=_packing_stations(memento.packing, travel),
    )
    warehouse.homes = tuple(p.home for p in memento.pods)
    warehouse.advance(memento.now)
    _orders(warehouse, memento, later, reused or {})
    for station, told in zip(warehouse.stations, memento.stations, strict=True):
        _keep_requests(warehouse, station, told, memento)
        warehouse.occupy_picker(station, told.picker_free or 0)
        warehouse.staff(station, told.staffed, told.changes)
        warehouse.activate(station, told.active)
        warehouse.put_in_service(station, told.in_service)
    for robot, given_robot in zip(warehouse.robots, memento.robots, strict=True):
        warehouse.put_in_service(robot, given_robot.in_service)
    for cell in memento.chargers_down:
        known = f"found {cell}; expected a charger of the layout that is not named before"
        _check(cell in warehouse.chargers, known, "chargers_down")
        warehouse.put_charger_in_service(cell, False, ())
    if wait_for_stock and not warehouse.unlimited_stock:
        begin_to_wait(warehouse, {i: o.waits for i, o in enumerate(memento.orders) if o.waits is not None})
    _bind(warehouse, memento)
    _carry(warehouse, memento)
    _store(warehouse, memento)
    _promise(warehouse, memento)
    for i, bundle in enumerate(memento.bundles):
        _restore_bundle(warehouse, bundle, "bundles", i)
    _pack(warehouse, memento)
    return warehouse


def _orders(warehouse: Warehouse, memento: Memento, later: Sequence[OrderData], reused: Mapping[int, Order]) -> None:
    """Let the orders arrive, and those that are begun or cancelled be so."""
    orders = []
    for i, given in enumerate(memento.orders):
        order = reused.get(id(given))
        if order is None or not order.renew(i, lambda: warehouse.now):
            order = Order(i, given.data, lambda: warehouse.now)
        orders.append(order)
    arrived = len(orders)
    orders += [Order(arrived + i, data, lambda: warehouse.now) for i, data in enumerate(later)]
    warehouse.orders = tuple(orders)
    warehouse.arrived.update((order.id, order) for order in orders[:arrived])
    warehouse.backlog.add(*orders[:arrived])
    items = [0] * warehouse.n_skus
    for order in orders[:arrived]:
        for sku, quantity in order.lines:
            items[sku] += quantity
    wanted = np.array(items, np.int64)
    warehouse.open_demand += wanted
    warehouse.ordered += wanted
    for order, given in zip(orders, memento.orders, strict=False):
        if given.parts or given.cancelled:
            begun = bool(given.parts and given.cancelled)
            _check(not begun, "found it for an order that is begun", "orders", order.id, "cancelled")
            _assign(warehouse, order, given, memento.skus)
            if given.cancelled:
                warehouse.cancel(order)


def begin_to_wait(warehouse: Warehouse, told: Mapping[int, bool]) -> None:
    """Let orders wait for stock from now on.

    Orders that are begun, or that are told not to wait, claim their open lines first. Of the others, the oldest
    first, those wait that the stock cannot serve or that are told to.

    Parameters
    ----------
    warehouse
        In which no order waits.
    told
        Whether an order waits, by id, of those of which that is known.
    """
    claims, wanted = Claims(warehouse.pods), warehouse.open_demand.tolist()
    warehouse.claims = claims
    if not any(told.values()) and all(claims.unclaimed[sku] >= items for sku, items in enumerate(wanted)):
        for sku, items in enumerate(wanted):
            claims.claim(sku, items)
        return
    for station in warehouse.stations:
        for request in station.open_requests:
            claims.claim(request.sku, request.items)
    shown = {order.id: bool(order.parts) or told.get(order.id) is False for order in warehouse.backlog}
    for order in sorted(warehouse.backlog, key=lambda order: (not shown[order.id], by_age(order))):
        if shown[order.id]:
            for line in order.open_lines:
                claims.claim(*line)
        elif told.get(order.id) and claims.lacking(order) is None:
            claims.wait(order, order.lines[0].sku)  # there is enough: any of its SKUs will do
        else:
            claims.serve(order)
    if claims.waiting:
        backlog, warehouse.backlog = warehouse.backlog, Backlog(warehouse.n_skus)
        warehouse.backlog.add(*(order for order in backlog if not order.waits_for_stock))


def _check(holds: bool, problem: str, *path: str | int) -> None:
    if not holds:
        raise ContradictionError(problem, *path)


def _at(among: Sequence[T], number: int, *path: str | int) -> T:
    _check(0 <= number < len(among), f"found the id {number}; expected 0 to {len(among) - 1}", *path)
    return among[number]


def _check_names(memento: Memento, travel: Travel, checked: Container[int]) -> None:
    """Check that there are the stations, SKUs and storage locations that are named, and the cells once each."""
    n, most = len(memento.stations), len(travel.layout.stations)
    _check(n <= most, f"found {n}; the layout has {most}", "stations")
    wanted = (("orders", "lines", i, one.data.lines) for i, one in enumerate(memento.orders) if id(one) not in checked)
    held = (("pods", "contents", i, one.data.contents) for i, one in enumerate(memento.pods))
    for section, key, i, items in (*wanted, *held):
        for sku, number in items:
            if not 0 <= sku < len(memento.skus):
                _at(memento.skus, sku, section, i, key)
            if number is not None and number < 0:
                _check(False, f"found {number} items; expected 0 or more", section, i, key)
    places = {*travel.layout.storage_locations}
    for i, pod in enumerate(memento.pods):
        known = pod.home in places or pod.home in (-1, pod.cell)  # the cell is looked at later
        _check(known, f"found {pod.home}; expected a storage location", "pods", i, "home")
        used = sum((items or 0) * (memento.sizes[sku] if memento.sizes else 1) for sku, items in pod.data.contents)
        least = f"found {pod.capacity}; expected at least {used}, what the pod holds"
        _check(used <= pod.capacity, least, "pods", i, "capacity")
    for key, cells in (("empty_pods", memento.blocked), ("reserved", memento.reserved)):
        for cell in cells:
            _check(cell in places, f"found {cell}; expected a storage location that is not named before", key)
            places.remove(cell)


def _assign(warehouse: Warehouse, order: Order, given: OrderMemento, skus: Sequence[str]) -> None:
    for i, part in enumerate(given.parts):
        path = ("orders", order.id, "parts", i)
        station = _at(warehouse.stations, part.station, *path, "station")
        left = {line.sku for line in order.open_lines}
        for sku in part.skus:
            problem = f'names SKU "{_at(skus, sku, *path)}", which is no line of the order that is still to be assigned'
            _check(sku in left, problem, *path, "skus")
            left.remove(sku)
        if part.skus:
            warehouse.assign(order, station, part.skus, part.period)


def _keep_requests(warehouse: Warehouse, station: Station, given: StationMemento, memento: Memento) -> None:
    """Leave a station with the requests told, in their order and with their ids; the others were picked."""
    assigned = {(request.order.id, request.sku): request for request in station.open_requests}
    picked = Counter({line: request.items for line, request in assigned.items()})
    path, last = ("stations", station.id, "requests"), -1
    for i, wanted in enumerate(given.requests):
        line = wanted.order, wanted.sku
        if not picked[line]:
            name = _at(warehouse.orders, wanted.order, *path, i).name
            more = f'requests more of SKU "{_at(memento.skus, wanted.sku, *path, i)}" for order "{name}"'
            raise ContradictionError(f"{more} than `lines` and `parts` of the order assign to this station", *path, i)
        expected = f"found the id {wanted.id} after {last}; expected a higher one for each request"
        _check(wanted.id > last, expected, *path)
        last = wanted.id
        picked[line] -= 1
    runs = [(first.id, assigned[first.order, first.sku], items) for _, first, items in _runs(given.requests)]
    if (held := given.in_hand) is not None:
        _check(bool(picked[held]), "names no item picked here", "stations", station.id, "in_hand")
        picked[held] -= 1
    for line, number in picked.items():
        for _ in range(number):
            warehouse.close(assigned[line])
            warehouse.release(assigned[line])
    if held is not None:
        warehouse.close(assigned[held])
    problem = f"found {given.capacity}; expected at least {station.load}, what is assigned and not picked"
    orders = {known.order.id for _, known, _ in runs} | ({held[0]} if held else set())
    alone = len(orders) == 1  # one larger than any station
    key = "order_capacity" if given.counts_orders else "item_capacity"
    _check(alone or given.capacity >= station.load, problem, "stations", station.id, key)
    warehouse.renumber(station, runs)


def _runs(requests: Sequence[RequestMemento]) -> list[tuple[int, RequestMemento, int]]:
    """Return position, first item and number of items of those of a line that follow each other for the same pod."""
    runs: list[tuple[int, RequestMemento, int]] = []
    for at, item in enumerate(requests):
        if runs:
            begin, first, items = runs[-1]
            if item == first._replace(id=first.id + items):
                runs[-1] = begin, first, items + 1
                continue
        runs.append((at, item, 1))
    return runs


def _bind(warehouse: Warehouse, memento: Memento) -> None:
    """Bind pods: which ones, and in which order at a station, is `inbound`; each pod's own order is `bound_for`."""
    for station, given in zip(warehouse.stations, memento.stations, strict=True):
        for i, number in enumerate(given.inbound):
            path = ("stations", station.id, "inbound", i)
            pod = _at(warehouse.pods, number, *path)
            _check(pod not in station.inbound_pods, f'names pod "{pod.name}" twice; expected each once', *path)
            warehouse.bind(pod, station, promise=False)
    for pod, told in zip(warehouse.pods, memento.pods, strict=True):
        same = sorted(told.bound_for) == sorted(pod.bound_for)
        _check(same, "expected the stations that have the pod in `inbound`, each once", "pods", pod.id, "bound_for")
        warehouse.reroute(pod, told.bound_for)


def _carry(warehouse: Warehouse, memento: Memento) -> None:
    """Give robots their tasks, and let robots in a station's line stand there."""
    kind = warehouse.travel.layout.kind
    for robot, given in zip(warehouse.robots, memento.robots, strict=True):
        free = 0 <= given.cell < len(kind) and kind[given.cell] != CellKind.WALL
        _check(free, f"expected a cell of the layout, 0 to {len(kind) - 1}, no wall", "robots", robot.id, "cell")
        warehouse.send(robot, given.goal)
        busy = given.task is not None and given.goal is not None
        _check(not busy, "found a goal and a task; expected one of them", "robots", robot.id, "goal")
        if given.task is not None:
            path = ("robots", robot.id, "task")
            pod = _at(warehouse.pods, given.task, *path)
            _check(pod.robot is None, f'names pod "{pod.name}", which is another robot\'s task', *path)
            warehouse.waiting[pod.id] = pod
            warehouse.take_task(robot, pod)
            if memento.pods[pod.id].cell is None:
                warehouse.lift(robot, pod)
        if given.charge is not None and robot.charge is None:
            warehouse.put_battery(robot, battery_for_a_moment(given.charge, low=given.low))
    in_line: set[int] = set()
    for station, told in zip(warehouse.stations, memento.stations, strict=True):
        path = ("stations", station.id, "line")
        for i, number in enumerate(told.line):
            name = _at(warehouse.pods, number, *path, i).name
            _check(number in told.inbound, f'names pod "{name}", which `inbound` does not', *path, i)
            _check(number not in in_line, f'names pod "{name}", which stands in a line already', *path)
            if (robot_id := warehouse.pods[number].robot) is None:
                raise ContradictionError(f'names pod "{name}", which no robot carries', *path, i)
            stored = memento.pods[number].cell is not None
            _check(
                not stored, "found a storage location for a pod that stands in a station's line", "pods", number, "cell"
            )
            in_line.add(number)
            warehouse.join_line(warehouse.robots[robot_id], station)
        room = station.queue_length + 1 - len(told.line)
        problem = f"found {told.queue_room}; expected 0 to {room}, what the line leaves"
        _check(0 <= told.queue_room <= room, problem, "stations", station.id, "queue_room")
        for _ in range(station.queue_room - told.queue_room):
            warehouse.claim_slot(station)


def _store(warehouse: Warehouse, memento: Memento) -> None:
    """Put pods where they are stored; whatever is left is free."""
    layout, places = warehouse.travel.layout, {*warehouse.travel.layout.storage_locations}
    taken = dict.fromkeys((*memento.blocked, *memento.reserved), "another pod")
    for pod, given in zip(warehouse.pods, memento.pods, strict=True):
        path, cell = ("pods", pod.id, "cell"), given.cell
        if cell is None:
            expected = "expected the pod's cell, or that it is in a line or a robot's task"
            _check(pod.robot is not None, f"is missing; {expected}", *path)
            continue
        if cell not in places:
            first = layout.storage_locations[0]
            expected = f"the first is {first} ({layout.where(first)})"
            raise ContradictionError(f"found {cell}, which is no storage location of the layout; {expected}", *path)
        _check(cell not in taken, f"found {cell}, where there is {taken.get(cell)} already", *path)
        taken[cell] = f'pod "{pod.name}"'
    warehouse.reserved = set(memento.reserved)
    warehouse.free_locations = [cell for cell in layout.storage_locations if cell not in taken]
    waiting = [pod.id for pod in warehouse.pods if pod.bound_for and pod.robot is None]
    names = ", ".join(warehouse.pods[number].name for number in waiting) or "none"
    expected = f"expected the stored pods that are inbound and no robot's task: {names}"
    _check(sorted(memento.waiting) == waiting, expected, "waiting")
    warehouse.waiting = {number: warehouse.pods[number] for number in memento.waiting}


def _restore_bundle(warehouse: Warehouse, told: BundleMemento, *path: str | int) -> None:
    """Let a bundle be where it was, on its pod where that is bound for its station."""
    _at(warehouse.sizes, told.sku, *path, "sku")
    bundle = warehouse.bundle_arrives(told.sku, told.items, told.name, told.id, told.arrival_tick)
    if told.station is not None:
        station = _at(warehouse.stations, told.station, *path, "station")
        expected = f"expected one that holds more bundles than the {len(station.bundles)} named before"
        _check(station.free_bundle_capacity > 0, expected, *path, "station")
        warehouse.assign_bundle(bundle, station)
    if told.pod is not None:
        pod = _at(warehouse.pods, told.pod, *path, "pod")
        bound = told.station in pod.bound_for and pod.free_space >= bundle.size
        _check(bound, "expected a pod with space for it that is bound for its station", *path, "pod")
        warehouse.bind_bundle(bundle, pod)


def _packing_stations(told: Sequence[PackingMemento], travel: Travel) -> list[PackingStation]:
    """Return packing stations at which nothing has happened yet."""
    if not told:
        return []
    section = evolve(told[0].section, stations=len(told))
    scenario = Scenario(RulesSection(poa_pps=RuleChoice("")), packing=section)
    stations = process("packing", "packing").stations(scenario, travel.layout)
    zeros = [one.zero for one in told]
    return [evolve(one, hours=evolve(one.hours, zero=zero)) for one, zero in zip(stations, zeros, strict=True)]


def _pack(warehouse: Warehouse, memento: Memento) -> None:
    """Let orders be as far as they are at their packing stations."""
    for order, given in zip(warehouse.orders, memento.orders, strict=False):
        if given.packing is not None:
            path = ("orders", order.id, "packing")
            problem = "found it for an order of which no part is assigned"
            _check(bool(order.parts), problem, *path)
            boxed = "expected a box for an order that is split, and for no other"
            _check((given.packing.box is not None) == order.split, boxed, *path, "box")
            warehouse.bind_packing(order, _at(warehouse.packing, given.packing.station, *path, "station"))
            warehouse.pack(order, **asdict(given.packing))
            if order.complete:
                warehouse.free_box(order, "picked")
    for i, (station, told) in enumerate(zip(warehouse.packing, memento.packing, strict=True)):
        section = ("packing", "stations", i)
        left = [order for order in station.orders if (at := order.packing) is not None and not at.packed]
        names = ", ".join(order.name for order in left) or "none"
        expected = f"expected the orders whose `packing` names it and that are not packed: {names}"
        _check(sorted(told.orders) == sorted(order.id for order in left), expected, *section, "orders")
        boxes = [order.packing.box for order in left if order.packing is not None and order.packing.box is not None]
        _check(len(boxes) == len({*boxes}), "found a box that two orders have", *section, "orders")

        def task(
            one: TaskMemento, path: tuple[str | int, ...] = section, bound: Sequence[int] = told.orders
        ) -> PackingTask:
            name = warehouse.orders[one.order].name
            _check(one.order in bound, f'names order "{name}", which is not bound for it', *path, "tasks")
            return PackingTask(one.kind, warehouse.orders[one.order], *one[2:6])

        warehouse.packing[i] = evolve(
            station,
            orders=tuple(warehouse.orders[order] for order in told.orders),
            tasks=tuple(map(task, told.tasks)),
            working=tuple((task(one), one.until_s or 0.0) for one in told.working),
        )


def _promise(warehouse: Warehouse, memento: Memento) -> None:
    """Promise items on inbound pods to requests: first as told, then to whatever is left over."""
    for station, given in zip(warehouse.stations, memento.stations, strict=True):
        for request, (at, wanted, items) in zip(station.open_requests, _runs(given.requests), strict=True):
            if wanted.pod is not None:
                path = ("stations", station.id, "requests")
                pod = _at(warehouse.pods, wanted.pod, *path, at, "pod")
                spare = max(pod.free_items(request.sku), 0) if station.id in pod.bound_for else 0
                lacking = f'pod "{pod.name}" is not inbound here with an item of "{memento.skus[request.sku]}" to spare'
                _check(spare >= items, lacking, *path, at + spare, "pod")
                warehouse.promises.promise(request, pod, items)
    for station in warehouse.stations:
        for pod in station.inbound_pods:
            warehouse.promises.promise_items(pod, station)
