"""Greedy pairs of order and station, with the parameters that POA rules share, and the compiled search for the best."""

import math
from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cases import cases
from rmfs_commands.testing import check_rule, small_world
from rmfs_core.decisions import OrderAssignment
from rmfs_core.warehouse import CAPACITY, UNLIMITED, Station, WarehouseView
from rmfs_rules.common_lines import CommonLines
from rmfs_rules.first_come import FirstCome
from rmfs_rules.helpers import assign_best_pairs, sum_per_order
from rmfs_rules.helpers.pairs_search import HEAD, Precedence, Scores, Stations, best_pair, completed_by, values_of
from rmfs_rules.near_best_pod import NearBestPod
from rmfs_rules.pod_match import PodMatch
from rmfs_rules.workload import Workload
from standing import assigned as decide

PAIRS = (PodMatch, CommonLines, FirstCome, Workload, NearBestPod)
OF_PAIRS = pytest.mark.parametrize("rule", PAIRS)
"""Rules with all of these parameters."""
FOUR = {"1": ["a"], "2": ["a"], "3": ["a"], "4": ["a"]}


@OF_PAIRS
def test_of_orders_that_are_alike_one_goes_first(rule: type[Any]) -> None:
    world = small_world(FOUR, {"p": ["a"]}, capacities=[2], due_s={"3": 50, "2": 90})
    assert [name for name, _ in decide(world, rule())] == ["1", "2"]
    assert [name for name, _ in decide(world, rule(tie_break="due"))] == ["3", "2"]
    first = Counter(decide(world, rule(tie_break="random"), seed)[0][0] for seed in range(400))
    assert set(first) == set(FOUR)
    assert all(55 <= number <= 145 for number in first.values())


@OF_PAIRS
@cases("wrong problem", ({"tie_break": "newest"}, "'tie_break' must be in"), ({"fast_lane": -1}, "must be >= 0"))
def test_wrong_parameters_are_refused(rule: type[Any], wrong: dict[str, Any], problem: str) -> None:
    with pytest.raises(ValueError, match=problem):
        rule(**wrong)


ORDERS = {"1": {"a": 2, "b": 1}, "2": ["c"], "3": {"a": 1, "b": 1, "c": 4}}


def view(**changes: object) -> WarehouseView:
    """Return a world of three orders of 3, 1 and 6 items; two stations for 6 and 4 items unless said otherwise."""
    settings: dict[str, object] = {"capacities": (6, 4), **changes}
    return WarehouseView(small_world(ORDERS, {"p": ["a", "b", "c"]}, **settings))


def test_values_of_lines_are_summed_by_order() -> None:
    world = view()
    assert sum_per_order(world, world.backlog_lines.quantity).tolist() == [3, 1, 6]
    assert sum_per_order(world, np.ones_like(world.backlog_lines.quantity)).tolist() == [2, 1, 3]
    assert check_rule(PodMatch(tie_break="random", late_first=True, fast_lane=2)).findings == ()


def scores(**by_station: list[int]) -> Callable[[Station], np.ndarray]:
    return lambda station: np.array(by_station[f"s{station.id}"])


def chosen(found: list[OrderAssignment]) -> list[tuple[int, int]]:
    return [(one.order, one.station) for one in found]


@cases(
    "s0 s1 expected",
    ([0, 0, 9], [0, 0, 0], [(2, 0), (0, 1), (1, 1)]),  # the best pair first; then nothing else fits station 0
    ([1, 5, 0], [1, 1, 0], [(1, 0), (0, 1)]),  # of the tie of order 0 the station with the lower load
    ([0, 0, 0], [0, 0, 0], [(0, 0), (1, 1)]),  # all alike: the oldest order, the lowest id
    ([0, 0, 0], [0, 9, 0], [(1, 1), (0, 0)]),  # order 2 fits nowhere then
)
def test_the_best_pair_that_fits_goes_first(s0: list[int], s1: list[int], expected: list[tuple[int, int]]) -> None:
    """Scores decide, then age, load, id; an order of six items fits the empty station 0 only."""
    assert chosen(assign_best_pairs(view(), scores(s0=s0, s1=s1))) == expected


def test_scores_are_asked_for_again_where_they_changed() -> None:
    asked: list[int] = []

    def score(station: Station) -> np.ndarray:
        asked.append(station.id)
        return np.array([0, 0, 0]) if asked.count(0) < 2 else np.array([0, 7, 0])

    told: list[tuple[int, int]] = []

    def assigned(station: Station, position: int) -> list[int]:
        told.append((station.id, position))
        return [0] if len(told) == 1 else []

    assert chosen(assign_best_pairs(view(), score, assigned)) == [(0, 0), (1, 0)]
    assert asked == [0, 1, 0]
    assert told == [(0, 0), (0, 1)]


def test_nothing_to_assign() -> None:
    """Neither without orders nor without capacity is any score asked for."""

    def unasked(station: Station) -> np.ndarray:
        raise AssertionError("nothing fits")

    assert assign_best_pairs(WarehouseView(small_world({}, {"p": ["a"]})), unasked) == []
    full = small_world({"1": ["a"], "2": ["b"]}, {"p": ["a", "b"]}, capacities=(1,))
    full.assign(full.orders[0], full.stations[0], [0])
    assert assign_best_pairs(WarehouseView(full), unasked) == []


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
    taken = drawn(st.booleans(), (number,), np.bool_)
    first = maybe(st.booleans(), number, np.bool_)[0]
    rank = maybe(st.integers(0, 2), number, np.float64)[0]
    counts = drawn(st.booleans(), (stations,), np.bool_)
    placed = maybe(st.booleans(), number, np.bool_, bool(counts.all()))
    capacity = drawn(st.integers(1, 9), (stations,), np.int64)
    free = np.minimum(drawn(st.integers(-1, 9), (stations,), np.int64), capacity)
    load = drawn(st.integers(0, 2), (stations,), np.int64)
    largest = UNLIMITED if counts.any() else int(capacity.max())
    extra = 0.3 * drawn(st.integers(-1, 1), (stations,), np.float64)  # no sum is another one but for rounding
    kept = data.draw(st.integers(0, 2))
    pod, left = drawn(st.integers(-1, 0), (stations,), np.int64), drawn(st.integers(0, 4), stock.items.shape, np.int64)

    def score(place: int, at: int) -> float:
        return sum(min(items, table[at, sku]) for sku, items in columns.of_order(place)) if table.size else 0

    def fits(place: int, at: int) -> bool:
        wanted, items = columns.of_order(place), int(columns.items[place])
        completed = pod[at] == 0 and all(left[[*stock.sku].index(sku)] >= number for sku, number in wanted)
        room = free[at] if completed or not load[at] else min(free[at], max(free[at] - kept, 0))
        if free[at] < 0:
            return False
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
        room = np.array([*zip(free, load, capacity, counts, load, strict=True)], CAPACITY)
        heads, entries = np.zeros(stations, HEAD), (stock.of_pod, stock.sku, left)
        heads["pod"] = pod
        told = Stations(room, heads, largest, extra, placed, kept, np.zeros((0, 0), np.bool_), *entries)
        scores = Scores(table, scored, zeros)
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
    stations = Stations(np.zeros(0, CAPACITY), np.zeros(0, HEAD), 9, np.zeros(0), flags, 0, flags, *entries)
    whole = [
        place
        for place in range(len(named))
        if all(left[[*view.stock.sku].index(sku)] >= items for sku, items in view.lines.of_order(place))
    ]
    assert sorted(completed_by(view.lines, stations, 0).tolist()) == whole
