"""The compiled work on a table's intervals, held against sets of ticks."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from rmfs_core.traffic import intervals

CELLS, ROOM = 3, 2


class Pool(NamedTuple):
    """The arrays that the functions work on, as `rmfs_core.traffic.intervals` lays them out."""

    room: NDArray[np.int64]
    first: NDArray[np.int64]
    count: NDArray[np.int64]  # type: ignore[assignment]  # in place of the method of tuples
    since: NDArray[np.int64]
    until: NDArray[np.int64]
    owner: NDArray[np.int64]

    def of(self, cell: int) -> list[tuple[int, int, int]]:
        """(since, until, owner) of a cell's intervals."""
        low = self.first[cell]
        columns = (array[low : low + self.count[cell]].tolist() for array in (self.since, self.until, self.owner))
        return list(zip(*columns, strict=True))

    @property
    def looked_at(self) -> tuple[NDArray[np.int64], ...]:
        """The arrays without ``room``, which only who inserts needs."""
        return self[1:]


def pool(size: int) -> Pool:
    """Return an empty pool with room for two intervals of each cell."""
    first = np.arange(CELLS, dtype=np.int64) * ROOM
    room = np.full(CELLS, ROOM, dtype=np.int64)
    zeros = [np.zeros(size, dtype=np.int64) for _ in range(3)]
    return Pool(room, first, np.zeros(CELLS, dtype=np.int64), *zeros)


def column(*values: int) -> NDArray[np.int64]:
    """Return whole numbers as an array."""
    return np.array(values, dtype=np.int64)


def insert(arrays: Pool, used: int, owner: int, *rows: tuple[int, int, int]) -> tuple[int, int]:
    """Insert rows of cell, since and until from the first one on."""
    cells, since, until = (column(*values) for values in zip(*rows, strict=True))
    done, after = intervals.insert(cells, since, until, 0, owner, used, *arrays)
    return int(done), int(after)


def test_what_touches_of_one_owner_becomes_one() -> None:
    """Overlapping or end to end, also across a gap that a third one fills; another owner's stays apart."""
    arrays = pool(20)
    _, used = insert(arrays, 6, 7, (0, 10, 20), (0, 30, 40))
    _, used = insert(arrays, used, 8, (0, 40, 50))
    assert arrays.of(0) == [(10, 20, 7), (30, 40, 7), (40, 50, 8)]
    _, used = insert(arrays, used, 7, (0, 20, 30))
    assert arrays.of(0) == [(10, 40, 7), (40, 50, 8)]
    insert(arrays, used, 7, (0, 15, 25))
    assert arrays.of(0) == [(10, 40, 7), (40, 50, 8)]
    assert (arrays.of(1), arrays.of(2)) == ([], [])


def test_a_full_pool_says_how_far_it_came() -> None:
    """What is in stays in; who called packs it into a larger one and goes on from there."""
    arrays = pool(6)  # nothing is left beside the room of the cells
    done, used = insert(arrays, 6, 7, (0, 0, 5), (1, 0, 5), (0, 10, 15), (2, 0, 5))
    assert (done, used) == (2, 6)
    assert [arrays.of(cell) for cell in range(CELLS)] == [[(0, 5, 7)], [(0, 5, 7)], []]
    larger = pool(30)
    packed = intervals.pack(*arrays, larger.since, larger.until, larger.owner)
    again = Pool(arrays.room, arrays.first, arrays.count, larger.since, larger.until, larger.owner)
    assert packed == arrays.room.sum() <= 30
    done, _ = insert(again, packed, 7, (0, 10, 15), (2, 0, 5))
    assert done == 2
    assert [again.of(cell) for cell in range(CELLS)] == [[(0, 5, 7), (10, 15, 7)], [(0, 5, 7)], [(0, 5, 7)]]


def test_a_conflict_is_the_first_of_what_was_asked_for() -> None:
    """By the place in the question, with the entry of who has it; intervals that touch do not overlap."""
    arrays = pool(20)
    insert(arrays, 6, 7, (0, 10, 20), (1, 0, 5))
    insert(arrays, 6, 8, (2, 0, 5))

    def conflict(me: int, *rows: tuple[int, int, int]) -> tuple[int, int]:
        cells, since, until = (column(*values) for values in zip(*rows, strict=True))
        found, entry = intervals.conflict(cells, since, until, me, *arrays.looked_at)
        return int(found), int(entry)

    assert conflict(9, (0, 0, 10), (0, 20, 30)) == (-1, -1)
    assert conflict(9, (0, 0, 10), (1, 4, 6), (0, 10, 11)) == (1, arrays.first[1])
    assert conflict(7, (0, 0, 30), (1, 0, 5)) == (-1, -1)
    assert conflict(7, (0, 0, 30), (2, 4, 5)) == (1, arrays.first[2])
    assert conflict(9, (0, 0, 10)) == (-1, -1)
    assert conflict(9, (0, 20, 25)) == (-1, -1)
    assert conflict(9, (0, 19, 25)) == (0, arrays.first[0])
    assert conflict(7, (0, 0, 30)) == (-1, -1)


def test_what_is_over_is_forgotten() -> None:
    """An interval that ends at the tick is over; one that goes on stays whole."""
    arrays = pool(20)
    insert(arrays, 6, 7, (0, 0, 10), (0, 12, 20), (1, 0, 11))
    intervals.forget(10, *arrays.looked_at)
    assert [arrays.of(cell) for cell in range(CELLS)] == [[(12, 20, 7)], [(0, 11, 7)], []]


STEPS = st.lists(
    st.tuples(st.integers(0, CELLS - 1), st.integers(0, 20), st.integers(1, 8), st.integers(0, 2), st.integers(0, 5)),
    max_size=25,
)


@given(STEPS)
@settings(max_examples=60)
def test_intervals_are_the_ticks_of_each_owner(steps: list[tuple[int, int, int, int, int]]) -> None:
    """Inserted where free, removed, and asked for in whatever order: as with a set of ticks for each owner and cell."""
    arrays, used = pool(2000), CELLS * ROOM
    ticks: dict[tuple[int, int], set[int]] = {}
    for cell, begin, length, owner, action in steps:
        wanted = set(range(begin, begin + length))
        others = set().union(*(found for (at, who), found in ticks.items() if at == cell and who != owner))
        asked = (column(cell), column(begin), column(begin + length))
        free = intervals.conflict(*asked, owner, *arrays.looked_at) == (-1, -1)
        assert free == (not wanted & others)
        if action == 0:
            intervals.remove(column(cell), owner, *arrays.looked_at)
            ticks.pop((cell, owner), None)
        elif free:
            _, used = insert(arrays, used, owner, (cell, begin, begin + length))
            ticks.setdefault((cell, owner), set()).update(wanted)
        for at in range(CELLS):
            rows = arrays.of(at)
            assert all(one[1] <= next_[0] for one, next_ in pairwise(rows))
            for who in range(3):
                has = [tick for since, until, owner_ in rows if owner_ == who for tick in range(since, until)]
                assert has == sorted(ticks.get((at, who), set()))
