"""The paper's instance generator (Section 4.1.1)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rmfs_core.clock import to_ticks
from rmfs_core.errors import InputError
from rmfs_core.randomness import stream
from rmfs_core.scenario.model import Arrivals, InstanceSection
from rmfs_core.world.instance import Instance, OrderData, PodData

_LENGTH_P = 0.4
_TRIES = 10_000
_ENOUGH = np.iinfo(np.int64).max  # items of a SKU whose stock is unlimited


def generate_instance(section: InstanceSection, seed: int) -> Instance:
    """Draw SKUs, orders and pods.

    An order has a number of lines from a geometric distribution with p = 0.4, truncated to 1..min(\\|I\\|, max_lines),
    of one item each; its SKUs are drawn without replacement with the probabilities of `sku_demand`. Shuffled lists of
    all SKUs are concatenated and cut into chunks of alpha, one for each pod. A chunk across the end of a list may have
    a SKU twice: such a pod holds one SKU less (and twice the items, where stock is finite), as the paper's cut has it.

    An order that the pods cannot fill (a SKU is on no pod, or the orders before it take all items of it) is drawn
    again within the same stream. SKUs that are on no pod are left out of the instance.

    Parameters
    ----------
    section
        Sizes.
    seed
        The scenario's seed. Orders, pods and arrivals each have a stream of their own.

    Raises
    ------
    InputError
        When the pods hold too little to draw an order that they can fill.
    """
    pods = _draw_pods(section, stream(seed, "pods"))
    orders = _draw_orders(section, _stock(section.skus, pods), stream(seed, "orders"))
    arrivals = _draw_arrivals(section.arrivals, len(orders), stream(seed, "arrivals"))
    held = sorted({sku for contents in pods for sku in contents})
    new_id = {sku: i for i, sku in enumerate(held)}
    return Instance(
        skus=tuple(str(sku + 1) for sku in held),
        orders=tuple(
            OrderData(str(i + 1), tick, tuple((new_id[sku], 1) for sku in skus))
            for i, (tick, skus) in enumerate(zip(arrivals, orders, strict=True))
        ),
        pods=tuple(
            PodData(str(i + 1), tuple((new_id[sku], items) for sku, items in contents.items()))
            for i, contents in enumerate(pods)
        ),
    )


def order_lengths(longest: int) -> NDArray[np.float64]:
    """Return the probabilities of 1..longest lines: geometric with p = 0.4, truncated and scaled to a sum of 1."""
    return _geometric(_LENGTH_P, longest)


def sku_demand(skus: int) -> NDArray[np.float64]:
    """Return the probability of each SKU, the most wanted first: geometric with p = 5/\\|I\\|, scaled to a sum of 1.

    Up to ten SKUs have p = 0.5: the formula gives a single SKU everything at \\|I\\| = 5 and is no probability below.
    """
    return _geometric(5 / skus if skus > 10 else 0.5, skus)


def _geometric(p: float, largest: int) -> NDArray[np.float64]:
    weights: NDArray[np.float64] = np.power(1 - p, np.arange(largest, dtype=np.float64))
    weights /= weights.sum()
    return weights


def _draw_pods(section: InstanceSection, rng: np.random.Generator) -> list[dict[int, int | None]]:
    """Return the items (None: unlimited) of each SKU on each pod."""
    entries = section.pods * section.skus_per_pod
    lists = -(-entries // section.skus)
    shuffled = rng.permuted(np.tile(np.arange(section.skus), (lists, 1)), axis=1)
    chunks = shuffled.ravel()[:entries].reshape(section.pods, section.skus_per_pod).tolist()
    items = section.items_per_sku
    return [{sku: items and items * chunk.count(sku) for sku in chunk} for chunk in chunks]


def _stock(skus: int, pods: list[dict[int, int | None]]) -> NDArray[np.int64]:
    """Return the items of each SKU on all pods."""
    stock = np.zeros(skus, dtype=np.int64)
    for contents in pods:
        for sku, items in contents.items():
            stock[sku] = _ENOUGH if items is None else stock[sku] + items
    return stock


def _draw_orders(section: InstanceSection, left: NDArray[np.int64], rng: np.random.Generator) -> list[list[int]]:
    """Return the SKUs of each order; takes what they want out of ``left``."""
    lengths = order_lengths(min(section.skus, section.max_lines)).cumsum()
    demand = sku_demand(section.skus)
    orders: list[list[int]] = []
    for _ in range(section.orders):
        for _ in range(_TRIES if left.any() else 0):
            length = min(int(np.searchsorted(lengths, rng.random(), side="right")) + 1, len(lengths))
            skus = rng.choice(section.skus, size=length, replace=False, p=demand)
            if left[skus].all():
                break
        else:
            raise _too_little(section, len(orders), int(np.count_nonzero(left)))
        if section.items_per_sku is not None:
            left[skus] -= 1
        orders.append(skus.tolist())
    return orders


def _too_little(section: InstanceSection, drawn: int, skus_left: int) -> InputError:
    return InputError(
        "instance",
        f"after {drawn} of {section.orders} orders the {section.pods} pods of {section.skus_per_pod} SKUs each have "
        f"items of {skus_left} of {section.skus} SKUs left, too few to draw an order that they can fill; "
        f"expected more `pods` or `skus_per_pod`{' or `items_per_sku`' if section.items_per_sku else ''}, "
        "or fewer `orders` or `skus`",
    )


def _draw_arrivals(arrivals: Arrivals, orders: int, rng: np.random.Generator) -> list[int]:
    """Return the tick at which each order arrives, ascending."""
    if arrivals.orders_per_hour is None:
        return [0] * orders
    times = rng.exponential(3600 / arrivals.orders_per_hour, size=orders).cumsum()
    return [to_ticks(time) for time in times.tolist()]
