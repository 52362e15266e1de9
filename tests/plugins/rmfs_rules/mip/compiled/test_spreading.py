"""Sending pods to stations, against trying everything."""

from __future__ import annotations

from itertools import combinations, product

import numpy as np
import pytest

from rmfs_rules.mip.compiled.arrays import Arrays, arrays_of
from rmfs_rules.mip.compiled.spreading import FOUND, next_that_fills, sets_that_fill, spread
from rmfs_rules.mip.compiled.stacking import fill
from rmfs_rules.mip.period.reduction import Reduced
from rmfs_rules.mip.period.solution import Model

WHOLE = (Model.INTEGRATED, Model.SPLIT_AMONG_STATIONS)
ENDLESS = 10**9


@pytest.mark.parametrize("model", WHOLE)
def test_pods_that_fill_are_the_fewest(all_periods, model):
    """The least number of visits, if it is up to two, is that of trying all of them, for every number of places."""
    seen = set()
    for period in all_periods[::2]:
        reduced = Reduced(period, model)
        if not reduced.candidates.any():
            continue
        arrays, pods = arrays_of(reduced)
        places = list(product(range(len(pods)), range(len(period.stations))))
        fillings = [[_masks(arrays, chosen) for chosen in combinations(places, visits)] for visits in range(3)]
        for target in range(1, reduced.reachable_sum + 1):
            enough = [any(fill(arrays, mask, target)[0] for mask in masks) for masks in fillings]
            least = enough.index(True) if any(enough) else None
            assert least == _fewest(arrays, target)
            seen.add(least)
    assert seen == {None, 0, 1, 2}


def _fewest(arrays: Arrays, target: int) -> int | None:
    """Return the least number of visits (up to two) with which the search fills the target."""
    for visits in range(3):
        for number in range(min(visits, 1), visits + 1):
            sets, work = sets_that_fill(arrays, number, target), np.zeros(1, np.int64)
            found, chosen, masks, _ = next_that_fills(arrays, sets, -1, visits, target, work, ENDLESS)
            if found == FOUND:
                sent = [(p, s) for p, mask in zip(chosen, masks, strict=True) for s in range(8) if mask >> s & 1]
                assert len(sent) == visits
                assert fill(arrays, _masks(arrays, sent), target)[0]
                return visits
    return None


def _masks(arrays: Arrays, visits) -> np.ndarray:
    """Return per SKU the stations that cover it with these visits."""
    mask = arrays.at_hand.copy()
    for pod, station in visits:
        mask[arrays.pod_sku[arrays.pod_start[pod] : arrays.pod_start[pod + 1]]] |= 1 << station
    return mask


def test_symmetry_loses_nothing(all_periods):
    """Of interchangeable stations only one sequence is tried; that finds stations for a set of pods all the same."""
    found = 0
    for period in all_periods[300:]:
        reduced = Reduced(period, Model.SPLIT_AMONG_STATIONS)
        if not reduced.candidates.any() or len(period.stations) == 1:
            continue
        arrays, pods = arrays_of(reduced)
        assert arrays.alike
        for number, visits in ((1, 1), (1, 2), (2, 2), (2, 3)):
            for chosen in combinations(range(len(pods)), number):
                for target in (1, reduced.reachable_sum):
                    args = (np.array(chosen), visits, target, np.zeros(1, np.int64), ENDLESS)
                    answer = spread(arrays, *args)[0]
                    assert answer == spread(arrays._replace(alike=False), *args)[0]
                    found += answer
    assert found > 100


@pytest.mark.parametrize("splits", [0, 1])
def test_symmetry_loses_nothing_with_few_splits(small_periods, splits):
    """Nor where few orders may be split."""
    found = 0
    for period in small_periods:
        reduced = Reduced(period, Model.SPLIT_AMONG_STATIONS)
        arrays, pods = arrays_of(reduced, splits)
        if not arrays.alike:
            continue
        for number, visits in ((1, 1), (1, 2), (2, 2), (2, 3)):
            for chosen in combinations(range(len(pods)), number):
                for target in (1, reduced.reachable_sum):
                    args = (np.array(chosen), visits, target, np.zeros(1, np.int64), ENDLESS)
                    answer = spread(arrays, *args)[0]
                    assert answer == spread(arrays._replace(alike=False), *args)[0]
                    found += answer
    assert found > 50
