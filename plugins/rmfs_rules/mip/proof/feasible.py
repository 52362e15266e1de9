"""Solutions found quickly, optimal or not: every one satisfies the printed constraints, and so bounds from above.

`fill` assigns what the pods at the stations cover. Where there is a choice, the oldest orders go first.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from rmfs_rules.mip.period.placing import Slots
from rmfs_rules.mip.period.reduction import Reduced, highest, masks_of
from rmfs_rules.mip.period.solution import Model, Part, parts_from


def fill(reduced: Reduced, covered: NDArray[np.bool_]) -> tuple[Part, ...]:
    """Assign as much as a quick search finds.

    For split-over-time (single items) and for a single station it is the most that is possible.

    Parameters
    ----------
    reduced
        The period.
    covered
        SKUs that are at each station, with new visits counted in. Shape (stations, n_skus).
    """
    if reduced.model is Model.SPLIT_OVER_TIME:
        return _fill_with_lines(reduced, covered)
    if reduced.model is Model.INTEGRATED or len(reduced.capacities) == 1:
        return fill_with_orders(reduced, covered)
    somewhere: NDArray[np.bool_] = np.asarray(covered.any(axis=0, keepdims=True))
    orders = np.flatnonzero(_covered_orders(reduced, somewhere)[0]).tolist()
    kinds = masks_of(covered).tolist()
    return fill_with_split_orders(reduced, orders, lambda: Slots.covered(reduced.capacities, kinds), kinds)


def _fill_with_lines(reduced: Reduced, covered: NDArray[np.bool_]) -> tuple[Part, ...]:
    period, kinds = reduced.period, masks_of(covered)
    mask = kinds[period.line_sku]
    lines = np.flatnonzero(mask if period.single_items else (mask > 0) & reduced.candidates)
    if len(period.capacities) == 1:
        lines = lines[: period.capacities[0]]
    return place_lines(reduced, Slots.covered(period.capacities, kinds.tolist()), lines, kinds.tolist())


def place_lines(reduced: Reduced, slots: Slots, lines: NDArray[np.int64], kinds: Sequence[int]) -> tuple[Part, ...]:
    """Place lines of one item each: a maximum flow, the first lines first.

    Parameters
    ----------
    reduced
        The period.
    slots
        The slots.
    lines
        Positions of the lines.
    kinds
        Number of each SKU among the rows.
    """
    period, room = reduced.period, sum(reduced.period.capacities)
    placed: list[tuple[int, int]] = []
    full: set[int] = set()  # kinds that find no slot any more; none that failed can succeed later
    for line in lines.tolist():  # most often the first few fill all slots
        sku = int(period.line_sku[line])
        if kinds[sku] not in full:
            if slots.add(kinds[sku]):
                placed.append((int(period.line_order[line]), sku))
                if len(placed) == room:
                    break
            else:
                full.add(kinds[sku])
    return _parts(slots, placed, kinds)


def _parts(slots: Slots, lines: Iterable[tuple[int, int]], kinds: Sequence[int]) -> tuple[Part, ...]:
    """Name the station of each placed line (order, SKU), keeping lines of an order together where it is free to."""
    placed: list[tuple[int, int, int]] = []
    used: dict[int, list[int]] = {}
    for order, sku in lines:
        station = slots.take(kinds[sku], used.get(order, ()))
        used.setdefault(order, []).append(station)
        placed.append((order, station, sku))
    return parts_from(placed)


def fill_with_orders(reduced: Reduced, covered: NDArray[np.bool_]) -> tuple[Part, ...]:
    """Fill station by station with whole orders whose SKUs are all there; the fullest fill of each, oldest first.

    Parameters
    ----------
    reduced
        The period.
    covered
        SKUs that are at each station, with new visits counted in. Shape (stations, n_skus).
    """
    period, sizes = reduced.period, reduced.sizes
    fits = _covered_orders(reduced, covered)
    stations = fits.sum(axis=0)
    parts: list[Part] = []
    left = np.ones(len(sizes), dtype=np.bool_)
    for station in sorted(range(len(period.capacities)), key=lambda s: (int(fits[s].sum()), s)):
        room = period.capacities[station]
        candidates = np.flatnonzero(fits[station] & left & (sizes <= room))
        # An order that no other station could take goes first.
        candidates = candidates[np.argsort(stations[candidates], kind="stable")]
        chosen = candidates[subset(sizes[candidates].tolist(), room)]
        left[chosen] = False
        parts += [_whole(reduced, order, station) for order in chosen.tolist()]
    return tuple(parts)


def _whole(reduced: Reduced, order: int, station: int) -> Part:
    return Part(order, station, tuple(sku for sku, _ in reduced.period.lines_of(order)))


def _covered_orders(reduced: Reduced, covered: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return for each station which orders that can be assigned at all it covers. Shape (stations, orders)."""
    period, kept = reduced.period, reduced.candidates
    order, sku = period.line_order[kept], period.line_sku[kept]
    missing = np.array([np.bincount(order[~row[sku]], minlength=len(period.orders)) for row in covered])
    fits: NDArray[np.bool_] = (missing == 0) & (reduced.sizes > 0)
    return fits


def subset(sizes: Sequence[int], room: int) -> list[int]:
    """Return positions of sizes with the largest sum up to ``room``, the foremost where there is a choice."""
    reached = [1]
    limit = (1 << (room + 1)) - 1
    for size in sizes:
        reached.append(reached[-1] | (reached[-1] << size) & limit)
        if reached[-1] >> room & 1:
            break
    goal = highest(reached[-1], room)
    chosen = []
    for position in range(len(reached) - 1, 0, -1):
        if not reached[position - 1] >> goal & 1:
            chosen.append(position - 1)
            goal -= sizes[position - 1]
    return chosen[::-1]


def fill_with_split_orders(
    reduced: Reduced, orders: Sequence[int], free: Callable[[], Slots], kinds: Sequence[int]
) -> tuple[Part, ...]:
    """Place orders line by line over the stations, such that what is left stays a sum that orders can fill.

    Parameters
    ----------
    reduced
        The period.
    orders
        Positions of orders of single items, oldest first.
    free
        Returns the free slots.
    kinds
        Number of each SKU among these.
    """
    sizes = reduced.sizes.tolist()
    best: tuple[list[int], Slots] = ([], free())
    for sequence in (orders, sorted(orders, key=lambda o: -sizes[o])):
        found = _place_orders(reduced, sequence, free(), kinds)
        if sum(sizes[o] for o in found[0]) > sum(sizes[o] for o in best[0]):
            best = found
        if sum(sizes[o] for o in best[0]) == reduced.reachable_sum:
            break
    return _parts(best[1], [(o, i) for o in best[0] for i, _ in reduced.period.lines_of(o)], kinds)


def _place_orders(
    reduced: Reduced, sequence: Sequence[int], slots: Slots, kinds: Sequence[int]
) -> tuple[list[int], Slots]:
    period, sizes, left = reduced.period, reduced.sizes.tolist(), sum(reduced.period.capacities)
    later = [1]  # sums that the orders from a position on can have, as bits
    for order in reversed(sequence):
        later.append(later[-1] | (later[-1] << sizes[order]) & ((1 << (left + 1)) - 1))
    later.reverse()
    chosen = []
    goal = highest(later[0], left)
    for position, order in enumerate(sequence):
        rest = goal - sizes[order]
        if rest >= 0 and later[position + 1] >> rest & 1:
            if slots.add_all([kinds[i] for i, _ in period.lines_of(order)]):
                chosen.append(order)
                goal = rest
                if goal == 0:
                    break
            elif not later[position + 1] >> goal & 1:
                goal = highest(later[position + 1], goal)
    return chosen, slots
