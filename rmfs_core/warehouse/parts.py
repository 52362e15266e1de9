"""Orders, requests, pods, stations and robots as rules see them.

Public attributes are read-only; what begins with an underscore belongs to this folder.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple, cast

from attrs import frozen

from rmfs_core.clock import to_seconds
from rmfs_core.world import OrderData, PodData, StationCells

UNLIMITED = 1 << 40
"""Number of items that stands for an unlimited stock: more than any run can pick, and safe in sums."""


put = object.__setattr__
"""Sets an attribute past `ReadOnly`, which looks at its name first: for what is made or moves all the time."""


class ReadOnly:
    """Base of what rules see: public attributes are set once and never again."""

    __slots__ = ()

    id: int
    name: str

    @property
    def label(self) -> str:
        """Name and id, for messages: people know the name, rules return the id."""
        return f"{self.name} (id {self.id})"

    def __setattr__(self, name: str, value: object) -> None:
        if name[0] != "_" and hasattr(self, name):
            raise AttributeError(f"{type(self).__name__}.{name} is read-only")
        put(self, name, value)


class OrderLine(NamedTuple):
    """One SKU (id) and how many items of it are wanted."""

    sku: int
    quantity: int


@frozen
class OrderPacking:
    """Packing of an order: its station and its progress.

    Parameters
    ----------
    station, box
        Id of the packing station; number of its box there, None for an order that is not split.
    first_part_s, expected_s
        When its first part came there, and when it would be packed if no other came and a packer were free; or None.
    items_in_box, packed
        How many of its items are in its box; whether it is packed.
    """

    station: int
    box: int | None
    first_part_s: float | None = None
    items_in_box: int = 0
    expected_s: float | None = None
    packed: bool = False


class Order(ReadOnly):
    """A pick order in the backlog or at stations."""

    __slots__ = (
        "_cancelled",
        "_now",
        "_open",
        "_packing",
        "_parts",
        "_waits",
        "arrival_s",
        "arrival_tick",
        "due_s",
        "due_tick",
        "id",
        "items",
        "lines",
        "name",
        "priority",
    )

    arrival_tick: int
    arrival_s: float
    due_tick: int | None
    due_s: float | None
    priority: int
    lines: tuple[OrderLine, ...]
    items: int

    def __init__(self, order_id: int, data: OrderData, now: Callable[[], int]) -> None:
        put(self, "id", order_id)
        put(self, "name", data.name)
        put(self, "arrival_tick", data.arrival_tick)
        put(self, "arrival_s", to_seconds(data.arrival_tick))
        put(self, "due_tick", data.due_tick)
        put(self, "due_s", None if data.due_tick is None else to_seconds(data.due_tick))
        put(self, "priority", data.priority)
        put(self, "lines", tuple([OrderLine(sku, quantity) for sku, quantity in data.lines]))
        put(self, "items", data.items)
        self._now = now
        self._open: dict[int, OrderLine] = {line.sku: line for line in self.lines}
        self._parts: list[Part] = []
        self._packing: OrderPacking | None = None
        self._waits = self._cancelled = False

    def renew(self, order_id: int, now: Callable[[], int]) -> bool:
        """Take an id and a clock in another warehouse; return whether it is as it arrived."""
        put(self, "id", order_id)
        self._now = now
        return len(self._open) == len(self.lines) and not (self._parts or self._waits or self._cancelled)

    @property
    def cancelled(self) -> bool:
        """Whether it has left before anything of it was assigned; it has no open lines then, and is complete."""
        return self._cancelled

    @property
    def waits_for_stock(self) -> bool:
        """Whether it is kept out of the backlog until the pods hold enough for all its lines."""
        return self._waits

    @property
    def slack_s(self) -> float | None:
        """Seconds that are left until it is due, negative when it is late; None without a due time."""
        return None if self.due_tick is None else to_seconds(self.due_tick - self._now())

    @property
    def open_lines(self) -> tuple[OrderLine, ...]:
        """Lines not yet assigned to any station. All lines, unless the order was split over time."""
        return tuple(self._open.values())

    @property
    def open_items(self) -> int:
        """Number of items of the open lines."""
        return sum([line.quantity for line in self._open.values()])

    @property
    def unpicked_items(self) -> int:
        """Number of items not yet picked, assigned or not."""
        return self.open_items + sum([part.unpicked_items for part in self._parts])

    @property
    def complete(self) -> bool:
        """Whether its last item is done: picked, or handled, as ``stations.release`` says."""
        return not self._open and all(part._done == part._items for part in self._parts)

    @property
    def split(self) -> bool:
        """Whether it is known to be split: parts at several stations or of several periods, or lines left to assign."""
        return len(self._parts) > 1 or bool(self._parts and self._open)

    @property
    def packing(self) -> OrderPacking | None:
        """Where it is packed; None until its first part is assigned, and where there are no packing stations."""
        return self._packing

    @property
    def parts(self) -> tuple[Part, ...]:
        """Its parts assigned so far, first to last."""
        return tuple(self._parts)

    def part_of(self, station: int, period: int) -> Part | None:
        """Return what a period has assigned of it to a station so far."""
        return next((part for part in self._parts if part.station == station and part.period == period), None)

    def has_place_at(self, station: int) -> bool:
        """Whether a part of it takes up capacity at a station."""
        return bool(self._parts) and any(part.station == station and part._done < part._items for part in self._parts)

    @property
    def stations(self) -> tuple[int, ...]:
        """Ids of the stations that parts of the order were assigned to, in the order of assignment, without repeats."""
        return tuple(dict.fromkeys(part.station for part in self._parts))

    def __repr__(self) -> str:
        return f"Order({self.name!r}, lines={self.lines})"


class Part(ReadOnly):
    """Part of an order that one period assigned to a station: it takes capacity there until its last item is done."""

    __slots__ = ("_done", "_items", "_picked", "_skus", "order", "period", "station")

    order: Order
    station: int
    period: int

    def __init__(self, order: Order, station: int, period: int) -> None:
        put(self, "order", order)
        put(self, "station", station)
        put(self, "period", period)
        self._skus: list[int] = []
        self._items = self._picked = self._done = 0

    @property
    def skus(self) -> tuple[int, ...]:
        """SKU ids of its lines, as they were assigned."""
        return tuple(self._skus)

    @property
    def items(self) -> int:
        """Number of items of the part."""
        return self._items

    @property
    def unpicked_items(self) -> int:
        """Number of its items not yet picked."""
        return self._items - self._picked


class Request(ReadOnly):
    """Extract requests of one order line at a station, one after another, that were promised the same pod or none.

    Items count up from 0 as they are assigned; ``id`` is the number of the oldest item.
    """

    __slots__ = ("_items", "_pod", "id", "order", "part", "sku", "station")

    part: Part
    order: Order
    station: int
    sku: int
    _items: int
    _pod: Pod | None

    def __init__(self, request_id: int, part: Part, sku: int, items: int = 1, pod: Pod | None = None) -> None:
        put(self, "part", part)
        put(self, "order", part.order)
        put(self, "station", part.station)
        put(self, "sku", sku)
        put(self, "id", request_id)
        put(self, "_items", items)
        put(self, "_pod", pod)

    @property
    def items(self) -> int:
        """Number of items that are still to be picked."""
        return self._items

    @property
    def covered(self) -> bool:
        """Whether a pod inbound to the station holds an item for each of its items."""
        return self._pod is not None

    @property
    def pod(self) -> Pod | None:
        """The inbound pod that its items are promised from; another one may serve them in the end."""
        return self._pod

    def __repr__(self) -> str:
        what = f"order={self.order.name!r}, sku={self.sku}, items={self._items}, station={self.station}"
        return f"Request({what}, covered={self.covered})"


class Bundle(ReadOnly):
    """A replenishment order: items of one SKU (id) that are to be stored on one pod; ``size`` is the space they take.

    It is gone when it is stored.
    """

    __slots__ = ("_pod", "_station", "arrival_s", "arrival_tick", "id", "items", "name", "size", "sku")

    def __init__(self, bundle_id: int, name: str, sku: int, items: int, size: int, arrival_tick: int) -> None:
        self.id = bundle_id
        self.name = name
        self.sku = sku
        self.items = items
        self.size = size
        self.arrival_tick = arrival_tick
        self.arrival_s = to_seconds(arrival_tick)
        self._station: int | None = None
        self._pod: int | None = None

    @property
    def station(self) -> int | None:
        """Id of the replenishment station that it is assigned to, None while it waits."""
        return self._station

    @property
    def pod(self) -> int | None:
        """Id of the pod that it will be stored on and whose space it has, None until that is decided."""
        return self._pod

    def __repr__(self) -> str:
        return f"Bundle({self.name!r}, sku={self.sku}, items={self.items}, station={self._station}, pod={self._pod})"


class Pod(ReadOnly):
    """A pod: its contents, where it is, and which stations it is bound for."""

    __slots__ = (
        "_arrival",
        "_bundles",
        "_carrier",
        "_contents",
        "_itinerary",
        "_location",
        "_promised",
        "_touched",
        "_used",
        "_view",
        "capacity",
        "id",
        "name",
    )

    def __init__(
        self, pod_id: int, data: PodData, cell: int, capacity: int = UNLIMITED, sizes: Sequence[int] = ()
    ) -> None:
        self.id = pod_id
        self.name = data.name
        self.capacity = capacity
        self._used = sum((number or 0) * (sizes[sku] if sizes else 1) for sku, number in data.contents)
        self._bundles: dict[int, Bundle] = {}  # to be stored on it
        self._contents = {sku: UNLIMITED if number is None else number for sku, number in data.contents}
        self._view: Mapping[int, int] = MappingProxyType(self._contents)
        self._promised: dict[int, dict[int, int]] = {}  # SKU -> station -> items promised to requests there
        self._touched: set[tuple[Pod, int]] = set()  # SKUs whose free items may have changed since the warehouse looked
        self._location: int | None = cell
        self._itinerary: list[int] = []
        self._carrier: Robot | None = None
        self._arrival: Callable[[Pod], int | None] = lambda _: None  # until a warehouse has it

    @property
    def contents(self) -> Mapping[int, int]:
        """Items per SKU id; `UNLIMITED` (2**40) where the stock is unlimited."""
        return self._view

    @property
    def cell(self) -> int:
        """Cell index where the pod is, or was when the robot that carries it last stood still."""
        return cast("Robot", self._carrier).cell if self._location is None else self._location

    @property
    def location(self) -> int | None:
        """Cell index of the storage location it stands in, or None while a robot carries it."""
        return self._location

    @property
    def robot(self) -> int | None:
        """Id of the robot that carries it or is on its way to fetch it."""
        return None if self._carrier is None else self._carrier.id

    @property
    def bound_for(self) -> tuple[int, ...]:
        """Ids of the stations it is at or will visit, in this order."""
        return tuple(self._itinerary)

    @property
    def bundles(self) -> tuple[Bundle, ...]:
        """Bundles that are to be stored on it, by id."""
        return tuple(bundle for _, bundle in sorted(self._bundles.items()))

    @property
    def free_space(self) -> int:
        """Space, of ``capacity``, that neither items nor bundles to come take; `UNLIMITED` without a capacity."""
        taken = self._used + sum(bundle.size for bundle in self._bundles.values())
        return UNLIMITED if self.capacity >= UNLIMITED else self.capacity - taken

    @property
    def expected_arrival_s(self) -> float | None:
        """When it will be at the station it is bound for next, in seconds: as if no other robot were in the way.

        Counted from where its robot last stood, so late by a straight run at most; now for a pod in the station's line.
        None where that is unknown: it is bound for no station, or no robot fetches it yet.
        """
        tick = self._arrival(self)
        return None if tick is None else to_seconds(tick)

    def free_items(self, sku: int) -> int:
        """Items of a SKU that are not promised to any request."""
        number = self._contents.get(sku, 0)
        promised = self._promised.get(sku)
        return number if number >= UNLIMITED or not promised else number - sum(promised.values())

    def __repr__(self) -> str:
        return f"Pod({self.name!r}, location={self._location}, bound_for={self._itinerary})"


class Station(ReadOnly):
    """A station with its queue: orders are picked at it, bundles stored, or both.

    Attributes
    ----------
    picks, stores
        Whether it does either.
    bundle_capacity
        Bundles that can be assigned to it at a time; 0 where nothing is stored.
    """

    __slots__ = (
        "_active",
        "_bundles",
        "_by_sku",
        "_claimed_slots",
        "_in_hand",
        "_in_service",
        "_inbound",
        "_line",
        "_load",
        "_now",
        "_picker_expected",
        "_picker_free",
        "_requests",
        "_staffed",
        "_until",
        "bundle_capacity",
        "capacity",
        "cells",
        "counts_orders",
        "id",
        "name",
        "picks",
        "queue_length",
        "stores",
    )

    def __init__(
        self,
        station_id: int,
        cells: StationCells,
        capacity: int,
        counts_orders: bool,
        queue_length: int,
        name: str | None = None,
        bundle_capacity: int = 0,
        picks: bool = True,
    ) -> None:
        self.id = station_id
        self.name = name or str(station_id + 1)
        self.picks, self.stores, self.bundle_capacity = picks, bundle_capacity > 0, bundle_capacity
        self._bundles: dict[int, Bundle] = {}
        self.cells = cells
        self.capacity = capacity
        self.counts_orders = counts_orders
        self.queue_length = queue_length
        self._load = 0
        self._requests: list[Request] = []  # by id
        self._by_sku: dict[int, list[Request]] = {}
        self._inbound: dict[int, Pod] = {}
        self._line: list[Robot] = []
        self._claimed_slots = 0
        self._in_hand: Request | None = None
        self._picker_free = self._picker_expected = 0
        self._staffed = self._active = self._in_service = True
        self._until: int | None = None  # tick at which its timetable opens or closes it next
        self._now: Callable[[], int] = int  # 0, until a warehouse has it

    @property
    def open(self) -> bool:
        """Whether it takes new orders: it is staffed, active, and in service."""
        return self._staffed and self._active and self._in_service

    @property
    def in_service(self) -> bool:
        """Whether items are picked there now; False from a failure (``stations.outages``) to its repair."""
        return self._in_service

    @property
    def staffed(self) -> bool:
        """Whether its timetable (``stations.open``) has it open now; True for a station without one."""
        return self._staffed

    @property
    def active(self) -> bool:
        """Whether the activation rule named it when it was asked last; True where there is no such rule."""
        return self._active

    @property
    def opens_s(self) -> float | None:
        """When its timetable opens it next, in seconds; None while it is staffed, or where that never happens."""
        return None if self._staffed or self._until is None else to_seconds(self._until)

    @property
    def closes_s(self) -> float | None:
        """When its timetable closes it next, in seconds; None while it is not staffed, or where that never happens."""
        return to_seconds(self._until) if self._staffed and self._until is not None else None

    @property
    def in_hand(self) -> tuple[int, int] | None:
        """Ids of order and SKU of the item that is picked and not yet handled; None where there is none."""
        return None if self._in_hand is None else (self._in_hand.order.id, self._in_hand.sku)

    @property
    def picker_free_s(self) -> float:
        """When the picker is expected to have handled the item in hand, in seconds: now, where there is none."""
        return to_seconds(max(self._picker_expected, self._now()))

    @property
    def cell(self) -> int:
        """Cell index of the station itself."""
        return self.cells.station

    @property
    def load(self) -> int:
        """Capacity in use: items of the parts that are here, or their orders (order capacity)."""
        return self._load

    @property
    def free_capacity(self) -> int:
        """Items (or orders, with order capacity) that can still be assigned now; none while it is closed."""
        return max(self.capacity - self._load, 0) if self._staffed and self._active and self._in_service else 0

    @property
    def bundles(self) -> tuple[Bundle, ...]:
        """Bundles assigned to it and not stored yet, in the order of assignment."""
        return tuple(self._bundles.values())

    @property
    def free_bundle_capacity(self) -> int:
        """Bundles that can still be assigned now."""
        return self.bundle_capacity - len(self._bundles)

    @property
    def open_requests(self) -> tuple[Request, ...]:
        """Requests not yet picked, oldest first."""
        return tuple(self._requests)

    @property
    def uncovered_requests(self) -> tuple[Request, ...]:
        """Open requests for which no inbound pod holds an item, oldest first."""
        return tuple([request for request in self._requests if request._pod is None])

    @property
    def uncovered(self) -> dict[int, int]:
        """Items of ``uncovered_requests`` by SKU, those of the oldest first."""
        items: dict[int, int] = {}
        for request in self._requests:
            if request._pod is None:
                items[request.sku] = items.get(request.sku, 0) + request._items
        return items

    @property
    def open_items(self) -> int:
        """Number of items assigned to it and not yet picked."""
        return sum([request._items for request in self._requests])

    @property
    def uncovered_items(self) -> int:
        """Number of items of ``uncovered_requests``."""
        return sum([request._items for request in self._requests if request._pod is None])

    @property
    def inbound_pods(self) -> tuple[Pod, ...]:
        """Pods at the station or bound for it, in the order in which their trips were decided."""
        return tuple(self._inbound.values())

    @property
    def line(self) -> tuple[Robot, ...]:
        """Robots at the station (first) and in its queue."""
        return tuple(self._line)

    @property
    def pods_in_line(self) -> tuple[int, ...]:
        """Ids of the pods at the station (first) and in its queue."""
        return tuple(robot.pod for robot in self._line if robot.pod is not None)

    @property
    def queue_room(self) -> int:
        """Pods that could still set out for the station now."""
        return self.queue_length + 1 - self._claimed_slots

    def __repr__(self) -> str:
        return f"Station({self.name}, load={self._load}/{self.capacity}, open_items={self.open_items})"


class Robot(ReadOnly):
    """A robot with its position and its task."""

    __slots__ = (
        *("_battery", "_cell", "_goal", "_heading", "_in_service", "_on_duty", "_pod", "_task"),
        *("id", "name"),
    )

    def __init__(self, robot_id: int, cell: int, heading: int, name: str | None = None, on_duty: bool = True) -> None:
        self.id = robot_id
        self.name = name or str(robot_id + 1)
        self._cell = cell
        self._heading = heading
        self._pod: int | None = None
        self._task: int | None = None
        self._on_duty = on_duty
        self._goal: int | None = None
        self._in_service = True
        self._battery: Any = None  # of the process ``battery``

    @property
    def cell(self) -> int:
        """Cell index where it stands, or last stood while it drives."""
        return self._cell

    @property
    def heading(self) -> int:
        """0 east, 1 north, 2 west, 3 south."""
        return self._heading

    @property
    def pod(self) -> int | None:
        """Id of the pod it carries."""
        return self._pod

    @property
    def task(self) -> int | None:
        """Id of the pod it carries or is on its way to fetch; None without one."""
        return self._task

    @property
    def on_duty(self) -> bool:
        """Whether it takes tasks now (``robots.available``); one that does not finishes the task that it has."""
        return self._on_duty

    @property
    def in_service(self) -> bool:
        """Whether it works; False from when it fails, or its maintenance begins, until that is over."""
        return self._in_service

    @property
    def goal(self) -> int | None:
        """Cell that it was sent to without a task, until it has come to rest and is charged; None otherwise."""
        return self._goal

    @property
    def resting(self) -> bool:
        """Whether it is in service, has no task and was not sent anywhere."""
        return self._task is None and self._goal is None and self._in_service

    @property
    def charge(self) -> float | None:
        """Charge of its battery as a share of the capacity, 0 to 1; None without one."""
        return None if self._battery is None else self._battery.share

    @property
    def low(self) -> bool:
        """Whether its charge is too low for a task: it might not reach a charger afterwards."""
        return self._battery is not None and self._battery.low

    @property
    def idle(self) -> bool:
        """Whether it can take a task: it is on duty and in service, has none and no goal, and has charge enough."""
        free = self._task is None and self._goal is None and self._on_duty and self._in_service
        return free and (self._battery is None or not self.low)

    def __repr__(self) -> str:
        return f"Robot({self.name}, cell={self._cell}, task={self._task}, pod={self._pod})"
