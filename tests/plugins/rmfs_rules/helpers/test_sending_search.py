"""Compiled looks at what pods hold, against plain ones."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import BUSY, STORED, WarehouseView
from rmfs_rules.helpers.sending_search import held as held_by
from rmfs_rules.helpers.sending_search import servers, worth

SKUS = "abcd"
pods = st.lists(st.dictionaries(st.sampled_from(SKUS), st.integers(0, 3)), min_size=1, max_size=6)


@given(pods, st.sets(st.integers(0, 3)), st.booleans(), st.data())
def test_pods_that_serve_are_found_by_id(
    held: list[dict[str, int]], skus: set[int], fetch: bool, data: st.DataObject
) -> None:
    """Each once, with an item of one of the SKUs, where it may leave from, and not from the station itself."""
    world = small_world({"1": [*SKUS]}, {str(i): pod for i, pod in enumerate(held)})
    at = np.array([data.draw(st.sampled_from([STORED, BUSY, 0, 1])) for _ in held])
    found = servers(WarehouseView(world).stock, at, np.array([*skus], np.int64), 0, fetch)
    assert found.tolist() == [
        pod.id
        for pod in world.pods
        if any(pod.free_items(sku) > 0 for sku in skus) and (at[pod.id] == 1 or (fetch and at[pod.id] == STORED))
    ]


@given(pods, st.lists(st.integers(0, 4), min_size=4, max_size=4))
def test_pods_are_worth_what_is_wanted_of_them(held: list[dict[str, int]], wanted: list[int]) -> None:
    """The sum over its SKUs of min(free items, items wanted), of each of some pods."""
    world = small_world({"1": [*SKUS]}, {str(i): pod for i, pod in enumerate(held)})
    some = np.arange(len(held))[::-1]
    sums = [sum(min(wanted[sku], pod.free_items(sku)) for sku in pod.contents) for pod in reversed(world.pods)]
    assert worth(WarehouseView(world).stock, some, np.array(wanted)).tolist() == sums


@given(pods, st.lists(st.integers(0, 4), min_size=4, max_size=4))
def test_values_of_what_pods_have_free_are_summed(given: list[dict[str, int]], values: list[int]) -> None:
    """Each SKU once, whatever number of items there is."""
    world = small_world({"1": [*SKUS]}, {str(i): pod for i, pod in enumerate(given)})
    sums = [sum(values[sku] for sku in pod.contents if pod.free_items(sku) > 0) for pod in world.pods]
    assert held_by(WarehouseView(world).stock, np.array(values)).tolist() == sums
