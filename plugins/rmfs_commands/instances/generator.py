"""The paper's instance generator (Section 4.1.1)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from rmfs_commands.instances.calendar import Calendar
from rmfs_core.clock import to_seconds, to_ticks
from rmfs_core.errors import InputError
from rmfs_core.randomness import stream
from rmfs_core.scenario.model import Due, InstanceSection, SkuDemand
from rmfs_core.world import Instance, OrderData, PodData

_LENGTH_P = 0.4
_TRIES = 10_000
_DAY_S = 86_400.0
_ENOUGH = np.iinfo(np.int64).max  # items of a SKU whose stock is unlimited


def generate_instance(section: InstanceSection, seed: int) -> Instance:
    """Draw SKUs, orders and pods.

    An order has a number of lines from a geometric distribution with p = 0.4, truncated to 1..min(\\|I\\|, max_lines),
    of one item each; its SKUs are drawn without replacement with the probabilities of `sku_demand`. Shuffled lists of
    all SKUs are concatenated and cut into chunks of alpha, one for each pod. A chunk across the end of a list may have
    a SKU twice: such a pod holds one SKU less (and twice the items, where stock is finite), as the paper's cut has it.

    `instance.lines` and `instance.demand` replace these distributions. SKUs may be dealt out at random to
    groups: then each line after the first has, with a probability, a SKU of the group of a line before it.

    An order that the pods cannot fill (a SKU is on no pod, or the orders before it take all items of it) is drawn
    again within the same stream. SKUs that are on no pod are left out of the instance.

    Parameters
    ----------
    section
        Sizes.
    seed
        The scenario's seed. Orders, pods, arrivals and due times each have a stream of their own.

    Raises
    ------
    InputError
        When the pods hold too little to draw an order that they can fill.
    """
    pods = _draw_pods(section, stream(seed, "pods"))
    left = _stock(section.skus, pods)
    if section.replenishment is not None and section.replenishment.process in ("reorder-point", "poisson"):
        left[left > 0] = _ENOUGH  # it is brought when it runs out
    orders = _draw_orders(section, left, stream(seed, "orders"))
    arrivals = draw_arrivals(section, len(orders), stream(seed, "arrivals"))
    due = _draw_due(section.due, arrivals, stream(seed, "due times"))
    held = sorted({sku for contents in pods for sku in contents})
    new_id = {sku: i for i, sku in enumerate(held)}
    return Instance(
        skus=tuple(str(sku + 1) for sku in held),
        orders=tuple(
            OrderData(
                str(i + 1),
                arrival_tick=tick,
                lines=tuple((new_id[sku], 1) for sku in skus),
                due_tick=due_tick,
                priority=priority,
            )
            for i, (tick, skus, (due_tick, priority)) in enumerate(zip(arrivals, orders, due, strict=True))
        ),
        pods=tuple(
            PodData(str(i + 1), tuple((new_id[sku], items) for sku, items in contents.items()))
            for i, contents in enumerate(pods)
        ),
    )


def order_lengths(longest: int) -> NDArray[np.float64]:
    """Return the probabilities of 1..longest lines: geometric with p = 0.4, truncated and scaled to a sum of 1."""
    return _geometric(_LENGTH_P, longest)


def sku_demand(skus: int, demand: SkuDemand | None = None) -> NDArray[np.float64]:
    """Return the probability of each SKU, the most wanted first: geometric with p = 5/\\|I\\|, scaled to a sum of 1.

    Up to ten SKUs have p = 0.5: the formula gives a single SKU everything at \\|I\\| = 5 and is no probability below.
    With ``demand`` it is Zipf's law, shifted.
    """
    if demand is None:
        return _geometric(5 / skus if skus > 10 else 0.5, skus)
    weights: NDArray[np.float64] = np.power(np.arange(1.0, skus + 1) + demand.shift, -demand.exponent)
    weights /= weights.sum()
    return weights


def _geometric(p: float, largest: int) -> NDArray[np.float64]:
    weights: NDArray[np.float64] = np.power(1 - p, np.arange(largest, dtype=np.float64))
    weights /= weights.sum()
    return weights


def _draw_pods(section: InstanceSection, rng: Generator) -> list[dict[int, int | None]]:
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


def _draw_orders(section: InstanceSection, left: NDArray[np.int64], rng: Generator) -> list[list[int]]:
    """Return the SKUs of each order; takes what they want out of ``left``."""
    lengths = order_lengths(min(section.skus, section.max_lines)).cumsum()
    if section.lines is not None:
        lengths = np.cumsum(section.lines[: section.skus]) / sum(section.lines[: section.skus])
    demand = sku_demand(section.skus, section.demand)
    shares = _shares(demand)
    groups = section.demand and section.demand.groups
    group_of = rng.permutation(section.skus) % groups if groups else None
    orders: list[list[int]] = []
    for _ in range(section.orders):
        for _ in range(_TRIES if left.any() else 0):
            length = min(int(lengths.searchsorted(rng.random(), side="right")) + 1, len(lengths))
            skus = draw_distinct(length, demand, shares, rng)
            if section.demand is not None and group_of is not None:
                _bring_together(skus, section.demand.together, demand, group_of, rng)
            if left[skus].all():
                break
        else:
            raise _too_little(section, len(orders), int(np.count_nonzero(left)))
        if section.items_per_sku is not None:
            left[skus] -= 1
        orders.append(skus.tolist())
    return orders


def draw_distinct(
    number: int, weights: NDArray[np.float64], shares: NDArray[np.float64], rng: Generator
) -> NDArray[np.int64]:
    """Draw so many different indices, as ``rng.choice(len(weights), number, replace=False, p=weights)`` does.

    `Generator.choice` checks the weights and adds them up in every call; here ``shares`` has their cumulative shares.
    """
    drawn: dict[int, None] = {}
    while len(drawn) < number:
        if drawn:
            left = weights.copy()
            left[[*drawn]] = 0
            shares = _shares(left)
        drawn |= dict.fromkeys(shares.searchsorted(rng.random(number - len(drawn)), side="right").tolist())
    return np.array([*drawn])


def _shares(weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the cumulative shares of weights."""
    shares = weights.cumsum()
    shares /= shares[-1]
    return shares


def _too_little(section: InstanceSection, drawn: int, skus_left: int) -> InputError:
    return InputError(
        "instance",
        f"after {drawn} of {section.orders} orders the {section.pods} pods of {section.skus_per_pod} SKUs each have "
        f"items of {skus_left} of {section.skus} SKUs left, too few to draw an order that they can fill; "
        f"expected more `pods` or `skus_per_pod`{' or `items_per_sku`' if section.items_per_sku else ''}, "
        "or fewer `orders` or `skus`",
    )


def _bring_together(
    skus: NDArray[np.int64], together: float, weights: NDArray[np.float64], group_of: NDArray[np.int64], rng: Generator
) -> None:
    """Put SKUs of the groups of lines before them instead of some lines of an order."""
    for i in range(1, len(skus)):
        if rng.random() < together:
            group = np.flatnonzero(group_of == group_of[skus[rng.integers(i)]])
            mate = rng.choice(group, p=weights[group] / weights[group].sum())
            if mate not in skus:
                skus[i] = mate


def draw_arrivals(section: InstanceSection, orders: int, rng: Generator) -> list[int]:
    """Return the tick at which each order arrives, ascending."""
    arrivals = section.arrivals
    if arrivals.process in ("start", "refill"):
        return [0] * orders
    if arrivals.orders_per_hour is None:
        times = np.sort(rng.random(orders)) * _DAY_S
    else:
        times = rng.exponential(3600 / arrivals.orders_per_hour, size=orders).cumsum()
    if arrivals.profile is not None:  # as many in a day, but an hour counts as its weight
        weights = np.array(arrivals.profile, dtype=np.float64)
        share, hours = np.concatenate(([0.0], weights.cumsum() / weights.sum())), np.arange(25) * 3600.0
        begin = to_seconds(Calendar(section.start).time_of_day())
        days, rest = np.divmod(times / _DAY_S + np.interp(begin, hours, share), 1)
        times = days * _DAY_S + np.interp(rest, share, hours) - begin
    return [to_ticks(time) for time in times.tolist()]


def _draw_due(due: Due | None, arrivals: Sequence[int], rng: Generator) -> list[tuple[int | None, int]]:
    """Return the tick at which each order is due, and its priority."""
    if due is None:
        return [(None, 0)] * len(arrivals)
    urgent = rng.random(len(arrivals)) < due.priority_share
    allowed = due.allowance_s + due.spread_s * rng.uniform(-1, 1, len(arrivals))
    if due.priority_allowance_s is not None:
        allowed = np.where(urgent, due.priority_allowance_s, allowed)
    drawn = zip(arrivals, allowed.tolist(), urgent.tolist(), strict=True)
    return [(tick + to_ticks(seconds), int(first)) for tick, seconds, first in drawn]
