"""The state of the warehouse. Only the kernel changes it; rules see it through `WarehouseView`.

Stock is promised: as soon as a request is open at a station and a pod inbound there holds a free item of its SKU, that
item is promised to the request. A request is covered exactly when something is promised to it. Promises say what is
still needed; which pod serves a request in the end is decided by arrival (`next_request`, `secure`).
"""

from __future__ import annotations

from bisect import bisect_left, insort
from collections import Counter
from collections.abc import Callable, Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from rmfs_core.clock import to_seconds, to_ticks
from rmfs_core.warehouse.battery import Battery
from rmfs_core.warehouse.parts import (
    UNLIMITED,
    BacklogLines,
    BacklogLog,
    Bundle,
    FreeItems,
    Order,
    Part,
    Pod,
    Request,
    Robot,
    Station,
)
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
        Space on each pod.
    battery
        Makes a robot's battery with this clock; None: they have none.
    """

    def __init__(
        self,
        instance: Instance,
        travel: Travel,
        stations: Sequence[Station],
        robots: Sequence[Robot],
        pod_cells: Sequence[int],
        blocked: Iterable[int] = (),
        pod_capacity: int = UNLIMITED,
        battery: Callable[[Callable[[], int]], Battery] | None = None,
    ) -> None:
        self.now = 0
        self.travel = travel
        self.n_skus = len(instance.skus)
        self.unlimited_stock = instance.unlimited_stock
        self.orders = tuple(Order(i, data, lambda: self.now) for i, data in enumerate(instance.orders))
        self.arrived: dict[int, Order] = {}
        self.sizes = instance.sizes or (1,) * self.n_skus
        self.pods = tuple(
            Pod(i, data, cell, pod_capacity, self.sizes)
            for i, (data, cell) in enumerate(zip(instance.pods, pod_cells, strict=True))
        )
        self.free_items = _FreeItems(self.pods)
        self.homes = tuple(pod_cells)
        self.stations = tuple(stations)
        self.picking = tuple(station for station in stations if station.picks)
        self.storing = tuple(station for station in stations if station.stores)
        self.bundles: dict[int, Bundle] = {}
        """Those that are assigned to no station; the others are at theirs."""
        self._next_bundle = 0
        for station in self.stations:
            station._now = lambda: self.now
        for pod in self.pods:
            pod._arrival = self._arrival
        self.has_places = True
        self._largest = max([UNLIMITED if s.counts_orders else s.capacity for s in self.picking], default=0)
        self.robots = tuple(robots)
        for robot in robots:
            robot._battery = battery(lambda: self.now) if battery else None
            robot._charging = robot._cell in travel.layout.chargers
        self.blocked = tuple(sorted(blocked))
        taken = {*pod_cells, *self.blocked}
        self.free_locations = [cell for cell in travel.layout.storage_locations if cell not in taken]
        self.reserved: set[int] = set()
        self.waiting: dict[int, Pod] = {}
        self.open_demand = np.zeros(self.n_skus, dtype=np.int64)
        self.split_orders_open = 0
        self._backlog: dict[int, Order] = {}
        self._backlog_tuple: tuple[Order, ...] | None = ()
        self._sizes: Counter[int] = Counter()
        self._line_sizes: Counter[int] = Counter()
        self.log = BacklogLog()
        self._backlog_lines: BacklogLines | None = None
        self._available: NDArray[np.int64] | None = None
        self._next_request = 0
        with_sku: dict[int, list[Pod]] = {}
        for pod in self.pods:
            for sku in pod.contents:
                with_sku.setdefault(sku, []).append(pod)
        self._with_sku = {sku: tuple(pods) for sku, pods in with_sku.items()}

    # What is there

    @property
    def backlog(self) -> tuple[Order, ...]:
        """Orders with open lines, oldest first."""
        if self._backlog_tuple is None:
            self._backlog_tuple = tuple(self._backlog.values())
        return self._backlog_tuple

    @property
    def backlog_size(self) -> int:
        """Number of orders with open lines."""
        return len(self._backlog)

    @property
    def backlog_lines(self) -> BacklogLines:
        """Open lines of the backlog as arrays."""
        if self._backlog_lines is None:
            self._backlog_lines = self.log._lines()
        return self._backlog_lines

    def pods_with(self, sku: int) -> tuple[Pod, ...]:
        """Pods that held a SKU at the start, or were given it since."""
        return self._with_sku.get(sku, ())

    def size_at(self, order: Order, station: Station) -> int:
        """Capacity that the open lines of an order take up at a station: all of it, if no station has enough."""
        if station.counts_orders:
            return 0 if order._open and order.has_place_at(station.id) else 1
        return min(order.open_items, station.capacity) if order.open_items > self._largest else order.open_items

    @property
    def spare_locations(self) -> int:
        """Free storage locations beyond one for each pod that is being carried and may go back there."""
        return len(self.free_locations) - sum(robot._pod is not None for robot in self.robots)

    def in_backlog(self, order: Order) -> bool:
        """Whether an order has arrived and has open lines."""
        return order.id in self._backlog

    def fits_smallest(self, *, single_line: bool) -> bool:
        """Whether some station has room for the smallest order of the backlog (or line), or for one that goes alone."""
        sizes = self._line_sizes if single_line else self._sizes
        if not sizes:
            return False
        smallest, alone = min(sizes), max(self._sizes) > self._largest
        return any(
            s.free_capacity >= (1 if s.counts_orders else smallest) or (alone and s.open and not s.load)
            for s in self.picking
        )

    @property
    def available(self) -> NDArray[np.int64]:
        """Items on each station's inbound pods that are not promised to any request."""
        if self._available is None:
            self._available = np.zeros((len(self.stations), self.n_skus), dtype=np.int64)
            for station in self.stations:
                for pod in station._inbound.values():
                    self._count(pod, station, 1)
        return self._available[: len(self.picking)]

    def _count(self, pod: Pod, station: Station, sign: int) -> None:
        """Take the free items of an inbound pod into the account of what is available, or out of it."""
        if self._available is not None:
            self._available[station.id, list(pod._contents)] += [sign * pod.free_items(sku) for sku in pod._contents]

    def _promise(self, request: Request, pod: Pod) -> None:
        promise(request, pod)
        if self._available is not None and pod._contents[request.sku] < UNLIMITED:
            self._available[pod._itinerary, request.sku] -= 1

    def _withdraw(self, request: Request) -> None:
        pod = request._pod
        _withdraw(request)
        if self._available is not None and pod is not None and pod._contents[request.sku] < UNLIMITED:
            self._available[pod._itinerary, request.sku] += 1

    def leaving_pods(self) -> tuple[Pod, ...]:
        """Pods that stand at a station, have nothing left to serve there and are bound nowhere else."""
        there = [(station, pod) for station in self.stations if (pod := self.pod_at(station)) is not None]
        there = [(at, pod) for at, pod in there if pod._itinerary == [at.id] and not pod._bundles]
        leaving = [pod for at, pod in there if not self._serves(at, pod)]
        return tuple(sorted(leaving, key=lambda pod: pod.id))

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
        return self.pods[robot._pod] if robot._pod is not None and robot.cell == station.cell else None

    def _serves(self, station: Station, pod: Pod) -> bool:
        """Whether there is a `next_request`."""
        return any(self._usable(pod, sku, station.id) for sku in station._by_sku if sku in pod._contents)

    def next_request(self, station: Station, pod: Pod) -> Request | None:
        """Oldest open request at a station that an item on the pod can serve, not counting items promised elsewhere."""
        best: Request | None = None
        for sku in station._by_sku if len(station._by_sku) < len(pod._contents) else pod._contents:
            if (requests := station._by_sku.get(sku)) and self._usable(pod, sku, station.id):
                first = next(iter(requests.values()))
                if best is None or first.id < best.id:
                    best = first
        return best

    def next_bundle(self, station: Station, pod: Pod) -> Bundle | None:
        """First bundle that is to be stored on a pod at a station."""
        return next((bundle for bundle in station._bundles.values() if bundle._pod == pod.id), None)

    def _usable(self, pod: Pod, sku: int, station: int) -> bool:
        number = pod._contents.get(sku, 0)
        if number >= UNLIMITED:
            return True
        promised = pod._promised.get(sku)
        return number > 0 if not promised else number - sum(promised.values()) + promised.get(station, 0) > 0

    # What the kernel does to it

    def advance(self, tick: int) -> None:
        """Set the clock."""
        self.now = tick

    def order_arrives(self, order: Order, tick: int | None = None) -> None:
        """Put an order into the backlog; ``tick``: when, where the order did not know it."""
        if tick is not None:
            object.__setattr__(order, "arrival_tick", tick)
            object.__setattr__(order, "arrival_s", to_seconds(tick))
        self.arrived[order.id] = order
        self._backlog[order.id] = order
        self.log._add(order)
        self._sizes[order.open_items] += 1
        for line in order.lines:
            self._line_sizes[line.quantity] += 1
            self.open_demand[line.sku] += line.quantity
        self._backlog_changed()

    def assign(self, order: Order, station: Station, skus: Sequence[int], period: int = 1) -> int:
        """Turn open lines of an order into requests at a station; return their number of items.

        What one period assigns of an order to a station is one part, in however many steps it does. Whatever the
        steps, the promises to all that it assigns are a maximum flow over the pods; earlier promises stay.
        """
        was_split, had_place = order.split, order.has_place_at(station.id)
        lines = [order._open.pop(sku) for sku in skus]
        items = sum(line.quantity for line in lines)
        _drop(self._sizes, order._open_size)
        order._open_size -= items
        for line in lines:
            _drop(self._line_sizes, line.quantity)
            self.log._close(order, line.sku)
        if order._open:
            self._sizes[order._open_size] += 1
        else:
            del self._backlog[order.id]
        self._backlog_changed()
        part = order.part_of(station.id, period)
        if part is None:
            part = Part(order, station.id, period)
            order._parts.append(part)
        station._load += int(not had_place) if station.counts_orders else items
        part._skus += skus
        part._items += items
        part._unpicked += items
        part._left += items
        self.split_orders_open += order.split - was_split
        for line in lines:
            for _ in range(line.quantity):
                request = Request(self._next_request, part, line.sku)
                self._next_request += 1
                station._requests[request.id] = request
                station._by_sku.setdefault(line.sku, {})[request.id] = request
                self._promise_from_inbound(station, request)
        return items

    def bind(self, pod: Pod, station: Station, *, promise: bool = True) -> None:
        """Decide a trip: the pod is bound for the station from now on. ``promise``: and its items are promised."""
        pod._itinerary.append(station.id)
        station._inbound[pod.id] = pod
        self._count(pod, station, 1)
        if pod._carrier is None:
            self.waiting[pod.id] = pod
        if promise:
            self.promise_items(pod, station)

    def bundle_arrives(
        self, sku: int, items: int, name: str = "", number: int | None = None, tick: int | None = None
    ) -> Bundle:
        """Let a bundle arrive: the next one, now, called by its number, unless told otherwise."""
        number = self._next_bundle if number is None else number
        arrival = self.now if tick is None else tick
        bundle = Bundle(number, name or str(number + 1), sku, items, items * self.sizes[sku], arrival)
        self._next_bundle = max(self._next_bundle, number + 1)
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
        if bundle._station in pod._itinerary:
            return None
        self.bind(pod, self.stations[bundle._station])
        return self.stations[bundle._station]

    def store_bundle(self, bundle: Bundle, pod: Pod) -> None:
        """Put the items of a bundle on its pod; requests at stations that it is bound for may have waited for them."""
        assert bundle._station is not None
        del self.stations[bundle._station]._bundles[bundle.id], pod._bundles[bundle.id]
        pod._used += bundle.size
        if bundle.sku not in pod._contents:
            pod._contents[bundle.sku] = 0
            with_it = (*self._with_sku.get(bundle.sku, ()), pod)
            self._with_sku[bundle.sku] = tuple(sorted(with_it, key=lambda other: other.id))
            self.free_items = _FreeItems(self.pods)
        pod._changes += 1
        if pod._contents[bundle.sku] < UNLIMITED:
            pod._contents[bundle.sku] += bundle.items
            if self._available is not None:
                self._available[pod._itinerary, bundle.sku] += bundle.items
        pod._touched.add(pod)
        for station in pod._itinerary:
            self.promise_items(pod, self.stations[station])

    def take_task(self, robot: Robot, pod: Pod) -> None:
        """Give a waiting pod to a robot."""
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
        if (battery := robot._battery) is None or not robot._charging:
            return 0
        missing = max(share * battery.capacity_j, battery.low_j) - battery.left_j(self.now, True)
        return to_ticks(max(missing, 0.0) / battery.section.charging_w) + 1

    def lift(self, robot: Robot, pod: Pod) -> None:
        """Let a robot lift the pod it stands under."""
        self._lifted(robot)
        assert pod._location is not None
        insort(self.free_locations, pod._location)
        pod._location = None
        robot._pod = pod.id

    def _lifted(self, robot: Robot) -> None:
        if (battery := robot._battery) is not None:
            battery.work(self.travel.motion.lift_ticks, battery.section.lifting_w, charging=False)

    def move(self, robot: Robot, cell: int, heading: int, ticks: int = 0) -> None:
        """Let a robot stand in another cell, after driving and turning for so many ticks."""
        if (battery := robot._battery) is not None:
            watts = battery.section.empty_w if robot._pod is None else battery.section.loaded_w
            battery.work(ticks, watts, robot._charging)
            robot._charging = cell in self.travel.layout.chargers
        robot._cell, robot._heading = cell, heading

    def reserve(self, location: int) -> None:
        """Keep a free storage location for a pod that is on its way to it."""
        del self.free_locations[bisect_left(self.free_locations, location)]
        self.reserved.add(location)

    def store(self, robot: Robot, pod: Pod) -> None:
        """Set a pod down where the robot stands; the robot is idle then."""
        self._lifted(robot)
        self.reserved.discard(robot._cell)
        pod._cell = pod._location = robot._cell
        pod._carrier = None
        robot._pod = robot._task = None
        if pod._itinerary:
            self.waiting[pod.id] = pod

    def staff(self, station: Station, staffed: bool, until: int | None) -> None:
        """Open or close a station by its timetable, which changes that at a tick."""
        station._staffed, station._changes = staffed, until

    def activate(self, station: Station, active: bool) -> None:
        """Activate a station, or no longer."""
        station._active = active

    def put_on_duty(self, number: int) -> None:
        """Let the first robots take tasks, and the others none."""
        for robot in self.robots:
            robot._on_duty = robot.id < number

    def occupy_picker(self, station: Station, until: int) -> None:
        """Let a picker have an item in hand until a tick."""
        station._picker_free = until

    def claim_place(self, station: Station) -> None:
        """Keep a place in the line of a station for a pod that sets out for it."""
        station._claims += 1

    def give_up_place(self, station: Station) -> None:
        """Let go of a place that nobody waits for; who waits for one gets it handed over, still claimed."""
        station._claims -= 1

    def place_at_station(self, robot: Robot, pod: Pod, station: Station) -> None:
        """Let a robot stand with a pod at the end of a station's line from the start."""
        self.bind(pod, station)
        self.take_task(robot, pod)
        self.lift(robot, pod)
        robot._cell = station.cells.slot(len(station._line))
        self.join_line(robot, station)
        self.claim_place(station)

    def join_line(self, robot: Robot, station: Station) -> None:
        """Let a robot with a pod join the line of a station, at its end."""
        station._line.append(robot)

    def leave(self, robot: Robot, pod: Pod, station: Station) -> None:
        """End a visit: the robot leaves the line, and the pod is no longer bound for the station."""
        station._line.remove(robot)
        self._count(pod, station, -1)
        pod._itinerary.remove(station.id)
        del station._inbound[pod.id]

    def secure(self, request: Request, pod: Pod) -> None:
        """Make sure that the item for a request is promised from the pod that is about to serve it."""
        if request._pod is pod:
            return
        same_sku = self.stations[request.station]._by_sku[request.sku]
        # The pod's item may be promised to a younger request here: the two swap what they were promised.
        younger = next((other for other in same_sku.values() if other._pod is pod), None)
        if younger is not None:
            younger._pod, request._pod = request._pod, pod
            return
        released = request._pod
        if released is not None:
            self._withdraw(request)
        self._promise(request, pod)
        if released is not None:
            for station in released._itinerary:
                self.promise_items(released, self.stations[station])

    def fulfil(self, request: Request, pod: Pod, *, handled: bool = True) -> None:
        """Pick the item of a request from a pod that stands at its station; ``handled``: and give its place back."""
        self.secure(request, pod)
        self._withdraw(request)
        pod._changes += 1
        if pod._contents[request.sku] < UNLIMITED:
            pod._contents[request.sku] -= 1
            pod._used -= self.sizes[request.sku]
            if self._available is not None:
                self._available[pod._itinerary, request.sku] -= 1
        self.close(request)
        if handled:
            self.release(request)

    def close(self, request: Request) -> None:
        """Take the request of a picked item off the books; its place is kept until `release`."""
        station = self.stations[request.station]
        del station._requests[request.id]
        del station._by_sku[request.sku][request.id]
        if not station._by_sku[request.sku]:
            del station._by_sku[request.sku]
        self.open_demand[request.sku] -= 1
        request.order._unpicked -= 1
        request.part._unpicked -= 1
        station._in_hand = request

    def release(self, request: Request) -> None:
        """Give back the place of a picked item; its part shares one until the last of its items is done."""
        station, order, part = self.stations[request.station], request.order, request.part
        station._in_hand = None
        order._left -= 1
        part._left -= 1
        if part._left == 0:
            station._load -= int(not order.has_place_at(station.id)) if station.counts_orders else part._items
        if order.complete and order.split:
            self.split_orders_open -= 1

    # Promises

    def _promise_from_inbound(self, station: Station, request: Request, tried: set[int] | None = None) -> bool:
        """Promise an item of the first pod that has one free, or can have by what its period assigned elsewhere."""
        sku, pods, tried = request.sku, [], tried or set()
        for pod in station._inbound.values():
            if sku in pod._contents and pod.id not in tried:
                if pod.free_items(sku) > 0:
                    self._promise(request, pod)
                    return True
                pods.append(pod)
        for pod in pods:
            tried.add(pod.id)
            for other in (self.stations[at] for at in pod._itinerary if at != station.id):
                for moved in other._by_sku.get(sku, {}).values():
                    if moved._pod is pod and moved.part.period == request.part.period:
                        self._withdraw(moved)
                        if self._promise_from_inbound(other, moved, tried):
                            self._promise(request, pod)
                            return True
                        self._promise(moved, pod)
                        break  # the others from here have the same ways out
        return False

    def promise_items(self, pod: Pod, station: Station) -> None:
        """Promise free items of a pod to the uncovered requests of a station, oldest first."""
        for sku in pod._contents:
            for request in station._by_sku.get(sku, {}).values():
                if not request.covered:
                    if pod.free_items(sku) <= 0:
                        break
                    self._promise(request, pod)

    def _backlog_changed(self) -> None:
        self._backlog_tuple = None
        self._backlog_lines = None


class _FreeItems:
    """Free items of the pods as arrays; of those that gave or took back promises since the last look, read anew."""

    def __init__(self, pods: Sequence[Pod]) -> None:
        self.pods = pods
        self.start = np.cumsum([0, *(len(pod._contents) for pod in pods)])
        self.shown: FreeItems | None = None
        self.touched = set(pods)
        for pod in pods:
            pod._touched = self.touched

    def now(self) -> FreeItems:
        """Return them as they are."""
        if self.shown is None:
            of = np.repeat(np.arange(len(self.pods)), np.diff(self.start))
            sku = np.array([sku for held in self.pods for sku in sorted(held._contents)], dtype=np.int64)
            self.shown = FreeItems(of, sku, np.zeros(len(sku), dtype=np.int64))
        if self.touched:
            number = self.shown.number.copy()
            for pod in self.touched:
                entries = slice(self.start[pod.id], self.start[pod.id + 1])
                number[entries] = [pod.free_items(sku) for sku in self.shown.sku[entries].tolist()]
            self.shown = FreeItems(self.shown.pod, self.shown.sku, number)
            self.touched.clear()
        return self.shown


def promise(request: Request, pod: Pod) -> None:
    """Promise a free item of a pod to a request that is uncovered."""
    request._pod = pod
    pod._touched.add(pod)
    by_station = pod._promised.setdefault(request.sku, {})
    by_station[request.station] = by_station.get(request.station, 0) + 1


def _withdraw(request: Request) -> None:
    assert request._pod is not None
    request._pod._touched.add(request._pod)
    by_station = request._pod._promised[request.sku]
    by_station[request.station] -= 1
    if not by_station[request.station]:
        del by_station[request.station]
    request._pod = None


def _drop(counter: Counter[int], size: int) -> None:
    counter[size] -= 1
    if not counter[size]:
        del counter[size]
