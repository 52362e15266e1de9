"""Compiled look-ups among the entries of pods and SKUs; `pod_sending` says what the arrays are."""

from __future__ import annotations

import numpy as np

from rmfs_core.jit import njit


@njit(cache=True)
def servers(skus, by_sku, first, pod, number, at, station, least, found):
    """Ids, ascending, of the pods with a free item of one of the SKUs that are at ``least`` or beyond, and not here."""
    lowest, highest, count = len(found), -1, 0
    for sku in skus:
        for place in range(first[sku], first[sku + 1]):
            entry = by_sku[place]
            one = pod[entry]
            if number[entry] > 0 and at[one] >= least and at[one] != station and not found[one]:
                found[one] = True
                lowest, highest, count = min(lowest, one), max(highest, one), count + 1
    ids, count = np.empty(count, np.int64), 0
    for one in range(lowest, highest + 1):
        if found[one]:
            found[one] = False
            ids[count] = one
            count += 1
    return ids


@njit(cache=True)
def highest(pods, values):
    """Those of some pods, one at least, with the highest of values by pod."""
    best, count = pods.copy(), 0
    for one in pods:
        if count and values[one] > values[best[0]]:
            count = 0
        if not count or values[one] == values[best[0]]:
            best[count] = one
            count += 1
    return best[:count]


@njit(cache=True)
def items_on(pods, skus, by_sku, first, pod, number, row):
    """Free items of SKUs on pods, shape (pods, SKUs); ``row`` is -1 for every pod, before and afterwards."""
    items = np.zeros((len(pods), len(skus)), np.int64)
    for i in range(len(pods)):
        row[pods[i]] = i
    for column in range(len(skus)):
        for place in range(first[skus[column]], first[skus[column] + 1]):
            entry = by_sku[place]
            if row[pod[entry]] >= 0:
                items[row[pod[entry]], column] = number[entry]
    for one in pods:
        row[one] = -1
    return items


@njit(cache=True)
def with_most(skus, wanted, by_sku, first, pod, number, at, where, sums):
    """Ids of the pods at ``where`` with most of so many items of each SKU, if any; ``sums`` by pod are all zeros."""
    most, count = 1, 0
    for i in range(len(skus)):
        for place in range(first[skus[i]], first[skus[i] + 1]):
            entry = by_sku[place]
            one = pod[entry]
            if at[one] == where and number[entry] > 0:
                sums[one] += min(wanted[i], number[entry])
                if sums[one] > most:
                    most, count = sums[one], 0
                count += sums[one] == most
    ids, count = np.empty(count, np.int64), 0
    for sku in skus:
        for place in range(first[sku], first[sku + 1]):
            one = pod[by_sku[place]]
            if sums[one] == most:
                ids[count] = one
                count += 1
            sums[one] = 0
    return ids


@njit(cache=True)
def change_sums(entries, items, wanted, by_sku, first, pod, sku, known, known_wanted, sums):
    """Bring sums by pod of min(items, items wanted) up to the items of some entries, and what is wanted, by SKU."""
    for i in range(len(entries)):
        entry = entries[i]
        most = known_wanted[sku[entry]]
        sums[pod[entry]] += min(items[i], most) - min(known[entry], most)
        known[entry] = items[i]
    for one in range(len(wanted)):
        most, before = wanted[one], known_wanted[one]
        if most != before:
            for place in range(first[one], first[one + 1]):
                entry = by_sku[place]
                sums[pod[entry]] += min(known[entry], most) - min(known[entry], before)
            known_wanted[one] = most
