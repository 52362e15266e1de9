"""The data a run starts from."""

from __future__ import annotations

import pytest

from rmfs_core.world import Instance, OrderData, PodData


def test_an_orders_items_are_the_sum_of_its_lines() -> None:
    """Not their number."""
    assert OrderData("1", 0, ((0, 2), (3, 5))).items == 7


@pytest.mark.parametrize(
    ("contents", "unlimited"),
    [
        ([((0, None), (1, None)), ((2, None),)], True),
        ([((0, None), (1, 3)), ((2, None),)], False),  # a single number is enough
        ([((0, 0),)], False),  # none left is a number, too
        ([()], True),
    ],
)
def test_stock_is_unlimited_where_no_pod_has_a_number(
    contents: list[tuple[tuple[int, int | None], ...]], unlimited: bool
) -> None:
    """The paper's assumption holds of an instance or it does not."""
    pods = tuple(PodData(str(i), held) for i, held in enumerate(contents))
    assert Instance(("a", "b", "c"), (), pods).unlimited_stock is unlimited
