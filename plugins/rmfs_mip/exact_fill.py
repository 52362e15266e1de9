"""The most that given pods can fill, exactly, for stations with few free places.

Dynamic programming over the vectors of places taken at each station, one bit for each vector: assigning an order shifts
the bits. Orders that the same stations can serve line by line are interchangeable; of each such group no more are tried
than fit.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from rmfs_mip.reduction import Reduced, masks_of
from rmfs_mip.solution import Model, Part

MOST_VECTORS = 20_000
"""Bits that a set of vectors may have; more, and the solver is the better way."""


@frozen
class _Group:
    """Interchangeable orders: each option is a line's (station mask, items), or the whole order's."""

    lines: tuple[tuple[int, int], ...]
    size: int
    orders: tuple[int, ...]


class ExactFill:
    """Fills the stations of a period.

    Parameters
    ----------
    reduced
        The period, for one of the two models that assign orders completely.
    """

    def __init__(self, reduced: Reduced) -> None:
        self.reduced = reduced
        self.rooms = reduced.capacities
        self.strides = [1]
        for room in self.rooms:
            self.strides.append(self.strides[-1] * (2 * room + 1))
        self.possible = self.strides[-1] <= MOST_VECTORS
        if self.possible:
            self._prepare()

    def _prepare(self) -> None:
        """Set up the vectors by their sum, and the lines of the orders that can be assigned, order by order."""
        self.by_total = [0] * (sum(self.rooms) + 1)
        for vector in product(*(range(room + 1) for room in self.rooms)):
            self.by_total[sum(vector)] |= 1 << sum(n * stride for n, stride in zip(vector, self.strides, strict=False))
        self.valid = sum(self.by_total)
        period, kept = self.reduced.period, self.reduced.candidates
        self.sku, self.quantity = period.line_sku[kept], period.line_quantity[kept]
        order = period.line_order[kept]
        self.starts = np.flatnonzero(np.diff(order, prepend=-1))
        self.orders = order[self.starts]
        self.sizes = np.add.reduceat(self.quantity, self.starts) if len(order) else self.quantity
        rng = np.random.default_rng(1)  # hash values: an order's key is the sum over its lines, whatever their sequence
        self.keys = rng.integers(1 << 62, size=(int(self.quantity.max(initial=0)) + 1, 1 << len(self.rooms)))
        self.end = len(order)
        self.mask = self.quantity  # of each line; `groups` sets it

    def groups(self, covered: NDArray[np.bool_]) -> list[_Group]:
        """Group the orders that can be served with these SKUs at the stations, the group of the oldest first."""
        if not self.end:
            return []
        mask = self.mask = masks_of(covered)[self.sku]
        if self.reduced.model is Model.INTEGRATED:
            everywhere = np.bitwise_and.reduceat(mask, self.starts)
            for station, room in enumerate(self.rooms):
                everywhere &= np.where(self.sizes <= room, -1, ~(1 << station))
            served, keys = everywhere > 0, everywhere + (self.sizes << len(self.rooms))
        else:
            served = np.minimum.reduceat(mask, self.starts) > 0
            keys = np.add.reduceat(self.keys[self.quantity, mask], self.starts)
        positions = np.flatnonzero(served)
        _, first, inverse = np.unique(keys[positions], return_index=True, return_inverse=True)
        members: list[list[int]] = [[] for _ in first]
        for position, group in zip(positions.tolist(), inverse.tolist(), strict=True):
            members[group].append(position)
        return [self._group(members[g], mask) for g in np.argsort(first)]

    def _group(self, members: list[int], mask: NDArray[np.int64]) -> _Group:
        one = members[0]
        start = int(self.starts[one])
        end = int(self.starts[one + 1]) if one + 1 < len(self.starts) else self.end
        size = int(self.sizes[one])
        if self.reduced.model is Model.INTEGRATED:
            stations = int(np.bitwise_and.reduce(mask[start:end]))
            stations &= sum(1 << s for s, room in enumerate(self.rooms) if size <= room)
            lines: tuple[tuple[int, int], ...] = ((stations, size),)
        else:
            lines = tuple(zip(mask[start:end].tolist(), self.quantity[start:end].tolist(), strict=True))
        most = sum(self.rooms) // size
        return _Group(lines, size, tuple(int(self.orders[m]) for m in members[:most]))

    def most(self, covered: NDArray[np.bool_]) -> int:
        """Return the most places that can be filled with these SKUs at the stations."""
        reached = 1
        full = self.by_total[-1]
        for group in self.groups(covered):
            for _ in group.orders:
                more = reached | self._placed(reached, group)
                if more == reached:
                    break
                reached = more
            if reached & full:
                break
        return self._highest(reached)

    def parts(self, covered: NDArray[np.bool_]) -> tuple[Part, ...]:
        """Return an assignment that fills the most places."""
        steps: list[tuple[_Group, int, int]] = []  # group, order, vectors reached before
        reached = 1
        for group in self.groups(covered):
            for order in group.orders:
                steps.append((group, order, reached))
                reached |= self._placed(reached, group)
        goal = (reached & self.by_total[self._highest(reached)]).bit_length() - 1
        found: dict[tuple[int, int], list[int]] = {}
        for group, order, before in reversed(steps):
            if not before >> goal & 1:
                goal = self._take_back(group, order, before, goal, found)
        return tuple(Part(order, station, tuple(skus)) for (order, station), skus in sorted(found.items()))

    def _placed(self, reached: int, group: _Group) -> int:
        for mask, items in group.lines:
            placed = 0
            for station in range(len(self.rooms)):
                if mask >> station & 1 and items <= self.rooms[station]:
                    placed |= reached << (items * self.strides[station])
            reached = placed & self.valid
        return reached

    def _highest(self, reached: int) -> int:
        return next(total for total in range(len(self.by_total) - 1, -1, -1) if reached & self.by_total[total])

    def _take_back(
        self, group: _Group, order: int, before: int, goal: int, found: dict[tuple[int, int], list[int]]
    ) -> int:
        """Note where an order's lines are, on a way from the vectors before to the goal; return where the way began."""
        stations = range(len(self.rooms))
        options = [[s for s in stations if mask >> s & 1 and n <= self.rooms[s]] for mask, n in group.lines]
        skus = self._skus(group, order)
        for choice in product(*options):
            steps = [n * self.strides[s] for s, (_, n) in zip(choice, group.lines, strict=True)]
            start = goal - sum(steps)
            if start >= 0 and before >> start & 1 and self._fits(start, choice, group):
                for station, some in zip(choice, skus, strict=True):
                    found.setdefault((order, station), []).extend(some)
                return start
        raise AssertionError("no way back to a vector that was reached")

    def _fits(self, start: int, choice: tuple[int, ...], group: _Group) -> bool:
        """Whether the places taken at each station stay within its room."""
        taken = [start // self.strides[s] % (2 * room + 1) for s, room in enumerate(self.rooms)]
        for station, (_, items) in zip(choice, group.lines, strict=True):
            taken[station] += items
        return all(n <= room for n, room in zip(taken, self.rooms, strict=True))

    def _skus(self, group: _Group, order: int) -> list[list[int]]:
        """Return the SKUs of an order that stand for each of its group's lines."""
        at = int(np.searchsorted(self.orders, order))
        end = int(self.starts[at + 1]) if at + 1 < len(self.starts) else self.end
        lines = slice(int(self.starts[at]), end)
        if self.reduced.model is Model.INTEGRATED:
            return [self.sku[lines].tolist()]
        alike: dict[tuple[int, int], list[int]] = {}
        for sku, mask, items in zip(
            self.sku[lines].tolist(), self.mask[lines].tolist(), self.quantity[lines].tolist(), strict=True
        ):
            alike.setdefault((mask, items), []).append(sku)
        return [[alike[line].pop(0)] for line in group.lines]


def visits_worth_trying(reduced: Reduced) -> list[tuple[int, int]]:
    """Return a new visit (pod, station) for each class of pods that no other dominates."""
    period = reduced.period
    visits = []
    for station in range(len(period.capacities)):
        wanted = reduced.wanted(station) & ~period.covered[station]
        visits += [(pod, station) for pod in reduced.classes(wanted, period.idle)]
    return visits
