"""The compiled searches, called as `travel` does, on a grid small enough to work out by hand."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from rmfs_core.world import EAST, NORTH, SOUTH, WEST, Layout, parse_map
from rmfs_core.world.travel_search import FAR, descend, times_from, times_to

LAYOUT = parse_map("....\n.@@.\n.##.", "horseshoe")
"""A way round a wall; cells 9 and 10 are storage locations between its ends."""


def column(*values: int) -> NDArray[np.int64]:
    """Return whole numbers as an array that is read-only, as those are that the searches are compiled for."""
    array = np.array(values, dtype=np.int64)
    array.setflags(write=False)
    return array


OFFSETS = column(1, -4, -1, 4)
RUNS = column(0, 10, 14, 17, 20, 22)
"""A long run takes less time than short ones after each other, as with acceleration."""
TURNS = column(0, 3, 6, 3)
LANE = column(*[-1] * 12)


def floor_of(layout: Layout, *but: int) -> NDArray[np.bool_]:
    """Return which cells may be crossed: all but the walls and some."""
    cells: NDArray[np.bool_] = layout.kind > 0
    cells[list(but)] = False
    cells.setflags(write=False)
    return cells


def grid(crossed: NDArray[np.bool_]) -> tuple[NDArray[np.int64] | NDArray[np.int8] | NDArray[np.bool_], ...]:
    """Return what all searches are handed: moves, passable cells, offsets, runs and turns."""
    return LAYOUT.moves, crossed, OFFSETS, RUNS, TURNS


def test_whole_runs_and_turns_are_added_up() -> None:
    """From the south-west to the south-east corner: north two, east three, south two, and two turns in between."""
    times = times_to(11, *grid(floor_of(LAYOUT, 9, 10)))
    assert times[8, NORTH] == 14 + 3 + 17 + 3 + 14
    assert times[8, SOUTH] == 6 + times[8, NORTH]
    assert times[8, EAST] == 3 + times[8, NORTH]
    assert times[11].tolist() == [0, 0, 0, 0]


def test_a_cell_that_is_not_passable_is_an_end_only() -> None:
    """Straight through the storage locations it is one run; where they may not be crossed, one is still a goal."""
    assert times_to(11, *grid(floor_of(LAYOUT)))[8, EAST] == 17
    blocked = times_to(9, *grid(floor_of(LAYOUT, 9, 10)))
    assert blocked[8, EAST] == 10
    assert blocked[11, WEST] == blocked[11, NORTH] + 3  # round the wall, not over cell 10
    assert blocked[11, NORTH] == 14 + 3 + 17 + 3 + 14 + 3 + 10


def test_what_cannot_be_reached_is_far() -> None:
    """Walls, and what lies behind them."""
    times = times_to(8, *grid(floor_of(LAYOUT)))
    assert (times[5] == FAR).all()
    cut = parse_map("..@.", "cut")
    far = times_to(0, cut.moves, floor_of(cut), column(1, -4, -1, 4), RUNS, TURNS)
    assert far[1].tolist() == [10 + 6, 10 + 3, 10, 10 + 3]
    assert (far[3] == FAR).all()


def test_forward_and_backward_searches_agree() -> None:
    """From each cell with each heading to each cell: the fastest arrival, whatever the heading there."""
    crossed = floor_of(LAYOUT)
    cells = [int(cell) for cell in np.flatnonzero(crossed)]
    to = {goal: times_to(goal, *grid(crossed)) for goal in cells}
    for start in cells:
        for heading in range(4):
            forward = times_from(start, heading, LANE, *grid(crossed))
            assert [forward[goal] for goal in cells] == [to[goal][start, heading] for goal in cells]


def test_a_queue_is_not_entered_on_the_way_elsewhere() -> None:
    """Searching forwards, cells of another lane end every run; those of one's own do not."""
    row = parse_map(".....", "row")
    lane = column(-1, -1, 0, -1, -1)
    arrays = row.moves, floor_of(row), column(1, -5, -1, 5), RUNS, TURNS
    assert times_from(0, EAST, lane, *arrays).tolist() == [0, 10, FAR, FAR, FAR]
    assert times_from(2, EAST, lane, *arrays).tolist() == [6 + 14, 6 + 10, 0, 10, 14]


def test_a_path_is_read_off_the_table() -> None:
    """The ends of its runs; of equally fast paths the one that goes on ahead, and stops first."""
    crossed = floor_of(LAYOUT, 9, 10)
    table = times_to(11, *grid(crossed))
    table.setflags(write=False)
    assert descend(8, NORTH, 11, table, *grid(crossed)).tolist() == [0, 3, 11]
    assert descend(11, NORTH, 11, table, *grid(crossed)).tolist() == []
    with pytest.raises(ValueError, match="the table of times does not belong to this goal"):
        descend(8, NORTH, 9, table, *grid(crossed))
