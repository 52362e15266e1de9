"""Which pods are wanted enough, against sums worked out by hand."""

from __future__ import annotations

import numpy as np

from rmfs_core.warehouse.parts import UNLIMITED
from rmfs_pod_index.compiled import sorted_by_sku
from rmfs_pod_index.period import NONE, Shelves
from rmfs_pod_index.urging import needed, next_urgent, urges


def shown(values: list[int]) -> np.ndarray:
    """An array as the view has them: for looking only."""
    array = np.array(values, dtype=np.int64)
    array.setflags(write=False)
    return array


def test_the_ages_of_the_lines_that_a_pod_has_items_for_add_up() -> None:
    """Pod 0 has lines of 30 and 40 ticks, pod 1 the second alone; a pod that ran out does not count."""
    sku, items = shown([0, 1, 1, 0]), shown([1, UNLIMITED, 1, 0])
    by_sku, first_with = sorted_by_sku(sku, 2)
    shelves = Shelves(np.array([0, 2, 3, 4]), sku, shown([0, 0, 1, 2]), first_with, by_sku)
    lines = shown([0, 1]), np.array([30, 40]), *sorted_by_sku(shown([0, 1]), 2), np.array([0, 1])
    total, number = urges(lines, 3, shelves, items, 100)
    assert (total.tolist(), number.tolist()) == ([70, 40, 0], [2, 1, 0])
    assert next_urgent(total, number, 0, 70) == (30, True)
    assert next_urgent(total, number, 0, 71) == (1, False)
    assert next_urgent(total, number, 0, 100) == (15, False)
    assert next_urgent(total, number, 10, 100) == (5, False)
    assert next_urgent(total, number, 15, 100) == (45, True)
    assert next_urgent(total, 0 * number, 0, 100) == (NONE, False)


def test_the_fuller_a_station_the_more_it_takes() -> None:
    """Sixteen times as much where all places are taken, or more than all."""
    assert [needed(load, 30, 500, 16.0) for load in (0, 2, 30, 31)] == [500, 1000, 8000, 8000]
