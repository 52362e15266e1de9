"""Which pods are wanted enough, against sums worked out by hand."""

from __future__ import annotations

import numpy as np

from rmfs_pod_index.period import NONE
from rmfs_pod_index.urging import find_urgent, needed, next_urgent


def test_the_ages_of_the_lines_that_a_pod_has_items_for_add_up() -> None:
    """Pod 0 has lines of 30 and 40 ticks, pod 1 the second alone, pod 2 none."""
    now, lines, arrivals = 100, np.array([2, 1, 0]), np.array([130, 60, 0])

    def soonest(need: int, passed: int = 0) -> tuple[int, bool]:
        tick, urgent = next_urgent(lines, arrivals, now + passed, need, 0)
        return (tick if tick == NONE else tick - now - passed), urgent

    assert soonest(70) == (30, True)
    assert soonest(71) == (1, False)
    assert soonest(100) == (15, False)
    assert soonest(100, 10) == (5, False)
    assert soonest(100, 15) == (45, True)
    assert next_urgent(0 * lines, 0 * arrivals, now, 100, 0) == (NONE, False)
    urge, urgent = np.zeros(3, np.int64), np.zeros(3, np.int64)
    assert find_urgent(urge, urgent, lines, arrivals, now, 40) == 2
    assert (urge.tolist(), urgent.tolist()[:2]) == ([70, 40, 0], [0, 1])
    assert find_urgent(urge, urgent, lines, arrivals, now, NONE) == 3


def test_the_fuller_a_station_the_more_it_takes() -> None:
    """Sixteen times as much where all places are taken, or more than all."""
    assert [needed(load, 30, 500, 16.0) for load in (0, 2, 30, 31)] == [500, 1000, 8000, 8000]
