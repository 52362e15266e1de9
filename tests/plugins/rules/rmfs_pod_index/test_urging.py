"""Which pods are wanted enough, against sums worked out by hand."""

from __future__ import annotations

import numpy as np

from rmfs_pod_index.period import NONE, NOW, URGENT, new_account
from rmfs_pod_index.urging import find_urgent, needed, next_urgent


def test_the_ages_of_the_lines_that_a_pod_has_items_for_add_up() -> None:
    """Pod 0 has lines of 30 and 40 ticks, pod 1 the second alone, pod 2 none."""
    account, now = new_account(np.zeros(0, np.int64), np.zeros(0, np.int64), 3, 1, np.zeros((1, 1), np.int64)), 100
    period = account.period
    period.ages["lines_of"], period.ages["arrivals_of"], period.numbers[NOW] = (2, 1, 0), (130, 60, 0), now

    def soonest(need: int, passed: int = 0) -> tuple[int, bool]:
        tick, urgent = next_urgent(*account.parts, now + passed, need)
        return (tick if tick == NONE else tick - now - passed), urgent

    def urgent(need: int) -> list[int]:
        find_urgent(period, need)
        return period.urgent[: period.numbers[URGENT]].tolist()

    assert soonest(70) == (30, True)
    assert soonest(71) == (1, False)
    assert soonest(100) == (15, False)
    assert soonest(100, 10) == (5, False)
    assert soonest(100, 15) == (45, True)
    assert urgent(40) == [0, 1]
    assert period.ages["urge"].tolist() == [70, 40, 0]
    assert urgent(NONE) == [0, 1, 2]
    period.ages["lines_of"] = period.ages["arrivals_of"] = 0
    assert soonest(100) == (NONE, False)


def test_the_fuller_a_station_the_more_it_takes() -> None:
    """Sixteen times as much where all places are taken, or more than all."""
    assert [needed(load, 30, 500, 16.0) for load in (0, 2, 30, 31)] == [500, 1000, 8000, 8000]
