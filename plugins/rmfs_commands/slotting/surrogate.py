"""The surrogate: how many pods the orders of a batch need, each batch served alone by one station.

Pods are taken greedily, the one with the most lines that are still open first. This leaves out quantities, the orders
of other stations and those to come, so its figures are no forecast; differences between placements are what it is for.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from rmfs_core.jit import njit

Ints = NDArray[np.int64]


@frozen(eq=False)
class Batches:
    """Batches of orders.

    Parameters
    ----------
    skus
        SKU ids of all batches, one after the other, each once a batch.
    starts
        Where each batch begins in ``skus``, and the end of the last. Shape (batches + 1,).
    of_sku, sku_starts
        The same the other way round: the batches of each SKU, ascending.
    orders
        How many orders there are in all.
    """

    skus: Ints
    starts: Ints
    of_sku: Ints
    sku_starts: Ints
    orders: int

    @classmethod
    def of(cls, baskets: Sequence[Sequence[int]], size: int, skus: int, most: int | None = None) -> Batches:
        """Return batches of so many orders that arrive one after the other; at most so many batches, evenly spread."""
        begins = list(range(0, len(baskets), size))
        if most is not None and len(begins) > most:
            begins = [begins[i * len(begins) // most] for i in range(most)]
        chosen = [baskets[begin : begin + size] for begin in begins]
        sets = [sorted({sku for basket in batch for sku in basket}) for batch in chosen]
        flat, starts = _flat(sets)
        batch = np.repeat(np.arange(len(sets)), np.diff(starts))
        order = np.argsort(flat, kind="stable")
        sku_starts = np.concatenate(([0], np.cumsum(np.bincount(flat, minlength=skus))))
        return cls(flat, starts, batch[order], sku_starts.astype(np.int64), sum(map(len, chosen)))


def _flat(lists: Iterable[Sequence[int]]) -> tuple[Ints, Ints]:
    lists = list(lists)
    starts = np.concatenate(([0], np.cumsum([len(one) for one in lists]))).astype(np.int64)
    return np.array([entry for one in lists for entry in one], dtype=np.int64), starts


@frozen(eq=False)
class Shelves:
    """Which SKUs stand where, as arrays that a search changes in place.

    Parameters
    ----------
    held
        SKU ids by pod, -1 behind the last. Shape (pods, most SKUs of a pod).
    loads
        Space that the items of each take. The same shape.
    rooms
        Number of SKUs of each pod.
    free
        Space that is free on each pod.
    where
        Pods of each SKU, -1 behind the last. Shape (SKUs, most pods of a SKU).
    copies
        Number of pods of each SKU.
    """

    held: Ints
    loads: Ints
    rooms: Ints
    free: Ints
    where: Ints
    copies: Ints

    @classmethod
    def of(cls, held: Sequence[Sequence[int]], loads: Sequence[Sequence[int]], space: int, skus: int) -> Shelves:
        """Return the arrays of pods, on each of which there is so much space."""
        pods: list[list[int]] = [[] for _ in range(skus)]
        for pod, of_pod in enumerate(held):
            for sku in of_pod:
                pods[sku].append(pod)
        free = np.array([space - sum(of_pod) for of_pod in loads], dtype=np.int64)
        rooms, copies = (np.array([len(one) for one in many], dtype=np.int64) for many in (held, pods))
        return cls(_padded(held), _padded(loads), rooms, free, _padded(pods), copies)

    def visits(self, batches: Batches) -> tuple[float, Ints]:
        """Return the visits per order, and the number of visits of each pod."""
        tally = np.zeros(len(self.rooms), dtype=np.int64)
        of_batch = _visits(batches.skus, batches.starts, self.where, self.copies, tally)
        return float(of_batch.sum()) / max(batches.orders, 1), tally

    def search(self, batches: Batches, draws: NDArray[np.float64]) -> None:
        """Exchange SKUs of two pods wherever the batches need no more visits after it; one attempt a row of draws."""
        _search(*self._arrays(batches), draws, True)

    def gains(self, batches: Batches, draws: NDArray[np.float64]) -> Ints:
        """Return, for each row of draws, what an exchange would save, and change nothing.

        Columns: saved visits, pod and position on it of one SKU, pod and position of the other; saved is 0 where there
        is nothing to exchange.
        """
        return np.asarray(_search(*self._arrays(batches), draws, False))

    def _arrays(self, batches: Batches) -> tuple[Ints, ...]:
        own = (self.held, self.loads, self.rooms, self.free, self.where, self.copies)
        return (*own, batches.skus, batches.starts, batches.of_sku, batches.sku_starts)

    def exchange(self, pod: int, at: int, other: int, there: int) -> None:
        """Exchange the SKUs at two positions of two pods."""
        _exchange(self.held, self.loads, self.free, self.where, self.copies, pod, at, other, there)


def _padded(lists: Sequence[Sequence[int]]) -> Ints:
    found = np.full((len(lists), max(map(len, lists), default=0)), -1, dtype=np.int64)
    for row, one in enumerate(lists):
        found[row, : len(one)] = one
    return found


@njit(cache=True)
def _cover(  # noqa: PLR0912 (compiled, and called for each batch: a function more would cost time)
    skus, begin, end, where, copies, count, touched, left, tally
):
    """Return the visits of one batch; ``count`` is all 0 before and after, and ``tally`` counts the pods if it can."""
    n_touched, open_, visits = 0, end - begin, 0
    for i in range(open_):
        sku = skus[begin + i]
        left[i] = sku
        for k in range(copies[sku]):
            pod = where[sku, k]
            if count[pod] == 0:
                touched[n_touched] = pod
                n_touched += 1
            count[pod] += 1
    while open_ > 0:
        best, most = -1, 0
        for t in range(n_touched):
            pod = touched[t]
            if count[pod] > most or (count[pod] == most and pod < best):
                best, most = pod, count[pod]
        visits += 1
        if tally.size:
            tally[best] += 1
        kept = 0
        for i in range(open_):
            sku, here = left[i], False
            for k in range(copies[sku]):
                if where[sku, k] == best:
                    here = True
                    break
            if here:
                for k in range(copies[sku]):
                    count[where[sku, k]] -= 1
            else:
                left[kept] = sku
                kept += 1
        open_ = kept
    return visits


@njit(cache=True)
def _visits(skus, starts, where, copies, tally):
    """Return the visits of each batch."""
    found = np.zeros(starts.size - 1, dtype=np.int64)
    count = np.zeros(tally.size, dtype=np.int64)
    touched, left = np.zeros(tally.size, dtype=np.int64), np.zeros(copies.size, dtype=np.int64)
    for batch in range(found.size):
        found[batch] = _cover(skus, starts[batch], starts[batch + 1], where, copies, count, touched, left, tally)
    return found


@njit(cache=True)
def _stands_on(where, copies, sku, pod):
    """Return where a pod is among those of a SKU; -1 where it is not."""
    for k in range(copies[sku]):
        if where[sku, k] == pod:
            return k
    return -1


@njit(cache=True)
def _exchange(held, loads, free, where, copies, pod, at, other, there):
    sku, second = held[pod, at], held[other, there]
    where[sku, _stands_on(where, copies, sku, pod)] = other
    where[second, _stands_on(where, copies, second, other)] = pod
    held[pod, at], held[other, there] = second, sku
    more = loads[other, there] - loads[pod, at]
    loads[pod, at], loads[other, there] = loads[other, there], loads[pod, at]
    free[pod] -= more
    free[other] += more


@njit(cache=True)
def _search(held, loads, rooms, free, where, copies, skus, starts, of_sku, sku_starts, draws, keep):
    """Try an exchange a row of draws: bring a SKU of a batch to a pod with another SKU of the batch."""
    n_batches = starts.size - 1
    value = _visits(skus, starts, where, copies, np.zeros(rooms.size, dtype=np.int64))
    count, touched = np.zeros(rooms.size, dtype=np.int64), np.zeros(rooms.size, dtype=np.int64)
    left, none = np.zeros(copies.size, dtype=np.int64), np.zeros(0, dtype=np.int64)
    seen, after = np.full(n_batches, -1, dtype=np.int64), np.zeros(n_batches, dtype=np.int64)
    found = np.zeros((draws.shape[0], 5), dtype=np.int64)
    for t in range(draws.shape[0]):
        begin, end = starts[int(draws[t, 0] * n_batches)], starts[int(draws[t, 0] * n_batches) + 1]
        if end - begin < 2:
            continue
        sku = skus[begin + int(draws[t, 1] * (end - begin))]
        mate = skus[begin + int(draws[t, 2] * (end - begin))]
        pod, other = where[sku, int(draws[t, 3] * copies[sku])], where[mate, int(draws[t, 4] * copies[mate])]
        there = int(draws[t, 5] * rooms[other])
        second = held[other, there]
        if second == mate or _stands_on(where, copies, sku, other) >= 0 or _stands_on(where, copies, second, pod) >= 0:
            continue
        at = 0
        while held[pod, at] != sku:
            at += 1
        more = loads[other, there] - loads[pod, at]
        if more > free[pod] or -more > free[other]:
            continue
        _exchange(held, loads, free, where, copies, pod, at, other, there)
        saved = 0
        for one in (sku, second):
            for i in range(sku_starts[one], sku_starts[one + 1]):
                batch = of_sku[i]
                if seen[batch] != t:
                    seen[batch] = t
                    after[batch] = _cover(
                        skus, starts[batch], starts[batch + 1], where, copies, count, touched, left, none
                    )
                    saved += value[batch] - after[batch]
        found[t] = saved, pod, at, other, there
        if not keep or saved < 0:
            _exchange(held, loads, free, where, copies, pod, at, other, there)
            continue
        for one in (sku, second):
            for i in range(sku_starts[one], sku_starts[one + 1]):
                value[of_sku[i]] = after[of_sku[i]]
    return found
