"""The compiled scores of pod-index against sums over every set of lines."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rmfs_core.warehouse.parts import UNLIMITED
from rmfs_pod_index.compiled import NONE, Contents, Lines, best_covered, best_pods, line_costs, urgent

HANDLE_S, VISIT_S = 10.0, 100.0


def shown(values: list[int]) -> np.ndarray:
    """An array as the view has them: for looking only."""
    array = np.array(values, dtype=np.int64)
    array.setflags(write=False)
    return array


def lines_of(*rows: tuple[int, int], n_skus: int = 4) -> Lines:
    """Lines given as (SKU, items)."""
    sku = shown([row[0] for row in rows])
    by_sku = np.argsort(sku, kind="stable")
    first = np.searchsorted(sku[by_sku], np.arange(n_skus + 1))
    return Lines(sku, shown([row[1] for row in rows]), by_sku, first)


def contents_of(*pods: dict[int, int]) -> Contents:
    """Pods given as SKU and free items."""
    sku = [one for pod in pods for one in sorted(pod)]
    items = [pod[one] for pod in pods for one in sorted(pod)]
    first = np.cumsum([0, *(len(pod) for pod in pods)])
    return Contents(first, shown(sku), shown(items))


def test_a_line_whose_sku_is_at_no_station_bears_its_share_of_a_visit() -> None:
    """SKU 1 shares a visit with SKU 0 (three lines in all on pod 0); pod 1 would bring but one of them."""
    lines = lines_of((0, 1), (1, 2), (1, 1), (2, 1))
    pods = contents_of({0: UNLIMITED, 1: UNLIMITED}, {0: UNLIMITED}, {2: 0})
    here = np.array([True, False, False, False])
    cost = line_costs(lines, pods, here, HANDLE_S, 300.0)
    assert cost.tolist() == [10.0, 20.0 + 100.0, 10.0 + 100.0, 10.0]


def test_the_best_covered_line_has_the_largest_worth_and_is_the_oldest_of_equals() -> None:
    """The last line would be worth most, but there is one item of its SKU and it wants two."""
    lines = lines_of((0, 1), (1, 1), (1, 1), (2, 2))
    worth, fits = np.array([0.2, 0.5, 0.5, 1.0]), np.array([True, True, True, True])
    assert best_covered(lines, worth, fits, np.array([1, 1, 1, 0])) == 1
    assert best_covered(lines, worth, ~fits, np.array([1, 1, 1, 0])) == NONE
    assert best_covered(lines, worth, fits, np.array([0, 0, 1, 9])) == NONE


def test_an_index_worked_by_hand() -> None:
    """Pod 0 brings two lines, (0.5 + 1) / (100 + 2 * 10); pod 1 one that finishes its order, 1 / (100 + 10)."""
    lines = lines_of((0, 1), (1, 1), (2, 1))
    pods = contents_of({0: UNLIMITED, 1: UNLIMITED}, {2: UNLIMITED})
    worth, fits = np.array([0.5, 1.0, 1.0]), np.ones(3, dtype=bool)
    nothing, both = np.zeros(4, dtype=np.int64), np.arange(2)

    def best(bound: float, available: np.ndarray = nothing) -> list[int]:
        return list(best_pods(bound, both, lines, worth, fits, pods, available, HANDLE_S, VISIT_S))

    assert best(0.0) == [0]
    assert best(1.49 / 120) == [0]
    assert best(1.51 / 120) == []
    assert best(0.0, np.array([0, 5, 0, 0])) == [1]  # what is there already is brought by no pod


def test_pods_that_are_as_good_are_all_named() -> None:
    """Two pods with the same SKU."""
    pods = contents_of({0: UNLIMITED}, {0: 1}, {1: 1})
    lines = lines_of((0, 1), n_skus=2)
    found = best_pods(
        0.0, np.arange(3), lines, np.ones(1), np.ones(1, dtype=bool), pods, np.zeros(2, dtype=np.int64), 13.0, 300.0
    )
    assert list(found) == [0, 1]


@given(data=st.data())
def test_the_best_pods_are_those_of_the_best_sets_of_lines(data: st.DataObject) -> None:
    """Whatever the lines: no set that a pod would bring has a larger ratio than the pods that are named."""
    enough = data.draw(st.booleans(), label="enough of everything")
    size = st.integers(1, 3) if enough else st.just(1)
    rows = data.draw(st.lists(st.tuples(st.integers(0, 3), size), min_size=1, max_size=7), label="lines")
    items = st.just(UNLIMITED) if enough else st.integers(0, 3)
    pods = data.draw(st.lists(st.dictionaries(st.integers(0, 3), items, min_size=1), min_size=1, max_size=4))
    worth = np.array(data.draw(st.lists(st.integers(1, 8), min_size=len(rows), max_size=len(rows)))) / 8
    fits = np.array(data.draw(st.lists(st.booleans(), min_size=len(rows), max_size=len(rows))), dtype=bool)
    available = np.array(data.draw(st.lists(st.integers(0, 1), min_size=4, max_size=4)))
    visit_s = data.draw(st.sampled_from([0.0, 50.0, 300.0]))

    def ratio(pod: dict[int, int]) -> float:
        best = 0.0
        gaining = [i for i, (sku, n) in enumerate(rows) if fits[i] and n > available[sku] and pod.get(sku, 0) > 0]
        for number in range(1, len(gaining) + 1):
            for chosen in combinations(gaining, number):
                taken = [sum(rows[i][1] for i in chosen if rows[i][0] == sku) for sku in range(4)]
                if all(taken[sku] <= pod.get(sku, 0) + available[sku] for sku in range(4)):
                    seconds = visit_s + HANDLE_S * sum(rows[i][1] for i in chosen)
                    best = max(best, sum(worth[i] for i in chosen) / seconds)
        return best

    ratios = [ratio(pod) for pod in pods]
    found = best_pods(
        0.0, np.arange(len(pods)), lines_of(*rows), worth, fits, contents_of(*pods), available, HANDLE_S, visit_s
    )
    expected = [i for i, one in enumerate(ratios) if one > 0 and one == pytest.approx(max(ratios), rel=1e-6)]
    assert list(found) == expected


def test_a_pod_is_urgent_when_the_ages_of_its_lines_add_up() -> None:
    """Pod 0 has lines of 30 s and 40 s, pod 1 the second alone; taken lines and pods that ran out do not count."""
    lines = lines_of((0, 1), (1, 1), (2, 1), n_skus=3)
    pods = contents_of({0: 1, 1: 1}, {1: 1}, {0: 0, 2: 9})
    untaken, ages = np.array([True, True, False]), np.array([30.0, 40.0, 500.0])
    assert urgent(np.arange(3), lines, untaken, ages, pods, 70.0).tolist() == [True, False, False]
    assert urgent(np.arange(3), lines, untaken, ages, pods, 40.0).tolist() == [True, True, False]
