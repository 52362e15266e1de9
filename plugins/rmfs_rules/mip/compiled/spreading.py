"""Whether some visits let whole orders fill the stations: compiled, and exact.

`spread` tries the ways to send a set of pods to the stations with a given number of visits, and whether orders can then
fill the slots (`compiled.stacking`). It leaves out the ways that a cut forbids: of the items that the set
completes, a group of stations that covers some of them alone can take no more than its free slots, and all but a known
slack of the items have to find one.

A limit on newly split orders only takes solutions away, so these cuts hold with it, and `too_few_splits` cuts more.
How many orders are split depends neither on the pods that bring their SKUs nor on the names of the stations, so it is
still enough to try one sequence of interchangeable stations, and pods that no other pod dominates.
"""

from __future__ import annotations

import numpy as np

from rmfs_core.jit import njit
from rmfs_rules.mip.compiled.pod_sets import complete, copied, next_set, ones
from rmfs_rules.mip.compiled.stacking import fill, fill_with_few_splits, newly_split

FOUND, NOT_FOUND, NO_SETS, TOO_MANY = 0, 1, 2, 3
"""Answers of `next_that_fills`."""


@njit(cache=True)
def _completed(a, pods):
    """Return the orders whose SKUs are all on these pods or at hand, their items per SKU, and the sum of these.

    No more items are counted than there are on the pods and at hand.
    """
    there, stock = a.at_hand > 0, a.items_at_hand.copy()
    for pod in pods:
        for at in range(a.pod_start[pod], a.pod_start[pod + 1]):
            there[a.pod_sku[at]] = True
            stock[a.pod_sku[at]] += a.pod_items[at]
    items, total = np.zeros(len(there), np.int64), 0
    orders, count = np.empty(len(a.order_start) - 1, np.int64), 0
    for order in range(len(a.order_start) - 1):
        if complete(a, order, there):
            orders[count] = order
            count += 1
            for line in range(a.order_start[order], a.order_start[order + 1]):
                items[a.line_sku[line]] += a.line_items[line]
    for sku in range(len(items)):
        items[sku] = min(items[sku], stock[sku])
        total += items[sku]
    return orders[:count], items, total


@njit(cache=True)
def _crowded(by_mask, rooms, slack):
    """Whether a group of stations alone covers more items than its slots and the slack."""
    for group in range(1, 1 << len(rooms)):
        items = -slack
        for mask in range(1, group + 1):
            if mask & ~group == 0:
                items += by_mask[mask]
        for station in range(len(rooms)):
            items -= rooms[station] * (group >> station & 1)
        if items > 0:
            return True
    return False


@njit(cache=True)
def _whole_orders_short(a, mask, target):
    """Whether orders that have to go to a single station cannot fill the target: by cuts, as in `_crowded`."""
    by_mask, total = np.zeros(1 << len(a.rooms), np.int64), 0
    single = _single_stations(a, np.arange(len(a.items)), mask)
    for order in range(len(a.items)):
        if single[order]:
            by_mask[single[order]] += a.items[order]
            total += a.items[order]
    return total < target or _crowded(by_mask, a.rooms, total - target)


@njit(cache=True)
def too_few_splits(a, orders, mask, target):
    """Whether a cut shows that more of the orders than allowed have to be split newly to fill the target.

    For a group of stations: it takes at most its free slots. Outside of it are only orders that go to one station
    there, and lines of split orders that are covered there. Of orders that would be split newly, the best count.
    """
    stations = len(a.rooms)
    single = _single_stations(a, orders, mask)
    for group in range((1 << stations) - 1):
        filled, by_items = 0, np.zeros(a.rooms.sum() + 1, np.int64)
        for station in range(stations):
            filled += a.rooms[station] * (group >> station & 1)
        for at in range(len(orders)):
            if single[at] & ~group:
                filled += a.items[orders[at]]
                continue
            outside = 0
            for line in range(a.order_start[orders[at]], a.order_start[orders[at] + 1]):
                outside += a.line_items[line] * (mask[a.line_sku[line]] & ~group != 0)
            if a.begun[orders[at]]:
                filled += outside
            else:
                by_items[outside] += 1
        left = a.splits
        for outside in range(len(by_items) - 1, 0, -1):
            taken = min(left, by_items[outside])
            filled += taken * outside
            left -= taken
        if filled < target:
            return True
    return False


@njit(cache=True)
def _single_stations(a, orders, mask):
    """Return for each of the orders the bit mask of stations that can take it as a whole."""
    single = np.full(len(orders), (1 << len(a.rooms)) - 1)
    for at in range(len(orders)):
        for line in range(a.order_start[orders[at]], a.order_start[orders[at] + 1]):
            single[at] &= mask[a.line_sku[line]]
        for station in range(len(a.rooms)):
            if a.rooms[station] < a.items[orders[at]]:
                single[at] &= ~(1 << station)
    return single


@njit(cache=True)
def _cut(a, orders, mask, by_mask, last, depth, total, target, work):
    """Whether a cut shows that these visits cannot fill the target, wherever the pods after ``depth`` go."""
    if _crowded(by_mask, a.rooms, total - target):
        return True
    if a.splits < 0:
        return False
    work[0] += 5
    anywhere = np.full(len(mask), (1 << len(a.rooms)) - 1)
    for sku in range(len(mask)):
        if last[sku] <= depth:
            anywhere[sku] = mask[sku]
    return too_few_splits(a, orders, anywhere, target)


@njit(cache=True)
def _next_stations(a, pod, sent, most, used):
    """Return the bit mask of stations after ``sent`` to send a pod to, at most ``most`` of them; 0 after the last.

    Of interchangeable stations, the first ``used`` have pods of the set; of the others, the first go first.
    """
    for mask in range(sent + 1, 1 << len(a.rooms)):
        fresh = mask >> used
        if mask & ~a.useful[pod] == 0 and ones(mask) <= most and not (a.alike and fresh & (fresh + 1)):
            return mask
    return 0


@njit(cache=True)
def _settle(a, pod, sent, last, depth, items, mask, by_mask):
    """Let a pod bring its SKUs to stations, and count the items of SKUs that no later pod brings."""
    for at in range(a.pod_start[pod], a.pod_start[pod + 1]):
        sku = a.pod_sku[at]
        mask[sku] |= sent
        if last[sku] == depth:
            by_mask[mask[sku]] += items[sku]


@njit(cache=True)
def _stack(a, mask, target, work):
    """Fill the target with orders whose SKUs are there: first with any, then with few enough newly split ones."""
    work[0] += 10
    found, chosen = fill(a, mask, target)
    if not found or a.splits < 0 or newly_split(a, chosen) <= a.splits:
        return found, chosen
    return fill_with_few_splits(a, mask, target, work)


@njit(cache=True)
def spread(a, pods, visits, target, work, most_work, refused=0):
    """Find stations for each of the pods such that orders fill the target.

    Parameters
    ----------
    a
        The period (`compiled.arrays.Arrays`).
    pods
        The pods, each of which is sent somewhere.
    visits
        Number of visits in all.
    target
        Slots to fill.
    work, most_work
        A single number, to which what was tried is added; above the other the answer no proves nothing.
    refused
        How many of the answers are passed over.

    Returns
    -------
    found, sent, chosen
        Whether there are some; a bit mask of stations for each pod; the orders as `compiled.stacking.fill`.
    """
    n, skus = len(pods), len(a.at_hand)
    orders, items, total = _completed(a, pods)
    sent, chosen = np.zeros(n + 1, np.int64), np.empty((0, 2), np.int64)
    if total < target:
        return False, sent[:n], chosen
    last = np.full(skus, -1)  # pod of the set that brings the SKU last
    for depth in range(n):
        for at in range(a.pod_start[pods[depth]], a.pod_start[pods[depth] + 1]):
            last[a.pod_sku[at]] = depth
    mask, by_mask = np.zeros((n + 1, skus), np.int64), np.zeros((n + 1, 1 << len(a.rooms)), np.int64)
    left, used = np.zeros(n + 1, np.int64), np.zeros(n + 1, np.int64)
    copied(a.at_hand, mask[0])
    left[0], depth, passed = visits, 0, 0
    for sku in range(skus):
        if last[sku] < 0:
            by_mask[0, a.at_hand[sku]] += items[sku]
    while depth >= 0 and work[0] <= most_work:
        if depth == n:
            if left[n] == 0 and not (a.whole and _whole_orders_short(a, mask[n], target)):
                found, chosen = _stack(a, mask[n], target, work)
                if found and passed == refused:
                    return True, sent[:n], chosen
                passed += found
            depth -= 1
            continue
        stations = _next_stations(a, pods[depth], sent[depth], left[depth] - (n - depth - 1), used[depth])
        sent[depth] = stations
        if stations == 0:
            depth -= 1
            continue
        work[0] += 1
        left[depth + 1], used[depth + 1] = left[depth] - ones(stations), used[depth]
        while stations >> used[depth + 1]:
            used[depth + 1] += 1
        copied(mask[depth], mask[depth + 1])
        copied(by_mask[depth], by_mask[depth + 1])
        _settle(a, pods[depth], stations, last, depth, items, mask[depth + 1], by_mask[depth + 1])
        if not _cut(a, orders, mask[depth + 1], by_mask[depth + 1], last, depth, total, target, work):
            depth += 1
            sent[depth] = 0
    return False, sent[:n], chosen


@njit(cache=True)
def next_that_fills(a, sets, refused, visits, target, work, most_work):
    """Search pods that fill slots.

    Stations are left aside at first: a set of pods that completes too little cannot fill them, wherever its pods go.

    Parameters
    ----------
    a
        The period (`compiled.arrays.Arrays`).
    sets
        A search for sets of pods whose orders have as many items as the target (`compiled.pod_sets.sets_of`), which
        goes on where it was.
    refused
        How many answers with the set that was reached last were refused; -1 at first.
    visits
        Number of visits of them in all.
    target
        Slots to fill.
    work, most_work
        A single number, to which what was tried is added; above the other the search gives up.

    Returns
    -------
    answer, pods, sent, chosen
        `FOUND`, `NOT_FOUND` (there are none), `NO_SETS` (not even with any number of visits) or `TOO_MANY` (it gave
        up); the pods; a bit mask of stations for each; the orders as `compiled.stacking.fill`.
    """
    answer = NO_SETS if refused < 0 else NOT_FOUND
    while refused >= 0 or next_set(a, sets, work, most_work):
        answer = NOT_FOUND
        found, masks, orders = spread(a, sets.chosen, visits, target, work, most_work, max(refused, 0))
        if found:
            return FOUND, sets.chosen, masks, orders
        refused = -1
    if work[0] > most_work:
        answer = TOO_MANY
    return answer, sets.chosen, sets.chosen, np.empty((0, 2), np.int64)
