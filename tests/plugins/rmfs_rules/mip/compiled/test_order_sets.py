"""Sets of orders for a station, the pods that serve them, and the choice of a set for each station: by brute force."""

from __future__ import annotations

from itertools import combinations, combinations_with_replacement, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rmfs_rules.mip.compiled.order_sets import (
    MOST_BITS,
    Kinds,
    cheapest_sets,
    choose,
    fewest_pods,
    kinds_of,
    least_pods,
)

ENDLESS = 10**9
seeds = st.integers(0, 10**6)


def made(seed: int, more: int = 0) -> tuple[Kinds, list[list[int]], list[list[int]]]:
    """Return a few types of orders and pods as bits, what each type misses, and what each pod has.

    The first type may want more SKUs, which are on the first pod alone.
    """
    rng = np.random.default_rng(seed)
    skus = np.sort(rng.choice(1000, 7, replace=False)).tolist()
    types, pods = int(rng.integers(1, 5)), int(rng.integers(1, 7))
    missing = [sorted(rng.choice(skus, rng.integers(0, 4), replace=False).tolist()) for _ in range(types)]
    held = [sorted(rng.choice(skus, rng.integers(1, 4), replace=False).tolist()) for _ in range(pods)]
    sizes = np.array([max(len(m), 1) + int(rng.integers(2)) for m in missing], dtype=np.int64)
    for wanted in missing[0], held[0]:
        wanted.extend(range(1000, 1000 + more))
    return kinds_of(sizes, rng.integers(1, 4, types), missing, held), missing, held


def fewest(held: list[list[int]], skus: set[int]) -> float:
    """Return how many pods it takes at least to have all SKUs, by trying all sets."""
    return min(
        (
            len(c)
            for n in range(len(held) + 1)
            for c in combinations(held, n)
            if skus.issubset({i for p in c for i in p})
        ),
        default=float("inf"),
    )


def bits_of(kinds: Kinds, types: tuple[int, ...]) -> np.ndarray:
    """Return the SKUs that some types miss, as bits."""
    return np.bitwise_or.reduce(kinds.needs[list(types)], axis=0, initial=0)


@pytest.mark.parametrize("more", [0, MOST_BITS])
@given(seed=seeds)
@settings(max_examples=100, deadline=None)
def test_the_fewest_pods_are_those_of_brute_force(more, seed):
    """As many as trying all sets says, which have all SKUs, and never fewer than the bound; with one number or two."""
    kinds, missing, held = made(seed, more)
    work, room = np.zeros(1, np.int64), np.zeros(200, np.int64)
    for number in range(len(missing) + 1):
        for types in combinations(range(len(missing)), number):
            skus = {i for t in types for i in missing[t]}
            truth = fewest(held, skus)
            bits = bits_of(kinds, types)
            rest = np.zeros_like(bits)
            assert min(least_pods(kinds, bits, len(held), room, rest), len(held) + 1) <= truth
            count, pods = fewest_pods(kinds, bits, 0, len(held), work, ENDLESS)
            assert count == min(truth, len(held) + 1)
            if truth < float("inf"):
                assert skus.issubset({i for p in pods.tolist() for i in held[p]})


@given(seed=seeds, limit=st.floats(0.5, 9.0))
@settings(max_examples=200, deadline=None)
def test_every_set_below_the_limit_is_found_once(seed, limit):
    """The sets and their costs are those of trying every number of orders of each type."""
    kinds, missing, held = made(seed)
    prices, room = np.random.default_rng(seed).uniform(0, 1, len(missing)), 4
    truth = {}
    for numbers in product(*(range(n + 1) for n in kinds.counts.tolist())):
        free = room - int(np.dot(numbers, kinds.sizes))
        cost = fewest(held, {i for t, n in enumerate(numbers) if n for i in missing[t]})
        cost += float(np.dot(numbers, prices)) + 2 * free
        if free >= 0 and cost < limit - 1e-5:
            truth[numbers] = cost
    costs, sets = cheapest_sets(kinds, prices, room, 2.0, limit, 1000, np.zeros(1, np.int64), ENDLESS)
    found = dict(zip(map(tuple, sets.tolist()), costs.tolist(), strict=True))
    assert len(found) == len(costs)
    assert {numbers for numbers, cost in found.items() if cost < limit - 1e-5} == set(truth)
    assert all(found[numbers] == pytest.approx(cost) for numbers, cost in truth.items())
    few, _ = cheapest_sets(kinds, prices, room, 2.0, limit, 3, np.zeros(1, np.int64), ENDLESS)
    assert sorted(few.tolist()) == pytest.approx(sorted(costs.tolist())[:3], abs=1e-5)


def test_it_gives_up_when_told():
    """With no steps left the search ends, and the count of steps says so."""
    kinds, missing, _ = made(1)
    work = np.zeros(1, np.int64)
    cheapest_sets(kinds, np.zeros(len(missing)), 4, 2.0, 9.0, 10, work, -1)
    assert work[0] > -1
    one = np.ones(1, np.int64)  # order of twelve SKUs; each pod has the first one and another
    hard = kinds_of(12 * one, one, [list(range(12))], [[0, sku] for sku in range(1, 12) for _ in range(3)])
    work[0] = 0
    count, _ = fewest_pods(hard, bits_of(hard, (0,)), 0, 12, work, 100)
    assert (count, int(work[0])) == (13, 101)
    sets = np.zeros((1, len(missing)), np.int64)
    assert not len(choose(np.zeros(1), sets, np.zeros(len(missing)), kinds.counts, 2, 1.0, work, -1))


@given(seed=seeds, most=st.floats(0.0, 3.0))
@settings(max_examples=300, deadline=None)
def test_a_choice_is_found_if_there_is_one(seed, most):
    """A set for each station, no order twice, sets and orders left not too dear: as trying all choices says."""
    rng = np.random.default_rng(seed)
    types, sets, stations = int(rng.integers(1, 4)), int(rng.integers(1, 8)), int(rng.integers(1, 4))
    counts = rng.integers(1, 4, types)
    numbers, costs = rng.integers(0, 3, (sets, types)), np.sort(np.round(rng.uniform(0, 1.5, sets), 2))
    prices = np.round(rng.uniform(0, 1, types), 2) * rng.integers(0, 2, types)

    def total(chosen: tuple[int, ...]) -> float:
        left = counts - numbers[list(chosen)].sum(axis=0)
        return float("inf") if (left < 0).any() else float(costs[list(chosen)].sum() + left @ prices)

    truth = min(total(chosen) for chosen in combinations_with_replacement(range(sets), stations))
    found = choose(costs, numbers, prices, counts, stations, most, np.zeros(1, np.int64), ENDLESS)
    if abs(truth - most) > 1e-5:
        assert (len(found) > 0) == (truth < most)
    if len(found):
        assert len(found) == stations
        assert total(tuple(found.tolist())) <= most + 1e-5
