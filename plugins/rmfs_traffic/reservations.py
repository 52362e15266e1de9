"""The reservation table: who has which cell when, and what a PP rule that reserves is asked with."""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from typing import NamedTuple

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from rmfs_core.decisions import Rows
from rmfs_traffic.paths import FOREVER, Occupancy, Query, Stop, run_between
from rmfs_traffic.roads import Roads

ROOM = 4
"""Entries set aside for each cell at first."""
Columns = tuple[Rows, Rows, Rows]
NOTHING = np.zeros(0, dtype=np.int64)


class ReservedError(ValueError):
    """A cell is to be reserved that another has then.

    Parameters
    ----------
    cell
        Cell index.
    owner, since, until
        Who has it, and between which ticks.
    """

    def __init__(self, cell: int, owner: int, since: int, until: int) -> None:
        ends = "forever" if until >= FOREVER else f"to {until}"
        super().__init__(f"cell {cell} is reserved by {owner} from tick {since} {ends}")
        self.cell = cell
        self.owner = owner
        self.since = since
        self.until = until


class Intervals(NamedTuple):
    """The table's arrays for a compiled search; `rmfs_traffic.intervals` says how they are laid out."""

    first: NDArray[np.int64]
    count: NDArray[np.int64]  # type: ignore[assignment]  # instead of the method of tuples
    since: NDArray[np.int64]
    until: NDArray[np.int64]
    owner: NDArray[np.int64]


class Reservations:
    """Intervals of ticks, half-open, in which cells are reserved. No two owners ever have a cell at once.

    Parameters
    ----------
    cells
        Number of cells of the layout.
    """

    def __init__(self, cells: int) -> None:
        from rmfs_traffic import intervals  # compiled: imported when needed, for it takes its time

        self._work = intervals
        first, count = np.arange(cells, dtype=np.int64) * ROOM, np.zeros(cells, dtype=np.int64)
        self._room = np.full(cells, ROOM, dtype=np.int64)
        self._used = cells * ROOM
        pool = 2 * self._used
        since, until = np.zeros(pool, dtype=np.int64), np.zeros(pool, dtype=np.int64)
        self.arrays = Intervals(first, count, since, until, np.full(pool, -1, dtype=np.int64))
        """The arrays as they are now; they may be others after the next change."""
        self._cells_of: dict[int, NDArray[np.int64]] = {}

    # Looking

    def reserved(self, cell: int) -> list[tuple[int, int, int]]:
        """(owner, since, until) of a cell's intervals, ascending."""
        first = int(self.arrays.first[cell])
        return [self._entry(p) for p in range(first, first + int(self.arrays.count[cell]))]

    def blocker(self, cell: int, since: int, owner: int = -1) -> int | None:
        """Return who else than ``owner`` has a cell first from a tick on; None when nobody does."""
        return next((who for who, _, end in self.reserved(cell) if who != owner and end > since), None)

    def copy(self) -> Reservations:
        """Return a table of its own with the same reservations, for a rule to try paths in."""
        other = copy(self)
        other.arrays = Intervals(*(array.copy() for array in self.arrays))
        other._room, other._cells_of = self._room.copy(), self._cells_of.copy()
        return other

    # Changing

    def commit(self, owner: int, occupancy: Occupancy) -> None:
        """Reserve what a path occupies instead of all that its owner had before.

        Raises
        ------
        ReservedError
            When another has one of the cells then; nothing is changed in that case.
        """
        new, before = (occupancy.cells, occupancy.since, occupancy.until), self._cells_of.get(owner, NOTHING)
        found, entry, done, self._used = self._work.replace(*new, before, owner, self._used, self._room, *self.arrays)
        if found >= 0:
            raise ReservedError(int(new[0][found]), *self._entry(entry))
        self._cells_of[owner] = new[0]
        if done < len(new[0]):
            self._insert(owner, new, done)

    def settle(self, owner: int, roads: Roads, start: Stop, ends: Rows) -> tuple[Rows, Stop]:
        """Reserve what legs occupy instead of all that their owner had before: `drive` and `commit` in one go.

        ``ends`` has cell and wait of each leg. Returns the columns of an `Occupancy` as rows, and where the legs end.
        """
        before = self._cells_of.get(owner, NOTHING)
        rows, cell, heading, tick, found, entry, done, self._used = self._work.settle(
            *start, ends, *roads.grid, before, owner, self._used, self._room, *self.arrays
        )
        if found >= 0:
            raise ReservedError(int(rows[0, found]), *self._entry(entry))
        if not rows.size:
            run_between(roads, cell, int(ends[heading, 0]))
        self._cells_of[owner] = rows[0]
        if done < rows.shape[1]:
            self._insert(owner, rows, done)
        return rows, Stop(cell, heading, tick)

    def add(self, owner: int, occupancy: Occupancy) -> None:
        """Reserve more for an owner; as `commit`, but what it had stays."""
        self.check(owner, occupancy)
        self._insert(owner, (occupancy.cells, occupancy.since, occupancy.until))

    def hold(self, owner: int, cell: int, since: int) -> None:
        """Reserve one cell more for an owner, without end."""
        cells, begins, ends = (np.array([value], dtype=np.int64) for value in (cell, since, FOREVER))
        self.add(owner, Occupancy(cells, begins, ends))

    def seize(self, owner: int, occupancy: Occupancy) -> set[int]:
        """As `commit`, but who else has one of the cells then loses all that it has reserved of that cell.

        Returns who has lost something. What the table has of them is no whole path any more: the caller this commits
        another one for each of them.
        """
        losers = set()
        while (hit := self._conflict(owner, occupancy)) is not None:
            found, entry = hit
            loser = int(self.arrays.owner[entry])
            self._work.remove(occupancy.cells[found : found + 1], loser, *self.arrays)
            losers.add(loser)
        self.commit(owner, occupancy)
        return losers

    def check(self, owner: int, occupancy: Occupancy) -> None:
        """Raise `ReservedError` when another has one of the cells then."""
        if (hit := self._conflict(owner, occupancy)) is not None:
            raise ReservedError(int(occupancy.cells[hit[0]]), *self._entry(hit[1]))

    def _entry(self, entry: int) -> tuple[int, int, int]:
        """(owner, since, until) of an entry of the pool."""
        _, _, since, until, owner = self.arrays
        return int(owner[entry]), int(since[entry]), int(until[entry])

    def is_free(self, owner: int, occupancy: Occupancy) -> bool:
        """Whether nobody else has one of the cells then."""
        return self._conflict(owner, occupancy) is None

    def release(self, owner: int) -> None:
        """Remove all that an owner has reserved."""
        cells = self._cells_of.pop(owner, None)
        if cells is not None:
            self._work.remove(cells, owner, *self.arrays)

    def forget_before(self, tick: int) -> None:
        """Remove what ended by a tick, so that the table stays as small as what is to come."""
        self._work.forget(tick, *self.arrays)

    def _conflict(self, owner: int, new: Occupancy) -> tuple[int, int] | None:
        """Position of the first interval that another's overlaps, and that one's entry."""
        found, entry = self._work.conflict(new.cells, new.since, new.until, owner, *self.arrays)
        return None if found < 0 else (found, entry)

    def _insert(self, owner: int, new: Columns, done: int = 0) -> None:
        while True:
            done, self._used = self._work.insert(*new, done, owner, self._used, self._room, *self.arrays)
            if done == len(new[0]):
                break
            self._grow()
        before = self._cells_of.get(owner)
        self._cells_of[owner] = new[0] if before is None else np.union1d(before, new[0])

    def _grow(self) -> None:
        """Pack the pool, into a larger one where that leaves little space."""
        needed = int(self.arrays.count.sum()) + 2 * len(self._room)
        pool = max(len(self.arrays.since), 2 * needed)
        since, until = np.zeros(pool, dtype=np.int64), np.zeros(pool, dtype=np.int64)
        owner = np.full(pool, -1, dtype=np.int64)
        self._used = self._work.pack(self._room, *self.arrays, since, until, owner)
        self.arrays = Intervals(*self.arrays[:2], since, until, owner)


@frozen(eq=False)
class Traffic:
    """The other robots' reservations, and the path that is wanted among them.

    Parameters
    ----------
    roads
        The layout as path planning sees it.
    table
        Who has reserved which cell when. For looking only: the way of driving reserves what a path occupies.
    query
        From where, when and where to. A robot that is on its way is planned for from the end of the leg under way.
    """

    roads: Roads
    table: Reservations
    query: Query


@frozen(eq=False)
class FleetTraffic:
    """Reservations of robots; robots with new paths can give up some.

    Parameters
    ----------
    roads
        The layout as path planning sees it.
    table
        Who has reserved which cell when, as long as nothing is replaced. For looking only; plan in a copy.
    under_way
        Cells that robots of the query occupy until their new paths begin: their legs under way, by robot.
    reserved, arrives
        Cells occupied by paths that may be kept, and the ticks at which they end.
    """

    roads: Roads
    table: Reservations
    under_way: Mapping[int, Occupancy]
    reserved: Mapping[int, Occupancy]
    arrives: Mapping[int, int]
