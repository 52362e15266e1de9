"""SKUs on pods."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rmfs_commands.convert.lines import Sku
from rmfs_commands.convert.placement import PLACEMENTS, items_on, place


@given(
    wanted=st.lists(st.integers(0, 50), min_size=1, max_size=30),
    pods=st.integers(1, 12),
    more=st.integers(0, 4),
    placement=st.sampled_from(PLACEMENTS),
    seed=st.integers(0, 3),
)
def test_every_sku_is_somewhere_and_no_pod_is_too_full(
    wanted: list[int], pods: int, more: int, placement: str, seed: int
) -> None:
    """Each SKU on one pod or more, none twice on a pod, no pod over its places, and stock enough for all orders."""
    skus = [Sku(f"s{i}", lines, 2 * lines) for i, lines in enumerate(sorted(wanted, reverse=True))]
    per_pod = -(-len(skus) // pods) + more
    baskets = [["s0", f"s{len(skus) - 1}"]] if min(wanted) else []
    held = place(skus, pods, per_pod, placement, np.random.default_rng(seed), baskets)
    assert {sku for pod in held for sku in pod} == set(range(len(skus)))
    assert all(len(set(pod)) == len(pod) <= per_pod for pod in held)
    items, raised = items_on(skus, held, 3)
    stock = [sum(items[i] for pod in held if i in pod) for i in range(len(skus))]
    assert all(stock[i] >= sku.items for i, sku in enumerate(skus))
    assert raised == sum(items > 3)


def test_popularity_gives_fast_movers_more_pods() -> None:
    """Sixteen times the lines, four times the places that are left after the first: 4 / 9 of 26, and one."""
    skus = [Sku("fast", 80, 80), *(Sku(f"slow{i}", 5, 5) for i in range(5))]
    held = place(skus, 16, 2, "popularity", np.random.default_rng(1))
    copies = [sum(i in pod for pod in held) for i in range(6)]
    assert copies[0] in (12, 13)
    assert set(copies[1:]) <= {3, 4}
    assert sum(copies) == 32


def test_what_is_bought_together_stands_together() -> None:
    """Two pairs that are always ordered together share a pod each."""
    skus = [Sku(name, 10, 10) for name in ("ale", "bun", "nut", "tea")]
    baskets = [["ale", "tea"], ["bun", "nut"]] * 10
    held = place(skus, 2, 2, "co-purchase", np.random.default_rng(1), baskets)
    assert sorted(held) == [[0, 3], [1, 2]]


def test_skus_without_order_lines_stand_anywhere() -> None:
    """On a pod each, spread over all pods, not together on the last that are filled."""
    skus = [*(Sku(f"known{i}", 10, 10) for i in range(8)), *(Sku(f"new{i}", 0, 1) for i in range(4))]
    held = place(skus, 4, 3, "co-purchase", np.random.default_rng(1), [["known0", "known1"], ["known2", "known3"]])
    assert [sum(sku >= 8 for sku in pod) for pod in held] == [1, 1, 1, 1]


@pytest.mark.parametrize("placement", PLACEMENTS)
def test_the_same_seed_places_alike(placement: str) -> None:
    """The placement depends on the seed alone."""
    skus = [Sku(f"s{i}", 30 - i, 30 - i) for i in range(30)]
    one, two = (place(skus, 9, 7, placement, np.random.default_rng(5)) for _ in range(2))
    assert one == two
