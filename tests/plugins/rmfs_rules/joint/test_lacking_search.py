"""The compiled account of what orders lack, over several blocks, against a count of all lines."""

from __future__ import annotations

import numpy as np
import pytest

from rmfs_rules.joint import lacking_search as work
from rmfs_rules.joint.lacking import Lacking

SKUS, STATIONS = 9, 3


def held_against_a_count(orders: Lacking, rows: np.ndarray, at: np.ndarray, there: set[int], chosen: set[int]) -> None:
    """Compare what each order lacks, and what blocks promise; ``rows`` have the places of orders in place of ids."""
    kept = orders.kept
    for place in sorted(there):
        lines = rows[:, rows[0] == place]
        missing = (at[:, lines[1]] >= 0) & (at[:, lines[1]] < lines[2])
        out = work.OUT * ((place in chosen) + bool(missing[-1].any()))
        slot = kept.orders[work.WHERE, place]
        assert kept.lacks[:-1, slot].tolist() == (missing[:-1].sum(axis=1) + out).tolist()
        assert kept.sizes[slot // work.BLOCK] == lines[2].sum()
    for station in range(STATIONS):
        for block in range(kept.counts[work.BLOCKS]):
            slots = slice(block * work.BLOCK, (block + 1) * work.BLOCK)
            of_block = zip(kept.lacks[station, slots].tolist(), kept.places[slots].tolist(), strict=True)
            least, first = min((pair for pair in of_block if pair[1] in there), default=(work.OUT, -1))
            if kept.value[station, block] < 0:
                continue  # not known until it is looked through
            places = 1 if kept.counted[station] else kept.sizes[block]
            assert kept.value[station, block] == (work.NEVER if least >= work.OUT else least * work.SCALE // places)
            if least < work.OUT:
                assert (kept.least[station, block], kept.who[station, block]) == (least, first)


@pytest.mark.parametrize("seed", range(6))
def test_whatever_changes(seed: int) -> None:
    """Orders join, are chosen, and leave, and stations and all pods have other numbers of items."""
    rng = np.random.default_rng(seed)
    orders, rows, there = Lacking(), np.zeros((3, 0), np.int64), set[int]()
    orders.begin(np.array([False, True, False]), SKUS, 8)
    first = 0
    for _ in range(8):
        more = int(rng.integers(1, work.BLOCK))
        lines = [
            (place, sku, int(rng.integers(1, 4)))
            for place in range(first, first + more)
            for sku in rng.choice(SKUS, rng.integers(1, 4), False).tolist()
        ]
        orders.join(np.array(lines, np.int64).T.copy())
        rows = np.concatenate([rows, np.array(lines).T], axis=1)
        there |= {*range(first, first + more)}
        first += more
        at = rng.integers(-1, 4, (STATIONS + 1, SKUS))
        at[-1] = np.maximum(at[-1], 0) + int(rng.integers(3))
        orders.let(at)
        for station in range(STATIONS):
            for block in range(orders.kept.counts[work.BLOCKS]):
                if rng.random() < 0.5:
                    work.look_through(station, block, orders.kept)
        held_against_a_count(orders, rows, at, there, set())
        orders.taken = rng.choice(sorted(there), 3, False).tolist()
        for place in orders.taken:
            work.exclude(orders.kept.orders[work.WHERE, place], work.OUT, orders.kept)
        held_against_a_count(orders, rows, at, there, {*orders.taken})
        orders.let(at)
        gone = {*rng.choice(sorted(there), len(there) // 3, False).tolist()}
        work.leave(np.flatnonzero(np.isin(rows[0], sorted(gone))), orders.kept)
        there -= gone
        held_against_a_count(orders, rows, at, there, set())
        if rng.random() < 0.5:
            work.close_up(orders.kept)
            sizes = np.bincount([rows[2, rows[0] == place].sum() for place in there])
            assert orders.kept.counts[work.BLOCKS] == (-(-sizes // work.BLOCK)).sum()
            held_against_a_count(orders, rows, at, there, set())
        wanted = np.bincount(rows[1], weights=rows[2] * np.isin(rows[0], sorted(there)), minlength=SKUS)
        assert orders.kept.wanted.tolist() == wanted.tolist()
        assert orders.number == len(there)
