"""Solutions found quickly satisfy the printed constraints."""

from __future__ import annotations

import numpy as np
import pytest

from rmfs_rules.mip.period.effort import Effort
from rmfs_rules.mip.period.reduction import Reduced
from rmfs_rules.mip.period.solution import Model, Solution, items_of, objective_of
from rmfs_rules.mip.printed.constraints import violation
from rmfs_rules.mip.proof.feasible import fill, fill_with_orders
from rmfs_rules.mip.proof.greedy import station_by_station


def _solution(period, visits, parts, weight=2) -> Solution:
    before = {(pod, station) for station, pods in enumerate(period.inbound) for pod in pods}
    visits = tuple(sorted(before | set(visits)))
    return Solution(parts, visits, objective_of(period, parts, len(visits), weight), 0.0, "search")


@pytest.mark.parametrize("model", Model)
def test_what_is_filled_satisfies_the_constraints(periods, model):
    """With any new visits, on periods with single items."""
    rng = np.random.default_rng(1)
    filled = 0
    for period in periods:
        if not period.single_items:
            continue
        pairs = [(pod, s) for pod in range(len(period.stock.pods)) for s in range(len(period.stations))]
        visits = [pair for pair in pairs if rng.random() < 0.4]
        parts = fill(Reduced(period, model), period.covered_with(visits))
        assert violation(period, _solution(period, visits, parts), model, 2) is None
        filled += items_of(period, parts) > 0
    assert filled > 100


@pytest.mark.parametrize("weight", [0.5, 2])
def test_whole_orders_are_a_solution_of_all_models(periods, weight):
    """Never empty while some order fits some station and pays; integrated, so also of the two that split."""
    for period in periods:
        reduced = Reduced(period, Model.INTEGRATED)
        if reduced.candidates.any():
            visits, _ = station_by_station(reduced, weight, Effort())
            parts = fill_with_orders(reduced, period.covered_with(visits))
            assert parts or weight < 1
            for model in Model:
                assert violation(period, _solution(period, visits, parts, weight), model, weight) is None


def test_a_station_is_filled_as_far_as_whole_orders_go(random_period):
    """At a single station, the fullest choice of orders whose SKUs are there."""
    for seed in range(100):
        period = random_period(seed)
        reduced = Reduced(period, Model.INTEGRATED)
        if len(period.stations) == 1 and reduced.candidates.any():
            parts = fill_with_orders(reduced, np.ones_like(period.covered))
            assert items_of(period, parts) == reduced.reachable[0]
