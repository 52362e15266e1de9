"""The account of lines and items against one that is made anew."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from rmfs_pod_index.account import find_wanted, join, sorted_by_sku, update
from rmfs_pod_index.period import NONE, OF_LINES, OF_ORDERS, WANTED, Period, Shelves, new_period, with_room

N_SKUS = 4
SKUS = np.array([0, 1, 1, 2, 0, 3])
"""Pods 0 to 2 have two each."""


def shelves() -> Shelves:
    """Three pods."""
    by_sku, first_with = sorted_by_sku(SKUS, N_SKUS)
    return Shelves(np.array([0, 2, 4, 6]), SKUS, np.array([0, 0, 1, 1, 2, 2]), first_with, by_sku)


def lines_by_sku(period: Period) -> list[list[int]]:
    """The open lines of each SKU, forwards; backwards they are the same."""
    found: list[list[int]] = []
    for sku in range(N_SKUS):
        forwards, backwards, line = [], [], period.head[sku]
        while line != NONE:
            forwards.append(int(line))
            line = period.after[line]
        line = period.tail[sku]
        while line != NONE:
            backwards.append(int(line))
            line = period.before[line]
        assert forwards == backwards[::-1]
        found.append(forwards)
    return found


@given(data=st.data())
def test_whatever_joins_and_leaves_the_account_is_right(data: st.DataObject) -> None:
    """Lines of each SKU oldest first, and what they and the pods that have items for them add up to."""
    held = shelves()
    period = new_period(N_SKUS, 3, 1, len(SKUS))
    there: list[int] = []
    items = np.zeros(len(SKUS), np.int64)
    items.setflags(write=False)
    for order in range(data.draw(st.integers(1, 4))):
        begin = int(period.end.max(initial=0))
        rows = data.draw(st.lists(st.tuples(st.integers(0, 3), st.integers(1, 3)), min_size=1, max_size=4))
        end = begin + len(rows)
        period = with_room(with_room(period, OF_LINES, end), OF_ORDERS, order + 1)
        period.order[begin:end], period.arrival[order] = order, 10 * order
        period.sku[begin:end], period.quantity[begin:end] = np.array(rows).T
        join(period, begin, end, held)
        there += range(begin, end)
        left = data.draw(st.lists(st.sampled_from(there), unique=True)) if there else []
        there = [line for line in there if line not in left]
        items = np.array(data.draw(st.lists(st.integers(-1, 2), min_size=len(SKUS), max_size=len(SKUS))))
        items.setflags(write=False)
        update(period, np.array(left, np.int64), items, held)
        assert lines_by_sku(period) == [[i for i in there if period.sku[i] == sku] for sku in range(N_SKUS)]
        for i in range(order + 1):
            assert period.open_items[i] == sum(period.quantity[line] for line in there if period.order[line] == i)
        for pod in range(3):
            has = {SKUS[entry] for entry in range(2 * pod, 2 * pod + 2) if items[entry] > 0}
            mine = [line for line in there if period.sku[line] in has]
            assert period.lines_of[pod] == len(mine)
            assert period.arrivals_of[pod] == sum(10 * period.order[line] for line in mine)
        find_wanted(period)
        assert period.wanted[: period.numbers[WANTED]].tolist() == sorted({int(period.sku[line]) for line in there})
