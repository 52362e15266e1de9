"""Placing lines one by one, against trying everything."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rmfs_rules.mip.period.placing import Places

rooms = st.lists(st.integers(0, 3), min_size=1, max_size=3)


def _most(capacities: list[int], masks: list[int]) -> int:
    """Return how many lines any assignment places."""
    best = 0
    for choice in product(range(-1, len(capacities)), repeat=len(masks)):
        allowed = all(at < 0 or mask >> at & 1 for at, mask in zip(choice, masks, strict=True))
        if allowed and all(choice.count(station) <= room for station, room in enumerate(capacities)):
            best = max(best, sum(at >= 0 for at in choice))
    return best


@given(rooms, st.lists(st.integers(0, 7), max_size=5))
def test_one_by_one_is_the_most(capacities: list[int], masks: list[int]) -> None:
    """As many lines find a place as in any assignment, and each stands where its kind is covered."""
    masks = [mask & ((1 << len(capacities)) - 1) for mask in masks]
    places = Places(capacities)
    placed = [mask for mask in masks if places.add(mask)]
    assert len(placed) == _most(capacities, masks)
    stations = [places.take(mask, ()) for mask in placed]
    assert all(mask >> station & 1 for mask, station in zip(placed, stations, strict=True))
    assert (np.bincount(stations, minlength=len(capacities)) <= capacities).all()


def test_all_lines_of_an_order_or_none() -> None:
    """Where one line finds no place, the others give theirs back."""
    places = Places([1, 1])
    assert not places.add_all([1, 1])
    assert places.free == [1, 1]
    assert places.add_all([3, 1])
    assert places.free == [0, 0]


def test_a_preferred_station_goes_first() -> None:
    """Lines of a kind are interchangeable, so any station where some stand may be named; then they are used up."""
    places = Places([1, 1])
    assert places.add(3)
    assert places.add(3)
    assert places.take(3, [1]) == 1
    assert places.take(3, [1]) == 0
    with pytest.raises(ValueError, match="no line of this kind"):
        places.take(3, [1])
