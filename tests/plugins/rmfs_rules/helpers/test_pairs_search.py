"""The compiled search for a station's best order against a plain one."""

import math
from typing import Any

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import CAPACITY, UNLIMITED, WarehouseView
from rmfs_rules.helpers.pairs_search import (
    HEAD,
    SHARE,
    Precedence,
    Scores,
    Stations,
    best_pair,
    completed_by,
    values_of,
)

SKUS = "abc"
lines = st.dictionaries(st.sampled_from(SKUS), st.integers(1, 4), min_size=1, max_size=3)


@given(st.lists(lines, min_size=1, max_size=8), st.integers(1, 3), st.data())
def test_the_best_pair_is_found(orders: list[dict[str, int]], stations: int, data: st.DataObject) -> None:
    """By first, value, rank, age, load, of those that fit; scores by SKU and given ones alike; nothing stays behind."""
    number = len(orders)
    view = WarehouseView(small_world({str(i): order for i, order in enumerate(orders)}, {"p": [*SKUS]}))
    columns, stock = view.lines, view.stock

    def drawn(values: st.SearchStrategy[Any], shape: tuple[int, ...], kind: Any) -> Any:
        length = math.prod(shape)
        return np.array(data.draw(st.lists(values, min_size=length, max_size=length)), kind).reshape(shape)

    def maybe(values: st.SearchStrategy[Any], columns: int, kind: Any, may: bool = True) -> Any:
        return drawn(values, (stations, columns if may and data.draw(st.booleans()) else 0), kind)

    table = maybe(st.integers(0, 4), view.n_skus, np.int64)
    shares = maybe(st.integers(0, 1), view.n_skus, np.int64)
    taken = drawn(st.booleans(), (number,), np.bool_)
    first = maybe(st.booleans(), number, np.bool_)[0]
    rank = maybe(st.integers(0, 2), number, np.float64)[0]
    counts = drawn(st.booleans(), (stations,), np.bool_)
    placed = maybe(st.booleans(), number, np.bool_, bool(counts.all()))
    capacity = drawn(st.integers(1, 9), (stations,), np.int64)
    free = np.minimum(drawn(st.integers(-1, 9), (stations,), np.int64), capacity)
    load = drawn(st.integers(0, 2), (stations,), np.int64)
    largest, queued = UNLIMITED if counts.any() else int(capacity.max()), data.draw(st.booleans())
    extra = drawn(st.integers(-1, 1), (stations,), np.float64)
    kept = data.draw(st.integers(0, 2))
    pod, left = drawn(st.integers(-1, 0), (stations,), np.int64), drawn(st.integers(0, 4), stock.items.shape, np.int64)

    def score(place: int, at: int) -> float:
        wanted = columns.of_order(place)
        share = sum(shares[at, sku] for sku, _ in wanted) / len(wanted) if shares.size else 0.0
        return (sum(min(items, table[at, sku]) for sku, items in wanted) if table.size else 0) + SHARE * share

    def fits(place: int, at: int) -> bool:
        wanted, items = columns.of_order(place), int(columns.items[place])
        completed = pod[at] == 0 and all(left[[*stock.sku].index(sku)] >= number for sku, number in wanted)
        room = free[at] if completed or not load[at] else min(free[at], max(free[at] - kept, 0))
        if free[at] < 0 or (queued and not counts[at] and items > capacity[at]):
            return False
        if queued:
            return bool(room >= 1)
        if counts[at]:
            return bool(room >= (0 if placed.size and placed[at, place] else 1))
        return bool(items <= room or (items > largest and room == capacity[at]))

    able = [
        (
            not (first.size and first[place]),
            -score(place, at) - extra[at],
            rank[place] if rank.size else 0,
            place,
            load[at],
            at,
        )
        for place in range(number)
        for at in range(stations)
        if not taken[place] and fits(place, at)
    ]
    best = min(able, default=(0, 0, 0, -1, 0, -1))
    rank.setflags(write=False)
    given = np.array([[score(place, at) for place in range(number)] for at in range(stations)], np.float64)
    for scored in (np.zeros((stations, 0)), given):
        zeros = np.zeros(number)
        room = np.array([*zip(free, load, capacity, counts, strict=True)], CAPACITY)
        heads, entries = np.zeros(stations, HEAD), (stock.of_pod, stock.sku, left)
        heads["pod"] = pod
        told = Stations(room, heads, largest, queued, extra, placed, kept, np.zeros((0, 0), np.bool_), *entries)
        scores = Scores(table, shares, scored, zeros)
        assert best_pair(columns, scores, Precedence(taken, first, rank), told) == (best[3], best[5])
        assert not zeros.any()
        values = values_of(columns, scores, 0, told)
        assert [at for at in range(stations) if values[at] > -math.inf] == [at for at in range(stations) if fits(0, at)]


@given(st.lists(lines, max_size=8), st.lists(st.integers(0, 4), min_size=3, max_size=3))
def test_completed_orders_are_found(orders: list[dict[str, int]], left: list[int]) -> None:
    named = {str(i): order for i, order in enumerate([dict.fromkeys(SKUS, 1), *orders])}
    view = WarehouseView(small_world(named, {"p": [*SKUS]}))
    stock, none = view.stock, np.zeros((0, 0))
    entries = stock.of_pod, stock.sku, np.array(left)
    flags = none.astype(np.bool_)
    stations = Stations(np.zeros(0, CAPACITY), np.zeros(0, HEAD), 9, False, np.zeros(0), flags, 0, flags, *entries)
    whole = [
        place
        for place in range(len(named))
        if all(left[[*view.stock.sku].index(sku)] >= items for sku, items in view.lines.of_order(place))
    ]
    assert sorted(completed_by(view.lines, stations, 0).tolist()) == whole
