"""The compiled scores of pod-index against sums over every set of lines."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rmfs_core.warehouse.parts import UNLIMITED
from rmfs_pod_index.compiled import (
    best_covered,
    best_pods,
    brought_so_far,
    grouped,
    share_visits,
    sorted_by_sku,
    unknown,
)
from rmfs_pod_index.period import FOUND, NONE, Period, Shelves, Weights

HANDLE_S, VISIT_S, N_SKUS = 10.0, 100.0, 4
WEIGHTS = Weights(HANDLE_S, 0.0, 1.0, VISIT_S, 1.0, 0.5, 2, 0, 16.0, packing=False, near=0.0)


def shown(values: list[int]) -> np.ndarray:
    """An array as the view has them: for looking only."""
    array = np.array(values, dtype=np.int64)
    array.setflags(write=False)
    return array


def shelves_of(pods: list[dict[int, int]]) -> tuple[Shelves, np.ndarray]:
    """Pods given as SKU and free items: what they have, and how many."""
    sku = shown([one for pod in pods for one in sorted(pod)])
    items = shown([pod[one] for pod in pods for one in sorted(pod)])
    first = np.cumsum([0, *(len(pod) for pod in pods)])
    by_sku, first_with = sorted_by_sku(sku, N_SKUS)
    return Shelves(first, sku, shown([i for i, pod in enumerate(pods) for _ in pod]), first_with, by_sku), items


def wanted_skus(first: np.ndarray) -> np.ndarray:
    """The SKUs that have lines."""
    return np.flatnonzero(np.diff(first))


def period_of(
    rows: list[tuple[int, int]],
    worth: list[float],
    pods: list[dict[int, int]],
    *,
    available: list[list[int]] | None = None,
    taken: tuple[int, ...] = (),
    room: int = 100,
) -> tuple[Period, Shelves]:
    """Lines given as (SKU, items), each of an order of its own and worth so much; items that are at each station."""
    shelves, items = shelves_of(pods)
    sku, quantity = shown([row[0] for row in rows]), shown([row[1] for row in rows])
    by_sku, first = sorted_by_sku(sku, N_SKUS)
    here = np.array(available or [[0] * N_SKUS], dtype=np.int64)
    untaken, stations = np.array([i not in taken for i in range(len(rows))]), len(here)
    none, free = np.zeros(0, np.bool_), np.ones(stations, np.bool_)
    period = Period(
        order=shown(list(range(len(rows)))), sku=sku, quantity=quantity, age=np.zeros(0, np.int64), factor=np.zeros(0),
        by_sku=by_sku, first=first, wanted=wanted_skus(first), share=np.zeros(N_SKUS), left=np.ones(len(rows)),
        power=HANDLE_S * quantity / np.array(worth), open_items=quantity.copy(),
        least=HANDLE_S * np.arange(1.0 + max(quantity)),
        untaken=untaken, items=items,
        movable=np.ones(len(pods), np.bool_), last=np.full(len(pods), NONE),
        ages=np.zeros(N_SKUS, np.int64),
        urge=np.zeros(len(pods), np.int64), available=here, room=np.full(stations, room),
        load=np.zeros(stations, np.int64), capacity=np.full(stations, room),
        inbound=np.zeros(stations, np.int64), counts_orders=~free, open=free,
        placed=np.zeros((0, 0), np.bool_), split=none, single=none, before=none, parts=np.zeros(0, np.int64),
        turn=np.zeros(stations, np.int64), takes=np.empty((len(rows), 2), np.int64),
        sends=np.empty((len(pods), 2), np.int64), found=np.empty(len(pods), np.int64), numbers=np.zeros(8, np.int64),
    )  # fmt: skip
    return period, shelves


def best(period: Period, shelves: Shelves, bound: float = 0.0, weights: Weights = WEIGHTS) -> list[int]:
    """The pods of the largest index for the first station."""
    best_pods(period, 0, bound, period.movable, shelves, weights)
    return list(period.found[: period.numbers[FOUND]])


def test_a_line_whose_sku_is_at_no_station_bears_its_share_of_a_visit() -> None:
    """SKU 1 shares a visit with SKU 0 (three lines in all on pod 0); pod 1 would bring but one of them."""
    shelves, items = shelves_of([{0: UNLIMITED, 1: UNLIMITED}, {0: UNLIMITED}, {2: 0}])
    _, first = sorted_by_sku(shown([0, 1, 1, 2]), N_SKUS)
    available = np.array([[5, 0, 0, 0], [0, 0, 0, 0]])
    share = np.zeros(N_SKUS)
    share_visits(share, first, wanted_skus(first), available, shelves, items, 300.0)
    assert share.tolist() == [0.0, 100.0, 0.0, 0.0]


def test_free_items_count_where_a_pod_goes_last() -> None:
    """Pod 1 goes to the second station, pod 0, which was at the first, is stored."""
    shelves, items = shelves_of([{0: 3, 1: 1}, {0: 2, 2: 1}])
    available = np.array([[3, 1, 0, 0], [0, 0, 0, 0]])
    brought_so_far(available, np.array([0]), np.array([1]), np.array([NONE, 1]), shelves, items)
    assert available.tolist() == [[0, 0, 0, 0], [2, 0, 1, 0]]


def test_the_best_covered_line_has_the_largest_worth_and_is_the_oldest_of_equals() -> None:
    """The last line would be worth most, but there is one item of its SKU and it wants two."""
    rows, worth = [(0, 1), (1, 1), (1, 1), (2, 2)], [0.2, 0.5, 0.5, 1.0]
    nothing = np.zeros(N_SKUS, np.int64)

    def covered(here: list[int], **more: object) -> int:
        period, _ = period_of(rows, worth, [{3: 1}], available=[here], **more)  # type: ignore[arg-type]
        return int(best_covered(period, 0, nothing, WEIGHTS)[0])

    assert covered([1, 1, 1, 0]) == 1
    assert covered([1, 1, 1, 0], taken=(1,)) == 2
    assert covered([1, 1, 2, 0]) == 3
    assert covered([1, 1, 2, 0], room=1) == 1
    assert covered([0, 0, 1, 9]) == NONE


def test_an_index_worked_by_hand() -> None:
    """Pod 0 brings two lines, (0.5 + 1) / (100 + 2 * 10); pod 1 one that finishes its order, 1 / (100 + 10)."""
    rows, worth = [(0, 1), (1, 1), (2, 1)], [0.5, 1.0, 1.0]
    pods = [{0: UNLIMITED, 1: UNLIMITED}, {2: UNLIMITED}]
    assert best(*period_of(rows, worth, pods)) == [0]
    assert best(*period_of(rows, worth, pods), 1.49 / 120) == [0]
    assert best(*period_of(rows, worth, pods), 1.51 / 120) == []
    # What is there already is brought by no pod; what is at another station counts half
    assert best(*period_of(rows, worth, pods, available=[[0, 5, 0, 0]])) == [1]
    assert best(*period_of(rows, worth, pods, available=[[0, 0, 0, 0], [0, 5, 0, 0]])) == [1]
    assert best(*period_of(rows, worth, [{0: UNLIMITED}, {0: 1}, {3: 1}])) == [0, 1]


@given(data=st.data())
def test_the_best_pods_are_those_of_the_best_sets_of_lines(data: st.DataObject) -> None:
    """Whatever the lines: no set that a pod would bring has a larger ratio than the pods that are named."""
    enough = data.draw(st.booleans(), label="enough of everything")
    size = st.integers(1, 3) if enough else st.just(1)
    rows = data.draw(st.lists(st.tuples(st.integers(0, 3), size), min_size=1, max_size=7), label="lines")
    items = st.just(UNLIMITED) if enough else st.integers(0, 3)
    pods = data.draw(st.lists(st.dictionaries(st.integers(0, 3), items, min_size=1), min_size=1, max_size=4))
    worth = [w / 8 for w in data.draw(st.lists(st.integers(1, 8), min_size=len(rows), max_size=len(rows)))]
    taken = tuple(data.draw(st.sets(st.integers(0, len(rows) - 1))))
    here = data.draw(st.lists(st.integers(0, 1), min_size=4, max_size=4))
    weights = WEIGHTS._replace(visit_s=data.draw(st.sampled_from([0.0, 50.0, 300.0])))

    def ratio(pod: dict[int, int]) -> float:
        largest = 0.0
        gaining = [i for i, (sku, n) in enumerate(rows) if i not in taken and n > here[sku] and pod.get(sku, 0) > 0]
        for number in range(1, len(gaining) + 1):
            for chosen in combinations(gaining, number):
                used = [sum(rows[i][1] for i in chosen if rows[i][0] == sku) for sku in range(4)]
                if all(used[sku] <= pod.get(sku, 0) + here[sku] for sku in range(4)):
                    seconds = weights.visit_s + HANDLE_S * sum(rows[i][1] for i in chosen)
                    largest = max(largest, sum(worth[i] for i in chosen) / seconds)
        return largest

    ratios = [ratio(pod) for pod in pods]
    period, shelves = period_of(rows, worth, pods, available=[here], taken=taken)
    equal = [i for i, one in enumerate(ratios) if one > 0 and one == pytest.approx(max(ratios), rel=1e-6)]
    assert best(period, shelves, weights=weights) == equal

    near = data.draw(st.sampled_from([0.1, 0.3]))
    assume(all(one != pytest.approx((1 - near) * max(ratios), rel=1e-6) for one in ratios if one))
    as_good = [i for i, one in enumerate(ratios) if one > (1 - near) * max(ratios)]
    assert best(period, shelves, weights=weights._replace(near=near)) == as_good
    period.inbound[0] = 1
    assert best(period, shelves, weights=weights._replace(near=near)) == equal


@given(data=st.data())
def test_lines_that_cannot_be_best_are_left_out_without_a_difference(data: st.DataObject) -> None:
    """The best covered line and the best pods are those that all lines together would give."""
    orders = data.draw(st.lists(st.lists(st.integers(0, 3), min_size=1, max_size=4, unique=True), min_size=1))
    order = shown([i for i, skus in enumerate(orders) for _ in skus])
    sku = [one for skus in orders for one in skus]
    rows = [(one, data.draw(st.integers(1, 2))) for one in sku]
    pods = data.draw(st.lists(st.dictionaries(st.integers(0, 3), st.just(9), min_size=1), min_size=1, max_size=4))
    here = data.draw(st.lists(st.integers(0, 2), min_size=4, max_size=4))
    factor = np.array(
        data.draw(st.one_of(st.just([]), st.lists(st.floats(0.5, 3), min_size=len(orders), max_size=len(orders))))
    )
    weights = WEIGHTS._replace(finish=data.draw(st.sampled_from([0.0, 0.85, 1.2])))
    share = np.array([0.0 if n else 50.0 for n in here])

    def decided(least_of: float) -> tuple[int, list[int], list[int]]:
        period, shelves = period_of(rows, [1.0] * len(rows), pods, available=[here])
        period = period._replace(order=order, left=np.full(len(orders), -1.0), factor=factor, share=share)
        period.open_items[: len(orders)] = np.bincount(order, weights=period.quantity)
        least = least_of * (HANDLE_S * np.arange(1.0, 20)) ** weights.finish
        period = period._replace(least=np.append(least_of, least))
        line, most = best_covered(period, 0, np.zeros(N_SKUS, np.int64), weights)
        bound = most / HANDLE_S
        return line, best(period, shelves, bound, weights), best(period, shelves, 0.0, weights)

    assert decided(1.0) == decided(1e-100)


def test_lines_by_order_and_by_sku() -> None:
    """Two orders, of which the second has two lines."""
    found = grouped(shown([0, 1, 1]), shown([7, 9, 9]), shown([2, 2, 0]), shown([1, 3, 1]), N_SKUS)
    assert [one.tolist() for one in found] == [[7, 9], [1, 4], [2, 0, 1], [0, 1, 1, 3, 3], [0, 2]]


def test_orders_that_nothing_is_known_of() -> None:
    """Whether the list is too short or has no entry yet."""
    assert unknown(shown([0, 1, 5]), np.array([7, NONE])).tolist() == [1, 5]
