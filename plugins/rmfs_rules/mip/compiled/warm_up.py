"""Loading the compiled searches before a run, so that no decision's time has it in."""

from __future__ import annotations

import numpy as np

from rmfs_rules.mip.compiled import exchanging, pod_sets, spreading
from rmfs_rules.mip.compiled.arrays import arrays_of
from rmfs_rules.mip.period.period import Period, Stock
from rmfs_rules.mip.period.reduction import Reduced
from rmfs_rules.mip.period.solution import Model

MOST_WORK = 1000
"""More steps than the searches take here."""


def load() -> None:
    """Load the searches, or compile them: two stations, two pods and two orders of one line are searched."""
    stock = Stock(range(2), 2, [0, 1], [0, 1])
    lines = np.arange(2)
    period = Period(stock, (0, 1), (1, 1), ((), ()), (0, 1), lines, lines, (1, 1))
    arrays, _ = arrays_of(Reduced(period, Model.INTEGRATED))
    work = np.zeros(1, dtype=np.int64)
    sets = pod_sets.sets_of(arrays, 1, np.ones(2), 2.0)
    spreading.next_that_fills(arrays, sets, -1, 2, 2, work, MOST_WORK)
    pod_sets.best_sets(arrays, 1, np.ones(2), 0.5, 10, work, MOST_WORK)
    exchanging.exchanged(arrays, 1, 1, 1)
