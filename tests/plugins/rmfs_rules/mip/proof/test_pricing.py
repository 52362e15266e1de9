"""The sets of pods that pricing works with, against plain enumeration."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from rmfs_rules.mip.period.reduction import Reduced
from rmfs_rules.mip.period.solution import Model
from rmfs_rules.mip.printed.solver import Limits
from rmfs_rules.mip.proof import pricing
from rmfs_rules.mip.proof.pricing import Pricing

LIMITS = Limits()


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
            found = pricing.sets(number, values, least, 1000)
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
            found = [worth for worth, _ in pricing.sets(number, values, 0.0, 3)]
            assert sorted(found) == pytest.approx(sorted(worths)[-3:])


@pytest.mark.parametrize("limit", [3.0, 100.0])
def test_sets_of_orders_price_as_sets_of_pods_do(equal_stations, limit):
    """The cheapest pattern costs the same, whether its orders or its pods are searched, and is worth what it says."""
    for period in equal_stations[:60]:
        search = Pricing(Reduced(period, Model.INTEGRATED), 2, LIMITS)
        search.by_types = True  # few orders or not
        prices = -np.linspace(0, 1.5, len(search.sizes))
        by_orders, by_sets = search.by_orders(prices, limit), search.by_sets(prices, limit)
        assert by_orders.bound == pytest.approx(by_sets.bound)
        for value, pattern in by_orders.patterns:
            assert value == pytest.approx(pattern.cost - sum(prices[t] * n for t, n in pattern.orders))
            there = {sku for pod in pattern.pods for sku in period.stock.contents[pod]}
            assert all(there.issuperset(search.missing[t]) for t, _ in pattern.orders)
            assert sum(search.sizes[t] * n for t, n in pattern.orders) <= search.room


def test_sets_of_orders_are_for_few_orders_without_scarce_skus(periods, scarce_periods, monkeypatch):
    """However long sets of pods take: with many orders, or an SKU that is scarce, these alone are searched."""
    monkeypatch.setattr(pricing, "QUICK_WORK", -1)
    switched = []
    for period in (*periods[:40], *scarce_periods[:40]):
        reduced = Reduced(period, Model.INTEGRATED)
        search = Pricing(reduced, 2, LIMITS)
        search.by_sets(np.zeros(len(search.sizes)), 100.0)
        few = (search.sizes * search.counts).sum() <= pricing.MOST_BY_ORDERS * sum(reduced.capacities)
        assert search.by_types == (few and not len(reduced.scarce))
        switched.append(search.by_types)
    assert set(switched) == {False, True}


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
