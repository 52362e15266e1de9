"""The compiled scores of pod-index against sums over every set of lines."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rmfs_core.warehouse.parts import UNLIMITED
from rmfs_rules.pod_index import PodIndex
from rmfs_rules.pod_index.account import bring, join, update
from rmfs_rules.pod_index.compiled import best_covered, best_pods, better_line, find_within, share_visits
from rmfs_rules.pod_index.known import weigh
from rmfs_rules.pod_index.period import CLOSE, FOUND, NONE, OF_LINES, Period, new_account

HANDLE_S, VISIT_S, N_SKUS = 10.0, 100.0, 4
RULE = PodIndex(handle_s=HANDLE_S, cost_s=0, finish=1, visit_s=VISIT_S, stay=1, elsewhere=0.5, near=0)


def account(lines: list[tuple[int, int, int]], pods: list[dict[int, int]], stations: int = 1) -> Period:
    """Open lines given as (order, SKU, items), all orders as dear, and pods given as SKU and free items."""
    held = [(i, sku, pod[sku]) for i, pod in enumerate(pods) for sku in sorted(pod)]
    of_pod, skus, items = np.array(held, np.int64).reshape(-1, 3).T.copy()
    items.setflags(write=False)
    made = new_account(of_pod, skus, len(pods), N_SKUS, np.zeros((stations, 1), np.int64))
    made.make_room(dict.fromkeys(OF_LINES, len(lines)))
    weigh(made.period, RULE)
    made.period.pods["movable"] = made.period.pods["able"] = True
    update(*made.parts, 0, np.zeros(0, np.int64), np.arange(len(items)), items)
    orders = np.array([(i, 0, np.inf, 1.0, 1 + CLOSE) for i in {order for order, _, _ in lines}]).reshape(-1, 5)
    join(*made.parts, 0, np.array(lines, np.int64).reshape(-1, 3).T.copy(), orders)
    return made.period


def period_of(
    rows: list[tuple[int, int]],
    worth: list[float],
    pods: list[dict[int, int]],
    *,
    available: list[list[int]] | None = None,
    taken: tuple[int, ...] = (),
    room: int = 100,
) -> Period:
    """Lines given as (SKU, items), each of an order of its own and worth so much; items that are at each station."""
    here = np.array(available or [[0] * N_SKUS])
    period = account([(i, *row) for i, row in enumerate(rows)], pods, len(here))
    period.available[:] = here.T
    period.stations["room"] = room
    period.lines["untaken"][list(taken)] = False
    period.orders["left"] = 1.0
    seconds = HANDLE_S * np.array([items for _, items in rows])
    period.orders["power"][: len(rows)] = seconds / np.array(worth)
    return period


def best(period: Period, bound: float = 0.0, **weights: float) -> list[int]:
    """The pods of the largest index for the first station."""
    for name, weight in weights.items():
        period.weights[name] = weight
    find_within(period)
    best_pods(period, 0, bound)
    return sorted(period.found[: period.numbers[FOUND]])


def test_a_line_whose_sku_is_at_no_station_bears_its_share_of_a_visit() -> None:
    """SKU 1 shares a visit with SKU 0 (three lines in all on pod 0); pod 1 would bring but one of them."""
    pods = [{0: UNLIMITED, 1: UNLIMITED}, {0: UNLIMITED}, {2: 0}]
    period = account([(0, 0, 1), (1, 1, 1), (2, 1, 1), (3, 2, 1)], pods, 2)
    period.available[0, 0] = 5
    period.weights["cost_s"] = 300.0
    share_visits(period)
    assert period.skus["share"].tolist() == [0.0, 100.0, 0.0, 0.0]


def test_free_items_count_where_a_pod_goes() -> None:
    """And no longer when it goes elsewhere, or is gone."""
    period = account([], [{0: 3, 1: 1}, {0: 2, 2: 1}], 2)
    bring(period, 0, 0)
    bring(period, 1, 1)
    assert period.available.T.tolist() == [[3, 1, 0, 0], [2, 0, 1, 0]]
    bring(period, 0, 1)
    assert period.available.T.tolist() == [[0, 0, 0, 0], [5, 1, 1, 0]]
    bring(period, 1, NONE)
    assert period.available.T.tolist() == [[0, 0, 0, 0], [3, 1, 0, 0]]


def test_the_best_covered_line_has_the_largest_worth_and_is_the_oldest_of_equals() -> None:
    """The last line would be worth most, but there is one item of its SKU and it wants two."""
    rows, worth = [(0, 1), (1, 1), (1, 1), (2, 2)], [0.2, 0.5, 0.5, 1.0]

    def covered(here: list[int], **more: object) -> int:
        period = period_of(rows, worth, [{3: 1}], available=[here], **more)  # type: ignore[arg-type]
        return int(best_covered(period, 0)[0])

    assert covered([1, 1, 1, 0]) == 1
    assert covered([1, 1, 1, 0], taken=(1,)) == 2
    assert covered([1, 1, 2, 0]) == 3
    assert covered([1, 1, 2, 0], room=1) == 1
    assert covered([0, 0, 1, 9]) == NONE


def test_an_index_worked_by_hand() -> None:
    """Pod 0 brings two lines, (0.5 + 1) / (100 + 2 * 10); pod 1 one that finishes its order, 1 / (100 + 10)."""
    rows, worth = [(0, 1), (1, 1), (2, 1)], [0.5, 1.0, 1.0]
    pods = [{0: UNLIMITED, 1: UNLIMITED}, {2: UNLIMITED}]
    assert best(period_of(rows, worth, pods)) == [0]
    assert best(period_of(rows, worth, pods), 1.49 / 120) == [0]
    assert best(period_of(rows, worth, pods), 1.51 / 120) == []
    # What is there already is brought by no pod; what is at another station counts half
    assert best(period_of(rows, worth, pods, available=[[0, 5, 0, 0]])) == [1]
    assert best(period_of(rows, worth, pods, available=[[0, 0, 0, 0], [0, 5, 0, 0]])) == [1]
    assert best(period_of(rows, worth, [{0: UNLIMITED}, {0: 1}, {3: 1}])) == [0, 1]


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
    visit_s = data.draw(st.sampled_from([0.0, 50.0, 300.0]))

    def ratio(pod: dict[int, int]) -> float:
        largest = 0.0
        gaining = [i for i, (sku, n) in enumerate(rows) if i not in taken and n > here[sku] and pod.get(sku, 0) > 0]
        for number in range(1, len(gaining) + 1):
            for chosen in combinations(gaining, number):
                used = [sum(rows[i][1] for i in chosen if rows[i][0] == sku) for sku in range(4)]
                if all(used[sku] <= pod.get(sku, 0) + here[sku] for sku in range(4)):
                    seconds = visit_s + HANDLE_S * sum(rows[i][1] for i in chosen)
                    largest = max(largest, sum(worth[i] for i in chosen) / seconds)
        return largest

    ratios = [ratio(pod) for pod in pods]
    period = period_of(rows, worth, pods, available=[here], taken=taken)
    equal = [i for i, one in enumerate(ratios) if one > 0 and one == pytest.approx(max(ratios), rel=1e-6)]
    assert best(period, visit_s=visit_s) == equal

    near = data.draw(st.sampled_from([0.1, 0.3]))
    assume(all(one != pytest.approx((1 - near) * max(ratios), rel=1e-6) for one in ratios if one))
    as_good = [i for i, one in enumerate(ratios) if one > (1 - near) * max(ratios)]
    assert best(period, visit_s=visit_s, near=near) == as_good
    period.stations["inbound"][0] = 1
    assert best(period, visit_s=visit_s, near=near) == equal


@given(data=st.data())
def test_lines_that_cannot_be_best_are_left_out_without_a_difference(data: st.DataObject) -> None:
    """The best covered line and the best pods are those that all lines together would give."""
    orders = data.draw(st.lists(st.lists(st.integers(0, 3), min_size=1, max_size=4, unique=True), min_size=1))
    lines = [(i, one, data.draw(st.integers(1, 2))) for i, skus in enumerate(orders) for one in skus]
    pods = data.draw(st.lists(st.dictionaries(st.integers(0, 3), st.just(9), min_size=1), min_size=1, max_size=4))
    here = data.draw(st.lists(st.integers(0, 2), min_size=4, max_size=4))
    worth = data.draw(st.lists(st.floats(0.5, 3), min_size=len(orders), max_size=len(orders)))
    due_s = data.draw(st.lists(st.sampled_from([0.0, 900.0, np.inf]), min_size=len(orders), max_size=len(orders)))
    finish = data.draw(st.sampled_from([0.0, 0.85, 1.2]))

    def decided(least_of: float) -> tuple[int, list[int], list[int]]:
        period = account(lines, pods)
        orders = period.orders[: len(due_s)]
        period.weights["finish"] = finish
        period.least[:] = least_of * np.arange(len(period.least)) ** finish
        orders["worth"], orders["due_s"] = worth, due_s
        orders["highest"] = (1 + CLOSE) * RULE.due_factor * np.array(worth)
        period.available[:, 0], period.stations["room"] = here, 100
        period.skus["share"] = [0.0 if n else 50.0 for n in here]
        line, most = best_covered(period, 0)
        return line, best(period, most / HANDLE_S), best(period)

    assert decided(1.0) == decided(1e-100)


def test_of_lines_that_are_covered_already_none_is_better() -> None:
    """Two items are there before a pod brings a third: only the line that wants three counts."""
    period = period_of([(0, 2), (0, 3)], [1.0, 0.5], [{0: 1}], available=[[3, 0, 0, 0]])
    assert better_line(period, 0, 0, 2, NONE, 0.0) == (1, 0.5)
    assert better_line(period, 0, 0, 0, NONE, 0.0) == (0, 1.0)
