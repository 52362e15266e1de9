"""The search for sets of pods that complete orders, and its bound, against trying all sets."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rmfs_rules.mip.compiled.arrays import Arrays, arrays_of
from rmfs_rules.mip.compiled.pod_sets import next_set, potentials, sets_of
from rmfs_rules.mip.period.reduction import Reduced
from rmfs_rules.mip.period.solution import Model

ENDLESS = 10**9
seeds = st.integers(0, 10**6)


@pytest.fixture(name="arrays_from", scope="module")
def arrays_from_fixture(random_period):
    """Return a function from a seed to a random period as arrays, its number of pods, and a worth for each order.

    Half of them are searched with the sharper bound that large periods have.
    """

    def make(seed: int) -> tuple[Arrays, int, np.ndarray]:
        arrays, pods = arrays_of(Reduced(random_period(seed), Model.SPLIT_AMONG_STATIONS))
        rng = np.random.default_rng(seed)
        worth = rng.uniform(-0.5, 3, len(arrays.order_start) - 1)
        return arrays._replace(sharp=bool(rng.integers(2))), len(pods), worth

    return make


def _there(arrays: Arrays, pods: tuple[int, ...]) -> np.ndarray:
    """Return the SKUs that are at hand or on these pods."""
    there = arrays.at_hand > 0
    for pod in pods:
        there[arrays.pod_sku[arrays.pod_start[pod] : arrays.pod_start[pod + 1]]] = True
    return there


def _value(arrays: Arrays, worth: np.ndarray, pods: tuple[int, ...]) -> float:
    """Return the worth of the orders that the pods complete."""
    there = _there(arrays, pods)
    lines = [
        arrays.line_sku[first:last] for first, last in zip(arrays.order_start, arrays.order_start[1:], strict=False)
    ]
    return sum(max(w, 0.0) for w, skus in zip(worth, lines, strict=True) if there[skus].all())


@given(seed=seeds)
@settings(max_examples=200, deadline=None)
def test_potentials_bound_what_pods_complete(arrays_from, seed):
    """No set of pods completes more than the sum of their potentials, whichever pods went before."""
    arrays, n, worth = arrays_from(seed)
    for before in [(), *((pod,) for pod in range(n))]:
        rest = np.array([pod for pod in range(n) if pod not in before], dtype=np.int64)
        base = _value(arrays, worth, before)
        for more in range(1, len(rest) + 1):
            bound = dict(zip(rest.tolist(), potentials(arrays, worth, rest, _there(arrays, before), more), strict=True))
            for chosen in combinations(rest.tolist(), more):
                gain = _value(arrays, worth, (*before, *chosen)) - base
                assert gain <= sum(bound[pod] for pod in chosen) + 1e-9
                assert more > 1 or gain == pytest.approx(bound[chosen[0]])


@given(seed=seeds, share=st.floats(0, 1))
@settings(max_examples=200, deadline=None)
def test_every_set_is_found_once(arrays_from, seed, share):
    """The search names exactly the sets that complete enough."""
    arrays, n, worth = arrays_from(seed)
    for number in range(n + 1):
        values = {chosen: _value(arrays, worth, chosen) for chosen in combinations(range(n), number)}
        least = share * max(values.values()) + 1e-3
        search = sets_of(arrays, number, worth, least)
        found = []
        while next_set(arrays, search, np.zeros(1, np.int64), ENDLESS):
            found.append(tuple(sorted(search.chosen.tolist())))
        assert sorted(found) == sorted(chosen for chosen, value in values.items() if value >= least)


@given(seed=seeds, share=st.floats(0, 1))
@settings(max_examples=100, deadline=None)
def test_the_goal_may_rise(arrays_from, seed, share):
    """Raised to what was found, the search ends with the set that completes most."""
    arrays, n, worth = arrays_from(seed)
    number = int(share * n)
    best = max(_value(arrays, worth, chosen) for chosen in combinations(range(n), number))
    search = sets_of(arrays, number, worth, 0.0)
    last = -1.0
    while next_set(arrays, search, np.zeros(1, np.int64), ENDLESS):
        last = search.value[number]
        search.least[0] = last + 1e-3
    assert last == pytest.approx(best, abs=2e-3)


@given(seed=seeds)
@settings(max_examples=50, deadline=None)
def test_it_gives_up_when_told(arrays_from, seed):
    """With no steps left there is no further set, and the count of steps says so."""
    arrays, n, worth = arrays_from(seed)
    if n:
        work = np.zeros(1, np.int64)
        search = sets_of(arrays, 1, worth, 0.0)
        sets = sum(1 for _ in iter(lambda: next_set(arrays, search, work, 0), False))
        assert work[0] > 0
        assert sets <= 1
