"""The read-only view of the warehouse that every rule gets."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from rmfs_core.clock import to_seconds
from rmfs_core.warehouse.backlog import BacklogLines, FreeItems, items_in, lines_in
from rmfs_core.warehouse.column_keeping import columns_of
from rmfs_core.warehouse.columns import Lines, Stock
from rmfs_core.warehouse.packing import PackingStation
from rmfs_core.warehouse.parts import Bundle, Order, Pod, ReadOnly, Robot, Station
from rmfs_core.warehouse.state import Warehouse
from rmfs_core.world.travel import Travel


class WarehouseView(ReadOnly):
    """The warehouse as it is now, for looking only.

    Properties that return several objects make a tuple at each access: name it once where it is used in a loop.
    """

    __slots__ = ("_backlog", "_columns", "_lines", "_state")

    def __init__(self, state: Warehouse, backlog: Sequence[Order] | None = None) -> None:
        self._state = state
        self._backlog = None if backlog is None else tuple(backlog)
        self._lines: BacklogLines | None = None
        self._columns: Lines | None = None

    @property
    def now_tick(self) -> int:
        """Simulated time in ticks of 1 ms, the unit of travel times and of `Leg.wait_ticks`."""
        return self._state.now

    @property
    def now_s(self) -> float:
        """Simulated time in seconds."""
        return to_seconds(self._state.now)

    @property
    def orders(self) -> tuple[Order, ...]:
        """All orders that have arrived, in the order of arrival, whatever became of them."""
        return tuple(self._state.arrived.values())

    def orders_since(self, number: int = 0) -> list[Order]:
        """Orders that have arrived after the first ``number``, for rules that read each order once."""
        arrived = self._state.arrived
        latest = islice(reversed(arrived.values()), max(len(arrived) - number, 0))  # the rest is not even passed over
        return [*latest][::-1]

    @property
    def orders_waiting_for_stock(self) -> tuple[Order, ...]:
        """Orders that the pods cannot serve, oldest first: they are not in ``backlog`` until bundles are stored.

        An order waits when the items on pods, less what open requests and the orders of the backlog take, are too
        few for one of its lines. None where stock is unlimited, or with ``rules.wait_for_stock = false``.
        """
        return () if self._state.claims is None else tuple(self._state.claims.waiting.values())

    @property
    def filtered(self) -> bool:
        """Whether prefilters have left orders out of ``backlog``."""
        return self._backlog is not None

    @property
    def backlog(self) -> tuple[Order, ...]:
        """Orders with open lines, oldest first (arrival, then id); what the prefilters left when POA is decided.

        Whatever the stock cannot serve is not among them: see ``orders_waiting_for_stock``.
        """
        return self._state.backlog.orders if self._backlog is None else self._backlog

    @property
    def backlog_lines(self) -> BacklogLines:
        """The open lines of ``backlog`` as arrays, for rules that score all orders at once."""
        if self._backlog is None:
            return self._state.backlog.lines
        if self._lines is None:
            self._lines = lines_in(self.lines)
        return self._lines

    @property
    def lines(self) -> Lines:
        """Orders and open lines of ``backlog`` as columns; they hold for one call, later they change in place."""
        if self._backlog is None:
            return self._state.backlog.columns.lines()
        if self._columns is None:
            self._columns = columns_of(self._backlog, self._state.n_skus)
        return self._columns

    @property
    def stock(self) -> Stock:
        """Free items of the pods and where pods are, as columns; they hold for one call, later they change in place."""
        return self._state.columns.stock(self._state.leaving_pods())

    @property
    def capacities(self) -> NDArray[np.void]:
        """Capacities of the picking stations, as records by id: ``free``, ``load``, ``capacity``, ``counts_orders``.

        As `Station` has them, and ``inbound``: the number of its inbound pods. int64, shape (stations,). They hold for
        one call, later they change in place.
        """
        return self._state.capacities

    @property
    def version(self) -> int:
        """Number that changes with what decisions on orders and pods look at.

        When it changes, open lines, capacities, available items, stock, boxes, or the stored pods and their stations
        may have changed. It does not cover the time, ``leaving_pods``, robots, and the orders that prefilters show.
        """
        return self._state.changes + self._state.promises.changes

    @property
    def largest_capacity(self) -> int:
        """Items of the largest order that fits any station; `UNLIMITED` where one counts orders."""
        return self._state.largest_capacity

    def showing(self, orders: Sequence[Order]) -> WarehouseView:
        """Return the warehouse with some orders as its ``backlog``, oldest first, for rules that look at no others."""
        return type(self)(self._state, orders)

    @property
    def backlog_size(self) -> int:
        """Number of orders in ``backlog``; quicker than ``len(backlog)``."""
        return len(self._state.backlog) if self._backlog is None else len(self._backlog)

    @property
    def n_skus(self) -> int:
        """Number of SKUs; SKU ids are 0 .. n_skus - 1."""
        return self._state.n_skus

    @property
    def sizes(self) -> tuple[int, ...]:
        """Space that an item takes on a pod, by SKU id."""
        return self._state.sizes

    @property
    def unlimited_stock(self) -> bool:
        """Whether every pod has enough of every SKU it holds."""
        return self._state.unlimited_stock

    @property
    def pods(self) -> tuple[Pod, ...]:
        """The pods with contents, by id. (Empty pods only stand in the way.)"""
        return self._state.pods

    @property
    def free_items(self) -> FreeItems:
        """Items of each SKU on each pod that no request was promised, as they are now; ``stock`` is quicker."""
        return items_in(self.stock)

    @property
    def stations(self) -> tuple[Station, ...]:
        """The picking stations, by id."""
        return self._state.picking

    @property
    def replenishment_stations(self) -> tuple[Station, ...]:
        """The stations where bundles are stored, by id; stations that do only that have the ids after ``stations``."""
        return self._state.storing

    def station(self, station_id: int) -> Station:
        """Station of any kind by its id; pods may be bound for replenishment stations, too."""
        return self._state.stations[station_id]

    @property
    def bundles(self) -> tuple[Bundle, ...]:
        """Bundles that have arrived and are assigned to no station, oldest first."""
        return tuple(self._state.bundles.values())

    @property
    def robots(self) -> tuple[Robot, ...]:
        """The robots, by id."""
        return self._state.robots

    @property
    def idle_robots(self) -> tuple[Robot, ...]:
        """Robots that can take a task, by id."""
        return tuple(self._state.idle)

    @property
    def resting_robots(self) -> tuple[Robot, ...]:
        """Robots in service without a task or goal, by id: idle ones, those off duty or whose charge is too low."""
        return tuple(robot for robot in self._state.robots if robot.resting)

    @property
    def free_rest_cells(self) -> tuple[int, ...]:
        """Storage locations, with a pod or not, and chargers that a robot may be sent to without a task, ascending.

        Not those where a robot stands or is sent, that a pod is on its way to, or whose pod is to be fetched.
        """
        locations, taken = self._state.travel.layout.storage_locations, self._state.taken_cells()
        return tuple(cell for cell in sorted((*locations, *self._state.chargers)) if cell not in taken)

    @property
    def chargers(self) -> tuple[int, ...]:
        """Cell indices of the chargers in service, ascending."""
        return tuple(self._state.chargers)

    @property
    def free_pods(self) -> tuple[Pod, ...]:
        """Stored pods that are bound for no station, by id."""
        return tuple(pod for pod in self._state.pods if pod._location is not None and not pod._itinerary)

    @property
    def leaving_pods(self) -> tuple[Pod, ...]:
        """Pods at a station that serve nothing there any more and are bound for no other station, by id."""
        return self._state.leaving_pods()

    @property
    def waiting_pods(self) -> tuple[Pod, ...]:
        """Stored pods that are bound for a station and that no robot fetches yet, longest waiting first."""
        return tuple(self._state.waiting.values())

    @property
    def free_storage_locations(self) -> tuple[int, ...]:
        """Cell indices of the storage locations with no pod in them or on its way to them, ascending."""
        return tuple(self._state.free_locations)

    @property
    def blocked_locations(self) -> tuple[int, ...]:
        """Cell indices of the storage locations that hold an empty pod, ascending."""
        return self._state.blocked

    @property
    def reserved_locations(self) -> tuple[int, ...]:
        """Cell indices of the storage locations that a pod is on its way to, ascending."""
        return tuple(sorted(self._state.reserved))

    @property
    def travel(self) -> Travel:
        """Exact driving times on the grid without other robots."""
        return self._state.travel

    @property
    def split_orders_open(self) -> int:
        """Number of split orders that are not completely picked."""
        return self._state.split_orders_open

    @property
    def packing_stations(self) -> tuple[PackingStation, ...]:
        """The packing stations as they are now, by id; none where the scenario has none."""
        return tuple(self._state.packing)

    @property
    def free_boxes(self) -> int | None:
        """How many more orders can be split now: they count as `packing_from` says; None without packing stations."""
        return self._state.free_boxes

    def order(self, order_id: int) -> Order:
        """Order that has arrived, by its id, as events have it; KeyError for any other."""
        return self._state.arrived[order_id]

    def home(self, pod: Pod) -> int:
        """Cell index of the storage location at which a pod stood when the run started."""
        return self._state.homes[pod.id]

    def pods_with(self, sku: int) -> tuple[Pod, ...]:
        """Pods that held a SKU when the run started, or were given it since, by id."""
        return self._state.pods_with(sku)

    def fits(self, order: Order, station: Station) -> bool:
        """Whether all open lines of an order could be assigned to a station now."""
        return self._state.size_at(order, station) <= station.free_capacity

    def size_at(self, order: Order, station: Station) -> int:
        """Capacity that the open lines of an order take up at a station.

        In items; an order larger than any station takes up all of a station's capacity, so it fits an empty one. With
        order capacity: 1, or 0 if a part of the order is there already.
        """
        return self._state.size_at(order, station)

    def open_demand(self) -> NDArray[np.int64]:
        """Items wanted per SKU id and not yet picked, of all orders that arrived, also of orders that wait for stock.

        Shape (n_skus,).
        """
        return self._state.open_demand.copy()

    def ordered(self) -> NDArray[np.int64]:
        """Items per SKU id of all orders that have arrived, picked or not. Shape (n_skus,)."""
        return self._state.ordered.copy()

    def available(self) -> NDArray[np.int64]:
        """Items on each station's inbound pods that are not promised to any request. Shape (stations, n_skus)."""
        return self._state.promises.available[: len(self._state.picking)].copy()
