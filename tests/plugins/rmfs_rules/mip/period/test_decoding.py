"""From counts to lines of orders."""

from __future__ import annotations

import numpy as np
import pytest

from rmfs_rules.mip.period.decoding import Counts, parts_of
from rmfs_rules.mip.period.period import Period, Stock
from rmfs_rules.mip.period.reduction import Reduced
from rmfs_rules.mip.period.solution import Model, Part


@pytest.fixture
def period() -> Period:
    """Return two stations and three orders of SKUs 0 and 1, each on a pod of its own."""
    lines = np.array([[order, sku, 1] for order in range(3) for sku in range(2)]).T
    return Period(Stock((0, 1), ((0,), (1,)), 2), (0, 1), (2, 2), ((), ()), (10, 11, 12), *lines)


def test_the_oldest_orders_of_a_type_go_first(period: Period) -> None:
    """One whole order at each station: the two oldest."""
    reduced = Reduced(period, Model.INTEGRATED)
    counts = Counts(((0, 0), (1, 0), (0, 1), (1, 1)), whole={(0, 0): 1, (0, 1): 1}, splits_limited=True)
    assert parts_of(reduced, counts) == (Part(0, 0, (0, 1)), Part(1, 1, (0, 1)))


def test_lines_of_split_orders_go_where_their_sku_is(period: Period) -> None:
    """Two orders are split: the first pod goes to the first station, the second to the second one."""
    reduced = Reduced(period, Model.SPLIT_AMONG_STATIONS)
    parts = parts_of(reduced, Counts(((0, 0), (1, 1)), split={0: 2}))
    assert set(parts) == {Part(order, station, (station,)) for order in range(2) for station in range(2)}


def test_over_time_any_line_may_be_assigned(period: Period) -> None:
    """Where no limit counts the splits, the oldest lines that find a place are assigned."""
    reduced = Reduced(period, Model.SPLIT_OVER_TIME)
    parts = parts_of(reduced, Counts(((0, 0),)))
    assert set(parts) == {Part(0, 0, (0,)), Part(1, 0, (0,))}
    assert parts_of(reduced, Counts(((0, 0),), splits_limited=True)) == ()


def test_lines_of_several_items_go_as_counted() -> None:
    """With two items a line, a station gets as many lines of a kind as the counts say."""
    lines = np.array([[0, 0, 2], [1, 0, 2]]).T
    period = Period(Stock((0,), ((0,),), 1), (0, 1), (2, 2), ((), ()), (10, 11), *lines)
    counts = Counts(((0, 0), (0, 1)), split={0: 2}, lines={((0, 2), 0): 1, ((0, 2), 1): 1})
    assert parts_of(Reduced(period, Model.SPLIT_AMONG_STATIONS), counts) == (Part(0, 0, (0,)), Part(1, 1, (0,)))
