"""The warehouse at one moment as plain data: names, ids and numbers alone, to be compared or written down."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from attrs import field, frozen, validators

from rmfs_core.clock import to_ticks
from rmfs_core.scenario.model import PackingSection
from rmfs_core.warehouse import (
    UNLIMITED,
    Bundle,
    Order,
    OrderPacking,
    PackingStation,
    PackingTask,
    Pod,
    Robot,
    Station,
    WarehouseView,
)
from rmfs_core.world import OrderData, PodData


class PartMemento(NamedTuple):
    """Part of an order that one period assigned to a station: its lines, also those picked already."""

    station: int
    skus: tuple[int, ...]
    period: int


class RequestMemento(NamedTuple):
    """An item that is still to be picked; ``pod`` is the inbound pod that it is promised from."""

    id: int
    order: int
    sku: int
    pod: int | None


class BundleMemento(NamedTuple):
    """A bundle that is not stored; ``station`` and ``pod`` as far as they are decided."""

    id: int
    name: str
    sku: int
    items: int
    arrival_tick: int
    station: int | None = None
    pod: int | None = None

    @classmethod
    def of(cls, bundle: Bundle) -> BundleMemento:
        """Return what a bundle is now."""
        kind = bundle.id, bundle.name, bundle.sku, bundle.items, bundle.arrival_tick
        return cls(*kind, bundle.station, bundle.pod)


class TaskMemento(NamedTuple):
    """A task that waits at a packing station, or is being done until a time."""

    kind: str
    order: int
    tote: int
    items: int
    duration_s: float
    since_s: float
    until_s: float | None = None

    @classmethod
    def of(cls, task: PackingTask, until_s: float | None = None) -> TaskMemento:
        """Return what a task is now."""
        return cls(task.kind, task.order.id, *task[2:], until_s)


@frozen
class PackingMemento:
    """A packing station: the orders that are bound for it and not packed, what waits, and what is being done.

    ``zero`` is the tick of the day at time 0, from which its hours count.
    """

    section: PackingSection
    orders: tuple[int, ...] = ()
    tasks: tuple[TaskMemento, ...] = ()
    working: tuple[TaskMemento, ...] = ()
    zero: int = 0

    @classmethod
    def of(cls, station: PackingStation) -> PackingMemento:
        """Return what a packing station is now."""
        orders, tasks = tuple(order.id for order in station.orders), tuple(map(TaskMemento.of, station.tasks))
        working = tuple(TaskMemento.of(*doing) for doing in station.working)
        return cls(station.section, orders, tasks, working, station.hours.zero)


@frozen
class OrderMemento:
    """An order that has arrived, its parts, its packing, and whether it waits for stock; None: if it must."""

    data: OrderData
    parts: tuple[PartMemento, ...]
    waits: bool | None = field(default=None, eq=bool)
    packing: OrderPacking | None = None
    cancelled: bool = False

    @classmethod
    def of(cls, order: Order) -> OrderMemento:
        """Return what an order is now."""
        parts = tuple(PartMemento(part.station, part.skus, part.period) for part in order.parts)
        lines = tuple((sku, n) for sku, n in order.lines)
        return cls(
            OrderData(
                order.name,
                arrival_tick=order.arrival_tick,
                lines=lines,
                due_tick=order.due_tick,
                priority=order.priority,
            ),
            parts,
            order.waits_for_stock,
            order.packing,
            order.cancelled,
        )


@frozen
class PodMemento:
    """A pod and what it holds; ``cell`` is its storage location, None while it is carried; ``home`` -1: not known."""

    data: PodData
    cell: int | None
    home: int
    bound_for: tuple[int, ...]
    capacity: int = UNLIMITED

    @classmethod
    def of(cls, pod: Pod, home: int) -> PodMemento:
        """Return what a pod is now."""
        contents = tuple((sku, None if n >= UNLIMITED else n) for sku, n in pod.contents.items())
        capacity = pod.capacity + max(-pod.free_space, 0)  # more than that was counted on it
        return cls(PodData(pod.name, contents), pod.location, home, pod.bound_for, capacity)


@frozen
class StationMemento:
    """A station: requests, oldest first; inbound pods, as trips were decided; its line; order and SKU in hand, and when
    that is handled (tick); ``changes``: the tick at which its timetable opens or closes it."""

    name: str
    capacity: int
    counts_orders: bool
    queue_length: int
    requests: tuple[RequestMemento, ...]
    inbound: tuple[int, ...]
    line: tuple[int, ...]
    queue_room: int
    in_hand: tuple[int, int] | None = None
    picker_free: int | None = None
    staffed: bool = True
    active: bool = True
    changes: int | None = None
    bundle_capacity: int = 0
    picks: bool = True
    in_service: bool = True

    @classmethod
    def of(cls, station: Station, now: int) -> StationMemento:
        """Return what a station is now, at this tick."""
        requests = tuple(
            RequestMemento(number, *shared)
            for r in station.open_requests
            for shared in [(r.order.id, r.sku, None if r.pod is None else r.pod.id)]  # read once for all items
            for number in range(r.id, r.id + r.items)
        )
        inbound = tuple(pod.id for pod in station.inbound_pods)
        kind = station.name, station.capacity, station.counts_orders, station.queue_length
        free, changes_s = to_ticks(station.picker_free_s), station.closes_s if station.staffed else station.opens_s
        busy = free if free > now else None
        hours = station.staffed, station.active, None if changes_s is None else to_ticks(changes_s)
        line, stores = station.pods_in_line, (station.bundle_capacity, station.picks, station.in_service)
        return cls(*kind, requests, inbound, line, station.queue_room, station.in_hand, busy, *hours, *stores)


@frozen
class RobotMemento:
    """A robot; ``task`` is the pod that it carries or is on its way to fetch, ``goal`` where it is sent without one."""

    name: str
    cell: int
    heading: int = field(validator=validators.in_(range(4)))
    task: int | None
    on_duty: bool = True
    goal: int | None = None
    charge: float | None = None
    low: bool = False
    in_service: bool = True

    @classmethod
    def of(cls, robot: Robot) -> RobotMemento:
        """Return what a robot is now."""
        doing = robot.task, robot.on_duty, robot.goal
        return cls(robot.name, robot.cell, robot.heading, *doing, robot.charge, robot.low, robot.in_service)


@frozen
class Memento:
    """A warehouse at one moment; what has an id stands at its id.

    Parameters
    ----------
    now
        Simulated time in ticks.
    skus
        Names of the SKUs.
    orders, pods, stations, robots
        Objects of the warehouse, without orders that have not arrived.
    waiting
        Stored pods that are bound for a station and that no robot fetches yet, longest waiting first.
    blocked, reserved
        Cells of storage locations that hold an empty pod, and of locations that a pod is on its way to.
    bundles
        Arrived bundles that are not stored; at a station, and on a pod, in the order in which that was decided.
    sizes
        Space that an item of each SKU takes; empty: 1.
    packing
        Packing stations.
    chargers_down
        Cells of the chargers that are out of service.
    """

    now: int = field(validator=validators.ge(0))
    skus: tuple[str, ...]
    orders: tuple[OrderMemento, ...]
    pods: tuple[PodMemento, ...]
    stations: tuple[StationMemento, ...]
    robots: tuple[RobotMemento, ...]
    waiting: tuple[int, ...]
    blocked: tuple[int, ...]
    reserved: tuple[int, ...]
    bundles: tuple[BundleMemento, ...] = ()
    sizes: tuple[int, ...] = ()
    packing: tuple[PackingMemento, ...] = ()
    chargers_down: tuple[int, ...] = ()

    @classmethod
    def of(cls, view: WarehouseView, skus: Sequence[str]) -> Memento:
        """Return what a warehouse is now; a view does not show the names of its SKUs."""
        stations = (*view.stations, *(station for station in view.replenishment_stations if not station.picks))
        bundles = (*view.bundles, *(b for s in view.replenishment_stations for b in s.bundles))
        return cls(
            view.now_tick,
            tuple(skus),
            tuple(OrderMemento.of(order) for order in view.orders),
            tuple(PodMemento.of(pod, view.home(pod)) for pod in view.pods),
            tuple(StationMemento.of(station, view.now_tick) for station in stations),
            tuple(RobotMemento.of(robot) for robot in view.robots),
            tuple(pod.id for pod in view.waiting_pods),
            view.blocked_locations,
            view.reserved_locations,
            tuple(map(BundleMemento.of, bundles)),
            view.sizes if max(view.sizes, default=1) > 1 else (),
            tuple(map(PackingMemento.of, view.packing_stations)),
            tuple(cell for cell in view.travel.layout.chargers if cell not in view.chargers),
        )
