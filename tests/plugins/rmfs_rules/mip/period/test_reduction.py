"""What a period is reduced to: nothing that an optimum needs gets lost, and what is interchangeable is counted."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from rmfs_rules.mip.period.period import Period, Stock
from rmfs_rules.mip.period.reduction import Reduced, highest, masks_of, sums_of
from rmfs_rules.mip.period.solution import Model


@pytest.mark.parametrize("model", Model)
def test_types_count_the_orders(periods: list[Period], model: Model) -> None:
    """Every order that can be assigned is of one type, which has its lines; a type's orders are oldest first."""
    for period in periods[:100]:
        reduced = Reduced(period, model)
        assert sorted(order for kind in reduced.types for order in kind.orders) == list(reduced.orders)
        for kind in reduced.types:
            assert list(kind.orders) == sorted(kind.orders)
            assert all(reduced.lines_of(order) == kind.lines for order in kind.orders)
            assert kind.size == sum(quantity for _, quantity in kind.lines)
        assert all(len(kind.orders) == 1 for kind in Reduced(period, model, counted=False).types)


def test_what_no_station_can_take_is_left_out() -> None:
    """An order of three items, stations of two places: integrated drops it, the split models do not."""
    lines = np.array([[0, 0, 1], [0, 1, 1], [0, 2, 1], [1, 3, 1]]).T
    period = Period(Stock((0,), ((0, 1, 2),), 4), (0, 1), (2, 2), ((), ()), (0, 1), *lines)
    assert Reduced(period, Model.INTEGRATED).orders == ()
    assert Reduced(period, Model.SPLIT_AMONG_STATIONS).orders == (0,)  # order 1 wants what no pod has
    assert Reduced(period, Model.SPLIT_OVER_TIME).orders == (0,)
    assert not Reduced(period, Model.INTEGRATED).candidates.any()


def test_every_pod_is_within_one_that_is_kept(periods: list[Period]) -> None:
    """A pod left out brings nothing that a kept one, worth as much, does not bring; no kept one is within another."""
    rng = np.random.default_rng(1)
    for period in periods[:100]:
        reduced = Reduced(period, Model.SPLIT_OVER_TIME)
        wanted, value = rng.random(period.stock.n_skus) < 0.7, rng.integers(0, 2, len(period.stock.pods)).astype(float)
        brings = [{i for i in skus if wanted[i]} for skus in period.stock.contents]
        kept = reduced.classes(wanted, value)
        for pod, skus in enumerate(brings):
            assert not skus or any(skus <= brings[one] and value[pod] <= value[one] for one in kept)
        for pod in kept:
            assert not any(
                brings[pod] <= brings[other] and value[pod] <= value[other] for other in kept if other != pod
            )


def test_reachable_places(periods: list[Period]) -> None:
    """At each station, the most items of any orders that fit together; for split-among-stations, over all stations."""
    for period in periods[:100]:
        whole, among = (Reduced(period, model) for model in (Model.INTEGRATED, Model.SPLIT_AMONG_STATIONS))
        assert whole.reachable == tuple(_most(whole, room) for room in period.capacities)
        assert among.reachable == period.capacities
        assert among.reachable_sum == _most(among, sum(period.capacities))


def _most(reduced: Reduced, room: int) -> int:
    """Try every choice of orders."""
    sizes = [kind.size for kind in reduced.types for _ in kind.orders]
    sums = [sum(chosen) for n in range(len(sizes) + 1) for chosen in combinations(sizes, n)]
    return max(items for items in sums if items <= room)


def test_sums_as_bits() -> None:
    """Bit n says that some of the sizes add up to n."""
    assert sums_of([2, 3], 10) == 0b101101
    assert sums_of([2, 3], 4) == 0b1101
    assert highest(0b101101, 4) == 3
    assert highest(0b101101, 5) == 5


def test_masks() -> None:
    """Bit s says that station s covers the SKU."""
    assert masks_of(np.array([[True, False, True], [False, False, True]])).tolist() == [1, 0, 3]
