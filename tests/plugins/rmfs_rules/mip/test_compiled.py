"""The compiled searches: sets of pods, the stations that they go to, the orders there; against trying everything."""

from collections.abc import Iterator, Sequence
from itertools import combinations, product
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mip_periods import choices, new_splits, random_period, splitting_period
from rmfs_rules.mip import Integrated
from rmfs_rules.mip.compiled import warm_up
from rmfs_rules.mip.compiled.arrays import Arrays, arrays_of
from rmfs_rules.mip.compiled.exchanging import completed, exchanged
from rmfs_rules.mip.compiled.pod_sets import next_set, sets_of
from rmfs_rules.mip.compiled.spreading import FOUND, next_that_fills, sets_that_fill, spread, too_few_splits
from rmfs_rules.mip.compiled.stacking import fill, fill_with_few_splits, newly_split
from rmfs_rules.mip.period.period import Period
from rmfs_rules.mip.period.reduction import Reduced, masks_of
from rmfs_rules.mip.period.solution import Model
from rmfs_rules.mip.printed.solver import Limits
from rmfs_rules.mip.proof.steps import proof_of

AMONG = Model.SPLIT_AMONG_STATIONS
WHOLE = (Model.INTEGRATED, AMONG)
ENDLESS = 10**9
seeds = st.integers(0, 10**6)


def no_work() -> np.ndarray:
    return np.zeros(1, np.int64)


def there_with(arrays: Arrays, pods: Sequence[int]) -> np.ndarray:
    there = arrays.at_hand > 0
    for pod in pods:
        there[arrays.pod_sku[arrays.pod_start[pod] : arrays.pod_start[pod + 1]]] = True
    return there


def value_of(arrays: Arrays, worth: np.ndarray, pods: Sequence[int]) -> float:
    there = there_with(arrays, pods)
    lines = [arrays.line_sku[slice(*span)] for span in zip(arrays.order_start, arrays.order_start[1:], strict=False)]
    return sum(max(w, 0.0) for w, skus in zip(worth, lines, strict=True) if there[skus].all())


@pytest.fixture(name="arrays_from", scope="module")
def arrays_from_fixture():
    """Return a function from a seed to a random period as arrays, its number of pods, and a worth for each order.

    Half of them are searched with the sharper bound that large periods have.
    """

    def make(seed: int) -> tuple[Arrays, int, np.ndarray]:
        arrays, pods = arrays_of(Reduced(random_period(seed), AMONG))
        rng = np.random.default_rng(seed)
        worth = rng.uniform(-0.5, 3, len(arrays.order_start) - 1)
        return arrays._replace(sharp=bool(rng.integers(2))), len(pods), worth

    return make


@given(seed=seeds, share=st.floats(0, 1))
@settings(max_examples=200, deadline=None)
def test_every_set_is_found_once(arrays_from, seed, share):
    """The search names exactly the sets that complete enough."""
    arrays, n, worth = arrays_from(seed)
    for number in range(n + 1):
        values = {chosen: value_of(arrays, worth, chosen) for chosen in combinations(range(n), number)}
        least = share * max(values.values()) + 1e-3
        search = sets_of(arrays, number, worth, least)
        found = []
        while next_set(arrays, search, no_work(), ENDLESS):
            found.append(tuple(sorted(search.chosen.tolist())))
        assert sorted(found) == sorted(chosen for chosen, value in values.items() if value >= least)


@given(seed=seeds, share=st.floats(0, 1))
@settings(max_examples=100, deadline=None)
def test_the_goal_may_rise(arrays_from, seed, share):
    """Raised to what was found, the search ends with the set that completes most."""
    arrays, n, worth = arrays_from(seed)
    number = int(share * n)
    best = max(value_of(arrays, worth, chosen) for chosen in combinations(range(n), number))
    search = sets_of(arrays, number, worth, 0.0)
    last = -1.0
    while next_set(arrays, search, no_work(), ENDLESS):
        last = search.value[number]
        search.least[0] = last + 1e-3
    assert last == pytest.approx(best, abs=2e-3)


@given(seed=seeds)
@settings(max_examples=50, deadline=None)
def test_it_gives_up_when_told(arrays_from, seed):
    """With no steps left there is no further set, and the count of steps says so."""
    arrays, n, worth = arrays_from(seed)
    if n:
        work, search = no_work(), sets_of(arrays, 1, worth, 0.0)
        assert sum(1 for _ in iter(lambda: next_set(arrays, search, work, 0), False)) <= 1
        assert work[0] > 0


@pytest.mark.parametrize("seed", range(40))
def test_sets_that_are_found_by_exchanging(seed):
    """Many exchanges find the best of all sets; the seed alone decides; without one, the first pods are returned."""
    period = splitting_period(seed, 9, 2, 9) if seed % 2 else random_period(seed)
    arrays, pods = arrays_of(Reduced(period, AMONG))
    n, items_of = len(pods), arrays.items.astype(float)
    for number in range(n + 1):
        found, items = exchanged(arrays, number, 2000, 1)
        assert len(set(found.tolist())) == number
        assert items == completed(arrays, found, np.zeros(len(arrays.at_hand), np.bool_))
        assert items == value_of(arrays, items_of, found.tolist())
        assert items == max(value_of(arrays, items_of, chosen) for chosen in combinations(range(n), number))
    once, again = (exchanged(arrays, n // 2, 50, 3)[0].tolist() for _ in range(2))
    assert once == again
    assert exchanged(arrays, n // 2, 0, 3)[0].tolist() == list(range(n // 2))


def masks_with(arrays: Arrays, visits: Sequence[tuple[int, int]]) -> np.ndarray:
    mask = arrays.at_hand.copy()
    for pod, station in visits:
        mask[arrays.pod_sku[arrays.pod_start[pod] : arrays.pod_start[pod + 1]]] |= 1 << station
    return mask


def fewest_found(arrays: Arrays, target: int) -> int | None:
    """Return the least number of visits (up to two) with which the search fills the target."""
    for visits in range(3):
        for number in range(min(visits, 1), visits + 1):
            sets = sets_that_fill(arrays, number, target)
            found, chosen, masks, _ = next_that_fills(arrays, sets, -1, visits, target, no_work(), ENDLESS)
            if found == FOUND:
                sent = [(p, s) for p, mask in zip(chosen, masks, strict=True) for s in range(8) if mask >> s & 1]
                assert len(sent) == visits
                assert fill(arrays, masks_with(arrays, sent), target)[0]
                return visits
    return None


@pytest.mark.parametrize("model", WHOLE)
def test_pods_that_fill_are_the_fewest(all_periods, model):
    """The least number of visits, if it is up to two, is that of trying all of them, for every number of slots."""
    seen = set()
    for period in all_periods[::2]:
        reduced = Reduced(period, model)
        if not reduced.candidates.any():
            continue
        arrays, pods = arrays_of(reduced)
        pairs = list(product(range(len(pods)), range(len(period.stations))))
        fillings = [[masks_with(arrays, chosen) for chosen in combinations(pairs, visits)] for visits in range(3)]
        for target in range(1, reduced.reachable_sum + 1):
            enough = [any(fill(arrays, mask, target)[0] for mask in masks) for masks in fillings]
            least = enough.index(True) if any(enough) else None
            assert least == fewest_found(arrays, target)
            seen.add(least)
    assert seen == {None, 0, 1, 2}


@pytest.mark.parametrize("splits", [None, 0, 1])
def test_symmetry_loses_nothing(all_periods, small_periods, splits):
    """Of interchangeable stations only one sequence is tried; that finds stations for a set of pods all the same."""
    found = 0
    for period in small_periods if splits is not None else all_periods[300:]:
        reduced = Reduced(period, AMONG)
        if not reduced.candidates.any() or len(period.stations) == 1:
            continue
        arrays, pods = arrays_of(reduced, splits)
        assert arrays.alike or splits is not None
        for number, visits in ((1, 1), (1, 2), (2, 2), (2, 3)) if arrays.alike else ():
            for chosen, target in product(combinations(range(len(pods)), number), (1, reduced.reachable_sum)):
                args = (np.array(chosen), visits, target, no_work(), ENDLESS)
                answer = spread(arrays, *args)[0]
                assert answer == spread(arrays._replace(alike=False), *args)[0]
                found += answer
    assert found > 50


def assignments(period: Period, there: np.ndarray, model: Model, choices) -> Iterator[tuple[tuple, int]]:
    """Yield each assignment whose SKUs are there and that fits, with its items."""
    for choice in product(*(list(choices(lines, len(period.stations), model)) for lines in period.lines)):
        items, covered = [0] * len(period.stations), True
        for lines, where in zip(period.lines, choice, strict=True):
            for (sku, quantity), station in zip(lines, where, strict=True):
                if station is not None:
                    items[station] += quantity
                    covered &= bool(there[station][sku])
        if covered and all(n <= room for n, room in zip(items, period.capacities, strict=True)):
            yield choice, sum(items)


def check_filling(period: Period, orders: np.ndarray, number: int) -> None:
    taken = [sum(int(packed) >> (8 * s) & 255 for _, packed in orders) for s in range(len(period.stations))]
    assert sum(taken) == number
    assert all(n <= room for n, room in zip(taken, period.capacities, strict=True))
    assert len({order for order, _ in orders.tolist()}) == len(orders)


@pytest.mark.parametrize("model", WHOLE)
def test_fill_finds_the_most(all_periods, model):
    """It fills as many slots as any assignment to what is at the stations, and not one more."""
    tried = 0
    for period in all_periods:
        reduced = Reduced(period, model)
        if (len(period.stations) + 1) ** len(period.line_sku) > 3000 or not reduced.candidates.any():
            continue
        arrays, _ = arrays_of(reduced)
        most = max(items for _, items in assignments(period, period.covered, model, choices))
        found, orders = fill(arrays, masks_of(period.covered), most)
        assert found
        check_filling(period, orders, most)
        assert not fill(arrays, masks_of(period.covered), most + 1)[0]
        tried += most > 0
    assert tried > 50


def test_fill_finds_the_most_with_few_splits(small_periods):
    """It fills as many slots as any assignment with so few new splits, not one more, and the cut forbids none."""
    mattered = cut = 0
    rng = np.random.default_rng(1)
    for period in small_periods:
        there = (rng.random(period.covered.shape) < 0.6) & period.stocked
        reduced, masks = Reduced(period, AMONG), masks_of(there)
        most = [0, 0, 0]
        for choice, items in assignments(period, there, AMONG, choices):
            for splits in range(new_splits(period, choice), 3):
                most[splits] = max(most[splits], items)
        for splits, number in enumerate(most):
            arrays, _ = arrays_of(reduced, splits)
            spans = [slice(*span) for span in zip(arrays.order_start, arrays.order_start[1:], strict=False)]
            served = np.flatnonzero([masks[arrays.line_sku[at]].all() for at in spans])
            found, orders = fill_with_few_splits(arrays, masks, number, no_work())
            assert found
            check_filling(period, orders, number)
            assert newly_split(arrays, orders) <= splits
            assert not fill_with_few_splits(arrays, masks, number + 1, no_work())[0]
            assert not too_few_splits(arrays, served, masks, number)
            mattered += fill(arrays, masks, number + 1)[0]
            cut += too_few_splits(arrays, served, masks, number + 1)
    assert mattered > 50
    assert cut > 50


def test_what_is_loaded_is_what_periods_need(periods):
    """After loading, no period has anything left to compile: its arguments have the types that were loaded."""
    warm_up.load()
    loaded = [search.signatures for search in warm_up.searches()]
    assert all(loaded)
    for period in (*periods[:20], *(splitting_period(seed, 7, 3, 9) for seed in range(3))):
        for model in Model:
            proof_of(period, model, 2, Limits(), None).run()
            proof_of(period, model, 2, Limits(), 1).run()
    assert [search.signatures for search in warm_up.searches()] == loaded


def test_a_rule_loads_them(monkeypatch):
    """Once, and not for the printed form, which has no searches."""
    calls = []
    monkeypatch.setattr(warm_up, "load", lambda: calls.append("loaded"))
    monkeypatch.setattr(warm_up, "searches", lambda: (SimpleNamespace(signatures=[]),))
    Integrated(formulation="paper").prepare(None)
    assert calls == []
    Integrated().prepare(None)
    assert calls == ["loaded"]
    monkeypatch.setattr(warm_up, "searches", lambda: (SimpleNamespace(signatures=["some"]),))
    Integrated().prepare(None)
    assert calls == ["loaded"]
