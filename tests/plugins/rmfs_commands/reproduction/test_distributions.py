"""Order lengths and SKU probabilities of generated instances."""

import pytest

from rmfs_commands.reproduction.distributions import (
    distribution_tables,
    order_lengths,
    sku_probabilities,
    truncated_geometric,
)
from rmfs_commands.reproduction.paper import load_paper
from rmfs_core.world import Instance
from rmfs_core.world.instance import OrderData

THREE_ORDERS = Instance(
    skus=("2", "1"),
    orders=(
        OrderData("a", 0, ((0, 1),)),
        OrderData("b", 0, ((1, 1),)),
        OrderData("c", 0, ((1, 1), (0, 1))),
        OrderData("d", 0, ((1, 1),)),
    ),
    pods=(),
)


def test_truncated_geometric() -> None:
    """p = 1/2 cut at 2 leaves 2/3 and 1/3."""
    assert truncated_geometric(0.5, 2) == pytest.approx([2 / 3, 1 / 3])


def test_shares_of_lengths() -> None:
    """Three of four orders have one line."""
    table = order_lengths(load_paper()["order-lengths"], {1: THREE_ORDERS})
    assert [line.ours.mean for line in table.lines[:3] if line.ours] == [0.75, 0.25, 0.0]
    assert len(table.lines) == 20


def test_shares_of_skus_are_those_of_orders_of_one_line() -> None:
    """The SKU called 1 is in two of the three orders of one line, whatever its id."""
    table = sku_probabilities(load_paper()["sku-probabilities"], {1: THREE_ORDERS})
    assert [line.ours.mean for line in table.lines[:2] if line.ours] == pytest.approx([2 / 3, 1 / 3])


def test_the_generator_draws_from_the_papers_distributions() -> None:
    """Of the 40 probabilities at most four lie beyond the 95 % interval of ten seeds, besides lengths beyond 15."""
    tables = distribution_tables(range(1, 11), load_paper())
    verdicts = [line.verdict for table in tables for line in table.lines if line.label[0] not in BEYOND]
    assert verdicts.count("in range") >= len(verdicts) - 4


BEYOND = {f"length {length}" for length in range(16, 21)}
"""Longer than a station's item capacity: never generated."""
