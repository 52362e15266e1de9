"""What needs no solver, against trying everything."""

from __future__ import annotations

from itertools import combinations, product

import numpy as np
import pytest
from rmfs_mip.check import violation
from rmfs_mip.exact_fill import ExactFill
from rmfs_mip.flow import fewest_visits, greedy_visits
from rmfs_mip.placing import Places
from rmfs_mip.reduction import Reduced
from rmfs_mip.search import network_of
from rmfs_mip.solution import Model, Solution, items_of, objective_of


@pytest.mark.parametrize("model", [Model.INTEGRATED, Model.SPLIT_AMONG_STATIONS])
def test_exact_fill_is_the_most(periods, model, choices):
    """No assignment to the pods at the stations fills more places, and this one satisfies the printed constraints."""
    for period in periods:
        filling = ExactFill(Reduced(period, model))
        parts = filling.parts(period.covered)
        visits = tuple(sorted((pod, s) for s, pods in enumerate(period.inbound) for pod in pods))
        value = objective_of(period, parts, len(visits), 2)
        assert violation(period, Solution(parts, visits, value, 0, "search"), model, 2) is None
        filled = sum(items_of(period, part) for part in parts)
        assert filling.most(period.covered) == filled
        if (len(period.stations) + 1) ** len(period.line_sku) <= 3000:
            assert filled == _most(period, model, choices)


def _most(period, model, choices):
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


def test_flow_and_its_bound(periods):
    """The minimum cut equals a flow by augmenting paths; no set of visits smaller than the bound fills the target."""
    for period in periods:
        reduced = Reduced(period, Model.SPLIT_OVER_TIME)
        if not period.single_items or not reduced.candidates.any():
            continue
        network = network_of(reduced)
        assert network.flow() == _flow_by_paths(network)
        visits, filled = greedy_visits(network, period.idle)
        assert filled.flow() == network.target
        least = fewest_visits(network)
        assert least <= len(visits)
        pairs = list(product(range(len(period.stock.pods)), range(len(period.stations))))
        if 0 < least <= 2:
            for chosen in combinations(pairs, least - 1):
                tried = network
                for pod, station in chosen:
                    tried = tried.adding(pod, station)
                assert tried.flow() < network.target


def _flow_by_paths(network):
    places = Places(network.capacities)
    units = np.repeat(network.mask, network.demand.astype(int)).tolist()
    return sum(places.add(mask) for mask in units)
