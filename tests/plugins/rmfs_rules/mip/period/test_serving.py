"""Which pod serves what: by flows, against the condition that no group of stations wants more than its pods have."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from rmfs_rules.mip.period.period import Period, Stock
from rmfs_rules.mip.period.serving import PlacesFromStock, short_of, stations_of
from rmfs_rules.mip.period.solution import Part


def _short(period, visits, parts):
    """Return the SKUs of which some group of stations wants more than the pods at one of them have."""
    at, short = stations_of(period, visits), set()
    for group in product((False, True), repeat=len(period.stations)):
        for sku in range(period.stock.n_skus):
            lines = [(part, dict(period.lines_of(part.order))) for part in parts if sku in part.skus]
            wanted = sum(lines_of[sku] for part, lines_of in lines if group[part.station])
            have = sum(
                period.stock.items.on(pod).get(sku, 0)
                for pod, stations in at.items()
                if any(group[s] for s in stations)
            )
            if wanted > have:
                short.add(sku)
    return short


def test_what_is_short(scarce_periods):
    """A SKU is named exactly when some group of stations lacks items of it; the lowest of them."""
    rng = np.random.default_rng(2)
    named = 0
    for period in scarce_periods * 3:
        pairs = list(product(range(len(period.stock.pods)), range(len(period.stations))))
        visits = tuple(pair for pair in pairs if rng.random() < 0.5)
        parts = tuple(
            Part(order, int(rng.integers(len(period.stations))), (sku,))
            for order, lines in enumerate(period.lines)
            for sku, _ in lines
            if rng.random() < 0.4
        )
        short = _short(period, visits, parts)
        assert short_of(period, visits, parts) == min(short, default=None)
        named += bool(short)
    assert 30 < named < 150


def test_unlimited_stock_is_never_short(random_period):
    """There is nothing to count."""
    assert short_of(random_period(0), (), (Part(0, 0, (0,)),)) is None


@pytest.fixture
def shared() -> Period:
    """Return a pod with one item of SKU 0 at two stations of one place, and another with one at the first alone."""
    lines = np.array([[0, 0, 1], [1, 0, 1], [2, 0, 1]]).T
    return Period(Stock.counted([{0: 1}, {0: 1}], 1), (0, 1), (1, 1), ((0, 1), (0,)), (0, 1, 2), *lines)


def test_an_item_moves_to_another_pod(shared):
    """The second item finds its place only by moving the first; a third finds none, and nothing changes."""
    places = PlacesFromStock(shared, ())
    assert places.add(0)
    assert places.add_all([0])
    assert not places.add(0)
    assert not places.add_all([0])
    assert {places.take(0, ()), places.take(0, ())} == {0, 1}
    with pytest.raises(ValueError, match="no item"):
        places.take(0, ())


def test_all_or_nothing(shared):
    """Where not all lines of an order find places, none is taken."""
    places = PlacesFromStock(shared, ())
    assert not places.add_all([0, 0, 0])
    assert places.free == [1, 1]
    assert places.add_all([0, 0])
    assert places.free == [0, 0]
