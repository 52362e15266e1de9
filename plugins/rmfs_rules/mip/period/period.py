"""Input of one period's model, as plain data read off the warehouse."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from attrs import define, evolve, field, frozen

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rmfs_core.warehouse import Order, Station, WarehouseView

Line = tuple[int, int]
"""SKU id and number of items."""


def _integers(values: Sequence[int] | NDArray[np.int64]) -> NDArray[np.int64]:
    return np.asarray(values, dtype=np.int64)


@frozen(eq=False, slots=False)
class Stock:
    """Contents of the pods, as entries sorted by pod and SKU: what a pod has a free item of.

    Parameters
    ----------
    pods
        Pod ids: 0, 1, ...
    n_skus
        Number of SKUs.
    pod, sku
        Pod and SKU id of each entry.
    number
        f_ip: items of it that are promised to no request. None where stock is unlimited, so that a pod with a SKU has
        enough of it.
    """

    pods: range
    n_skus: int
    pod: NDArray[np.int64] = field(converter=_integers)
    sku: NDArray[np.int64] = field(converter=_integers)
    number: NDArray[np.int64] | None = None

    @cached_property
    def starts(self) -> NDArray[np.int64]:
        """Where the entries of each pod begin, and where the last ones end. Shape (pods + 1,)."""
        return np.searchsorted(self.pod, np.arange(len(self.pods) + 1)).astype(np.int64, copy=False)

    @cached_property
    def stocked(self) -> NDArray[np.bool_]:
        """SKUs that are on some pod. Shape (n_skus,)."""
        stocked = np.zeros(self.n_skus, dtype=np.bool_)
        stocked[self.sku] = True
        return stocked

    @cached_property
    def holds(self) -> NDArray[np.float64]:
        """1 where a pod has a free item of a SKU, shape (pods, SKUs); for warehouses where that is not too large."""
        holds = np.zeros((len(self.pods), self.n_skus))
        holds[self.pod, self.sku] = 1.0
        return holds

    def items_on(self, pod: int) -> dict[int, int]:
        """Return the free items of each SKU on a pod, where stock is finite."""
        assert self.number is not None
        entries = slice(*self.starts[pod : pod + 2].tolist())
        return dict(zip(self.sku[entries].tolist(), self.number[entries].tolist(), strict=True))

    def skus_of(self, pod: int) -> NDArray[np.int64]:
        """Return the SKU ids on a pod."""
        return self.sku[self.starts[pod] : self.starts[pod + 1]]

    def on(self, pods: Sequence[int]) -> NDArray[np.bool_]:
        """Return the SKUs that are on some of these pods. Shape (n_skus,)."""
        there = np.zeros(self.n_skus, dtype=np.bool_)
        for pod in pods:
            there[self.skus_of(pod)] = True
        return there

    def sums(self, values: NDArray[Any]) -> NDArray[np.float64]:
        """Return for each pod the sum of the values of its SKUs, which are whole numbers. Shape (pods,)."""
        sums = np.bincount(self.pod, weights=values[self.sku], minlength=len(self.pods))
        return sums.astype(np.float64, copy=False)

    @classmethod
    def of(cls, warehouse: WarehouseView) -> Stock:
        """Read what the pods of a warehouse have now."""
        stock = warehouse.stock
        some = stock.items > 0
        number = None if warehouse.unlimited_stock else stock.items[some]
        return cls(range(len(stock.at)), warehouse.n_skus, stock.pod[some], stock.sku[some], number)

    def with_items(self, number: NDArray[np.int64]) -> Stock:
        """Return the same with other numbers of items of each entry, also none."""
        some = number > 0
        return evolve(self, pod=self.pod[some], sku=self.sku[some], number=number[some])


@frozen(eq=False)
class Preference:
    """Which pods are sent first among equally good ones.

    Parameters
    ----------
    pods
        From 0 to 1 for each pod; those with more go first. Shape (pods,).
    once_sent
        Value of a pod from when this period sends it; None: the same as before.
    """

    pods: NDArray[np.float64]
    once_sent: float | None = None


@define(eq=False, slots=False)
class Period:
    """Stations with free capacity, the backlog and the pods. Everything but ids is a position in these sequences.

    Parameters
    ----------
    stock
        All pods.
    stations, capacities
        Ids of the stations with free capacity, and C_s.
    inbound
        P_s for each of these stations: positions of the pods at it or bound for it, ascending.
    orders
        Ids of the backlog's orders, oldest first.
    line_order, line_sku, line_quantity
        Open lines: position of the order (ascending), SKU id, number of items.
    busy
        Positions of the pods that are bound for any station, also for one without free capacity, ascending.
    begun
        Whether parts of the order were assigned in earlier periods (so that it is split already).
    split_open
        n^l: split orders that take a slot at the packing stations now.
    preference
        Which pods are sent first among equally good ones. None: pods that are bound for no station.
    counting_orders
        Positions of the stations with order capacity: C_s is of parts of orders there, of items at the others.
    joined
        (order, station): the order has a slot there already, which a further part of it joins. Where it counts orders.
    """

    stock: Stock
    stations: tuple[int, ...]
    capacities: tuple[int, ...]
    inbound: tuple[tuple[int, ...], ...]
    orders: tuple[int, ...]
    line_order: NDArray[np.int64] = field(converter=_integers)
    line_sku: NDArray[np.int64] = field(converter=_integers)
    line_quantity: NDArray[np.int64] = field(converter=_integers)
    busy: tuple[int, ...] = ()
    begun: tuple[bool, ...] = ()
    split_open: int = 0
    preference: Preference | None = None
    counting_orders: frozenset[int] = frozenset()
    joined: frozenset[tuple[int, int]] = frozenset()

    @classmethod
    def of(
        cls, warehouse: WarehouseView, stock: Stock, *, packing: bool = False, without: Station | None = None
    ) -> Period:
        """Read the period that begins now.

        Parameters
        ----------
        warehouse
            The warehouse.
        stock
            Contents of its pods.
        packing
            Whether to look up which orders are split already.
        without
            A station that takes nothing now.
        """
        free = [station for station in warehouse.stations if station.free_capacity > 0 and station is not without]
        counting = [(at, station) for at, station in enumerate(free) if station.counts_orders]
        lines = warehouse.lines
        is_there = lines.open_lines > 0
        position = np.cumsum(is_there) - 1  # by row
        open_line = lines.quantity.nonzero()
        begun = lines.begun if counting or packing else ()
        at_rows = ((int(position[row]), warehouse.order(int(lines.order_id[row]))) for row in begun)
        with_parts = {o: order for o, order in at_rows if order.parts}  # of others, lines were cancelled
        return cls(
            stock=stock,
            stations=tuple(station.id for station in free),
            capacities=tuple(station.free_capacity for station in free),
            inbound=tuple(tuple(sorted(pod.id for pod in station.inbound_pods)) for station in free),
            orders=tuple(lines.order_id[is_there].tolist()),
            line_order=position[lines.order[open_line]],
            line_sku=lines.sku[open_line],
            line_quantity=lines.quantity[open_line],
            busy=tuple(sorted({pod.id for station in warehouse.stations for pod in station.inbound_pods})),
            begun=tuple(o in with_parts for o in range(np.count_nonzero(is_there))) if packing else (),
            split_open=warehouse.split_orders_open if packing else 0,
            counting_orders=frozenset(at for at, _ in counting),
            joined=frozenset(
                (o, at) for o, order in with_parts.items() for at, station in counting if order.has_place_at(station.id)
            ),
        )

    @classmethod
    def alone(cls, warehouse: WarehouseView, stock: Stock, order: Order, station: Station) -> Period:
        """Read a period of one order and one station, which has as many slots as the order has items."""
        return cls(
            stock=stock,
            stations=(station.id,),
            capacities=(order.open_items,),
            inbound=(tuple(sorted(pod.id for pod in station.inbound_pods)),),
            orders=(order.id,),
            line_order=[0] * len(order.open_lines),
            line_sku=[line.sku for line in order.open_lines],
            line_quantity=[line.quantity for line in order.open_lines],
            busy=tuple(sorted({pod.id for at in warehouse.stations for pod in at.inbound_pods})),
        )

    @cached_property
    def lines(self) -> tuple[tuple[Line, ...], ...]:
        """Open lines of each order, by SKU id."""
        starts = np.searchsorted(self.line_order, np.arange(len(self.orders) + 1)).tolist()
        lines = list(zip(self.line_sku.tolist(), self.line_quantity.tolist(), strict=True))
        return tuple(tuple(sorted(lines[first:last])) for first, last in pairwise(starts))

    def lines_of(self, order: int) -> tuple[Line, ...]:
        """Open lines of one order (position), by SKU id: where few orders are asked for, faster than `lines`."""
        first, last = self.line_order.searchsorted((order, order + 1)).tolist()
        skus, quantities = self.line_sku[first:last].tolist(), self.line_quantity[first:last].tolist()
        return tuple(sorted(zip(skus, quantities, strict=True)))

    @cached_property
    def covered(self) -> NDArray[np.bool_]:
        """SKUs that are at each station for nothing, on a pod of P_s. Shape (stations, n_skus)."""
        return np.array([self.stock.on(pods) for pods in self.inbound]).reshape(-1, self.stock.n_skus)

    def covered_with(self, visits: Sequence[tuple[int, int]]) -> NDArray[np.bool_]:
        """Return what the stations cover once new visits (pod, station) are counted in. Shape (stations, n_skus)."""
        if not visits:
            return self.covered
        covered = self.covered.copy()
        for pod, station in visits:
            covered[station, self.stock.skus_of(pod)] = True
        return covered

    @cached_property
    def supply(self) -> NDArray[np.float64]:
        """Free items of each SKU on all pods together, infinite where stock is unlimited. Shape (n_skus,)."""
        if self.stock.number is None:
            return np.where(self.stock.stocked, np.inf, 0.0)
        supply = np.bincount(self.stock.sku, weights=self.stock.number, minlength=self.stock.n_skus)
        return supply.astype(np.float64, copy=False)

    @cached_property
    def single_items(self) -> bool:
        """Whether every line is for one item, as the paper assumes."""
        return bool((self.line_quantity == 1).all())

    @cached_property
    def idle(self) -> NDArray[np.float64]:
        """1 for each pod that is bound for no station, else 0. Shape (pods,)."""
        idle = np.ones(len(self.stock.pods))
        idle[list(self.busy)] = 0.0
        return idle

    @cached_property
    def preferred(self) -> Preference:
        """`preference`, or what it is when None."""
        return Preference(self.idle, once_sent=0.0) if self.preference is None else self.preference

    @property
    def visits_before(self) -> int:
        """Pods of P_s over the stations: the constant that they add to the objective (1)."""
        return sum(map(len, self.inbound))

    @cached_property
    def rooms(self) -> tuple[int, ...]:
        """Most items that each station can get: its slots, or with order capacity all that there are."""
        if not self.counting_orders:
            return self.capacities
        everything = int(self.line_quantity.sum())
        return tuple(everything if s in self.counting_orders else room for s, room in enumerate(self.capacities))

    @cached_property
    def factors(self) -> tuple[int, ...]:
        """W_u of a free slot at each station: times 1, or with order capacity, the items of the largest order.

        With W_u > 1, a slot for an item is worth filling, as that takes one visit at most. A slot for an order may
        take as many visits as the order has items.
        """
        if not self.counting_orders:
            return (1,) * len(self.capacities)
        largest = int(np.bincount(self.line_order, weights=self.line_quantity).max(initial=1))
        return tuple(largest if s in self.counting_orders else 1 for s in range(len(self.capacities)))

    def slots(self, order: int, station: int, items: int) -> int:
        """Return how many slots so many items of an order, as one part, take at a station (positions)."""
        if station in self.counting_orders:
            return int((order, station) not in self.joined)
        return items

    def begun_before(self, order: int) -> bool:
        """Whether parts of an order (position) were assigned in earlier periods."""
        return bool(self.begun) and self.begun[order]
