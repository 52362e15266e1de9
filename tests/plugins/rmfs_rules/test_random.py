"""The rule `random` as POA; test_oracles.py has its other decisions, draw by draw."""

from collections import Counter
from typing import Any

import numpy as np
import pytest
from scipy.stats import chi2_contingency

from rmfs_commands.testing import small_world
from rmfs_core.clock import TICKS_PER_S
from rmfs_core.warehouse import WarehouseView
from rmfs_rules.helpers import assign_best_pairs
from rmfs_rules.random import Random

ORDERS = {"two": {"a": 2}, "one": ["a"], "both": ["a", "b"], "many": {"b": 7}, "three": {"a": 3}}
"""Of which `many` is larger than any station."""


@pytest.mark.parametrize("counts", [False, True], ids=["items", "orders"])
@pytest.mark.parametrize(("now_s", "max_wait_s"), [(0, None), (700, None), (50, 60), (60, 60)], ids=str)
def test_decisions_are_as_likely_as_those_of_lots(counts: bool, now_s: int, max_wait_s: float | None) -> None:
    """Whole decisions, by chi-square against those of `assign_best_pairs` with a lot for each pair as its score."""
    world = small_world(ORDERS, {"p": ["a", "b"]}, capacities=[2, 3], counts_orders=counts)
    world.advance(now_s * TICKS_PER_S)
    view, rng = WarehouseView(world), np.random.default_rng(5)

    def lots(_station: Any) -> Any:
        return rng.integers(1 << 62, size=len(ORDERS))

    def drawn() -> tuple[Any, ...]:
        return tuple(Random(max_wait_s).assign_orders(view, rng))

    def plain() -> tuple[Any, ...]:
        return tuple(assign_best_pairs(view, lots, max_wait_s=max_wait_s))

    times = [Counter(decide() for _ in range(3000)) for decide in (drawn, plain)]
    often = [decision for decision in times[1] if times[1][decision] >= 10]
    table = [[of[decision] for decision in often] + [3000 - sum(of[decision] for decision in often)] for of in times]
    assert len(often) > 2
    assert chi2_contingency(np.array(table)[:, np.any(table, axis=0)]).pvalue > 0.001
