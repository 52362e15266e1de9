"""The account of lines and items against one that is made anew."""

from __future__ import annotations

from itertools import product

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from rmfs_rules.pod_index.account import join, move, update
from rmfs_rules.pod_index.period import NONE, OF_LINES, WANTED, Period, new_account

N_SKUS = 4
SKUS = np.array([0, 1, 1, 2, 0, 3])
"""Pods 0 to 2 have two each."""


def lines_by_sku(period: Period) -> list[list[int]]:
    """The open lines of each SKU, forwards; backwards they are the same."""
    found: list[list[int]] = []
    for sku in range(N_SKUS):
        forwards, backwards, line = [], [], period.skus["head"][sku]
        while line != NONE:
            forwards.append(int(line))
            line = period.lines["after"][line]
        line = period.skus["tail"][sku]
        while line != NONE:
            backwards.append(int(line))
            line = period.lines["before"][line]
        assert forwards == backwards[::-1]
        found.append(forwards)
    return found


@given(data=st.data())
def test_whatever_joins_and_leaves_the_account_is_right(data: st.DataObject) -> None:
    """Lines of each SKU oldest first, and what they and the pods that have items for them add up to."""
    account = new_account(np.repeat(range(3), 2), SKUS, 3, N_SKUS, np.zeros((2, 1), np.int64))
    there: list[int] = []
    for order in range(data.draw(st.integers(1, 4))):
        begin = int(account.period.orders["end"].max(initial=0))
        rows = data.draw(st.lists(st.tuples(st.integers(0, 3), st.integers(1, 3)), min_size=1, max_size=4))
        end = begin + len(rows)
        account.make_room(dict.fromkeys(OF_LINES, end))
        period = account.period
        lines, orders = period.lines, period.orders
        told = np.array([(order, *row) for row in rows]).T.copy()
        join(*account.parts, begin, told, np.array([(order, 10 * order, np.inf, 1.0, 1.0)]))
        there += range(begin, end)
        left = data.draw(st.lists(st.sampled_from(there), unique=True)) if there else []
        there = [line for line in there if line not in left]
        items = np.array(data.draw(st.lists(st.integers(-1, 2), min_size=len(SKUS), max_size=len(SKUS))))
        items.setflags(write=False)
        changed = np.flatnonzero(items != period.entries["free"])
        update(*account.parts, 0, np.array(left, np.int64), changed, items)
        goes = data.draw(st.lists(st.sampled_from([NONE, 0, 1]), min_size=3, max_size=3), label="where pods go")
        move(*account.parts, np.array([(pod, last, NONE) for pod, last in enumerate(goes)]))
        assert lines_by_sku(period) == [[i for i in there if lines["sku"][i] == sku] for sku in range(N_SKUS)]
        for i in range(order + 1):
            assert orders["open_items"][i] == sum(
                lines["quantity"][line] for line in there if lines["order"][line] == i
            )
        for pod in range(3):
            has = {SKUS[entry] for entry in range(2 * pod, 2 * pod + 2) if items[entry] > 0}
            mine = [line for line in there if lines["sku"][line] in has]
            assert period.ages["lines_of"][pod] == len(mine)
            assert period.ages["arrivals_of"][pod] == sum(10 * lines["order"][line] for line in mine)
        for sku, station in product(range(N_SKUS), range(2)):
            there_of_it = [items[i] for i in range(len(SKUS)) if SKUS[i] == sku and goes[i // 2] == station]
            assert period.available[sku, station] == sum(there_of_it)
        assert period.wanted[: period.numbers[WANTED]].tolist() == sorted({int(lines["sku"][line]) for line in there})
        with_sku = sorted(zip(SKUS, np.repeat(range(3), 2), items, strict=True))
        assert period.holders.tolist() == [(pod, free) for _, pod, free in with_sku]
