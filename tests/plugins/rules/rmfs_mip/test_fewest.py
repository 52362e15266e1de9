"""The search for visits, each of its parts against trying everything."""

from __future__ import annotations

from itertools import combinations, product

import numpy as np
import pytest
from attrs import evolve

from rmfs_mip.arrays import Arrays, arrays_of
from rmfs_mip.fewest import FewestVisits
from rmfs_mip.paper import solve_printed
from rmfs_mip.period import Period, Stock
from rmfs_mip.reduction import Reduced, masks_of
from rmfs_mip.search import search_for
from rmfs_mip.solution import Model
from rmfs_mip.solver import Limits
from rmfs_mip.spreading import FOUND, pods_that_fill, spread
from rmfs_mip.stacking import fill

WHOLE = (Model.INTEGRATED, Model.SPLIT_AMONG_STATIONS)
ENDLESS = 10**9


@pytest.fixture(scope="module")
def all_periods(periods) -> list[Period]:
    """Return the random periods, and some with all stations like their first, as at t = 1."""
    alike = []
    for period in periods[:150]:
        n = len(period.stations)
        alike.append(evolve(period, capacities=period.capacities[:1] * n, inbound=period.inbound[:1] * n))
    return [*periods, *alike]


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
            found, chosen, masks, _ = pods_that_fill(arrays, number, visits, target, np.zeros(1, np.int64), ENDLESS)
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


@pytest.mark.parametrize("model", WHOLE)
def test_it_finds_the_optimum_by_itself(all_periods, brute_force, model):
    """Without any bound to start from, its value is the optimum of the brute force."""
    tried = 0
    for period in all_periods:
        reduced = Reduced(period, model)
        if (len(period.stations) + 1) ** len(period.line_sku) > 3000 or not reduced.candidates.any():
            continue
        least = period.visits_before + 2 * (sum(period.capacities) - reduced.reachable_sum)
        nothing = 2 * reduced.reachable_sum
        value, _ = FewestVisits(reduced, 2, ENDLESS).run(0, nothing)
        assert least + value == brute_force(period, model, 2)
        tried += 1
    assert tried > 50


def test_giving_up_proves_nothing_false(all_periods, brute_force):
    """With few steps, what it returns is still a lower bound, and it says so by returning no solution."""
    gave_up = 0
    for period in all_periods:
        reduced = Reduced(period, Model.SPLIT_AMONG_STATIONS)
        if (len(period.stations) + 1) ** len(period.line_sku) > 3000 or not reduced.candidates.any():
            continue
        least = period.visits_before + 2 * (sum(period.capacities) - reduced.reachable_sum)
        for most_work in (0, 5, 15, 40):
            value, found = FewestVisits(reduced, 2, most_work).run(0, 2 * reduced.reachable_sum)
            optimum = brute_force(period, Model.SPLIT_AMONG_STATIONS, 2)
            assert least + value <= optimum
            gave_up += found is None and least + value < optimum
    assert gave_up > 20


@pytest.mark.parametrize("stations", [6, 7, 8])
def test_many_stations(stations):
    """Up to seven stations fit the packed vectors; with more, the search stays out and the optimum is found as well."""
    rng = np.random.default_rng(stations)
    lines = [(order, int(sku), 1) for order in range(9) for sku in rng.choice(8, 2, replace=False)]
    period = Period(
        Stock(tuple(range(6)), tuple((sku, (sku + 3) % 8) for sku in range(6)), 8),
        tuple(range(stations)),
        (2, *[1] * (stations - 1)),
        tuple((int(pod),) for pod in rng.integers(0, 6, stations)),
        tuple(range(9)),
        *np.array(lines).T,
    )
    search = FewestVisits(Reduced(period, Model.SPLIT_AMONG_STATIONS), 2, ENDLESS)
    assert search.possible == (stations <= 7)
    optimum = solve_printed(period, Model.SPLIT_AMONG_STATIONS, 2, Limits()).objective
    assert search_for(period, Model.SPLIT_AMONG_STATIONS, 2, Limits()).run().objective == optimum
    if search.possible:
        least = period.visits_before + 2 * (sum(period.capacities) - search.reduced.reachable_sum)
        assert least + search.run(0, 100)[0] == optimum
