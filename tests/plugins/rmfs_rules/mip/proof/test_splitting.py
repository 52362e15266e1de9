"""Visits for few splits over time."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

import rmfs_core
from rmfs_rules.mip.period.effort import Effort
from rmfs_rules.mip.period.period import Period, Stock
from rmfs_rules.mip.period.reduction import Reduced
from rmfs_rules.mip.period.solution import Model
from rmfs_rules.mip.proof.splitting import visits_for_few_splits

ORDERS = [(0, 0), (0, 1), (1, 2), (1, 3), (2, 0), (2, 4), (3, 2), (3, 5)]  # order, SKU: each of two items


def reduced(pods: tuple[tuple[int, ...], ...]) -> Reduced:
    """Return a period of two empty stations with room for two items each."""
    lines = np.array([(order, sku, 1) for order, sku in ORDERS], dtype=np.int64).T
    stock = Stock(tuple(range(len(pods))), pods, 6)
    return Reduced(Period(stock, (0, 1), (2, 2), ((), ()), (0, 1, 2, 3), *lines), Model.SPLIT_OVER_TIME)


def test_pods_that_complete_orders_are_found() -> None:
    """Without any split, each station gets the pod that has a whole order."""
    visits = visits_for_few_splits(reduced(((0, 2), (0, 1), (2, 4), (2, 3))), 2, 0, Effort())
    assert visits is not None
    assert {pod for pod, _ in visits} == {1, 3}
    assert {station for _, station in visits} == {0, 1}


@pytest.mark.parametrize(("splits", "found"), [(1, False), (2, False), (3, False), (4, True)])
def test_splits_fill_what_whole_orders_do_not(splits: int, found: bool) -> None:
    """Pods that have one item of each order fill four places with four splits, and no less."""
    visits = visits_for_few_splits(reduced(((0, 2), (0, 2))), 2, splits, Effort())
    assert (visits is not None) == found


def test_without_effort_nothing_is_looked_for() -> None:
    """The search takes its steps from the period's effort, and notes that there were too few."""
    effort = Effort(1.0)
    assert visits_for_few_splits(reduced(((0, 1), (2, 3))), 2, 0, effort) is None
    assert effort.short


@pytest.mark.parametrize("seed", [1401, 1402])
def test_the_first_period_of_the_paper_with_packing_capacity(seed: int, tmp_path: Path) -> None:
    """Four visits fill 60 places with ten splits, which is proven; split-among-stations needs five."""
    rule = 'rules.poa_pps={rule="split-over-time", packing_capacity=10}'
    rmfs_core.run("paper-250", overrides=[f"seed={seed}", "rules.pp=free-flow", "run.until_s=1", rule], out=tmp_path)
    with (tmp_path / "periods.csv").open() as file:
        period = next(csv.DictReader(file))
    assert (period["status"], period["objective"], period["bound"]) == ("optimal", "4.0", "4.0")
