"""The state of the warehouse. Only the kernel changes it; rules see it through `WarehouseView`.

Stock is promised: as soon as a request is open at a station and a pod inbound there holds a free item of its SKU, that
item is promised to the request. A request is covered exactly when something is promised to it. Promises say what is
still needed; which pod serves a request in the end is decided by arrival (`next_request`, `secure`).
"""

from __future__ import annotations

from bisect import bisect_left, insort
from collections import Counter
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from rmfs_core.clock import to_seconds
from rmfs_core.warehouse.parts import UNLIMITED, BacklogLines, FreeItems, Order, Part, Pod, Request, Robot, Station
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
        Picking stations by id.
    robots
        Robots by id.
    pod_cells
        Cell of each pod with contents: its storage location.
    blocked
        Storage locations that hold an empty pod for the whole run.
    """

    def __init__(
        self,
        instance: Instance,
        travel: Travel,
        stations: Sequence[Station],
        robots: Sequence[Robot],
        pod_cells: Sequence[int],
        blocked: Iterable[int] = (),
    ) -> None:
        self.now = 0
        self.travel = travel
        self.n_skus = len(instance.skus)
        self.unlimited_stock = instance.unlimited_stock
        self.orders = tuple(Order(i, data, lambda: self.now) for i, data in enumerate(instance.orders))
        self.arrived: dict[int, Order] = {}
        self.pods = tuple(
            Pod(i, data, cell) for i, (data, cell) in enumerate(zip(instance.pods, pod_cells, strict=True))
        )
        self.free_items = _FreeItems(self.pods)
        self.homes = tuple(pod_cells)
        self.stations = tuple(stations)
        self._largest = max([UNLIMITED if s.counts_orders else s.capacity for s in stations], default=0)
        self.robots = tuple(robots)
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
        self._lines = _Lines(self.orders)
        self._backlog_lines: BacklogLines | None = None
        self._next_request = 0
        self._with_sku: dict[int, list[Pod]] = {}
        for pod in self.pods:
            for sku in pod.contents:
                self._with_sku.setdefault(sku, []).append(pod)

    # What is there

    @property
    def backlog(self) -> tuple[Order, ...]:
        """Orders with open lines, oldest first."""
        if self._backlog_tuple is None:
            self._backlog_tuple = tuple(self._backlog.values())
        return self._backlog_tuple

    @property
    def backlog_lines(self) -> BacklogLines:
        """Open lines of the backlog as arrays."""
        if self._backlog_lines is None:
            self._backlog_lines = self._lines.backlog()
        return self._backlog_lines

    def pods_with(self, sku: int) -> tuple[Pod, ...]:
        """Pods that held a SKU at the start."""
        return tuple(self._with_sku.get(sku, ()))

    def size_at(self, order: Order, station: Station) -> int:
        """Capacity that the open lines of an order take up at a station: all of it, if no station has enough."""
        if station.counts_orders:
            return 0 if order._open and order.has_place_at(station.id) else 1
        return min(order.open_items, station.capacity) if order.open_items > self._largest else order.open_items

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
            s.free_capacity >= (1 if s.counts_orders else smallest) or (alone and not s.load) for s in self.stations
        )

    def available(self) -> NDArray[np.int64]:
        """Items on each station's inbound pods that are not promised to any request."""
        table = np.zeros((len(self.stations), self.n_skus), dtype=np.int64)
        for station in self.stations:
            for pod in station.inbound_pods:
                table[station.id, list(pod._contents)] += [pod.free_items(sku) for sku in pod._contents]
        return table

    def leaving_pods(self) -> tuple[Pod, ...]:
        """Pods that stand at a station, have nothing left to serve there and are bound nowhere else."""
        there = [(station, pod) for station in self.stations if (pod := self.pod_at(station)) is not None]
        leaving = [pod for at, pod in there if pod._itinerary == [at.id] and self.next_request(at, pod) is None]
        return tuple(sorted(leaving, key=lambda pod: pod.id))

    def pod_at(self, station: Station) -> Pod | None:
        """Return the pod that stands at the station cell."""
        if not station._line:
            return None
        robot = station._line[0]
        return self.pods[robot._pod] if robot._pod is not None and robot.cell == station.cell else None

    def next_request(self, station: Station, pod: Pod) -> Request | None:
        """Oldest open request at a station that an item on the pod can serve, not counting items promised elsewhere."""
        best: Request | None = None
        for sku in station._by_sku if len(station._by_sku) < len(pod._contents) else pod._contents:
            if (requests := station._by_sku.get(sku)) and self._usable(pod, sku, station.id):
                first = next(iter(requests.values()))
                if best is None or first.id < best.id:
                    best = first
        return best

    def _usable(self, pod: Pod, sku: int, station: int) -> bool:
        number = pod._contents.get(sku, 0)
        if number >= UNLIMITED:
            return True
        promised = pod._promised.get(sku, {})
        return number - sum(promised.values()) + promised.get(station, 0) > 0

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
        self._lines.add(order)
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
            self._lines.close(order, line.sku)
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
        if pod._carrier is None:
            self.waiting[pod.id] = pod
        if promise:
            self.promise_items(pod, station)

    def take_task(self, robot: Robot, pod: Pod) -> None:
        """Give a waiting pod to a robot."""
        del self.waiting[pod.id]
        robot._task = pod.id
        pod._carrier = robot

    def lift(self, robot: Robot, pod: Pod) -> None:
        """Let a robot lift the pod it stands under."""
        assert pod._location is not None
        insort(self.free_locations, pod._location)
        pod._location = None
        robot._pod = pod.id

    def move(self, robot: Robot, cell: int, heading: int) -> None:
        """Let a robot stand in another cell."""
        robot._cell, robot._heading = cell, heading

    def reserve(self, location: int) -> None:
        """Keep a free storage location for a pod that is on its way to it."""
        del self.free_locations[bisect_left(self.free_locations, location)]
        self.reserved.add(location)

    def store(self, robot: Robot, pod: Pod) -> None:
        """Set a pod down where the robot stands; the robot is idle then."""
        self.reserved.discard(robot._cell)
        pod._cell = pod._location = robot._cell
        pod._carrier = None
        robot._pod = robot._task = None
        if pod._itinerary:
            self.waiting[pod.id] = pod

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
            _withdraw(request)
        promise(request, pod)
        if released is not None:
            for station in released._itinerary:
                self.promise_items(released, self.stations[station])

    def fulfil(self, request: Request, pod: Pod, *, handled: bool = True) -> None:
        """Pick the item of a request from a pod that stands at its station; ``handled``: and give its place back."""
        self.secure(request, pod)
        _withdraw(request)
        if pod._contents[request.sku] < UNLIMITED:
            pod._contents[request.sku] -= 1
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
                    promise(request, pod)
                    return True
                pods.append(pod)
        for pod in pods:
            tried.add(pod.id)
            for other in (self.stations[at] for at in pod._itinerary if at != station.id):
                for moved in other._by_sku.get(sku, {}).values():
                    if moved._pod is pod and moved.part.period == request.part.period:
                        _withdraw(moved)
                        if self._promise_from_inbound(other, moved, tried):
                            promise(request, pod)
                            return True
                        promise(moved, pod)
                        break  # the others from here have the same ways out
        return False

    def promise_items(self, pod: Pod, station: Station) -> None:
        """Promise free items of a pod to the uncovered requests of a station, oldest first."""
        for sku in pod._contents:
            for request in station._by_sku.get(sku, {}).values():
                if not request.covered:
                    if pod.free_items(sku) <= 0:
                        break
                    promise(request, pod)

    def _backlog_changed(self) -> None:
        self._backlog_tuple = None
        self._backlog_lines = None


class _Lines:
    """All order lines of a run as arrays; the open lines of the backlog are kept in compact form."""

    def __init__(self, orders: Sequence[Order]) -> None:
        rows = [(order.id, line.sku, line.quantity) for order in orders for line in order.lines]
        table = np.array(rows, dtype=np.int64).reshape(-1, 3)
        self.order, self.sku, self.quantity = table[:, 0], table[:, 1], table[:, 2]
        self.start = np.concatenate(([0], np.cumsum([len(order.lines) for order in orders]))).astype(np.int64)
        self.open = np.ones(len(rows), dtype=bool)
        self.current = np.zeros(0, dtype=np.int64)
        self.arrived: list[int] = []

    def add(self, order: Order) -> None:
        """Take in the lines of an order that arrived."""
        self.arrived.append(order.id)

    def close(self, order: Order, sku: int) -> None:
        """Mark a line as assigned."""
        at = next(i for i, line in enumerate(order.lines) if line.sku == sku)
        self.open[self.start[order.id] + at] = False

    def backlog(self) -> BacklogLines:
        """Return the open lines of the orders that arrived, oldest order first."""
        if self.arrived:
            new = [np.arange(self.start[i], self.start[i + 1]) for i in self.arrived]
            self.current = np.concatenate([self.current, *new])
            self.arrived.clear()
        self.current = self.current[self.open[self.current]]
        order = self.order[self.current]
        position = np.zeros(len(order), dtype=np.int64)
        np.cumsum(order[1:] != order[:-1], out=position[1:])
        return BacklogLines(position, order, self.sku[self.current], self.quantity[self.current])


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
