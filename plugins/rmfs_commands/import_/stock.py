"""Stock and orders that RAWSim-O would draw while it runs, or bring by and by."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from heapq import heapify, heapreplace
from operator import itemgetter

import numpy as np

from rmfs_commands.import_.notes import Notes
from rmfs_commands.import_.replenishing import Deliveries
from rmfs_commands.import_.settings import DEFAULT_SIZE, OrderList, Setting, Sku, Spread
from rmfs_commands.import_.warehouses import commonest
from rmfs_core.errors import InputError
from rmfs_core.randomness import stream

Contents = list[dict[str, int | None]]
"""SKUs and items of each pod; None: without end."""
Orders = list[tuple[float, list[tuple[str, int]]]]
"""Arrival in seconds and lines of each order."""

AT_ONCE = 4096
MISSES = 1000
MOST_DRAWN, MOST_BUNDLES, MOST_ORDERED = 500_000, 5_000_000, 10_000
"""Orders that are drawn at most; bundles on pods at the start; items of a line where stock sets no limit."""


class _Shelves:
    """Pods that are filled, the emptiest first."""

    def __init__(self, capacity: Sequence[float]) -> None:
        self.capacity = capacity
        self.contents: Contents = [{} for _ in capacity]
        self.load = [(0.0, pod) for pod in range(len(capacity))]

    def store(self, sku: str, items: int, weight: float) -> bool:
        """Put items on the pod that carries the least, unless they do not fit."""
        carried, pod = self.load[0]
        if carried + items * weight > self.capacity[pod]:
            return False
        heapreplace(self.load, (carried + items * weight, pod))
        self.contents[pod][sku] = (self.contents[pod].get(sku) or 0) + items
        return True


def drawn_contents(setting: Setting, skus: Sequence[Sku], capacity: Sequence[float], place: str) -> Contents:
    """Fill pods with bundles of SKUs, as often as orders want them, up to the setting's share of their capacity."""
    rng = stream(setting.seed, "imported pod contents")
    shares = np.array([sku.share for sku in skus])
    shelves, load, wanted, missed, stored = _Shelves(capacity), 0.0, setting.stocked * sum(capacity), 0, 0
    weightless = all(sku.weight == 0 for sku in skus)
    if weightless or wanted > 1e9:
        raise InputError(place, "found pods of unlimited capacity; expected a capacity and weights of items")
    while load < wanted and missed < MISSES:
        for i in rng.choice(len(skus), AT_ONCE, p=shares / shares.sum()):
            sku = skus[i]
            if load >= wanted or missed >= MISSES:
                break
            if shelves.store(sku.name, sku.bundle, sku.weight):
                load += sku.bundle * sku.weight
                missed, stored = 0 if sku.weight else missed + 1, stored + 1
            else:
                missed += 1
        if stored > MOST_BUNDLES:
            problem = f"found pods that can hold over {MOST_BUNDLES:,} bundles; expected fewer (by item weights)"
            raise InputError(place, problem)
    return shelves.contents


def stock_of(contents: Contents) -> dict[str, int]:
    """Return the items of each SKU on all pods."""
    stock: dict[str, int] = {}
    for pod in contents:
        for sku, items in pod.items():
            stock[sku] = stock.get(sku, 0) + (items or 0)
    return stock


def drawn_orders(
    setting: Setting,
    skus: Sequence[Sku],
    stock: Mapping[str, int] | None,
    stations: int,
    items_per_s: float,
    notes: Notes,
    deliveries: Deliveries | None = None,
) -> Orders:
    """Draw orders of what there is: by their rate, or else as many as stations could pick in the time of the run.

    Parameters
    ----------
    setting
        Lines, quantities, and when orders end.
    skus
        How often each is wanted.
    stock
        Items that there are of each SKU; None: as many as anybody wants.
    stations
        Number of picking stations.
    items_per_s
        How many items all of them handle a second.
    notes
        Told when the stock ends the orders, and when more is ordered than stations can handle.
    deliveries
        Bundles that add to the stock as time goes on.
    """
    rng = stream(setting.seed, "imported orders")
    poisson = setting.mode == "Poisson"
    there = {sku.name: MOST_ORDERED for sku in skus} if stock is None else dict(stock)
    left = sum(there.values())
    end = setting.emptied * left if stock is not None and deliveries is None else -1  # else stock does not end orders
    room = math.inf if poisson else items_per_s * setting.until_s + setting.backlog * setting.quantities.most
    numbers = _numbers(rng, setting.lines)
    quantities = _numbers(rng, setting.quantities)
    wanted = _wanted(rng, skus)
    gap_s = 3600 / (setting.rate_per_h * stations)
    orders: Orders = []
    now, unserved = 0.0, 0
    while room > 0 and left > end and len(orders) < MOST_DRAWN:
        if poisson and len(orders) + unserved >= setting.initial_orders:
            now += float(rng.exponential(gap_s))
            if now >= setting.until_s:
                break
        for sku, items in deliveries.arrived(now) if deliveries is not None else ():
            there[sku] = there.get(sku, 0) + items
            left += items
        lines = _lines(next(numbers), there, wanted, quantities)
        if not lines and (deliveries is None or unserved > len(orders) + MISSES):
            break
        unserved += not lines
        for sku, items in lines.items() if stock is not None else ():
            there[sku] -= items
            left -= items
        if deliveries is not None:
            deliveries.ordered(lines)
        room -= sum(lines.values())
        orders += [(now, list(lines.items()))] if lines else []
    notes.add("orders for which stock has nothing left when they arrive", unserved)
    if len(orders) == MOST_DRAWN:
        notes.add("orders drawn at most", MOST_DRAWN, "no more come")
    elif room > 0 and now < setting.until_s:
        notes.add("orders drawn until the stock of pods ends", len(orders), "no more come; stock is not filled up")
    if poisson:
        _note_overload(orders, gap_s, items_per_s, notes)
    return orders


def _lines(number: int, there: Mapping[str, int], wanted: Iterator[str], quantities: Iterator[int]) -> dict[str, int]:
    """Draw the lines of an order: of SKUs that there are, and no more of them."""
    lines: dict[str, int] = {}
    missed = 0
    while len(lines) < number and missed < MISSES:
        sku = next(wanted)
        items = 0 if sku in lines else min(next(quantities), there.get(sku, 0))
        missed = 0 if items else missed + 1
        if items:
            lines[sku] = items
    return lines


def _note_overload(orders: Orders, gap_s: float, handled_per_s: float, notes: Notes) -> None:
    """Note when orders of a rate have more items than stations can handle."""
    ordered_per_s = sum(items for _, lines in orders for _, items in lines) / max(len(orders), 1) / gap_s
    if ordered_per_s > handled_per_s:
        what = f"items ordered per hour, more than the {3600 * handled_per_s:,.0f} that output stations can handle"
        notes.add(what, round(3600 * ordered_per_s), "kept; more and more orders wait")


def _numbers(rng: np.random.Generator, spread: Spread) -> Iterator[int]:
    """Yield whole numbers without end."""
    while True:
        drawn = np.rint(rng.normal(spread.mean, spread.deviation, AT_ONCE))
        fitting = drawn[(drawn >= spread.least) & (drawn <= spread.most)]
        if not len(fitting):  # the mean is far outside
            fitting = np.array([min(max(spread.mean, spread.least), spread.most)])
        yield from map(int, fitting)


def _wanted(rng: np.random.Generator, skus: Sequence[Sku]) -> Iterator[str]:
    shares = np.array([sku.share for sku in skus])
    while True:
        yield from (skus[i].name for i in rng.choice(len(skus), AT_ONCE, p=shares / shares.sum()))


def stored_bundles(
    found: OrderList, capacity: Sequence[float], notes: Notes, *, later: bool = False
) -> tuple[Contents, list[tuple[float, str, int]]]:
    """Put the bundles of a list on pods at the start, unless they come ``later``.

    SKUs that orders want beyond these bundles never run out.

    Returns
    -------
    tuple
        Contents of the pods at the start, and the bundles that come later, by arrival.
    """
    shelves = _Shelves(capacity)
    coming: list[tuple[float, str, int]] = []
    without_room = 0
    largest = commonest(capacity)
    for time, sku, items in sorted(found.bundles, key=itemgetter(0)) if later else found.bundles:
        weight = found.weights.get(sku, DEFAULT_SIZE if later else 0.0)
        fits = items * weight <= largest if later else shelves.store(sku, items, weight)
        without_room += not fits
        if later and fits:
            coming.append((time, sku, items))
    if not later:
        notes.add("bundles that arrive during the run", len(found.bundles) - without_room, "on pods at the start")
    notes.add("bundles that fit on no pod", without_room)
    wanted: dict[str, int] = {}
    for _, lines in found.orders:
        for sku, items in lines:
            wanted[sku] = wanted.get(sku, 0) + items
    held: dict[str, int] = {}
    for pod in shelves.contents:
        for sku, on_pod in pod.items():
            held[sku] = held.get(sku, 0) + (on_pod or 0)
    for _, sku, items in coming:
        held[sku] = held.get(sku, 0) + items
    short = [sku for sku, items in wanted.items() if held.get(sku, 0) < items]
    on_pods = {sku for pod in shelves.contents for sku in pod}
    missing = [sku for sku in short if sku not in on_pods]
    by_number = [(len(pod), i) for i, pod in enumerate(shelves.contents)]
    heapify(by_number)
    for sku in missing:
        number, pod_number = by_number[0]
        heapreplace(by_number, (number + 1, pod_number))
        shelves.contents[pod_number][sku] = None
    endless = set(short)
    for pod in shelves.contents:
        pod.update({sku: None for sku in pod if sku in endless})
    notes.add("SKUs of which orders want more than bundles bring", len(short), "never run out")
    return shelves.contents, coming
