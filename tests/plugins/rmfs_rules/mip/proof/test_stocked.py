"""Solutions found quickly where SKUs are scarce satisfy the printed constraints."""

from __future__ import annotations

import numpy as np
import pytest

from rmfs_rules.mip.period.reduction import Reduced
from rmfs_rules.mip.period.solution import Model, Solution, items_of, objective_of
from rmfs_rules.mip.printed.constraints import violation
from rmfs_rules.mip.proof.stocked import fill_from_stock, lines_from_stock, one_line_orders


def _wrong(period, visits, parts, model):
    before = {(pod, station) for station, pods in enumerate(period.inbound) for pod in pods}
    sent = tuple(sorted(before | set(visits)))
    value = objective_of(period, parts, len(sent), 2)
    return violation(period, Solution(parts, sent, value, 0.0, "search"), model, 2)


def _random_visits(period, rng):
    pairs = [(pod, s) for pod in range(len(period.stock.pods)) for s in range(len(period.stations))]
    return tuple((pod, s) for pod, s in pairs if rng.random() < 0.4 and pod not in period.inbound[s])


@pytest.mark.parametrize("model", Model)
def test_what_is_filled_satisfies_the_constraints(scarce_periods, model):
    """With any new visits; where orders are split, on periods with single items."""
    rng = np.random.default_rng(1)
    filled = 0
    for period in scarce_periods:
        if period.single_items or model is Model.INTEGRATED:
            visits = _random_visits(period, rng)
            parts = fill_from_stock(Reduced(period, model), visits)
            assert _wrong(period, visits, parts, model) is None
            filled += items_of(period, parts) > 0
    assert filled > 20


def test_orders_of_one_line_are_a_solution_of_all_models(scarce_periods):
    """Whatever pods are sent."""
    rng = np.random.default_rng(2)
    found = 0
    for period in scarce_periods:
        reduced, visits = Reduced(period, Model.INTEGRATED), _random_visits(period, rng)
        lines = one_line_orders(reduced)
        assert all(len(period.lines_of(int(period.line_order[line]))) == 1 for line in lines)
        parts = lines_from_stock(reduced, visits, lines)
        for model in Model:
            assert _wrong(period, visits, parts, model) is None
        found += bool(parts)
    assert found > 10
