"""Look-ups among the entries of pods and SKUs, against plain ones."""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from rmfs_rules.helpers.pod_search import change_sums, highest, items_on, servers, with_most

N_SKUS, N_PODS = 4, 6


@st.composite
def shelves(draw: st.DrawFn) -> Any:
    """Draw what pods hold; return it also as arrays: entries by SKU, where SKUs begin; pod, SKU and items of each."""
    held = st.dictionaries(st.integers(0, N_SKUS - 1), st.integers(0, 3))
    pods = draw(st.lists(held, min_size=N_PODS, max_size=N_PODS))
    entries = [(pod, sku, held[sku]) for pod, held in enumerate(pods) for sku in sorted(held)]
    pod, sku, items = np.array(entries, np.int64).reshape(-1, 3).T.copy()
    by_sku = np.argsort(sku, kind="stable")
    return pods, (by_sku, np.searchsorted(sku[by_sku], np.arange(N_SKUS + 1)), pod, sku, items)


some_skus = st.lists(st.integers(0, N_SKUS - 1), unique=True, min_size=1)


@given(held=shelves(), skus=some_skus, places=st.lists(st.integers(-2, 2), min_size=N_PODS, max_size=N_PODS))
def test_pods_that_serve_are_found_by_id(held: Any, skus: list[int], places: list[int]) -> None:
    """Each once, with an item of one of the SKUs, where it may leave from; nothing is left behind for the next call."""
    pods, (by_sku, first, pod, _, items) = held
    found = np.zeros(N_PODS, np.bool_)
    for station, least in ((0, -1), (1, 0)):
        ids = servers(np.array(skus), by_sku, first, pod, items, np.array(places), station, least, found)
        assert ids.tolist() == [
            one
            for one in range(N_PODS)
            if places[one] >= least and places[one] != station and any(pods[one].get(sku, 0) for sku in skus)
        ]
        assert not found.any()


@given(held=shelves(), skus=some_skus, asked=st.lists(st.integers(0, N_PODS - 1), unique=True))
def test_items_are_told_by_pod_and_sku(held: Any, skus: list[int], asked: list[int]) -> None:
    """None of a SKU that a pod does not hold."""
    pods, (by_sku, first, pod, _, items) = held
    row = np.full(N_PODS, -1)
    found = items_on(np.array(asked, np.int64), np.array(skus), by_sku, first, pod, items, row)
    assert found.tolist() == [[pods[one].get(sku, 0) for sku in skus] for one in asked]
    assert (row == -1).all()


@given(
    held=shelves(),
    wanted=st.dictionaries(st.integers(0, N_SKUS - 1), st.integers(1, 3)),
    there=st.lists(st.booleans(), min_size=N_PODS, max_size=N_PODS),
)
def test_pods_with_most_of_what_is_wanted_are_found(held: Any, wanted: dict[int, int], there: list[bool]) -> None:
    """Each once, of those that are there; none where none has any, and nothing is left behind for the next call."""
    pods, (by_sku, first, pod, _, items) = held
    sums = np.zeros(N_PODS, np.int64)
    skus, numbers = (np.array(list(of), np.int64) for of in (wanted.keys(), wanted.values()))
    ids = with_most(skus, numbers, by_sku, first, pod, items, np.array(there, np.int64), 1, sums)
    has = [sum(min(wanted[sku], pods[one].get(sku, 0)) for sku in wanted) * there[one] for one in range(N_PODS)]
    assert sorted(ids.tolist()) == [one for one in range(N_PODS) if has[one] == max(has) > 0]
    assert not sums.any()


@given(values=st.lists(st.integers(0, 3), min_size=N_PODS, max_size=N_PODS), data=st.data())
def test_the_highest_are_all_that_no_other_exceeds(values: list[int], data: st.DataObject) -> None:
    """Of the pods that are asked about, in their order."""
    asked = data.draw(st.lists(st.integers(0, N_PODS - 1), unique=True, min_size=1))
    most = max(values[one] for one in asked)
    assert highest(np.array(asked), np.array(values)).tolist() == [one for one in asked if values[one] == most]


@given(held=shelves(), data=st.data())
def test_sums_are_those_made_anew(held: Any, data: st.DataObject) -> None:
    """However items and what is wanted change."""
    _, (by_sku, first, pod, sku, items) = held
    known, known_wanted, sums = np.zeros_like(items), np.zeros(N_SKUS, np.int64), np.zeros(N_PODS, np.int64)
    entries = np.arange(len(items))
    for _ in range(3):
        wanted = np.array(data.draw(st.lists(st.integers(0, 3), min_size=N_SKUS, max_size=N_SKUS)))
        change_sums(entries, items[entries], wanted, by_sku, first, pod, sku, known, known_wanted, sums)
        anew = np.bincount(pod, weights=np.minimum(items, wanted[sku]), minlength=N_PODS)
        assert sums.tolist() == anew.tolist()
        entries = np.array(data.draw(st.lists(st.sampled_from(range(len(items))))) if len(items) else [], np.int64)
        items[entries] = data.draw(st.integers(0, 4))
