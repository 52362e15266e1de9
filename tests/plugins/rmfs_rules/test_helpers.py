"""Code shared by rules: parameters, greedy pairs of order and station, large orders, pods that are sent."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pytest
from attrs import define, fields, validators
from hypothesis import given
from hypothesis import strategies as st

from cases import cases
from rmfs_commands.testing import small_world
from rmfs_core import JointDecision, OrderAssignment, PodTrip
from rmfs_core.warehouse import CAPACITY, UNLIMITED, Pod, Station, Warehouse, WarehouseView
from rmfs_rules.first_come import FirstCome
from rmfs_rules.helpers import assign_best_pairs, send_pods
from rmfs_rules.helpers.late import SHUT, assign_late
from rmfs_rules.helpers.oversize import Oversize, with_oversize
from rmfs_rules.helpers.pairs_search import HEAD, Precedence, Scores, Stations, best_pair, values_of
from rmfs_rules.helpers.parameters import parameter
from standing import assigned, put_at_station


@define
class Mine:
    """A rule with two parameters."""

    share: float = parameter(0.5, [validators.gt(0), validators.le(1)], "How much of it")
    window_s: float = parameter(20.0, None, "How long", "s", infinite=True)


def test_default_check_meaning_and_unit() -> None:
    assert (Mine().share, Mine(1).window_s) == (0.5, 20.0)
    for share in (0, 2):
        with pytest.raises(ValueError, match="'share' must be"):
            Mine(share)
    told = [dict(field.metadata) for field in fields(Mine)]
    assert told == [{"doc": "How much of it"}, {"unit": "s", "doc": "How long", "infinite": True}]


def test_scores_are_asked_for_again_where_they_changed() -> None:
    asked: list[int] = []

    def score(station: Station) -> np.ndarray:
        asked.append(station.id)
        return np.array([0, 0, 0]) if asked.count(0) < 2 else np.array([0, 7, 0])

    told: list[tuple[int, int]] = []

    def assigned(station: Station, position: int) -> list[int]:
        told.append((station.id, position))
        return [0] if len(told) == 1 else []

    orders = {"1": {"a": 2, "b": 1}, "2": ["c"], "3": {"a": 1, "b": 1, "c": 4}}
    view = WarehouseView(small_world(orders, {"p": ["a", "b", "c"]}, capacities=(6, 4)))
    assert assign_best_pairs(view, score, assigned) == [OrderAssignment(0, 0), OrderAssignment(1, 0)]
    assert asked == [0, 1, 0]
    assert told == [(0, 0), (0, 1)]


def test_a_fast_lane_has_each_item_of_the_pod_for_one_order() -> None:
    world = small_world({"1": ["b"], "2": ["a"], "3": ["a"]}, {"P": {"a": 1, "b": 1}}, capacities=(3,))
    put_at_station(world, 0)
    world.assign(world.orders[0], world.stations[0], [world.orders[0].lines[0].sku])
    assert assigned(world, FirstCome(fast_lane=2)) == [("2", 0)]


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


@cases("fitting expected", ({0}, [2, SHUT, SHUT]), ({0, 1, 2}, [2, 3, 4]), ids=["one", "all"])
def test_each_order_that_waited_and_fits_nowhere_keeps_a_station(fitting: set[int], expected: list[int]) -> None:
    """That with most room of those that could take it: 2 wants three items, 3 wants one."""
    world = small_world({"1": ["a"], "2": {"a": 3}, "3": ["a"]}, {"p": ["a"]}, capacities=[2, 3, 4])
    asked: list[int] = []
    free = np.array([station.free_capacity for station in world.stations])
    assign_late(WarehouseView(world), 0, free, lambda row: bool(asked.append(row)) or row in fitting)
    assert (asked, free.tolist()) == ([0, 1, 2], expected)


def world_of(*orders: dict[str, int]) -> Warehouse:
    """Return a world of orders with so many items of SKUs, and two stations for two and four items."""
    named = {str(number): lines for number, lines in enumerate(orders)}
    return small_world(named, {"p": ["a", "b", "c"]}, capacities=(2, 4))


FITS, SPREAD, LONG_LINE = {"a": 4}, {"a": 3, "b": 3}, {"a": 5}
"""Of which the second fits both stations together, and the last one has a line that fits neither."""


@cases(
    "large ways",
    (FITS, 0),
    (SPREAD, 1),
    ({"a": 4, "b": 1}, 1),  # its longest line just fits
    (SPREAD | {"c": 1}, 2),  # over time, its rest waits in the backlog
    (LONG_LINE, 3),  # no rule splits a line
)
def test_what_is_too_large_depends_on_how_orders_are_split(large: dict[str, int], ways: int) -> None:
    """Whole orders go to one station, split ones to all at once, or line by line."""
    view = WarehouseView(world_of(FITS, large))
    split: tuple[dict[str, bool], ...] = ({}, {"splits": True}, {"splits": True, "over_time": True})
    found = [Oversize.of(view, 600, **way) for way in split]
    assert [one is not None and one.order.name for one in found] == ["1"] * ways + [False] * (3 - ways)


def test_what_is_left_when_all_stations_are_empty_is_any_large_order() -> None:
    """Its lines may not fit the stations together; with anything at a station it is not known that they never will."""
    world = world_of(FITS, SPREAD, LONG_LINE)
    view, large = WarehouseView(world), JointDecision([OrderAssignment(1, 0)])
    left = Oversize.left(view)
    assert left is not None
    assert (left.order.name, left.station.id) == ("1", 0)
    assert with_oversize(view, None, lambda _: JointDecision(), lambda _: large) == large
    world.assign(world.orders[0], world.stations[1], [0])
    assert Oversize.left(view) is None


NOTHING, OTHERS, LARGE = (JointDecision([OrderAssignment(i, 0) for i in orders]) for orders in ([], [0], [1]))


@cases(
    "now_s load others alone expected without",
    (0, False, OTHERS, LARGE, OTHERS, [None]),  # it waits while others can be assigned
    (0, False, NOTHING, LARGE, LARGE, [None]),
    (0, True, NOTHING, LARGE, NOTHING, [None]),  # its station is not empty
    (600, True, OTHERS, LARGE, OTHERS, [0]),  # and is kept for it from now on
    (600, True, NOTHING, LARGE, NOTHING, [0]),
    (600, False, OTHERS, LARGE, LARGE, []),
    (600, False, OTHERS, NOTHING, OTHERS, [None]),  # free items are not enough: all stations are for others
)
def test_a_large_order_goes_alone_when_nothing_else_can_or_it_has_waited(
    now_s: int, load: bool, others: JointDecision, alone: JointDecision, expected: JointDecision, without: list[Any]
) -> None:
    """Order 1; the station with the lowest load is 0."""
    world, asked = world_of({"a": 1}, LONG_LINE, {"a": 1}, {"a": 1}), []
    for position, station in ((2, 0), (3, 1)) if load else ():
        world.assign(world.orders[position], world.stations[station], [0])
    world.now = now_s * 1000
    view = WarehouseView(world)

    def decide(kept: Station | None) -> JointDecision:
        asked.append(None if kept is None else kept.id)
        return others

    assert with_oversize(view, Oversize.of(view, 600, splits=True), decide, lambda large: alone) == expected
    assert asked == without


def test_only_pods_that_serve_an_uncovered_request_are_offered() -> None:
    """By id, not those that are bound for somewhere already, with what no pod serves yet: also none sent just now."""
    pods = {"p": ["x"], "q": ["a"], "r": ["a", "b"], "s": ["b", "c"], "t": ["a"]}
    world = small_world({"1": ["a", "b", "c"]}, pods)
    a, b, c = (line.sku for line in world.orders[0].lines)
    world.assign(world.orders[0], world.stations[0], [a, b, c])
    world.bind(world.pods[4], world.stations[0])  # covers a
    offered: list[tuple[list[int], dict[int, int]]] = []

    def choose(station: Station, pods: Sequence[Pod], wanted: Mapping[int, int]) -> Pod:
        offered.append(([pod.id for pod in pods], dict(wanted)))
        return pods[0]

    assert send_pods(WarehouseView(world), 9, choose) == [PodTrip(2, 0), PodTrip(3, 0)]
    assert offered == [([2, 3], {b: 1, c: 1}), ([3], {c: 1})]
