"""Sets of pods that complete orders of enough worth, found by branch and bound: compiled, and exact.

An order counts as completed when each of its SKUs is on a pod of the set or at hand at some station. `next_set` names
the sets one by one, `best_sets` the best of those for a single station, with a knapsack of the orders that fit there.

The bound. Let r more pods R complete an order with m missing SKUs and worth w. A pod of R that brings c of them gets
the share w c / m, and the shares of R add up to at least w. Unless c = m, the pod earns its share only with others: for
each of the m - c SKUs that it lacks, another pod of R brings it, and w c / m / (m - c) is put on that pair of pods. So
what R completes is worth at most the sum over its pods of: what the pod completes alone, plus its r - 1 largest pairs.
Where the period is large, a pod has no share, and a pair no part of it, if the best of the other candidates could not
bring what is missing then. The sum of the r largest of these potentials bounds any R; a pod whose potential with the
r - 1 largest others is too small is in none. This is the bound of Gilmore (1962, https://doi.org/10.1137/0110022) and
Lawler (1963, https://doi.org/10.1287/mnsc.9.4.586) for quadratic assignment, carried over to orders.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rmfs_core.jit import njit

MOST_BITS = 62
"""Bits of a number that stand for SKUs of an order."""
SLIP = 1e-6
"""Most that rounding may take from a bound."""


class Sets(NamedTuple):
    """State of a search for sets of pods: one row for each number of pods chosen so far.

    Parameters
    ----------
    worth
        Weight of each order (nothing, if not positive).
    least
        Least worth of a set, a single number; it may be raised during the search.
    depth
        Number of pods chosen, a single number.
    chosen
        The pods chosen.
    there
        SKUs at hand or on the chosen pods.
    value
        Worth of the orders that they complete.
    pods, potential, left, at
        Pods that may come next, best first, with their potentials; how many, and which is next (-1: not yet looked at).
    """

    worth: NDArray[np.float64]
    least: NDArray[np.float64]
    depth: NDArray[np.int64]
    chosen: NDArray[np.int64]
    there: NDArray[np.bool_]
    value: NDArray[np.float64]
    pods: NDArray[np.int64]
    potential: NDArray[np.float64]
    left: NDArray[np.int64]
    at: NDArray[np.int64]


@njit(cache=True)
def copied(source, target):
    """Copy an array to the beginning of another: what an assignment does, and is compiled in a tenth of its time."""
    for at in range(len(source)):
        target[at] = source[at]


@njit(cache=True)
def _missing(a, order, there, skus):
    """Write the SKUs that an order misses; return their number."""
    count = 0
    for line in range(a.order_start[order], a.order_start[order + 1]):
        if not there[a.line_sku[line]]:
            skus[count] = a.line_sku[line]
            count += 1
    return count


@njit(cache=True)
def _candidates_for(a, skus, place, touching, brings, which):
    """Write the candidates that bring some of the SKUs, how many, and which (bits, of the first `MOST_BITS`).

    Return their number (0: a SKU is on none).
    """
    count = 0
    for number, sku in enumerate(skus):
        alive, bit = False, 1 << min(number, MOST_BITS)
        for at in range(a.sku_start[sku], a.sku_start[sku + 1]):
            pod = a.sku_pod[at]
            if place[pod] >= 0:
                alive = True
                if brings[pod] == 0:
                    touching[count] = pod
                    which[pod] = 0
                    count += 1
                brings[pod] += 1
                which[pod] |= bit
        if not alive:
            for at in range(count):
                brings[touching[at]] = 0
            return 0
    return count


@njit(cache=True)
def ones(bits):
    """Return how many bits of a number are set."""
    count = 0
    while bits:
        count += 1
        bits &= bits - 1
    return count


@njit(cache=True)
def _others(brings, touching, numbers, more):
    """Return how many SKUs of an order the best ``more - 1`` pods bring at most, and the best ``more - 2``."""
    for c in range(len(numbers)):
        numbers[c] = 0
    for pod in touching:
        numbers[brings[pod]] += 1
    second, third, left = 0, 0, more - 1
    for c in range(len(numbers) - 1, 0, -1):
        taken = min(left, numbers[c])
        second += c * taken
        third += c * min(taken, max(left - 1, 0))
        left -= taken
    return second, third


@njit(cache=True)
def potentials(a, worth, pods, there, more):
    """Bound what each of the pods adds to the worth of the completed orders as one of ``more`` of them.

    Parameters
    ----------
    a
        The period (`compiled.arrays.Arrays`).
    worth
        Weight of each order.
    pods
        The pods to choose from.
    there
        SKUs that are at hand or on pods chosen before.
    more
        Number of pods still to choose.
    """
    n, total = len(pods), len(a.pod_start) - 1
    place, brings, touching = np.full(total, -1), np.zeros(total, np.int64), np.empty(total, np.int64)
    which = np.zeros(total, np.int64)
    largest = 0
    for at in range(n):
        place[pods[at]] = at
        largest = max(largest, a.pod_start[pods[at] + 1] - a.pod_start[pods[at]])
    pairs = n if more > 1 else 0
    alone, pair = np.zeros(n), np.zeros((pairs, pairs))
    numbers = np.zeros(len(there) + 1, np.int64)
    skus = np.empty(len(there), np.int64)
    for order in range(len(a.order_start) - 1):
        if worth[order] <= 0:
            continue
        m = _missing(a, order, there, skus)
        if m == 0 or m > more * largest:
            continue
        count = _candidates_for(a, skus[:m], place, touching, brings, which)
        others, third = m, m  # what the set brings of the order at most, besides one of its pods, and besides two
        if a.sharp:
            others, third = _others(brings, touching[:count], numbers[: m + 1], more)
        for x in range(count):
            pod = touching[x]
            c = brings[pod]
            if c == m:
                alone[place[pod]] += worth[order]
            elif more > 1 and c + others >= m:
                share = worth[order] * c / m / (m - c)
                for y in range(count):
                    if y != x:
                        other = touching[y]
                        # How many of the SKUs that it lacks the other one brings, or more
                        helps = ones(which[other] & ~which[pod]) if m < MOST_BITS else min(brings[other], m - c)
                        if c + helps + third >= m:
                            pair[place[pod], place[other]] += share * helps
        for x in range(count):
            brings[touching[x]] = 0
    _add_largest(alone, pair, min(more - 1, n))
    return alone


@njit(cache=True)
def _add_largest(alone, pair, number):
    """Add the largest so many pairs of each row to what the pod completes alone."""
    for at in range(len(alone)):
        for _ in range(number):
            best = pair[at].argmax()
            if pair[at, best] == 0.0:
                break
            alone[at] += pair[at, best]
            pair[at, best] = 0.0


@njit(cache=True)
def _promising(a, worth, pods, there, more, short):
    """Move those of the pods that may be in a set of ``more`` that adds ``short`` in worth to the front, best first.

    Return how many they are, and their potentials.
    """
    while True:
        potential, kept, others = potentials(a, worth, pods, there, more), 0, 0.0
        for place in range(len(pods)):
            best = place + potential[place:].argmax()
            pods[place], pods[best] = pods[best], pods[place]
            potential[place], potential[best] = potential[best], potential[place]
            if place < more - 1:
                others += potential[place]
            elif others + potential[place] < short - SLIP:
                break
            kept = place + 1
        if kept < more:
            return 0, potential
        if kept == len(pods) or more == 1:
            return kept, potential
        pods = pods[:kept]


@njit(cache=True)
def complete(a, order, there):
    """Whether all SKUs of an order are there: a table of these, or of the bit masks of the stations that have them."""
    line, last = a.order_start[order], a.order_start[order + 1]
    while line < last and there[a.line_sku[line]] != 0:
        line += 1
    return line == last


@njit(cache=True)
def _value_of(a, worth, there):
    """Return the worth of the orders that these SKUs complete."""
    value = 0.0
    for order in range(len(a.order_start) - 1):
        if worth[order] > 0 and complete(a, order, there):
            value += worth[order]
    return value


@njit(cache=True)
def sets_of(a, number, worth, least):
    """Return a search, for `next_set`, of sets of so many pods that complete orders of at least some worth."""
    n, rows = len(a.pod_start) - 1, number + 1
    there, pods = np.zeros((rows, len(a.at_hand)), np.bool_), np.zeros((rows, n), np.int64)
    value, left, at = np.zeros(rows), np.zeros(rows, np.int64), np.full(rows, -1)
    copied(a.at_hand > 0, there[0])
    copied(np.arange(n), pods[0])
    left[0] = n
    value[0] = _value_of(a, worth, there[0])
    chosen, depth, goal = np.zeros(number, np.int64), np.zeros(1, np.int64), np.full(1, float(least))
    return Sets(worth, goal, depth, chosen, there, value, pods, np.zeros((rows, n)), left, at)


@njit(cache=True)
def next_set(a, s, work, most_work):
    """Go on to the next set, ``s.chosen``; return whether there is one.

    Parameters
    ----------
    a
        The period.
    s
        The search.
    work, most_work
        A single number, to which the pods looked at are added; above the other the answer no proves nothing.
    """
    number = len(s.chosen)
    depth = s.depth[0]
    if depth == number and s.at[depth] < 0 and s.value[depth] >= s.least[0] - SLIP:
        s.at[depth] = 0
        return True
    if depth == number:
        depth -= 1
    while depth >= 0 and work[0] <= most_work:
        more, short = number - depth, s.least[0] - s.value[depth]
        if s.at[depth] < 0:
            work[0] += 1 + s.left[depth]
            open_pods = s.pods[depth, : s.left[depth]]
            s.left[depth], potential = _promising(a, s.worth, open_pods, s.there[depth], more, short)
            copied(potential, s.potential[depth])
            s.at[depth] = 0
        first = s.at[depth]
        if s.left[depth] - first < more or s.potential[depth, first : first + more].sum() < short - SLIP:
            depth -= 1  # the pods that are left here cannot do it
            continue
        s.at[depth] += 1
        s.chosen[depth] = s.pods[depth, first]
        _choose(a, s, depth, first)
        depth += 1
        if depth == number and s.value[depth] >= s.least[0] - SLIP:
            s.depth[0], s.at[depth] = depth, 0
            return True
        if depth == number:
            depth -= 1
    s.depth[0] = depth
    return False


@njit(cache=True)
def _choose(a, s, depth, first):
    """Set up the row after the choice of a pod: the pods before it were tried with all others."""
    copied(s.there[depth], s.there[depth + 1])
    for brought in range(a.pod_start[s.chosen[depth]], a.pod_start[s.chosen[depth] + 1]):
        s.there[depth + 1, a.pod_sku[brought]] = True
    s.left[depth + 1], s.at[depth + 1] = s.left[depth] - first - 1, -1
    copied(s.pods[depth, first + 1 : s.left[depth]], s.pods[depth + 1])
    s.value[depth + 1] = _value_of(a, s.worth, s.there[depth + 1])


@njit(cache=True)
def _knapsack(a, values, there, best):
    """Return the greatest sum of values of completed orders that fit into one station."""
    room = len(best) - 1
    for place in range(room + 1):
        best[place] = 0.0
    for order in range(len(a.order_start) - 1):
        if values[order] > 0 and complete(a, order, there):
            size = a.items[order]
            for place in range(room, size - 1, -1):
                best[place] = max(best[place], best[place - size] + values[order])
    return best[room]


@njit(cache=True)
def best_sets(a, number, values, least, kept, work, most_work):
    """Return the best sets of pods for one station, each worth the best orders that it completes and that fit there.

    Parameters
    ----------
    a
        The period (`compiled.arrays.Arrays`).
    number
        Number of pods in a set.
    values
        Weight of each order.
    least
        Least worth of a set.
    kept
        How many sets are returned at most: the best.
    work, most_work
        A single number, to which what was tried is added; the answer is complete only if it stays within the other.

    Returns
    -------
    worths, sets
        In no order.
    """
    best = np.zeros(a.rooms[0] + 1)
    worths, sets, found = np.zeros(kept), np.zeros((kept, number), np.int64), 0
    search = sets_of(a, number, values, least)
    while next_set(a, search, work, most_work):
        work[0] += 1
        worth = _knapsack(a, values, search.there[number], best)
        if worth < search.least[0] - SLIP:
            continue
        place = int(worths.argmin()) if found == kept else found
        worths[place] = worth
        copied(search.chosen, sets[place])
        found = min(found + 1, kept)
        if found == kept:
            search.least[0] = max(least, worths.min() + 2 * SLIP)  # what is kept is not replaced by equals
    return worths[:found], sets[:found]
