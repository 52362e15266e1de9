"""Split-among-stations with a packing capacity: each part of the search against trying everything."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, product
from math import prod

import numpy as np
import pytest
from attrs import evolve

from rmfs_mip.arrays import arrays_of
from rmfs_mip.check import newly_split, violation
from rmfs_mip.fewest import FewestVisits
from rmfs_mip.paper import solve_printed
from rmfs_mip.period import Period, Stock
from rmfs_mip.reduction import Reduced, masks_of
from rmfs_mip.search import search_for
from rmfs_mip.solution import Model
from rmfs_mip.solver import Limits
from rmfs_mip.spreading import _too_few_splits, spread
from rmfs_mip.stacking import fill, fill_with_few_splits
from rmfs_mip.stacking import newly_split as newly_split_of

AMONG = Model.SPLIT_AMONG_STATIONS
ENDLESS = 10**9


@pytest.fixture(scope="module")
def small(random_period) -> list[Period]:
    """Return random periods that are small enough to try everything, with all stations alike in every third."""
    periods = [random_period(seed) for seed in range(600)]
    periods += [_period(seed, orders=4, stations=2 + seed % 2, skus=6) for seed in range(150)]
    for seed in range(0, len(periods), 3):
        n = len(periods[seed].stations)
        periods[seed] = evolve(
            periods[seed], capacities=periods[seed].capacities[:1] * n, inbound=periods[seed].inbound[:1] * n
        )
    return [
        period
        for period in periods
        if len(period.stations) > 1
        and prod(1 + len(period.stations) ** len(lines) for lines in period.lines) <= 3000
        and Reduced(period, AMONG).candidates.any()
    ]


def _period(seed: int, orders: int, stations: int, skus: int) -> Period:
    """Return orders of one to five lines that want splitting, with no pods at the stations (as at t = 1) or some."""
    rng = np.random.default_rng(seed)
    longest = min(5, skus // 2)
    lines = [
        (order, int(sku), 1)
        for order in range(orders)
        for sku in sorted(rng.choice(skus, int(rng.integers(1, longest + 1)), replace=False))
    ]
    contents = tuple(tuple(sorted(rng.choice(skus, 2 + seed % 2, replace=False).tolist())) for _ in range(8))
    inbound = tuple((int(pod),) if seed % 2 else () for pod in rng.integers(0, 8, stations))
    return Period(
        Stock(tuple(range(8)), contents, skus),
        tuple(range(stations)),
        (longest,) * stations if seed % 3 else (longest + 1, *[2] * (stations - 1)),
        inbound,
        tuple(range(orders)),
        *np.array(lines, dtype=np.int64).T,
        busy=tuple(sorted({pod for pods in inbound for pod in pods})),
        begun=tuple(bool(b) for b in rng.random(orders) < 0.3) if seed % 4 > 1 else (),
        split_open=seed % 3,
    )


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


def test_fill_finds_the_most_with_few_splits(small, choices, new_splits):
    """It fills as many places as any assignment with so few new splits, not one more, and the cut forbids none."""
    mattered = cut = 0
    rng = np.random.default_rng(1)
    for period in small:
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
            assert newly_split_of(arrays, orders) <= splits
            assert not fill_with_few_splits(arrays, masks, number + 1, np.zeros(1, np.int64))[0]
            assert not _too_few_splits(arrays, served, masks, number)
            mattered += fill(arrays, masks, number + 1)[0]
            cut += _too_few_splits(arrays, served, masks, number + 1)
    assert mattered > 50
    assert cut > 50


def _is_served(arrays, order: int, masks) -> bool:
    return bool(masks[arrays.line_sku[arrays.order_start[order] : arrays.order_start[order + 1]]].all())


@pytest.mark.parametrize("splits", [0, 1])
def test_it_finds_the_optimum_by_itself(small, brute_force, splits):
    """Without any bound to start from, its value is the optimum of the brute force."""
    mattered = 0
    for period in small:
        reduced = Reduced(period, AMONG)
        least = period.visits_before + 2 * (sum(period.capacities) - reduced.reachable_sum)
        value, found = FewestVisits(reduced, 2, ENDLESS, splits).run(0, 2 * reduced.reachable_sum)
        assert least + value == brute_force(period, AMONG, 2, splits)
        mattered += value > FewestVisits(reduced, 2, ENDLESS).run(0, 2 * reduced.reachable_sum)[0]
        if found is not None:
            search = search_for(period, AMONG, 2, Limits(), splits + period.split_open)
            search.offer((), (), "bounds")
            search.offer(*found, "search")
            assert search.incumbent.objective == least + value
            assert violation(period, search.incumbent, AMONG, 2, splits + period.split_open) is None
    assert mattered > 5


@pytest.mark.parametrize("splits", [0, 1])
def test_symmetry_loses_nothing(small, splits):
    """Of interchangeable stations only one sequence is tried; that finds stations for a set of pods all the same."""
    found = 0
    for period in small:
        reduced = Reduced(period, AMONG)
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


@pytest.mark.parametrize("splits", [0, 1, 2])
def test_the_whole_search_finds_the_optimum(splits):
    """It has the objective of the printed model, with and without begun orders and pods at the stations."""
    limited = 0
    for seed in range(12):
        period = _period(seed, orders=7, stations=3, skus=9)
        capacity = splits + period.split_open
        solution = search_for(period, AMONG, 2, Limits(), capacity).run()
        assert solution.objective == solve_printed(period, AMONG, 2, Limits(), capacity).objective, seed
        assert solution.bound == solution.objective
        assert violation(period, solution, AMONG, 2, capacity) is None
        assert len(newly_split(period, solution)) <= splits
        limited += solution.objective > search_for(period, AMONG, 2, Limits()).run().objective
    assert limited > 0
