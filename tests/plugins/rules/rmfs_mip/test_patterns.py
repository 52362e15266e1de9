"""Column generation finds the optimum of the printed form where the stations are alike."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from attrs import evolve

from rmfs_mip import patterns, search
from rmfs_mip.check import violation
from rmfs_mip.paper import solve_printed
from rmfs_mip.patterns import ColumnGeneration, Pricing, alike
from rmfs_mip.period import Period
from rmfs_mip.reduction import Reduced
from rmfs_mip.search import Search, search_for
from rmfs_mip.solution import Model
from rmfs_mip.solver import Limits

LIMITS = Limits()


@pytest.fixture(scope="module")
def equal_stations(periods) -> list[Period]:
    """Return the random periods with all stations like their first: as at t = 1, though with pods there."""
    made = []
    for period in periods:
        n = len(period.stations)
        if n > 1:
            made.append(evolve(period, capacities=period.capacities[:1] * n, inbound=period.inbound[:1] * n))
    return made[:120]


@pytest.fixture
def patterns_only(monkeypatch):
    """Leave out what would prove small periods before the patterns are needed."""
    monkeypatch.setattr(Search, "_by_fewest_visits", lambda self: None)
    for step in ("_by_bounds", "_by_whole_orders"):
        monkeypatch.setattr(Search, step, lambda self: None)


@pytest.mark.parametrize("model", [Model.INTEGRATED, Model.SPLIT_OVER_TIME])
def test_the_optimum_is_that_of_the_printed_form(equal_stations, patterns_only, model):
    """Whatever the patterns prove is true, and what they choose satisfies the printed constraints: 120 periods."""
    by_patterns = 0
    for number, period in enumerate(equal_stations):
        found = search_for(period, model, 2, LIMITS).run()
        assert found.objective == found.bound == solve_printed(period, model, 2, LIMITS).objective, number
        assert violation(period, found, model, 2) is None, number
        by_patterns += found.how == "patterns"
    assert by_patterns > 10


@pytest.mark.parametrize("most_work", [0, 20])
def test_pricing_by_the_model_is_as_good(equal_stations, patterns_only, monkeypatch, most_work):
    """Where the search for sets of pods takes too long, a single station's model prices; the optimum stays the same."""
    monkeypatch.setattr(patterns, "MOST_WORK", most_work)
    for period in equal_stations[:40]:
        found = search_for(period, Model.INTEGRATED, 2, LIMITS).run()
        assert found.objective == solve_printed(period, Model.INTEGRATED, 2, LIMITS).objective


@pytest.mark.parametrize("steps", [(1,), (1, 2), (2, 8)])
def test_few_close_sets_prove_nothing_false(equal_stations, patterns_only, monkeypatch, steps):
    """However few sets of pods a better solution is put together from, the optimum stays the same."""
    monkeypatch.setattr(search, "CLOSE_SETS", steps)
    monkeypatch.setattr(patterns, "CLOSE_SETS", steps)
    for period in equal_stations[:60]:
        found = search_for(period, Model.INTEGRATED, 2, LIMITS).run()
        assert found.objective == found.bound == solve_printed(period, Model.INTEGRATED, 2, LIMITS).objective


def test_the_relaxation_is_a_bound(equal_stations):
    """The bound of the relaxation never exceeds the optimum (without the pods that are there)."""
    for period in equal_stations[:60]:
        reduced = Reduced(period, Model.INTEGRATED)
        if reduced.candidates.any():
            generation = ColumnGeneration(reduced, 2, LIMITS, lambda: None)
            generation.run()
            optimum = solve_printed(period, Model.INTEGRATED, 2, LIMITS).objective - period.visits_before
            assert generation.bound <= optimum + 1e-6


@pytest.mark.parametrize("share", [0.0, 0.5, 0.9])
def test_the_sets_are_those_of_plain_enumeration(equal_stations, share):
    """The compiled search finds exactly the sets that trying all of them in Python finds worth enough."""
    for period in equal_stations[:40]:
        pricing = Pricing(Reduced(period, Model.INTEGRATED), 2, LIMITS)
        values = (2.0 * pricing.sizes + np.linspace(0, -1, len(pricing.sizes))) if len(pricing.sizes) else np.zeros(0)
        for number in range(min(len(pricing.pods), 3) + 1):
            worths = {
                chosen: _worth(pricing, chosen, values) for chosen in combinations(range(len(pricing.pods)), number)
            }
            least = share * max(worths.values()) + 1e-3
            found = pricing._sets(number, values, least, 1000)
            assert {tuple(sorted(chosen)) for _, chosen in found} == {
                c for c, worth in worths.items() if worth >= least
            }
            for worth, chosen in found:
                assert worth == pytest.approx(worths[tuple(sorted(chosen))])


def test_of_many_sets_the_best_are_kept(equal_stations):
    """Asked for three sets, the search returns three of the greatest worth."""
    for period in equal_stations[:40]:
        pricing = Pricing(Reduced(period, Model.INTEGRATED), 2, LIMITS)
        values = 2.0 * pricing.sizes - np.linspace(0, 1, len(pricing.sizes))
        for number in range(1, min(len(pricing.pods), 3) + 1):
            worths = [_worth(pricing, chosen, values) for chosen in combinations(range(len(pricing.pods)), number)]
            found = [worth for worth, _ in pricing._sets(number, values, 0.0, 3)]
            assert sorted(found) == pytest.approx(sorted(worths)[-3:])


def _worth(pricing: Pricing, chosen: tuple[int, ...], values: np.ndarray) -> float:
    """Return the best sum of values over the orders that a set of pods serves, by trying all numbers of each type."""
    at_hand = {sku for pod in chosen for sku in pricing.brings[pod]}
    sums = {0: 0.0}
    for t, missing in enumerate(pricing.missing):
        if at_hand.issuperset(missing):
            for used, worth in list(sums.items()):
                for n in range(1, int(pricing.counts[t]) + 1):
                    place = used + n * int(pricing.sizes[t])
                    if place <= pricing.room:
                        sums[place] = max(sums.get(place, -1.0), worth + n * float(values[t]))
    return max(sums.values())


def test_it_is_used_for_equal_stations_only(periods):
    """Other models, a single station, or stations with other room or pods are left to the solver."""
    for period in periods[:50]:
        equal = (
            len(set(period.capacities)) == 1 and len({frozenset(np.flatnonzero(row)) for row in period.covered}) == 1
        )
        assert alike(Reduced(period, Model.INTEGRATED)) == (equal and len(period.stations) > 1)
        assert not alike(Reduced(period, Model.SPLIT_OVER_TIME))


def test_a_time_limit_ends_it_in_order(equal_stations, patterns_only):
    """With no time at all there is a solution all the same, marked as stopped unless it happens to be proven."""
    for period in equal_stations[:40]:
        found = search_for(period, Model.INTEGRATED, 2, Limits(max_seconds=1e-9)).run()
        optimum = solve_printed(period, Model.INTEGRATED, 2, LIMITS).objective
        assert found.bound <= optimum <= found.objective
        assert found.stopped_early or found.objective == optimum
