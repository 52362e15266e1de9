"""Sets of orders for one station, of the least cost, found by branch and bound: compiled, and exact.

Where there are hardly more orders than places, most orders have to go somewhere, at prices that tell them apart. Then
few sets of orders are cheap, far fewer than the sets of pods that could serve them. `cheapest_sets` goes through the
types of orders, takes some of each, and leaves out what is too dear: by the prices, and what the other places cost at
least (a knapsack), and by the fewest pods that the SKUs so far need.

SKUs are bits, `MOST_BITS` to a number, those on the fewest pods first.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rmfs_core.jit import njit
from rmfs_rules.mip.compiled.pod_sets import ones

MOST_BITS = 62
"""Bits of a number that stand for SKUs."""
SLIP = 1e-6
"""What rounding may add to a cost."""
STEPS_PER_WORK = 8
"""Choices of a number of orders that take as long as a step of the other searches."""

PODS_PER_WORK = 32
"""Pods that are looked at in the time of such a step."""
SETS_PER_WORK = 500
"""Sets that are looked through in that time for the dearest."""

Integers = NDArray[np.int64]


class Kinds(NamedTuple):
    """The types of orders, and the pods, as bits.

    Parameters
    ----------
    sizes, counts
        Places that an order of each type takes, and how many orders it has.
    needs
        SKUs that each type misses, as bits. Shape (types, numbers).
    brings
        SKUs of each pod, as bits. Shape (pods, numbers).
    apart
        For each SKU those that share a pod with it, itself included, as bits. Shape (SKUs, numbers).
    """

    sizes: Integers
    counts: Integers
    needs: Integers
    brings: Integers
    apart: Integers


def kinds_of(sizes: Integers, counts: Integers, missing: list[list[int]], held: list[list[int]]) -> Kinds:
    """Return types of orders and pods as bits, from the SKUs that they miss and have."""
    wanted = {sku for skus in missing for sku in skus}
    pods_with = {sku: sum(sku in skus for skus in held) for sku in wanted}
    number = {sku: at for at, sku in enumerate(sorted(wanted, key=lambda sku: (pods_with[sku], sku)))}
    width = max(-(-len(number) // MOST_BITS), 1)

    def bits(skus: list[int]) -> list[int]:
        mask = sum(1 << number[sku] for sku in skus if sku in number)
        return [mask >> (MOST_BITS * word) & ((1 << MOST_BITS) - 1) for word in range(width)]

    together: dict[int, set[int]] = {sku: {sku} for sku in number}
    for skus in held:
        for sku in wanted.intersection(skus):
            together[sku].update(skus)
    needs = np.array([bits(skus) for skus in missing], dtype=np.int64).reshape(-1, width)
    brings = np.array([bits(skus) for skus in held], dtype=np.int64).reshape(-1, width)
    apart = np.array([bits(list(together[sku])) for sku in number], dtype=np.int64).reshape(-1, width)
    return Kinds(sizes, counts, needs, brings, apart)


@njit(cache=True)
def _lowest(bits):
    at = 0
    while not bits & 1:
        at += 1
        bits >>= 1
    return at


@njit(cache=True)
def _shared(skus, brings):
    """Return how many of the SKUs a pod brings."""
    count = 0
    for word in range(len(skus)):
        count += ones(skus[word] & brings[word])
    return count


@njit(cache=True)
def least_pods(k, skus, most, gains, rest):
    """Return a number of pods that the SKUs need at least; more than ``most`` stands for any number above it.

    As many as it takes if each brought SKUs that no other brings; and one for each SKU of some of which no two share a
    pod.

    Parameters
    ----------
    k
        Types of orders and pods.
    skus
        The SKUs, as bits.
    most
        A number of pods.
    gains, rest
        Room to work in: numbers up to that of the SKUs, and bits.
    """
    left = _shared(skus, skus)
    if left == 0:
        return 0
    for word in range(len(skus)):
        rest[word] = skus[word]
    single = 0
    for word in range(len(skus)):
        while rest[word]:
            single += 1
            apart = k.apart[MOST_BITS * word + _lowest(rest[word])]
            for other in range(len(skus)):
                rest[other] &= ~apart[other]
    if single > most:
        return single
    for gain in range(left + 1):
        gains[gain] = 0
    for pod in range(len(k.brings)):
        gains[_shared(skus, k.brings[pod])] += 1
    pods = 0
    for gain in range(left, 0, -1):
        used = min(gains[gain], -(-left // gain))
        pods += used
        left -= used * gain
        if left <= 0:
            return max(pods, single)
    return most + 1  # a SKU is on no pod


@njit(cache=True)
def fewest_pods(k, skus, least, most, work, most_work):
    """Return the fewest pods that have all SKUs: how many, and which; more than ``most`` if these are not enough.

    Parameters
    ----------
    k
        Types of orders and pods.
    skus
        The SKUs, as bits.
    least, most
        Numbers of pods to try.
    work, most_work
        A single number, to which what was tried is added; beyond the other the search gives up, as if none were enough.
    """
    width, pods, largest = len(skus), len(k.brings), 1
    for pod in range(pods):
        largest = max(largest, _shared(skus, k.brings[pod]))
    chosen = np.zeros(most + 1, np.int64)
    rest = np.zeros((most + 2, width), np.int64)
    for number in range(least, most + 1):
        depth = 0
        for word in range(width):
            rest[0, word] = skus[word]
        chosen[0] = -1
        while depth >= 0:
            left = _shared(rest[depth], rest[depth])
            if left == 0:
                return depth, chosen[:depth]
            if left > (number - depth) * largest:
                depth -= 1
                continue
            word = 0
            while rest[depth, word] == 0:
                word += 1
            bit = rest[depth, word] & -rest[depth, word]
            pod = chosen[depth] + 1
            while pod < pods and not k.brings[pod, word] & bit:
                pod += 1
            work[0] += 1
            if work[0] > most_work:
                return most + 1, chosen[:0]
            if pod == pods:
                depth -= 1
                continue
            chosen[depth] = pod
            for at in range(width):
                rest[depth + 1, at] = rest[depth, at] & ~k.brings[pod, at]
            depth += 1
            chosen[depth] = -1
    return most + 1, chosen[:0]


@njit(cache=True)
def _cheapest_rest(k, prices, room, weight):
    """Return what places cost at least with orders of the types from each on, or free: shape (types + 1, room + 1)."""
    types = len(k.sizes)
    table = np.zeros((types + 1, room + 1))
    for left in range(room + 1):
        table[types, left] = weight * left
    for t in range(types - 1, -1, -1):
        for left in range(room + 1):
            table[t, left] = table[t + 1, left]
            for number in range(1, min(k.counts[t], left // k.sizes[t]) + 1):
                cost = number * prices[t] + table[t + 1, left - number * k.sizes[t]]
                table[t, left] = min(table[t, left], cost)
    return table


@njit(cache=True)
def cheapest_sets(k, prices, room, weight, limit, kept, work, most_work):
    """Return the sets of orders of least cost: the fewest pods that serve them, their prices, and the free places.

    Parameters
    ----------
    k
        Types of orders and pods.
    prices
        What an order of each type costs.
    room
        Places of the station.
    weight
        What a place costs that stays free.
    limit
        Sets that cost as much are left out.
    kept
        How many sets are returned at most: the cheapest.
    work, most_work
        A single number, to which what was tried is added; the answer is complete only if it stays within the other.

    Returns
    -------
    costs, numbers
        Costs of the sets in no order, and how many orders of each type they have.
    """
    types, width = len(k.sizes), k.needs.shape[1]
    table = _cheapest_rest(k, prices, room, weight)
    skus, there = np.zeros((types + 1, width), np.int64), np.zeros(width, np.int64)
    cost, left = np.zeros(types + 1), np.full(types + 1, room)
    least, number = np.zeros(types + 1, np.int64), np.full(types + 1, -1)
    gains = np.zeros(MOST_BITS * width + 1, np.int64)
    costs, numbers, found = np.zeros(kept), np.zeros((kept, types), np.int64), 0
    t, steps = 0, 0
    while t >= 0 and work[0] <= most_work:
        if t == types:
            done = cost[t] + weight * left[t]
            most = int(max(limit - done, 0.0))
            pods, _ = fewest_pods(k, skus[t], least[t], most, work, most_work)
            if done + pods < limit - SLIP:
                place = int(costs.argmax()) if found == kept else found
                work[0] += kept // SETS_PER_WORK if found == kept else 0
                costs[place] = done + pods
                numbers[place] = number[:types]
                found = min(found + 1, kept)
                if found == kept:
                    limit = min(limit, costs.max())
            t -= 1
            continue
        if number[t] < 0:
            number[t] = min(k.counts[t], left[t] // k.sizes[t]) + 1
        number[t] -= 1
        if number[t] < 0:
            t -= 1
            continue
        steps += 1
        if steps == STEPS_PER_WORK:
            work[0] += 1
            steps = 0
        cost[t + 1], left[t + 1] = cost[t] + number[t] * prices[t], left[t] - number[t] * k.sizes[t]
        rest = cost[t + 1] + table[t + 1, left[t + 1]]
        if rest + least[t] >= limit - SLIP:
            continue
        grown = False
        for word in range(width):
            there[word] = skus[t, word] | (k.needs[t, word] if number[t] else 0)
            grown |= there[word] != skus[t, word]
        least[t + 1] = least[t]
        for word in range(width):
            skus[t + 1, word] = there[word]
        if grown:
            work[0] += 1 + len(k.brings) // PODS_PER_WORK
            least[t + 1] = max(least[t], least_pods(k, skus[t + 1], int(limit - rest), gains, there))
            if rest + least[t + 1] >= limit - SLIP:
                continue
        t += 1
        number[t] = -1
    return costs[:found], numbers[:found]


@njit(cache=True)
def _fits(numbers, left):
    """Whether no more orders are wanted than are left."""
    t = 0
    while t < len(left) and numbers[t] <= left[t]:
        t += 1
    return t == len(left)


@njit(cache=True)
def _sets_with(numbers):
    """Return the sets that have orders of each type, ascending, and where those of each type begin."""
    types = numbers.shape[1]
    start, sets = np.zeros(types + 1, np.int64), np.empty((numbers > 0).sum(), np.int64)
    count = 0
    for t in range(types):
        for at in range(len(numbers)):
            if numbers[at, t]:
                sets[count] = at
                count += 1
        start[t + 1] = count
    return start, sets


@njit(cache=True)
def _first_dearer(costs, sets, first, last, most):
    """Return the first place of some sets, ascending in cost, that costs more than ``most``."""
    while first < last:
        middle = (first + last) // 2
        if costs[sets[middle]] > most:
            last = middle
        else:
            first = middle + 1
    return first


@njit(cache=True)
def _to_try(costs, start, sets, prices, left, most, stations):
    """Return from where to where in ``sets`` are those of which one has to be chosen: as few as are known.

    The cheapest set of so many stations costs no more than its share; and orders that are too dear to be left are in
    some set.
    """
    types = len(left)
    first = start[types]
    last = _first_dearer(costs, sets, first, len(sets), most / stations)
    for t in range(types):
        if left[t] and prices[t] > most:
            dearer = _first_dearer(costs, sets, start[t], start[t + 1], most)
            if dearer - start[t] < last - first:
                first, last = start[t], dearer
    return first, last


@njit(cache=True)
def choose(costs, numbers, prices, counts, stations, most, work, most_work):
    """Choose a set of orders for each of some stations, no order twice, such that sets and orders left cost little.

    Parameters
    ----------
    costs, numbers
        Of the sets: costs, ascending and not negative, and how many orders of each type they have.
    prices, counts
        What an order of each type costs that no station gets, and how many orders the type has.
    stations
        How many sets are chosen; one may be chosen again.
    most
        What they and the orders left may cost.
    work, most_work
        A single number, to which what was tried is added; above the other the answer no proves nothing.

    Returns
    -------
    chosen
        Their places in ``costs``; empty if there are none.
    """
    start, of_type = _sets_with(numbers)
    sets = np.concatenate((of_type, np.arange(len(costs))))
    left, spent = np.zeros((stations + 1, len(counts)), np.int64), np.zeros(stations + 1)
    left[0] = counts
    at, last = np.full(stations + 1, -1), np.zeros(stations + 1, np.int64)
    depth = 0
    while depth >= 0 and work[0] <= most_work:
        if depth == stations:
            if spent[depth] + (left[depth] * prices).sum() <= most + SLIP:
                return sets[at[:stations]]
            depth -= 1
            continue
        if at[depth] < 0:
            rest = most + SLIP - spent[depth]
            at[depth], last[depth] = _to_try(costs, start, sets, prices, left[depth], rest, stations - depth)
        else:
            at[depth] += 1
        while at[depth] < last[depth] and not _fits(numbers[sets[at[depth]]], left[depth]):
            at[depth] += 1
            work[0] += 1
        if at[depth] >= last[depth]:
            at[depth] = -1
            depth -= 1
            continue
        work[0] += 1
        chosen = sets[at[depth]]
        spent[depth + 1] = spent[depth] + costs[chosen]
        for t in range(len(counts)):
            left[depth + 1, t] = left[depth, t] - numbers[chosen, t]
        depth += 1
        at[depth] = -1
    return sets[:0]
