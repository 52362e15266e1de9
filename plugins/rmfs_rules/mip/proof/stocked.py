"""Solutions found quickly where SKUs are scarce: as `rmfs_rules.mip.proof.feasible`, with an eye on the free items."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from attrs import define, field
from numpy.typing import NDArray

from rmfs_rules.mip.period.placing import Slots, stations_of
from rmfs_rules.mip.period.reduction import Reduced
from rmfs_rules.mip.period.solution import Model, Part, Visits
from rmfs_rules.mip.proof.feasible import fill_with_split_orders, place_lines, subset


def fill_from_stock(reduced: Reduced, visits: Visits) -> tuple[Part, ...]:
    """Assign as much as a quick search finds; for split-over-time, single items, the most that is possible.

    Parameters
    ----------
    reduced
        The period; for a model that splits orders, all lines are of one item.
    visits
        New visits.
    """
    period = reduced.period
    if reduced.model is Model.SPLIT_OVER_TIME:
        return lines_from_stock(reduced, visits, range(len(period.line_sku)))
    if reduced.model is Model.INTEGRATED or len(period.capacities) == 1:
        return _orders_at_hand(reduced, Shelf(reduced, visits))
    return fill_with_split_orders(
        reduced, reduced.orders, lambda: Slots.from_stock(period, visits), range(period.stock.n_skus)
    )


def lines_from_stock(reduced: Reduced, visits: Visits, lines: Sequence[int]) -> tuple[Part, ...]:
    """Place lines (positions) of one item each with new visits: a maximum flow, the first lines first."""
    period = reduced.period
    kept = np.array([line for line in lines if reduced.candidates[line]], dtype=np.int64)
    return place_lines(reduced, Slots.from_stock(period, visits), kept, range(period.stock.n_skus))


def one_line_orders(reduced: Reduced) -> list[int]:
    """Return the lines of one item, oldest first, that are all of an order: what three models treat alike."""
    period = reduced.period
    alone = np.bincount(period.line_order, minlength=len(period.orders))[period.line_order] == 1
    kept = reduced.candidates & alone & (period.line_quantity == 1)
    return [int(line) for line in np.flatnonzero(kept)]


@define
class Shelf:
    """Free items of the pods while orders take them, one order after the other.

    Parameters
    ----------
    reduced, visits
        The period, and new visits so far.
    """

    reduced: Reduced
    visits: Visits = ()
    left: NDArray[np.int64] = field(init=False)
    """Items, (pods, SKUs)."""
    supply: NDArray[np.int64] = field(init=False)
    """Items at each station, (stations, SKUs); a pod at several stations counts at each."""
    _at: dict[int, list[int]] = field(init=False)

    def __attrs_post_init__(self) -> None:
        period = self.reduced.period
        stock = period.stock
        assert stock.number is not None
        self.left = np.zeros((len(stock.pods), stock.n_skus), dtype=np.int64)
        self.left[stock.pod, stock.sku] = np.minimum(stock.number, sum(period.rooms))
        self.supply = np.zeros((len(period.capacities), period.stock.n_skus), dtype=np.int64)
        self._at = {}
        for pod, stations in stations_of(period, self.visits).items():
            for station in stations:
                self.bring(pod, station)

    def bring(self, pod: int, station: int) -> None:
        """Send a pod."""
        self._at.setdefault(pod, []).append(station)
        self.supply[station] += self.left[pod]

    def brought(self, pod: int, station: int) -> bool:
        """Whether a pod is at a station."""
        return station in self._at.get(pod, ())

    def take(self, station: int, lines: Sequence[tuple[int, int]]) -> None:
        """Take the items of lines off the pods at a station, first off pods that are at few others."""
        pods = sorted((pod for pod, at in self._at.items() if station in at), key=lambda pod: (len(self._at[pod]), pod))
        for sku, quantity in lines:
            wanted = quantity
            for pod in pods:
                number = min(wanted, int(self.left[pod, sku]))
                if number:
                    wanted -= number
                    self.left[pod, sku] -= number
                    self.supply[self._at[pod], sku] -= number


def _orders_at_hand(reduced: Reduced, shelf: Shelf) -> tuple[Part, ...]:
    """Fill station by station with whole orders that the pods there can serve all together.

    Orders that only few stations could take go first, among them the small ones, then the oldest.
    """
    period = reduced.period
    sizes = {order: kind.size for kind in reduced.types for order in kind.orders}
    served = [
        {o for o in reduced.orders if all(shelf.supply[s, i] >= q for i, q in period.lines[o])}
        for s in range(len(period.capacities))
    ]
    parts: list[Part] = []
    taken: set[int] = set()
    for station in sorted(range(len(period.capacities)), key=lambda s: (len(served[s]), s)):
        room = period.capacities[station]
        wanted = [o for o in reduced.orders if o in served[station] and o not in taken and sizes[o] <= room]
        wanted.sort(key=lambda o: (sum(o in at for at in served), sizes[o]))
        left, kept = shelf.supply[station].copy(), []
        for order in wanted:
            lines = period.lines[order]
            if all(left[i] >= q for i, q in lines):
                kept.append(order)
                for i, q in lines:
                    left[i] -= q
        for position in subset([sizes[o] for o in kept], room):
            order = kept[position]
            taken.add(order)
            parts.append(Part(order, station, tuple(sku for sku, _ in period.lines_of(order))))
            shelf.take(station, period.lines[order])
    return tuple(parts)
