"""The sets of pods that pricing works with, against plain enumeration."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from rmfs_rules.mip.period.reduction import Reduced
from rmfs_rules.mip.period.solution import Model
from rmfs_rules.mip.printed.solver import Limits
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
