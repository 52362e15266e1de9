"""Loading the compiled searches before a run, so that no decision's time has it in."""

from __future__ import annotations

from typing import Any

import numpy as np

from rmfs_mip.arrays import arrays_of
from rmfs_mip.fewest import FewestVisits
from rmfs_mip.period import Period, Stock
from rmfs_mip.reduction import Reduced
from rmfs_mip.solution import Model


def searches() -> tuple[Any, ...]:
    """Return the compiled functions that Python calls."""
    from rmfs_mip import pattern_search, spreading

    return spreading.pods_that_fill, pattern_search.best_sets


def load() -> None:
    """Load the searches, or compile them: solve a period of two stations, two pods and two orders of one line."""
    from rmfs_mip import pattern_search

    stock = Stock((0, 1), ((0,), (1,)), 2)
    lines = np.arange(2)
    period = Period(stock, (0, 1), (1, 1), ((), ()), (0, 1), lines, lines, (1, 1))
    reduced = Reduced(period, Model.INTEGRATED)
    FewestVisits(reduced, weight=2, most_work=1000).run(1, 4)
    arrays, _ = arrays_of(reduced)
    pattern_search.best_sets(arrays, 1, np.ones(2), 0.5, 10, np.zeros(1, dtype=np.int64), 1000)
