"""All sets of k pods for one station, each with the best orders that it serves: the compiled part of pricing."""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True)
def best_sets(k, room, n_skus, kept, pod_start, pod_sku, type_start, type_sku, sizes, counts, values):  # type: ignore[no-untyped-def]  # noqa: PLR0912 (one compiled loop)
    """Return the worths of the best sets of ``k`` pods and the sets, in no order; -1 where there are fewer.

    The worth of a set is the greatest sum of ``values`` over orders of at most ``room`` items whose missing SKUs
    (``type_start``, ``type_sku``) are all on its pods (``pod_start``, ``pod_sku``): a bounded knapsack.
    """
    n = len(pod_start) - 1
    worths = np.full(kept, -1.0)
    sets = np.zeros((kept, k), np.int64)
    if k > n:
        return worths, sets
    chosen = np.arange(k)
    held = np.zeros(n_skus, np.int64)
    for pod in range(k):
        for at in range(pod_start[pod], pod_start[pod + 1]):
            held[pod_sku[at]] += 1
    best = np.zeros(room + 1)
    worst = 0
    while True:
        best[:] = 0.0
        for number in range(len(sizes)):
            if values[number] <= 0:
                continue
            served = True
            for at in range(type_start[number], type_start[number + 1]):
                if held[type_sku[at]] == 0:
                    served = False
                    break
            if not served:
                continue
            size = sizes[number]
            for _ in range(min(counts[number], room // size)):
                for place in range(room, size - 1, -1):
                    best[place] = max(best[place], best[place - size] + values[number])
        if best[room] > worths[worst]:
            worths[worst] = best[room]
            sets[worst, :] = chosen
            worst = int(np.argmin(worths))
        last = k - 1
        while last >= 0 and chosen[last] == n - k + last:
            last -= 1
        if last < 0:
            return worths, sets
        for place in range(last, k):
            for at in range(pod_start[chosen[place]], pod_start[chosen[place] + 1]):
                held[pod_sku[at]] -= 1
        chosen[last] += 1
        for place in range(last + 1, k):
            chosen[place] = chosen[place - 1] + 1
        for place in range(last, k):
            for at in range(pod_start[chosen[place]], pod_start[chosen[place] + 1]):
                held[pod_sku[at]] += 1
