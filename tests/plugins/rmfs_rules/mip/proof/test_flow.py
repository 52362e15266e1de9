"""Maximum flow and its bounds, against augmenting paths and trying everything."""

from __future__ import annotations

from itertools import combinations, product

import numpy as np

from rmfs_rules.mip.period.placing import Places
from rmfs_rules.mip.period.reduction import Reduced
from rmfs_rules.mip.period.serving import PlacesFromStock
from rmfs_rules.mip.period.solution import Model
from rmfs_rules.mip.proof.flow import Network, fewest_visits, greedy_visits


def test_flow_and_its_bound(periods):
    """The minimum cut equals a flow by augmenting paths; no set of visits smaller than the bound fills the target."""
    for period in periods:
        reduced = Reduced(period, Model.SPLIT_OVER_TIME)
        if not period.single_items or not reduced.candidates.any():
            continue
        network = Network.of(reduced)
        assert network.flow() == _flow_by_paths(network)
        visits, filled = greedy_visits(network, period.preferred)
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


def test_flow_from_stock_and_its_bound(scarce_periods):
    """The same where SKUs are scarce: pods give no more than they have, and share it among their stations."""
    scarce = 0
    for period in scarce_periods:
        reduced = Reduced(period, Model.SPLIT_OVER_TIME)
        if not period.single_items or not len(reduced.scarce):
            continue
        scarce += 1
        network, places = Network.of(reduced), PlacesFromStock(period, ())
        units = period.line_sku[reduced.candidates].tolist()
        assert network.flow() == sum(places.add(sku) for sku in units)
        flows, _ = network.flows_with_one_more()
        for station, pod in product(range(len(period.stations)), range(len(period.stock.pods))):
            assert flows[station, pod] == network.adding(pod, station).flow()
        _, filled = greedy_visits(network, period.preferred)
        assert filled.flow() == network.target
        least = fewest_visits(network)
        pairs = list(product(range(len(period.stock.pods)), range(len(period.stations))))
        for chosen in combinations(pairs, least - 1) if 0 < least <= 3 else ():
            tried = network
            for pod, station in chosen:
                tried = tried.adding(pod, station)
            assert tried.flow() < network.target
    assert scarce > 15


def _flow_by_paths(network):
    places = Places(network.capacities)
    units = np.repeat(network.mask, network.demand.astype(int)).tolist()
    return sum(places.add(mask) for mask in units)
