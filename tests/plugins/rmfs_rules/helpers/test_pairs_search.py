"""The compiled search for a station's best order against a plain one."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import WarehouseView
from rmfs_rules.helpers.pairs_search import SHARE, Counts, Order, Space, best_by_score, best_by_sku, completed_by

SKUS = "abc"
lines = st.dictionaries(st.sampled_from(SKUS), st.integers(1, 4), min_size=1, max_size=3)


@given(st.lists(lines, min_size=1, max_size=8), st.data())
def test_the_best_order_is_found(orders: list[dict[str, int]], data: st.DataObject) -> None:
    """By first, score, rank, age, of those that fit; scores by SKU and given ones alike; nothing stays behind."""
    number = len(orders)
    view = WarehouseView(small_world({str(i): order for i, order in enumerate(orders)}, {"p": [*SKUS]}))
    skus = view.n_skus
    flags = st.lists(st.booleans(), min_size=number, max_size=number)
    most = np.array(data.draw(st.lists(st.integers(0, 4), min_size=skus, max_size=skus)))
    shares = np.array(data.draw(st.just([]) | st.lists(st.integers(0, 1), min_size=skus, max_size=skus)), np.int64)
    taken, first = np.array(data.draw(flags)), np.array(data.draw(st.just([]) | flags), np.bool_)
    rank = np.array(data.draw(st.just([]) | st.lists(st.integers(0, 2), min_size=number, max_size=number)), np.float64)
    counts, capacity = data.draw(st.booleans()), data.draw(st.integers(1, 9))
    free = data.draw(st.integers(0, capacity))
    room = data.draw(st.integers(0, free))
    placed = np.array(data.draw(st.just([]) | flags), np.bool_) if counts else np.zeros(0, np.bool_)
    completed = np.array([place for place in range(number) if data.draw(st.booleans())], np.int64)
    largest = np.inf if counts else data.draw(st.integers(1, 9))
    space = Space(room, free, capacity, float(largest), counts)
    columns = view.lines

    def score(place: int) -> float:
        wanted = columns.of_order(place)
        share = sum(shares[sku] for sku, _ in wanted) / len(wanted) if len(shares) else 0.0
        return sum(min(items, most[sku]) for sku, items in wanted) + SHARE * share

    scores = np.array([score(place) for place in range(number)], np.float64)

    def fits(place: int) -> bool:
        there = free if place in completed else room
        if counts:
            return there >= (0 if len(placed) and placed[place] else 1)
        items = int(columns.items[place])
        return items <= there or (items > largest and there == capacity)

    able = [
        (not (len(first) and first[place]), -float(scores[place]), rank[place] if len(rank) else 0.0, place)
        for place in range(number)
        if not taken[place] and fits(place)
    ]
    best = min(able, default=(True, -0.0, 0.0, -1))
    rank.setflags(write=False)
    zeros, order = np.zeros(number), Order(taken, first, rank)
    assert best_by_sku(columns, Counts(most, shares), zeros, order, space, placed, completed) == (best[3], -best[1])
    assert not zeros.any()
    assert best_by_score(columns, scores, order, space, placed, completed) == (best[3], -best[1])


@given(st.lists(lines, max_size=8), st.dictionaries(st.integers(0, 2), st.integers(0, 4)))
def test_completed_orders_are_found(orders: list[dict[str, int]], held: dict[int, int]) -> None:
    """Those of which every line can be served."""
    named = {str(i): order for i, order in enumerate([dict.fromkeys(SKUS, 1), *orders])}
    columns = WarehouseView(small_world(named, {"p": [*SKUS]})).lines
    entries = np.array([*held.items()], np.int64).reshape(-1, 2).T.copy()
    whole = [
        place for place in range(len(named)) if all(held.get(sku, 0) >= items for sku, items in columns.of_order(place))
    ]
    assert sorted(completed_by(columns, *entries).tolist()) == whole
