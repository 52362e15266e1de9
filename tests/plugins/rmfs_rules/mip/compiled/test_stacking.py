"""Filling places with whole orders, against trying everything."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np
import pytest

from rmfs_rules.mip.compiled.arrays import arrays_of
from rmfs_rules.mip.compiled.spreading import too_few_splits
from rmfs_rules.mip.compiled.stacking import fill, fill_with_few_splits, newly_split
from rmfs_rules.mip.period.period import Period
from rmfs_rules.mip.period.reduction import Reduced, masks_of
from rmfs_rules.mip.period.solution import Model

AMONG = Model.SPLIT_AMONG_STATIONS
WHOLE = (Model.INTEGRATED, AMONG)


@pytest.mark.parametrize("model", WHOLE)
def test_fill_finds_the_most(all_periods, choices, model):
    """It fills as many places as any assignment to what is at the stations, and not one more."""
    tried = 0
    for period in all_periods:
        reduced = Reduced(period, model)
        if (len(period.stations) + 1) ** len(period.line_sku) > 3000 or not reduced.candidates.any():
            continue
        arrays, _ = arrays_of(reduced)
        most = _most(period, model, choices)
        found, orders = fill(arrays, masks_of(period.covered), most)
        assert found
        taken = [sum(int(packed) >> (8 * s) & 255 for _, packed in orders) for s in range(len(period.stations))]
        assert sum(taken) == most
        assert all(n <= room for n, room in zip(taken, period.capacities, strict=True))
        assert len({order for order, _ in orders.tolist()}) == len(orders)
        assert not fill(arrays, masks_of(period.covered), most + 1)[0]
        tried += most > 0
    assert tried > 50


def _most(period: Period, model: Model, choices) -> int:
    """Try every assignment whose SKUs are covered."""
    best = 0
    options = [list(choices(lines, len(period.stations), model)) for lines in period.lines]
    for choice in product(*options):
        items = [0] * len(period.stations)
        covered = True
        for lines, where in zip(period.lines, choice, strict=True):
            for (sku, quantity), station in zip(lines, where, strict=True):
                if station is not None:
                    items[station] += quantity
                    covered &= bool(period.covered[station][sku])
        if covered and all(n <= room for n, room in zip(items, period.capacities, strict=True)):
            best = max(best, sum(items))
    return best


def _covered_assignments(period: Period, there: np.ndarray, choices) -> Iterator[tuple[tuple, list[int]]]:
    """Yield each assignment whose SKUs are covered and that fits, with the items at each station."""
    for choice in product(*(list(choices(lines, len(period.stations), AMONG)) for lines in period.lines)):
        items, covered = [0] * len(period.stations), True
        for lines, where in zip(period.lines, choice, strict=True):
            for (sku, quantity), station in zip(lines, where, strict=True):
                if station is not None:
                    items[station] += quantity
                    covered &= bool(there[station][sku])
        if covered and all(n <= room for n, room in zip(items, period.capacities, strict=True)):
            yield choice, items


def test_fill_finds_the_most_with_few_splits(small_periods, choices, new_splits):
    """It fills as many places as any assignment with so few new splits, not one more, and the cut forbids none."""
    mattered = cut = 0
    rng = np.random.default_rng(1)
    for period in small_periods:
        there = (rng.random(period.covered.shape) < 0.6) & period.stocked
        reduced, masks = Reduced(period, AMONG), masks_of(there)
        most = [0, 0, 0]
        for choice, items in _covered_assignments(period, there, choices):
            for splits in range(new_splits(period, choice), 3):
                most[splits] = max(most[splits], sum(items))
        for splits, number in enumerate(most):
            arrays, _ = arrays_of(reduced, splits)
            served = np.flatnonzero([_is_served(arrays, order, masks) for order in range(len(reduced.orders))])
            found, orders = fill_with_few_splits(arrays, masks, number, np.zeros(1, np.int64))
            assert found
            taken = [sum(int(packed) >> (8 * s) & 255 for _, packed in orders) for s in range(len(period.stations))]
            assert sum(taken) == number
            assert all(n <= room for n, room in zip(taken, period.capacities, strict=True))
            assert len({order for order, _ in orders.tolist()}) == len(orders)
            assert newly_split(arrays, orders) <= splits
            assert not fill_with_few_splits(arrays, masks, number + 1, np.zeros(1, np.int64))[0]
            assert not too_few_splits(arrays, served, masks, number)
            mattered += fill(arrays, masks, number + 1)[0]
            cut += too_few_splits(arrays, served, masks, number + 1)
    assert mattered > 50
    assert cut > 50


def _is_served(arrays, order: int, masks) -> bool:
    return bool(masks[arrays.line_sku[arrays.order_start[order] : arrays.order_start[order + 1]]].all())
