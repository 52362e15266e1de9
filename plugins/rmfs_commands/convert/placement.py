"""Which SKUs stand on which pods, and how many items of each.

Every SKU gets a pod first; the places that are left are shared out:

``random``
    Every SKU gets as many further pods as any other, anywhere.
``popularity``
    Further pods in proportion to the square root of order lines, so that what is wanted often can be had from many pods
    (scattered storage: Weidinger and Boysen 2018, doi:10.1287/trsc.2017.0779) and what is wanted seldom not from one.
``co-purchase``
    As many pods as with ``popularity``; SKUs that are bought together stand on the same pod, greedily: the most wanted
    SKU that still needs a pod, then again and again the one that the orders hold most often together with those on the
    pod (after the correlated storage of Mirzaei, Zaerpour and de Koster 2021, doi:10.1016/j.tre.2020.102207).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rmfs_commands.convert.lines import Sku
from rmfs_core.errors import InputError

PLACEMENTS = ("random", "popularity", "co-purchase")
_LEAST_LINES = 0.5
"""Order lines that a SKU counts as if no order wanted it: fewer than any other has."""


def place(
    skus: Sequence[Sku],
    rooms: Sequence[int],
    placement: str,
    rng: np.random.Generator,
    baskets: Iterable[Sequence[str]] = (),
    most: NDArray[np.int64] | None = None,
) -> list[list[int]]:
    """Return the SKUs of each pod, as positions in ``skus``; no pod has a SKU twice.

    Parameters
    ----------
    skus
        SKUs to place, most order lines first; those without order lines get a pod anywhere.
    rooms
        How many SKUs each pod holds.
    placement
        One of `PLACEMENTS`.
    rng
        Source of randomness.
    baskets
        SKU names of orders, for ``co-purchase``.
    most
        On how many pods each SKU can stand; None: on all.

    Raises
    ------
    InputError
        When the pods have fewer places than there are SKUs.
    """
    pods, places = len(rooms), sum(rooms)
    if places < len(skus):
        raise InputError(
            "--pods, --skus-per-pod",
            f"found {pods:,} pods of {max(rooms):,} SKUs, {places:,} places for {len(skus):,} SKUs; "
            f"expected --skus-per-pod {ceil(len(skus) / pods)} or more, or more pods",
        )
    copies = copies_of(skus, places, placement, rng, np.full(len(skus), pods) if most is None else most)
    if placement != "co-purchase":
        return anywhere(copies, rooms, [[] for _ in rooms], rng)
    known = np.where([sku.lines > 0 for sku in skus], copies, 0)
    held = _together(skus, known, rooms, baskets, rng)
    there = np.bincount([sku for pod in held for sku in pod], minlength=len(skus))
    return anywhere(np.where(there > 0, 0, np.maximum(copies - known, 1)), rooms, held, rng)


def items_on(skus: Sequence[Sku], pods: Sequence[Sequence[int]], items: int) -> tuple[NDArray[np.int64], int]:
    """Return how many items of each SKU stand on each of its pods, and for how many SKUs that is more than ``items``.

    More than ``items`` where all pods of a SKU would hold fewer than the orders want of it in all.
    """
    copies = np.zeros(len(skus), dtype=np.int64)
    for pod in pods:
        copies[pod] += 1
    wanted = np.array([sku.items for sku in skus], dtype=np.int64)
    needed = -(-wanted // copies)
    return np.maximum(needed, items), int((needed > items).sum())


def copies_of(
    skus: Sequence[Sku], places: int, placement: str, rng: np.random.Generator, most: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Return on how many pods each SKU stands: from 1 to ``most``, ``places`` in all or as many as there can be."""
    n = len(skus)
    weight = np.ones(n)
    if placement != "random":
        weight = np.sqrt(np.maximum([sku.lines for sku in skus], _LEAST_LINES))
    copies = np.ones(n, dtype=np.int64)
    spare = min(places, int(most.sum())) - n
    while spare > 0:
        open_ = copies < most
        share = np.where(open_, weight, 0.0)
        exact = spare * share / share.sum()
        more = np.minimum(np.floor(exact).astype(np.int64), most - copies)
        if (more + 1 > exact).all():  # what is left goes to the largest remainders, drawn among equals
            order = np.lexsort((rng.random(n), more - exact))
            order = order[copies[order] + more[order] < most[order]]
            more[order[: spare - int(more.sum())]] += 1
        copies += more
        spare -= int(more.sum())
    return copies


def anywhere(
    copies: NDArray[np.int64], rooms: Sequence[int], held: Sequence[Sequence[int]], rng: np.random.Generator
) -> list[list[int]]:
    """Put each SKU on that many pods that lack it: those with most room, drawn among equals.

    On fewer where fewer have room.
    """
    held = [list(pod) for pod in held]
    left = np.array(rooms) - [len(pod) for pod in held]
    for sku in sorted(np.flatnonzero(copies).tolist(), key=lambda sku: -copies[sku]):
        chosen = np.lexsort((rng.random(len(held)), -left))[: copies[sku]]
        chosen = chosen[: max(1, int((left[chosen] > 0).sum()))]
        left[chosen] -= 1
        for pod in chosen:
            held[pod].append(sku)
    return [sorted(pod) for pod in held]


def _together(
    skus: Sequence[Sku],
    copies: NDArray[np.int64],
    rooms: Sequence[int],
    baskets: Iterable[Sequence[str]],
    rng: np.random.Generator,
) -> list[list[int]]:
    """Fill pod after pod with SKUs that are bought together."""
    affinity = affinity_of(skus, baskets)
    left = copies.copy()
    noise = rng.random(len(skus)) * 0.5  # ties only: affinities and lines are whole numbers
    lines = np.array([sku.lines for sku in skus], dtype=float)
    held: list[list[int]] = []
    to_come = sum(rooms)
    for number, most in enumerate(rooms):
        room = min(most, -(-int(left.sum()) * most // max(to_come, 1)))
        to_come -= most
        pod: list[int] = []
        score = np.zeros(len(skus))
        while len(pod) < room:
            # A SKU that stands on as many pods as are still to come has to be on each of them.
            due = np.where(left >= len(rooms) - number, np.inf, 0.0)
            rank = np.where(left > 0, due + score * 1e6 + lines + noise, -1.0)
            rank[pod] = -1.0
            best = int(rank.argmax())
            if rank[best] < 0:
                break
            pod.append(best)
            left[best] -= 1
            begin, end = affinity.indptr[best], affinity.indptr[best + 1]
            score[affinity.indices[begin:end]] += affinity.data[begin:end]
        held.append(sorted(pod))
    return held


def affinity_of(skus: Sequence[Sku], baskets: Iterable[Sequence[str]]) -> Any:
    """Return how many orders hold both of two SKUs, as a sparse matrix in rows."""
    from scipy.sparse import csr_matrix

    position = {sku.name: i for i, sku in enumerate(skus)}
    begins, columns = [0], []
    for basket in baskets:
        columns += [position[name] for name in basket]
        begins.append(len(columns))
    ones = np.ones(len(columns), dtype=np.int64)
    holds = csr_matrix((ones, columns, begins), shape=(len(begins) - 1, len(skus)))
    together: Any = holds.T @ holds
    return together.tocsr()
