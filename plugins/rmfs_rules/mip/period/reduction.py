"""Shrinks a period without changing any optimum: what cannot be assigned goes, what is interchangeable is counted.

- Only lines whose SKU is on a pod and that fit some station; where orders are assigned whole, only orders that fit.
- Orders with the same lines are one type with a count.
- Pods that bring the same wanted SKUs to a station are one class there; a class within another is dropped.
- SKUs of which every pod has as many free items as the period can take of it need no count of these; the others are
  scarce, and a pod that brings one is in a class of its own.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from attrs import define, frozen
from numpy.typing import NDArray

from rmfs_rules.mip.period.period import Line, Period
from rmfs_rules.mip.period.solution import Model


@frozen
class OrderType:
    """Orders with the same lines.

    Parameters
    ----------
    lines
        SKU ids and numbers of items.
    size
        Slots that an order takes: items of all lines, or 1 where all stations count orders.
    begun
        Whether parts were assigned in earlier periods.
    orders
        Positions of the orders, oldest first.
    """

    lines: tuple[Line, ...]
    size: int
    begun: bool
    orders: tuple[int, ...]


@define(eq=False, slots=False)
class Reduced:
    """A period as one model needs it.

    Parameters
    ----------
    period, model
        The period and the model to solve.
    counted
        Whether equal orders are counted (False: each is its own type, so that they can be told apart by age).
    """

    period: Period
    model: Model
    counted: bool = True

    @property
    def capacities(self) -> tuple[int, ...]:
        """C_s."""
        return self.period.capacities

    @cached_property
    def most(self) -> int:
        """Largest number of items of an order that can be assigned at all (for split-over-time: of a line)."""
        one_order = self.model is Model.SPLIT_AMONG_STATIONS
        return sum(self.period.rooms) if one_order else max(self.period.rooms, default=0)

    @cached_property
    def interchangeable(self) -> bool:
        """Whether the stations have equal capacity and cover the same SKUs, as at t = 1."""
        covered = self.period.covered
        by_orders = not self.period.counting_orders or self.by_orders
        return len(set(self.capacities)) == 1 and by_orders and bool((covered == covered[0]).all())

    @cached_property
    def by_orders(self) -> bool:
        """Whether a whole order takes one slot, wherever it goes."""
        return len(self.period.counting_orders) == len(self.capacities) and not self.period.joined

    @cached_property
    def _obtainable(self) -> NDArray[np.bool_]:
        """Lines of which all pods together have enough. Shape (lines,)."""
        period = self.period
        if period.stock.number is None:
            return period.stock.stocked[period.line_sku]
        return period.supply[period.line_sku] >= period.line_quantity

    @cached_property
    def candidates(self) -> NDArray[np.bool_]:
        """Lines that can be assigned. Shape (lines,)."""
        period = self.period
        largest = max(period.rooms, default=0)
        good: NDArray[np.bool_] = self._obtainable & (period.line_quantity <= largest)
        if self.model is Model.SPLIT_OVER_TIME:
            return good
        n = len(period.orders)
        sizes = np.bincount(period.line_order, weights=period.line_quantity, minlength=n)
        bad = np.bincount(period.line_order[~good], minlength=n) > 0
        return ((sizes <= self.most) & ~bad)[period.line_order]

    @cached_property
    def demand(self) -> NDArray[np.float64]:
        """Items wanted per SKU, of the lines that can be assigned."""
        kept = self.candidates
        demand = np.bincount(
            self.period.line_sku[kept],
            weights=self.period.line_quantity[kept].astype(np.float64),
            minlength=self.period.stock.n_skus,
        )
        return demand.astype(np.float64, copy=False)

    @cached_property
    def scarce(self) -> NDArray[np.int64]:
        """SKUs of which some pod has fewer free items than the period could take from it, ascending."""
        stock = self.period.stock
        if stock.number is None:
            return np.zeros(0, dtype=np.int64)
        most = np.minimum(self.demand, sum(self.period.rooms))
        return np.unique(stock.sku[stock.number < most[stock.sku]])

    @cached_property
    def is_scarce(self) -> NDArray[np.bool_]:
        """Whether each SKU is scarce. Shape (n_skus,)."""
        scarce = np.zeros(self.period.stock.n_skus, dtype=np.bool_)
        scarce[self.scarce] = True
        return scarce

    @cached_property
    def deliverable(self) -> int:
        """Items that can be assigned at all, whatever their orders and stations."""
        if not len(self.scarce):
            return int(self.demand.sum())
        return int(np.minimum(self.demand, self.period.supply).sum())

    @cached_property
    def orders(self) -> tuple[int, ...]:
        """Positions of the orders with lines that can be assigned, oldest first."""
        return tuple(np.unique(self.period.line_order[self.candidates]).tolist())

    def lines_of(self, order: int) -> tuple[Line, ...]:
        """Lines of an order that can be assigned."""
        if self.model is not Model.SPLIT_OVER_TIME:
            return self.period.lines[order]
        supply, largest = self.period.supply, max(self.period.rooms)
        return tuple((i, q) for i, q in self.period.lines[order] if supply[i] >= q and q <= largest)

    @cached_property
    def sizes(self) -> NDArray[np.int64]:
        """Slots that each order takes with the lines that can be assigned; none where none can. Shape (orders,)."""
        period, kept = self.period, self.candidates
        if self.by_orders:
            return (np.bincount(period.line_order[kept], minlength=len(period.orders)) > 0).astype(np.int64)
        weights = period.line_quantity[kept].astype(np.float64)
        return np.bincount(period.line_order[kept], weights=weights, minlength=len(period.orders)).astype(np.int64)

    @cached_property
    def types(self) -> tuple[OrderType, ...]:
        """Types of the orders with lines that can be assigned, in the order of their oldest."""
        found: dict[tuple[tuple[Line, ...], bool, int], list[int]] = {}
        joining = {order for order, _ in self.period.joined}
        for order in self.orders:
            lines = self.lines_of(order)
            alone = not self.counted or order in joining or len(lines) < len(self.period.lines[order])
            key = (lines, self.period.begun_before(order), order if alone else -1)
            found.setdefault(key, []).append(order)
        return tuple(
            OrderType(lines, 1 if self.by_orders else sum(q for _, q in lines), begun, tuple(orders))
            for (lines, begun, _), orders in found.items()
        )

    @cached_property
    def reachable(self) -> tuple[int, ...]:
        """Slots of each station that can be filled when every SKU is there.

        Whole orders may leave slots that no order fits; for split-among-stations only the sum over the stations is so
        limited, see `reachable_sum`.
        """
        if self.model is not Model.INTEGRATED:
            return self.capacities
        return tuple(highest(sums_of(self._few_sizes(room), room), room) for room in self.capacities)

    @cached_property
    def reachable_sum(self) -> int:
        """Slots of all stations together that can be filled when every SKU is everywhere."""
        room = sum(self.reachable)
        if self.model is Model.SPLIT_AMONG_STATIONS:
            return highest(sums_of(self._few_sizes(room), room), room)
        return min(room, self.deliverable)

    def least(self, weight: float) -> float:
        """Return objective (1) without a new visit, had all slots been filled that can be, for a W_u."""
        return self.period.visits_before + weight * (sum(self.capacities) - self.reachable_sum)

    def _few_sizes(self, room: int) -> list[int]:
        """Return the sizes of the orders, each as often as it fits the capacity at most."""
        sizes, numbers = np.unique(self.sizes[(self.sizes > 0) & (self.sizes <= room)], return_counts=True)
        found = zip(sizes.tolist(), numbers.tolist(), strict=True)
        return [size for size, n in found for _ in range(min(n, room // size))]

    def wanted(self, station: int) -> NDArray[np.bool_]:
        """Return the SKUs of lines that can be assigned to a station (for integrated: with their whole order)."""
        period, room = self.period, self.period.rooms[station]
        kept = self.candidates & (period.line_quantity <= room)
        if self.model is Model.INTEGRATED:
            n = len(period.orders)
            sizes = np.bincount(period.line_order, weights=period.line_quantity, minlength=n)
            kept = kept & (sizes <= room)[period.line_order]
        wanted = np.zeros(period.stock.n_skus, dtype=np.bool_)
        wanted[period.line_sku[kept]] = True
        return wanted

    def classes(self, wanted: NDArray[np.bool_], value: NDArray[np.float64]) -> list[int]:
        """Return one pod (position) for every class of pods that no other class dominates.

        Parameters
        ----------
        wanted
            SKUs that a new pod at the station would be useful for. Shape (n_skus,).
        value
            Further worth of a pod; a pod is dominated only by one that is worth as much.
        """
        pod, sku = self.period.stock.pod, self.period.stock.sku
        kept = wanted[sku]
        useful, pod = np.unique(pod[kept], return_inverse=True)
        if not len(useful):
            return []
        sku = sku[kept]
        worth = value[useful]
        within = _within(pod, sku, len(useful))
        within &= worth[:, None] <= worth[None, :]
        strictly = within & ~within.T
        first = np.arange(len(useful))[:, None] > np.arange(len(useful))[None, :]
        dominated = (strictly | (within & within.T & first)).any(axis=1)
        if len(self.scarce):
            dominated &= np.bincount(pod[self.is_scarce[sku]], minlength=len(useful)) == 0
        return [int(p) for p in useful[~dominated]]


def _within(pod: NDArray[np.int64], sku: NDArray[np.int64], pods: int) -> NDArray[np.bool_]:
    """Return for each pair of pods whether the second brings all that the first brings.

    That is so when they have as many SKUs in common as the first has. What they have in common is counted SKU by SKU,
    over the pairs of pods that have it; pods (from 0 on) and SKUs are what the pods bring.
    """
    by_sku = np.argsort(sku, kind="stable")
    pod, sku = pod[by_sku], sku[by_sku]
    first = np.searchsorted(sku, sku)
    number = np.searchsorted(sku, sku, side="right") - first
    one = np.repeat(pod, number)
    place = np.arange(len(one)) - np.repeat(np.cumsum(number) - number, number)
    other = pod[np.repeat(first, number) + place]
    common = np.bincount(one * pods + other, minlength=pods * pods).reshape(pods, pods)
    within: NDArray[np.bool_] = common == np.diagonal(common)[:, None]
    return within


def sums_of(sizes: list[int], most: int) -> int:
    """Return the sums up to ``most`` that some of the sizes have, as bits."""
    reached, limit = 1, (1 << (most + 1)) - 1
    for size in sizes:
        if reached == limit:
            break
        reached |= (reached << size) & limit
    return reached


def highest(reached: int, most: int) -> int:
    """Return the largest sum up to ``most`` among bits."""
    return (reached & ((1 << (most + 1)) - 1)).bit_length() - 1


def masks_of(covered: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return per SKU the bit mask of the stations that cover it, from a table (stations, SKUs)."""
    masks: NDArray[np.int64] = (1 << np.arange(len(covered))) @ covered
    return masks
