"""The state of the warehouse. Only the kernel changes it; rules see it through `WarehouseView`."""

from __future__ import annotations

from bisect import bisect_left, insort
from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from itertools import count
from typing import Any

import numpy as np
from attrs import evolve
from numpy.typing import NDArray

from rmfs_core.clock import to_seconds
from rmfs_core.warehouse.backlog import Backlog
from rmfs_core.warehouse.claims import Claims
from rmfs_core.warehouse.column_keeping import StockColumns, shown
from rmfs_core.warehouse.columns import CAPACITY
from rmfs_core.warehouse.packing import PackingStation
from rmfs_core.warehouse.parts import UNLIMITED, Bundle, Order, OrderPacking, Part, Pod, Request, Robot, Station, put
from rmfs_core.warehouse.promises import Promises, drop_item, enter, serves_none
from rmfs_core.world import Instance
from rmfs_core.world.travel import Travel


class Warehouse:
    """Orders, pods, stations and robots at one moment.

    Parameters
    ----------
    instance
        SKUs, orders and pods.
    travel
        Travel times on the layout.
    stations
        By id: picking stations, then those where bundles are stored and nothing is picked.
    robots
        Robots by id.
    pod_cells
        Cell of each pod with contents: its storage location.
    blocked
        Storage locations that hold an empty pod for the whole run.
    pod_capacity
        Space on each pod; a sequence has that of each.
    battery
        Makes a robot's battery with this clock; None: they have none.
    wait_for_stock
        Whether orders that the stock cannot serve stay out of the backlog.
    packing
        The packing stations by id.
    """

    def __init__(
        self,
        instance: Instance,
        travel: Travel,
        stations: Sequence[Station],
        robots: Sequence[Robot],
        pod_cells: Sequence[int],
        blocked: Iterable[int] = (),
        pod_capacity: int | Sequence[int] = UNLIMITED,
        battery: Callable[[Callable[[], int]], Any] | None = None,
        *,
        wait_for_stock: bool = True,
        packing: Sequence[PackingStation] = (),
    ) -> None:
        self.now = 0
        self.packing = list(packing)
        self.travel = travel
        self.n_skus = len(instance.skus)
        self.unlimited_stock = instance.unlimited_stock
        self.orders = tuple(Order(i, data, lambda: self.now) for i, data in enumerate(instance.orders))
        self.arrived: dict[int, Order] = {}
        self.sizes = instance.sizes or (1,) * self.n_skus
        capacities = [pod_capacity] * len(pod_cells) if isinstance(pod_capacity, int) else pod_capacity
        self.pods = tuple(
            Pod(i, data, cell, capacity, self.sizes)
            for i, (data, cell, capacity) in enumerate(zip(instance.pods, pod_cells, capacities, strict=True))
        )
        self.claims = Claims(self.pods) if wait_for_stock and not self.unlimited_stock else None
        self.homes = tuple(pod_cells)
        self.stations = tuple(stations)
        self.picking = tuple(station for station in stations if station.picks)
        self.columns = StockColumns(self.pods, self.n_skus, len(self.picking))
        self.storing = tuple(station for station in stations if station.stores)
        self.bundles: dict[int, Bundle] = {}
        """Bundles that are assigned to no station; the others are at theirs."""
        self.bundles_so_far = 0
        for station in self.stations:
            station._now = lambda: self.now
        for pod in self.pods:
            pod._arrival = self._arrival
        self._capacities, self._booked = np.zeros(len(self.picking), CAPACITY), {*self.picking}
        self._shown_capacities = shown(self._capacities)
        self.changes = 0
        """How often orders, capacities, or where pods stand may have changed."""
        self.has_places = True
        self.largest_capacity = max([UNLIMITED if s.counts_orders else s.capacity for s in self.picking], default=0)
        self.robots = tuple(robots)
        self.chargers = [*travel.layout.chargers]  # those in service, ascending
        for robot in robots:
            robot._battery = battery(lambda: self.now) if battery else None
            if battery:
                robot._battery.charging = robot._cell in self.chargers
        self.blocked = tuple(sorted(blocked))
        taken = {*pod_cells, *self.blocked}
        self.free_locations = [cell for cell in travel.layout.storage_locations if cell not in taken]
        self.reserved: set[int] = set()
        self.waiting: dict[int, Pod] = {}
        self.open_demand = np.zeros(self.n_skus, dtype=np.int64)
        self.ordered = np.zeros(self.n_skus, dtype=np.int64)
        self.split_orders_open = 0
        self.backlog = Backlog(self.n_skus)
        self.promises = Promises(self.stations, self.n_skus)
        self.next_request = 0
        """Id of the request that is made next."""
        with_sku: dict[int, list[Pod]] = {}
        for pod in self.pods:
            for sku in pod.contents:
                with_sku.setdefault(sku, []).append(pod)
        self._with_sku = {sku: tuple(pods) for sku, pods in with_sku.items()}

    # What is there

    @property
    def free_boxes(self) -> int | None:
        """How many more orders can be split; None without packing stations."""
        return sum(station.free_boxes for station in self.packing) if self.packing else None

    @staticmethod
    def packing_of(order: Order) -> OrderPacking:
        """Return where an order is packed of which a part is assigned."""
        assert order._packing is not None, "bound for a packing station with its first part"
        return order._packing

    def pods_with(self, sku: int) -> tuple[Pod, ...]:
        """Pods that held a SKU at the start, or were given it since."""
        return self._with_sku.get(sku, ())

    def size_at(self, order: Order, station: Station) -> int:
        """Capacity that the open lines of an order take up at a station: all of it, if no station has enough."""
        if station.counts_orders:
            return 0 if order._open and order.has_place_at(station.id) else 1
        return min(order.open_items, station.capacity) if order.open_items > self.largest_capacity else order.open_items

    @property
    def idle(self) -> list[Robot]:
        """Robots that can take a task, by id."""
        return [robot for robot in self.robots if robot._task is None and robot.idle]

    @property
    def spare_locations(self) -> int:
        """Free storage locations beyond one for each pod that is being carried and may go back there."""
        return len(self.free_locations) - sum(robot._pod is not None for robot in self.robots)

    def fits_smallest(self, *, single_line: bool) -> bool:
        """Whether some station can take the smallest order of the backlog (or line), or one that goes alone."""
        sizes = self.backlog.line_sizes if single_line else self.backlog.sizes
        if not sizes:
            return False
        for s in self.picking:
            if (free := s.free_capacity) and (s.counts_orders or free >= min(sizes)):
                return True
            if free and not s._load and max(self.backlog.sizes) > self.largest_capacity:
                return True
        return False

    def leaving_pods(self) -> tuple[Pod, ...]:
        """Pods that stand at a station, have nothing left to serve there and are bound nowhere else."""
        leaving = []
        for at in self.stations:
            if at._line and (number := at._line[0]._pod) is not None and at._line[0]._cell == at.cells.station:
                pod = self.pods[number]  # as `pod_at`
                if len(pod._itinerary) == 1 and not pod._bundles and serves_none(at, pod):
                    leaving.append(pod)
        return tuple(sorted(leaving, key=lambda pod: pod.id) if len(leaving) > 1 else leaving)

    def _arrival(self, pod: Pod) -> int | None:
        """Return the tick at which a pod is expected at the station it is bound for next, where that is known."""
        robot = pod._carrier
        if robot is None or not pod._itinerary or not self.has_places:
            return None
        station = self.stations[pod._itinerary[0]]
        if robot in station._line:
            return self.now
        carried = self.travel.times_to(station.cell, True)
        if pod._location is None:
            return self.now + int(carried[robot._cell, robot._heading])
        fetched = self.travel.ticks(robot._cell, robot._heading, pod._location, False)
        return self.now + fetched + self.travel.motion.lift_ticks + int(carried[pod._location].min())

    def pod_at(self, station: Station) -> Pod | None:
        """Return the pod that stands at the station cell."""
        if not station._line:
            return None
        robot = station._line[0]
        return self.pods[robot._pod] if robot._pod is not None and robot._cell == station.cells.station else None

    def picker_free(self, station: Station) -> int:
        """Tick at which the picker will have handled the item in hand: now, where there is none."""
        return max(station._picker_free, self.now)

    def next_bundle(self, station: Station, pod: Pod) -> Bundle | None:
        """First bundle that is to be stored on a pod at a station."""
        return next((bundle for bundle in station._bundles.values() if bundle._pod == pod.id), None)

    # What the kernel does to it

    def advance(self, tick: int) -> None:
        """Set the clock."""
        self.now = tick

    def order_arrives(self, order: Order, tick: int | None = None) -> None:
        """Put an order into the backlog, or let it wait for stock; ``tick``: when, where the order did not know it."""
        if tick is not None:
            put(order, "arrival_tick", tick)
            put(order, "arrival_s", to_seconds(tick))
        self.arrived[order.id] = order
        self.changes += 1
        if self.claims is None or self.claims.serve(order):
            self.backlog.add(order)
        for line in order.lines:
            self.open_demand[line.sku] += line.quantity
            self.ordered[line.sku] += line.quantity

    def cancel(self, order: Order) -> Sequence[Order]:
        """Let an order leave of which nothing is assigned; return orders that waited for its items, oldest first."""
        lines = order.open_lines
        for line in lines:
            self.open_demand[line.sku] -= line.quantity
        order._cancelled = True
        self.changes += 1
        if self.claims is not None and order._waits:
            order._open.clear()
            self.claims.leave(order)
            return ()
        self.backlog.close(order, [*order._open])
        served = () if self.claims is None else self.claims.give(*lines)
        self.backlog.add(*served)
        return served

    def assign(self, order: Order, station: Station, skus: Sequence[int], period: int = 1) -> int:
        """Turn open lines of an order into requests at a station; return their number of items.

        What one period assigns of an order to a station is one part, in however many steps it does. Whatever the
        steps, the promises to all that it assigns are a maximum flow over the pods; earlier promises stay.
        """
        was_split, had_place = order.split, order.has_place_at(station.id)
        lines = self.backlog.close(order, skus)
        items = sum([line.quantity for line in lines])
        part = order.part_of(station.id, period)
        if part is None:
            part = Part(order, station.id, period)
            order._parts.append(part)
        station._load += int(not had_place) if station.counts_orders else items
        self._book(station)
        part._skus.extend(skus)
        part._items += items
        self.split_orders_open += order.split - was_split
        for line in lines:
            enter(station, Request(self.next_request, part, line.sku, line.quantity))
            self.next_request += line.quantity
            same_sku = station._by_sku[line.sku]
            while same_sku[-1]._pod is None and self.promises.cover(same_sku[-1]):
                pass
        return items

    def _book(self, station: Station) -> None:
        """Note that the capacity of a station, or the number of its inbound pods, may be another one."""
        self.changes += 1
        if station.picks:
            self._booked.add(station)

    @property
    def capacities(self) -> NDArray[np.void]:
        """Capacities of the picking stations, by id, as `WarehouseView` says."""
        for station in self._booked:
            places, pods = (station.capacity, station.counts_orders), len(station._inbound)
            self._capacities[station.id] = station.free_capacity, station._load, *places, pods
        self._booked.clear()
        return self._shown_capacities

    def bind(self, pod: Pod, station: Station, *, promise: bool = True) -> None:
        """Decide a trip: the pod is bound for the station from now on. ``promise``: and its items are promised."""
        self.columns.note(pod)
        pod._itinerary.append(station.id)
        station._inbound[pod.id] = pod
        self.promises.count(pod, station, 1)
        self._book(station)
        if pod._carrier is None:
            self.waiting[pod.id] = pod
        if promise:
            self.promises.promise_items(pod, station)

    def bind_packing(self, order: Order, station: PackingStation) -> int | None:
        """Bind an order for a packing station; return the number of its box there, None if it is not split."""
        box = None
        if order.split:
            taken = {self.packing_of(other).box for other in station.orders}
            box = next(number for number in count() if number not in taken)
        self.changes += 1
        order._packing = OrderPacking(station.id, box)
        free = station.free_boxes - (box is not None)
        self.packing[station.id] = evolve(station, orders=(*station.orders, order), free_boxes=free)
        return box

    def pack(self, order: Order, **changes: Any) -> None:
        """Change how far an order is at its packing station."""
        self.changes += 1
        order._packing = evolve(self.packing_of(order), **changes)
        if order._packing.packed:
            self.free_box(order, "packed")

    def free_box(self, order: Order, done: str) -> None:
        """Free the box of an order that is ``done``, ``"picked"`` or ``"packed"``, if boxes are free from then on."""
        if (at := order._packing) is not None and at.box is not None:
            station = self.packing[at.station]
            free = station.free_boxes + (station.section.packing_from == done)
            self.packing[at.station] = evolve(station, free_boxes=free)

    def bundle_arrives(
        self, sku: int, items: int, name: str = "", number: int | None = None, tick: int | None = None
    ) -> Bundle:
        """Let a bundle arrive: the next one, now, called by its number, unless told otherwise."""
        number = self.bundles_so_far if number is None else number
        arrival = self.now if tick is None else tick
        bundle = Bundle(number, name or str(number + 1), sku, items, items * self.sizes[sku], arrival)
        self.bundles_so_far = max(self.bundles_so_far, number + 1)
        self.bundles[number] = bundle
        return bundle

    def assign_bundle(self, bundle: Bundle, station: Station) -> None:
        """Decide at which station a bundle is stored."""
        del self.bundles[bundle.id]
        bundle._station = station.id
        station._bundles[bundle.id] = bundle

    def bind_bundle(self, bundle: Bundle, pod: Pod) -> Station | None:
        """Decide on which pod an assigned bundle is stored; return the station if the pod was not bound for it yet."""
        assert bundle._station is not None
        bundle._pod = pod.id
        pod._bundles[bundle.id] = bundle
        self.columns.note(pod)
        if bundle._station in pod._itinerary:
            return None
        self.bind(pod, self.stations[bundle._station])
        return self.stations[bundle._station]

    def store_bundle(self, bundle: Bundle, pod: Pod) -> Sequence[Order]:
        """Put the items of a bundle on its pod; return the orders that had to wait for them, the oldest first.

        Requests at stations that the pod is bound for may have waited for them, too.
        """
        assert bundle._station is not None
        del self.stations[bundle._station]._bundles[bundle.id], pod._bundles[bundle.id]
        self.columns.note(pod)
        pod._used += bundle.size
        if bundle.sku not in pod._contents:
            pod._contents[bundle.sku] = 0
            with_it = (*self._with_sku.get(bundle.sku, ()), pod)
            self._with_sku[bundle.sku] = tuple(sorted(with_it, key=lambda other: other.id))
        if pod._contents[bundle.sku] < UNLIMITED:
            pod._contents[bundle.sku] += bundle.items
            self.promises.change(pod, bundle.sku, bundle.items)
        pod._touched.add((pod, bundle.sku))
        for station in pod._itinerary:
            self.promises.promise_items(pod, self.stations[station])
        served = self.claims.give((bundle.sku, bundle.items)) if self.claims is not None else ()
        if served:
            self.backlog.add(*served)
        self.changes += 1
        return served

    def recount(self, pod: Pod, contents: Mapping[int, int], free_space: int) -> None:
        """Let a pod hold so many items of SKUs that it has held, at least those that it promised; claims stay."""
        pod._contents.update(contents)
        pod._touched.update((pod, sku) for sku in contents)
        pod._used += pod.free_space - free_space
        self.columns.note(pod)
        self.promises._available, self.changes = None, self.changes + 1

    def unassign(self, part: Part) -> None:
        """Take back a part of an order of which nothing is picked or promised; the backlog stays as it is."""
        order, station, was_split = part.order, self.stations[part.station], part.order.split
        while (request := next((one for one in station._requests if one.part is part), None)) is not None:
            drop_item(station, request)
        order._parts.remove(part)
        order._open.update((line.sku, line) for line in order.lines if line.sku in part._skus)
        station._load -= int(not order.has_place_at(station.id)) if station.counts_orders else part._items
        self.split_orders_open += order.split - was_split
        self._book(station)

    def take_task(self, robot: Robot, pod: Pod) -> None:
        """Give a waiting pod to a robot."""
        self.columns.note(pod)
        del self.waiting[pod.id]
        robot._task = pod.id
        pod._carrier = robot

    def send(self, robot: Robot, cell: int | None) -> None:
        """Send a robot without a task somewhere; None: it is free again."""
        robot._goal = cell

    def taken_cells(self) -> set[int]:
        """Cells where robots stand or are sent, pods come to, or robots come for pods: nobody may be sent there."""
        fetched = [pod._location for pod in self.pods if pod._location is not None and (pod._carrier or pod._itinerary)]
        return {*self.reserved, *fetched, *(c for r in self.robots for c in (r._cell, r._goal) if c is not None)}

    def ticks_to_charge(self, robot: Robot, share: float) -> int:
        """Ticks until the battery of a robot at a charger is so full, and full enough for a task."""
        return 0 if robot._battery is None else robot._battery.ticks_to(share)

    def lift(self, robot: Robot, pod: Pod) -> None:
        """Let a robot lift the pod it stands under."""
        if robot._battery is not None:
            robot._battery.lift(self.travel.motion.lift_ticks)
        assert pod._location is not None
        self.columns.note(pod)
        self.changes += not pod._itinerary  # others are busy already
        insort(self.free_locations, pod._location)
        pod._location = None
        robot._pod = pod.id

    def move(self, robot: Robot, cell: int, heading: int, ticks: int = 0) -> None:
        """Let a robot stand in another cell, after driving and turning for so many ticks."""
        if robot._battery is not None:
            robot._battery.drive(ticks, loaded=robot._pod is not None)
            robot._battery.charging = cell in self.chargers
        put(robot, "_cell", cell)
        put(robot, "_heading", heading)

    def reserve(self, location: int) -> None:
        """Keep a free storage location for a pod that is on its way to it."""
        del self.free_locations[bisect_left(self.free_locations, location)]
        self.reserved.add(location)

    def store(self, robot: Robot, pod: Pod) -> None:
        """Set a pod down where the robot stands; the robot is idle then."""
        if robot._battery is not None:
            robot._battery.lift(self.travel.motion.lift_ticks)
        self.reserved.discard(robot._cell)
        self.columns.note(pod)
        self.changes += 1
        pod._location = robot._cell
        pod._carrier = None
        robot._pod = robot._task = None
        if pod._itinerary:
            self.waiting[pod.id] = pod

    def staff(self, station: Station, staffed: bool, until: int | None) -> None:
        """Open or close a station by its timetable, which changes that at a tick."""
        station._staffed, station._until = staffed, until
        self._book(station)

    def activate(self, station: Station, active: bool) -> None:
        """Activate a station, or no longer."""
        station._active = active
        self._book(station)

    def put_on_duty(self, number: int) -> None:
        """Let the first robots take tasks, and the others none."""
        for robot in self.robots:
            robot._on_duty = robot.id < number

    def put_in_service(self, one: Robot | Station, in_service: bool) -> None:
        """Let a robot or a station work, or no longer."""
        one._in_service = in_service
        if isinstance(one, Station):
            self._book(one)

    def put_charger_in_service(self, cell: int, in_service: bool, driving: Container[int]) -> None:
        """Let a charger charge who stands there, or no longer; ``driving`` has the ids of robots that drive."""
        (insort if in_service else list.remove)(self.chargers, cell)
        for robot in self.robots:
            if robot._cell == cell and robot.id not in driving and robot._battery is not None:
                robot._battery.stand()
                robot._battery.charging = in_service

    def occupy_picker(self, station: Station, until: int, expected: int | None = None) -> None:
        """Let a picker have an item in hand until a tick; rules see when that is expected instead, if it is given."""
        station._picker_free, station._picker_expected = until, until if expected is None else expected

    def claim_slot(self, station: Station) -> None:
        """Keep a slot in the line of a station for a pod that sets out for it."""
        station._claimed_slots += 1

    def give_up_slot(self, station: Station) -> None:
        """Free a slot that nobody waits for; a robot that waits for one gets it handed over, still claimed."""
        station._claimed_slots -= 1

    def place_at_station(self, robot: Robot, pod: Pod, station: Station) -> None:
        """Let a robot stand with a pod at the end of a station's line from the start."""
        self.bind(pod, station)
        self.take_task(robot, pod)
        self.lift(robot, pod)
        robot._cell = station.cells.slot(len(station._line))
        self.join_line(robot, station)
        self.claim_slot(station)

    def join_line(self, robot: Robot, station: Station) -> None:
        """Let a robot with a pod join the line of a station, at its end."""
        station._line.append(robot)

    def leave(self, robot: Robot, pod: Pod, station: Station) -> None:
        """End a visit: the robot leaves the line, and the pod is no longer bound for the station."""
        station._line.remove(robot)
        self.promises.count(pod, station, -1)
        self.columns.note(pod)
        pod._itinerary.remove(station.id)
        del station._inbound[pod.id]
        self._book(station)

    def fulfil(self, request: Request, pod: Pod, *, handled: bool = True) -> None:
        """Pick an item of a request from a pod that stands at its station; ``handled``: and free its capacity."""
        request = self.promises.pick(request, pod)
        if pod._contents[request.sku] < UNLIMITED:
            pod._contents[request.sku] -= 1
            pod._used -= self.sizes[request.sku]
            if pod.capacity < UNLIMITED:
                self.columns.note(pod)
        self.close(request)
        if handled:
            self.release(request)

    @staticmethod
    def request_in_hand(station: Station) -> Request | None:
        """Return the request of which an item is picked and not yet handled at a station."""
        return station._in_hand

    def close(self, request: Request) -> None:
        """Take a picked item, the oldest of a request, off the books; its capacity is used until `release`."""
        station = self.stations[request.station]
        drop_item(station, request)
        self.open_demand[request.sku] -= 1
        request.part._picked += 1
        station._in_hand = request

    def release(self, request: Request) -> None:
        """Free the capacity of a picked item; with order capacity, when the last item of its part is done."""
        station, order, part = self.stations[request.station], request.order, request.part
        station._in_hand = None
        part._done += 1
        if part._done == part._items:
            station._load -= int(not order.has_place_at(station.id)) if station.counts_orders else part._items
            self._book(station)
        if order.split and order.complete:
            self.split_orders_open -= 1
            self.free_box(order, "picked")

    # What makes one anew that is under way

    def renumber(self, station: Station, requests: Iterable[tuple[int, Request, int]]) -> None:
        """Give a station these requests: each has an id, one of the same line that is there now, and items."""
        station._requests, station._by_sku = [], {}
        for number, known, items in requests:
            enter(station, Request(number, known.part, known.sku, items))
            self.next_request = max(self.next_request, number + items)

    def reroute(self, pod: Pod, stations: Sequence[int]) -> None:
        """Let a pod visit the stations that it is bound for in this order."""
        pod._itinerary = list(stations)

    @staticmethod
    def battery_of(robot: Robot) -> Any:
        """Return a robot's battery; None without one."""
        return robot._battery

    @staticmethod
    def put_battery(robot: Robot, battery: Any) -> None:
        """Give a robot a battery."""
        robot._battery = battery
