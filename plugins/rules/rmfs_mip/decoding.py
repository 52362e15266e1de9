"""From the values of an aggregated model to lines of orders: the oldest of a type or of a SKU first."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rmfs_mip.aggregated import Aggregated
from rmfs_mip.period import Line
from rmfs_mip.placing import Places
from rmfs_mip.reduction import Reduced, masks_of
from rmfs_mip.solution import Model, Part

Wanted = list[tuple[int, Line]]
"""Lines to place, each with the position of its order."""


def visits_of(model: Aggregated, values: Sequence[float]) -> tuple[tuple[int, int], ...]:
    """Return the new visits (pod, station)."""
    return tuple(sorted(key for key, column in model.x.items() if values[column] > 0.5))


def covered_with(reduced: Reduced, visits: Sequence[tuple[int, int]]) -> NDArray[np.bool_]:
    """Return what the stations cover once the new visits are counted in."""
    if not visits:
        return reduced.period.covered
    covered = reduced.period.covered.copy()
    for pod, station in visits:
        covered[station] |= reduced.period.stock.holds[pod] > 0
    return covered


def parts_of(reduced: Reduced, model: Aggregated, values: Sequence[float]) -> tuple[Part, ...]:
    """Return the assigned lines."""
    period = reduced.period
    rooms = list(period.capacities)
    parts: list[Part] = []
    wanted: Wanted = []
    for number, kind in enumerate(reduced.types):
        orders = list(kind.orders)
        for station in range(len(rooms)):
            if (number, station) in model.y:
                for _ in range(round(values[model.y[number, station]])):
                    parts.append(Part(orders.pop(0), station, tuple(sku for sku, _ in kind.lines)))
                    rooms[station] -= kind.size
        split = len(orders)
        if number in model.n:
            split = round(values[model.n[number]])
        elif not _free(reduced, model, kind.begun):
            split = 0
        wanted += [(order, line) for order in orders[:split] for line in kind.lines]
    if wanted:
        wanted.sort(key=lambda one: one[0])
        covered = covered_with(reduced, visits_of(model, values))
        placed = _placed(covered, rooms, wanted) if period.single_items else _counted(model, values, wanted)
        grouped: dict[tuple[int, int], list[int]] = {}
        for order, station, sku in placed:
            grouped.setdefault((order, station), []).append(sku)
        parts += [Part(order, station, tuple(skus)) for (order, station), skus in grouped.items()]
    return tuple(parts)


def _free(reduced: Reduced, model: Aggregated, begun: bool) -> bool:
    """Whether lines of an order without a column of its own may be assigned: over time, and its split is free."""
    return reduced.model is Model.SPLIT_OVER_TIME and (begun or model.splits is None)


def _placed(covered: NDArray[np.bool_], rooms: list[int], wanted: Wanted) -> list[tuple[int, int, int]]:
    """Place single items by augmenting paths; a line that finds no place stays in the backlog."""
    places = Places(rooms)
    mask = masks_of(covered).tolist()
    lines = [(order, sku) for order, (sku, _) in wanted if mask[sku] and places.add(mask[sku])]
    return [(order, places.take(mask[sku], ()), sku) for order, sku in lines]


def _counted(model: Aggregated, values: Sequence[float], wanted: Wanted) -> list[tuple[int, int, int]]:
    """Give each station as many lines of a kind as q says."""
    left = {key: round(values[column]) for key, column in model.q.items()}
    placed = []
    for order, line in wanted:
        for (kind, station), number in left.items():
            if kind == line and number > 0:
                left[kind, station] -= 1
                placed.append((order, station, line[0]))
                break
    return placed
