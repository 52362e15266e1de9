"""Solutions found quickly, optimal or not: every one satisfies the printed constraints, and so bounds from above.

`fill` assigns what the pods at the stations cover. Where there is a choice, the oldest orders go first.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from rmfs_rules.mip.period.placing import Places
from rmfs_rules.mip.period.reduction import Reduced, highest, masks_of
from rmfs_rules.mip.period.solution import Model, Part


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
    return _fill_with_split_orders(reduced, covered)


def _fill_with_lines(reduced: Reduced, covered: NDArray[np.bool_]) -> tuple[Part, ...]:
    """Place single lines, oldest first: a maximum flow with the oldest lines of all."""
    period = reduced.period
    mask = masks_of(covered)[period.line_sku]
    lines = np.flatnonzero(mask if period.single_items else (mask > 0) & reduced.candidates)
    if len(period.capacities) == 1:
        chosen = lines[: period.capacities[0]].tolist()
        stations = [0] * len(chosen)
    else:
        chosen, stations = _place(mask, lines, period.capacities, period.line_order)
    parts: dict[tuple[int, int], list[int]] = {}
    for line, station in zip(chosen, stations, strict=True):
        parts.setdefault((int(period.line_order[line]), station), []).append(int(period.line_sku[line]))
    return tuple(Part(order, station, tuple(skus)) for (order, station), skus in parts.items())


def _place(
    mask: NDArray[np.int64], lines: NDArray[np.int64], capacities: Sequence[int], order_of: NDArray[np.int64]
) -> tuple[list[int], list[int]]:
    places, room = Places(capacities), sum(capacities)
    chosen: list[int] = []
    full: set[int] = set()  # kinds that find no place any more; none that failed can succeed later
    for line, kind in zip(lines.tolist(), mask[lines].tolist(), strict=True):
        if kind not in full:
            if places.add(kind):
                chosen.append(line)
                if len(chosen) == room:
                    break
            else:
                full.add(kind)
    return chosen, _stations(places, [(int(order_of[line]), int(mask[line])) for line in chosen])


def _stations(places: Places, lines: Iterable[tuple[int, int]]) -> list[int]:
    """Name the station of each placed line (order, kind), keeping lines of an order together where it is free to."""
    stations: list[int] = []
    used: dict[int, list[int]] = {}
    for order, kind in lines:
        station = places.take(kind, used.get(order, ()))
        used.setdefault(order, []).append(station)
        stations.append(station)
    return stations


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


def _fill_with_split_orders(reduced: Reduced, covered: NDArray[np.bool_]) -> tuple[Part, ...]:
    """Place orders line by line over the stations, such that what is left stays a sum that orders can fill."""
    period = reduced.period
    mask = masks_of(covered).tolist()
    somewhere: NDArray[np.bool_] = np.asarray(covered.any(axis=0, keepdims=True))
    orders = np.flatnonzero(_covered_orders(reduced, somewhere)[0]).tolist()
    sizes = dict(zip(orders, reduced.sizes[orders].tolist(), strict=True))
    best: tuple[list[int], Places] = ([], Places(period.capacities))
    for sequence in (orders, sorted(orders, key=lambda o: -sizes[o])):
        found = _place_orders(reduced, sequence, mask, sizes)
        if sum(sizes[o] for o in found[0]) > sum(sizes[o] for o in best[0]):
            best = found
        if sum(sizes[o] for o in best[0]) == reduced.reachable_sum:
            break
    chosen, places = best
    lines = [(o, i) for o in chosen for i, _ in period.lines_of(o)]
    parts: dict[tuple[int, int], list[int]] = {}
    for (order, sku), station in zip(lines, _stations(places, [(o, mask[i]) for o, i in lines]), strict=True):
        parts.setdefault((order, station), []).append(sku)
    return tuple(Part(order, station, tuple(skus)) for (order, station), skus in parts.items())


def _place_orders(
    reduced: Reduced, sequence: Sequence[int], mask: Sequence[int], sizes: dict[int, int]
) -> tuple[list[int], Places]:
    period = reduced.period
    places, left = Places(period.capacities), sum(period.capacities)
    later = [1]  # sums that the orders from a position on can have, as bits
    for order in reversed(sequence):
        later.append(later[-1] | (later[-1] << sizes[order]) & ((1 << (left + 1)) - 1))
    later.reverse()
    chosen = []
    goal = highest(later[0], left)
    for position, order in enumerate(sequence):
        rest = goal - sizes[order]
        if rest >= 0 and later[position + 1] >> rest & 1:
            if places.add_all([mask[i] for i, _ in period.lines_of(order)]):
                chosen.append(order)
                goal = rest
                if goal == 0:
                    break
            elif not later[position + 1] >> goal & 1:
                goal = highest(later[position + 1], goal)
    return chosen, places
