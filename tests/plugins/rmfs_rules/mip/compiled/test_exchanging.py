"""Sets of pods that are found by exchanging pods, against trying all sets."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from rmfs_rules.mip.compiled.arrays import Arrays, arrays_of
from rmfs_rules.mip.compiled.exchanging import completed, exchanged
from rmfs_rules.mip.period.reduction import Reduced
from rmfs_rules.mip.period.solution import Model


@pytest.fixture(name="made", scope="module", params=range(40))
def made_fixture(request, random_period, splitting_period) -> tuple[Arrays, int]:
    """Return a period as arrays, and its number of pods."""
    period = splitting_period(request.param, 9, 2, 9) if request.param % 2 else random_period(request.param)
    arrays, pods = arrays_of(Reduced(period, Model.SPLIT_AMONG_STATIONS))
    return arrays, len(pods)


def _completed(arrays: Arrays, pods: tuple[int, ...]) -> int:
    there = {sku for sku, mask in enumerate(arrays.at_hand.tolist()) if mask}
    for pod in pods:
        there.update(arrays.pod_sku[arrays.pod_start[pod] : arrays.pod_start[pod + 1]].tolist())
    lines = [slice(*span) for span in zip(arrays.order_start, arrays.order_start[1:], strict=False)]
    return sum(int(arrays.line_items[at].sum()) for at in lines if there.issuperset(arrays.line_sku[at].tolist()))


def test_the_best_set_is_found_where_there_are_few(made):
    """With many exchanges the set completes as much as the best of all sets, and as much as is said."""
    arrays, n = made
    for number in range(n + 1):
        pods, items = exchanged(arrays, number, 2000, 1)
        assert len(set(pods.tolist())) == number
        assert items == completed(arrays, pods, np.zeros(len(arrays.at_hand), np.bool_))
        assert items == _completed(arrays, tuple(pods.tolist()))
        assert items == max(_completed(arrays, chosen) for chosen in combinations(range(n), number))


def test_the_same_seed_finds_the_same_set(made):
    """Nothing but the seed decides what is tried; without a step, the first pods are returned."""
    arrays, n = made
    once, again = (exchanged(arrays, n // 2, 50, 3) for _ in range(2))
    assert once[0].tolist() == again[0].tolist()
    assert exchanged(arrays, n // 2, 0, 3)[0].tolist() == list(range(n // 2))
