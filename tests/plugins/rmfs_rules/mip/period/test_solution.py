"""What a solution costs, and which orders it splits."""

from __future__ import annotations

import numpy as np
import pytest

from rmfs_rules.mip.period.period import Period, Stock
from rmfs_rules.mip.period.solution import Part, Solution, is_useful, is_whole, items_of, newly_split, objective_of


@pytest.fixture
def period() -> Period:
    """Return two stations; order 10 wants two of SKU 0 and one of SKU 1, order 11 one of SKU 0."""
    lines = np.array([[0, 0, 2], [0, 1, 1], [1, 0, 1]]).T
    return Period(Stock((0, 1), ((0,), (1,)), 2), (0, 1), (3, 2), ((), ()), (10, 11), *lines)


def test_the_objective_is_visits_and_free_places(period: Period) -> None:
    """Three items of five places are assigned with two visits: 2 + 1.5 * 2."""
    parts = (Part(0, 0, (0,)), Part(1, 1, (0,)))
    assert items_of(period, parts) == 3
    assert objective_of(period, parts, 2, 1.5) == 5.0


@pytest.mark.parametrize(
    ("parts", "split"),
    [
        ((Part(0, 0, (0, 1)), Part(1, 1, (0,))), []),
        ((Part(0, 0, (0,)), Part(0, 1, (1,))), [0]),  # at two stations
        ((Part(0, 0, (0,)),), [0]),  # a line stays in the backlog
    ],
)
def test_newly_split_orders(period: Period, parts: tuple[Part, ...], split: list[int]) -> None:
    """An order is split at several stations or with a line left over, unless it was split before."""
    assert newly_split(period, parts) == split
    period.begun = (True, True)
    assert newly_split(period, parts) == []


def test_a_pod_is_useful_where_a_part_needs_it(period: Period) -> None:
    """The pod with SKU 1 is of use at the station that gets the line, and nowhere else."""
    parts = (Part(0, 0, (0, 1)),)
    assert is_useful(period, 1, 0, parts)
    assert not is_useful(period, 1, 1, parts)


def test_how_a_solve_ended() -> None:
    """Only a limit ends it early."""
    assert Solution((), (), 2.0, 1.0, "stopped").stopped_early
    assert not Solution((), (), 2.0, 2.0, "flow").stopped_early
    assert is_whole(2)
    assert not is_whole(1.5)
