"""Section 4.1: what generated instances look like, next to the distributions that the paper draws them from."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

from rmfs_commands.reproduction.estimates import Estimate, estimate
from rmfs_commands.reproduction.paper import Exhibit, Range
from rmfs_commands.reproduction.tables import ABOVE, BELOW, IN_RANGE, NO_RUN, Line, Table
from rmfs_core.world import Instance

SAMPLE_ORDERS = 2000
"""Orders drawn per seed: as many as the largest instances have."""


def distribution_tables(seeds: Iterable[int], paper: Mapping[str, Exhibit]) -> list[Table]:
    """Return the tables of order lengths and SKU probabilities, from instances drawn with the given seeds."""
    from rmfs_commands.instances.generator import generate_instance
    from rmfs_core.scenario import InstanceSection

    lengths, skus = paper["order-lengths"], paper["sku-probabilities"]
    section = InstanceSection(orders=SAMPLE_ORDERS, skus=skus.values["skus"])
    drawn = {seed: generate_instance(section, seed) for seed in seeds}
    return [order_lengths(lengths, drawn), sku_probabilities(skus, drawn)]


def order_lengths(exhibit: Exhibit, drawn: Mapping[int, Instance]) -> Table:
    """Return the share of orders of each number of lines, over instances by seed."""
    expected = truncated_geometric(exhibit.values["p"], exhibit.values["longest"])

    def share(instance: Instance, length: int) -> float:
        return sum(len(order.lines) == length for order in instance.orders) / len(instance.orders)

    lines = _lines(expected, drawn, share, "length {}")
    what = (
        f"share of {SAMPLE_ORDERS:,} orders per seed; an order longer than a station's item capacity of 15 could never "
        "be assigned whole, so that ours end there; in range: the formula's figure lies within our interval"
    )
    return Table(exhibit, lines, "", 4, what)


def sku_probabilities(exhibit: Exhibit, drawn: Mapping[int, Instance]) -> Table:
    """Return the share of each SKU among orders of one line, over instances by seed.

    Orders of one line alone show the probabilities as they are: drawing without replacement changes those of the
    SKUs that come after.
    """
    expected = truncated_geometric(exhibit.values["p"], exhibit.values["skus"])

    def share(instance: Instance, sku: int) -> float:
        single = [order.lines[0][0] for order in instance.orders if len(order.lines) == 1]
        return sum(instance.skus[number] == str(sku) for number in single) / len(single)

    what = "share among the orders of one line; in range: the formula's figure lies within our interval"
    return Table(exhibit, _lines(expected, drawn, share, "SKU {}"), "", 4, what)


def truncated_geometric(p: float, largest: int) -> list[float]:
    """Return the probabilities of 1..largest under a geometric distribution with parameter p, truncated and scaled."""
    weights = [p * (1 - p) ** (k - 1) for k in range(1, largest + 1)]
    return [weight / sum(weights) for weight in weights]


def _lines(
    expected: Sequence[float], drawn: Mapping[int, Instance], share: Callable[[Instance, int], float], label: str
) -> tuple[Line, ...]:
    lines = []
    for k, probability in enumerate(expected, 1):
        ours = estimate((seed, share(instance, k)) for seed, instance in drawn.items())
        lines.append(
            Line((label.format(k),), Range(probability, probability, probability), ours, _agrees(probability, ours))
        )
    return tuple(lines)


def _agrees(expected: float, ours: Estimate | None) -> str:
    """Say whether an exact figure lies within our interval."""
    if ours is None:
        return NO_RUN
    if abs(expected - ours.mean) <= (ours.half_width or 0.0):
        return IN_RANGE
    return BELOW if ours.mean < expected else ABOVE
