"""A period as flat arrays, for the compiled searches."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rmfs_rules.mip.period.effort import is_large
from rmfs_rules.mip.period.reduction import Reduced, masks_of
from rmfs_rules.mip.period.solution import Model

Integers = NDArray[np.int64]

MOST_STATES = 200_000
"""Vectors of slots taken that `compiled.stacking.fill` may tell apart.

They are the product of the stations' free slots, each plus one.
"""
MOST_STATIONS = 7
"""Stations whose slots a packed vector can count, one byte each."""
USUAL_PODS, USUAL_NUMBER, USUAL_ORDERS = 100, 5, 250
"""With more orders, a step of a search takes longer in proportion; with more pods, and in a set, more than that."""
ENOUGH = 1 << 20
"""Items of a SKU that is not scarce: more than any period takes."""
LARGEST_ROOM = 127
"""Free slots of a station that its byte in a packed vector can count."""


class Arrays(NamedTuple):
    """Input of the searches; lists of lists are flat, with the start of each.

    Parameters
    ----------
    rooms
        Free slots of each station.
    at_hand, items_at_hand
        Per SKU the bit mask of the stations that cover it already, and how many items there are.
    order_start, line_sku, line_items
        Lines of the orders that can be assigned, oldest order first, and the slots that they take.
    items
        Slots that each order takes.
    pod_start, pod_sku, pod_items
        SKUs that each pod may bring, and how many items of each.
    sku_start, sku_pod
        Pods that may bring each SKU, ascending.
    useful
        Per pod the bit mask of the stations where it brings something new.
    whole
        Whether an order goes to a single station.
    alike
        Whether the stations are interchangeable.
    begun
        Per order whether it is split already.
    splits
        How many orders may newly be split; -1 for any number.
    sharp
        Whether sets of pods are bounded more sharply, which takes longer, and pays where many are to be looked at.
    """

    rooms: Integers
    at_hand: Integers
    items_at_hand: Integers
    order_start: Integers
    line_sku: Integers
    line_items: Integers
    items: Integers
    pod_start: Integers
    pod_sku: Integers
    pod_items: Integers
    sku_start: Integers
    sku_pod: Integers
    useful: Integers
    whole: bool
    alike: bool
    begun: NDArray[np.bool_]
    splits: int
    sharp: bool


def arrays_of(reduced: Reduced, splits: int | None = None, *, sharp: bool = False) -> tuple[Arrays, list[int]]:
    """Return a period as arrays, and the pods (positions) that are worth sending to some station.

    Parameters
    ----------
    reduced
        The period.
    splits
        How many orders may newly be split; None for any number.
    sharp
        Whether sets of pods are bounded more sharply, which they always are where the period is large.
    """
    period = reduced.period
    lacking = ~period.covered | reduced.is_scarce
    useful = np.array([reduced.wanted(s) & lacking[s] for s in range(len(reduced.capacities))])
    somewhere: NDArray[np.bool_] = np.asarray(useful.any(axis=0))
    pods = reduced.classes(somewhere, period.preferred.pods)
    pod, sku, items = _brought(reduced, pods, somewhere)
    by_sku = np.argsort(sku, kind="stable")
    kept = reduced.candidates
    order = period.line_order[kept]
    first = np.flatnonzero(np.diff(order, prepend=-1))
    n_skus = period.stock.n_skus
    start = np.append(first, len(order)).astype(np.int64)
    line_items = _slots(reduced, period.line_quantity[kept], first)
    arrays = Arrays(
        rooms=np.array(reduced.capacities, dtype=np.int64),
        at_hand=masks_of(period.covered),
        items_at_hand=_items_at_hand(reduced),
        order_start=start,
        line_sku=period.line_sku[kept],
        line_items=line_items,
        items=np.diff(np.append(0, np.cumsum(line_items))[start]),
        pod_start=np.searchsorted(pod, np.arange(len(pods) + 1)).astype(np.int64),
        pod_sku=sku.astype(np.int64),
        pod_items=items,
        sku_start=np.searchsorted(sku[by_sku], np.arange(n_skus + 1)).astype(np.int64),
        sku_pod=pod[by_sku].astype(np.int64),
        useful=_useful(useful, pod, sku, len(pods)) & ~_there(reduced, pods),
        whole=reduced.model is Model.INTEGRATED,
        alike=reduced.interchangeable and not (len(reduced.scarce) and any(period.inbound)),
        begun=np.array(period.begun, dtype=np.bool_)[order[first]] if period.begun else np.zeros(len(first), np.bool_),
        splits=-1 if splits is None else splits,
        sharp=sharp or is_large(period),
    )
    return arrays, pods


def _slots(reduced: Reduced, quantity: Integers, first: Integers) -> Integers:
    """Return the slots that lines take: one for each item, or one for the first line of an order."""
    if not reduced.by_orders:
        return quantity
    slots = np.zeros(len(quantity), dtype=np.int64)
    slots[first] = 1
    return slots


def price_of(reduced: Reduced, pods: int, number: int) -> float:
    """Return what a step of a search counts of a period's effort.

    Parameters
    ----------
    reduced
        The period.
    pods, number
        Pods to choose from, and how many are chosen.
    """
    many = (pods / USUAL_PODS) ** 2 * (number / USUAL_NUMBER) ** 3
    return max(many, 1.0) * max(len(reduced.orders) / USUAL_ORDERS, 1.0)


def _brought(reduced: Reduced, pods: list[int], wanted: NDArray[np.bool_]) -> tuple[Integers, Integers, Integers]:
    """Return what the pods (from 0 on) bring of the SKUs that are wanted, sorted by these, and items of scarce ones."""
    stock = reduced.period.stock
    place = np.full(len(stock.pods), -1)
    place[pods] = np.arange(len(pods))
    kept = wanted[stock.sku] & (place[stock.pod] >= 0)
    pod, sku, number = place[stock.pod[kept]], stock.sku[kept], np.full(np.count_nonzero(kept), ENOUGH)
    return pod, sku, number if stock.number is None else np.where(reduced.is_scarce[sku], stock.number[kept], number)


def _useful(useful: NDArray[np.bool_], pod: Integers, sku: Integers, pods: int) -> Integers:
    """Return for each of the pods the bit mask of the stations where some of its SKUs is useful."""
    return masks_of(np.array([np.bincount(pod, weights=at[sku], minlength=pods) > 0 for at in useful]))


def _items_at_hand(reduced: Reduced) -> Integers:
    """Return how many items of each SKU the pods at stations have."""
    period, stock = reduced.period, reduced.period.stock
    numbers = np.where(period.covered.any(axis=0), ENOUGH, 0)
    if stock.number is not None:
        there = np.isin(stock.pod, [pod for at in period.inbound for pod in at])
        scarce = np.bincount(stock.sku[there], stock.number[there], stock.n_skus).astype(np.int64)
        numbers = np.where(reduced.is_scarce, scarce, numbers)
    return numbers


def _there(reduced: Reduced, pods: list[int]) -> Integers:
    """Return for each of the pods the bit mask of the stations where it is already: it is not sent there again."""
    inbound = reduced.period.inbound
    return np.array([sum(1 << s for s, there in enumerate(inbound) if pod in there) for pod in pods], dtype=np.int64)
