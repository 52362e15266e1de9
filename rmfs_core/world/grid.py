"""A layout: what each cell is and which moves leave it."""

from __future__ import annotations

from collections.abc import Container, Iterable
from enum import IntEnum
from functools import cached_property

import numpy as np
from attrs import define, frozen
from numpy.typing import NDArray

from rmfs_core.entrypoints import format_module
from rmfs_core.errors import InputError

EAST, NORTH, WEST, SOUTH = range(4)
STEPS = ((1, 0), (0, -1), (-1, 0), (0, 1))
"""(columns, rows) of a step in each heading; row 0 is the northernmost."""
LONGEST_SIDE, MOST_CELLS = 5_000, 4_000_000
"""Of any map. Robots' times on straight runs are tables of the longest side squared: 0.8 GB at 5,000 cells."""


class CellKind(IntEnum):
    """The kind of a cell."""

    WALL = 0
    FLOOR = 1
    STORAGE = 2
    QUEUE = 3
    STATION = 4
    CHARGER = 5
    MAINTENANCE = 6


RESTING = (CellKind.STORAGE, CellKind.CHARGER, CellKind.MAINTENANCE)
"""Cells that robots rest in and, without a pod, cross."""


@frozen
class StationCells:
    """The cells of a station.

    Parameters
    ----------
    station
        Cell index of the station itself.
    queue
        Cell indices of the queue, from the one next to the station to the entry.
    clear
        How many of them, next to the station, are passed only: nobody waits there, so that the next pod rolls in.
    """

    station: int
    queue: tuple[int, ...]
    clear: int = 0

    @property
    def places(self) -> int:
        """How many robots can wait in the queue."""
        return len(self.queue) - self.clear

    def slot(self, position: int) -> int:
        """Cell of a position in line: 0 is the station, 1 the first where one waits; beyond the queue, its entry."""
        return self.station if position == 0 else self.queue[min(position + self.clear, len(self.queue)) - 1]


@define(eq=False, frozen=True, slots=False)
class Layout:
    """A grid of 1 m x 1 m cells. Cell index = row * width + column; row 0 is north, column 0 west.

    Parameters
    ----------
    width, height
        Columns and rows.
    kind
        `CellKind` of each cell, int8, shape (height * width,).
    moves
        Bit ``1 << heading`` is set where a robot may step from the cell into its neighbour in that heading,
        int8, shape (height * width,). Whether it may enter or cross a storage or queue cell depends on what it
        carries and where it goes: `rmfs_core.world.travel` has those rules.
    stations
        By id: picking stations in reading order (row by row from the north-west), then replenishment stations.
    replenishing
        How many of them, the last ones, are replenishment stations.
    packing
        Cell indices of the packing stations, in reading order: robots treat them as walls.
    """

    width: int
    height: int
    kind: NDArray[np.int8]
    moves: NDArray[np.int8]
    stations: tuple[StationCells, ...]
    replenishing: int = 0
    packing: tuple[int, ...] = ()

    @cached_property
    def storage_locations(self) -> tuple[int, ...]:
        """Cell indices of the storage locations, ascending."""
        return tuple(int(cell) for cell in np.flatnonzero(self.kind == CellKind.STORAGE))

    @cached_property
    def chargers(self) -> tuple[int, ...]:
        """Cell indices of the chargers, ascending."""
        return tuple(int(cell) for cell in np.flatnonzero(self.kind == CellKind.CHARGER))

    @cached_property
    def maintenance(self) -> tuple[int, ...]:
        """Cell indices of the maintenance cells, ascending."""
        return tuple(int(cell) for cell in np.flatnonzero(self.kind == CellKind.MAINTENANCE))

    @cached_property
    def lane(self) -> NDArray[np.int64]:
        """Id of the station whose queue (or station) a cell is, or -1. Shape (cells,)."""
        lane = np.full(self.kind.shape, -1, dtype=np.int64)
        for i, cells in enumerate(self.stations):
            lane[[cells.station, *cells.queue]] = i
        lane.setflags(write=False)
        return lane

    def nearest(self, starts: Container[int], goals: Iterable[int]) -> tuple[int, int]:
        """Which of some floor cells is fewest cells from a goal, over the floor, and that goal; one has to be there."""
        leads_to = {goal: goal for goal in goals}
        reached, moves = list(leads_to), np.where(self.kind == CellKind.FLOOR, self.moves, 0).tolist()
        steps = [dx + dy * self.width for dx, dy in STEPS]
        for cell in reached:  # grows on the way
            if cell in starts:
                break
            for heading, step in enumerate(steps):
                before = cell - step
                if 0 <= before < len(moves) and moves[before] >> heading & 1 and before not in leads_to:
                    leads_to[before] = leads_to[cell]
                    reached.append(before)
        return cell, leads_to[cell]

    def may_step(self, cell: int, heading: int) -> bool:
        """Whether a robot may step from a cell into its neighbour in a heading."""
        return bool(self.moves[cell] >> heading & 1)

    def neighbour(self, cell: int, heading: int) -> int | None:
        """Cell index of the neighbour in a heading, or None at the edge of the grid."""
        column, row = cell % self.width, cell // self.width
        column, row = column + STEPS[heading][0], row + STEPS[heading][1]
        return row * self.width + column if 0 <= column < self.width and 0 <= row < self.height else None

    def beside(self, cell: int) -> list[tuple[int, int]]:
        """Heading and cell index of each neighbour."""
        row, column = divmod(cell, self.width)
        there = column + 1 < self.width, row > 0, column > 0, row + 1 < self.height
        return [(heading, cell + dx + dy * self.width) for heading, (dx, dy) in enumerate(STEPS) if there[heading]]

    def distance(self, cell: int, other: int) -> int:
        """Metres between two cells along rows and columns."""
        return abs(cell % self.width - other % self.width) + abs(cell // self.width - other // self.width)

    def _repr_html_(self) -> str | None:
        """Return the layout drawn to scale for a notebook; None for one that is too large."""
        return format_module("drawing").html(self)  # type: ignore[no-any-return]

    def where(self, cell: int) -> str:
        """Cell for people: ``row 3, column 17`` (counted from 1, from the north-west corner)."""
        return where(cell, self.width)


def check_size(width: int, height: int, place: str) -> None:
    """Raise `InputError` when a map of so many cells is larger than any may be."""
    if max(width, height) > LONGEST_SIDE or width * height > MOST_CELLS:
        expected = f"expected at most {LONGEST_SIDE:,} in a row or column and {MOST_CELLS:,} in all"
        raise InputError(place, f"found a map of {width:,} x {height:,} cells; {expected}")


def where(cell: int, width: int) -> str:
    """Cell for people, counted from 1."""
    return f"row {cell // width + 1}, column {cell % width + 1}"
