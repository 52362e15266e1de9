"""Cells of a layout, and what is beside them."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import numpy as np
import pytest

from rmfs_commands.layouts import parse_map
from rmfs_core.world import EAST, NORTH, SOUTH, WEST, Layout, StationCells
from rmfs_core.world.grid import DRAWN, STEPS, where

LAYOUT = parse_map("#..#\nqqO.\n....\n.Oqq\n#...", "two stations")
"""Four columns, five rows; a queue of two cells west of the first station and one east of the second."""


def test_cells_are_counted_row_by_row_from_the_north_west() -> None:
    """Storage locations ascend, stations are in reading order with their queues from the station to the entry."""
    assert (LAYOUT.width, LAYOUT.height) == (4, 5)
    assert LAYOUT.storage_locations == (0, 3, 16)
    assert LAYOUT.stations == (StationCells(6, (5, 4)), StationCells(13, (14, 15)))


@pytest.mark.parametrize(
    ("cell", "neighbours"),
    [(0, [1, None, None, 4]), (3, [None, None, 2, 7]), (9, [10, 5, 8, 13]), (16, [17, 12, None, None])],
)
def test_neighbours_end_at_the_edge(cell: int, neighbours: list[int | None]) -> None:
    """East, north, west, south; a row does not go on in the next one."""
    assert [LAYOUT.neighbour(cell, heading) for heading in (EAST, NORTH, WEST, SOUTH)] == neighbours
    assert LAYOUT.beside(cell) == [(heading, one) for heading, one in enumerate(neighbours) if one is not None]


def test_headings_go_round_against_the_clock() -> None:
    """So that the difference of two is the turn between them; two steps in opposite headings cancel."""
    assert (EAST, NORTH, WEST, SOUTH) == (0, 1, 2, 3)
    for heading, (columns, rows) in enumerate(STEPS):
        assert STEPS[(heading + 2) % 4] == (-columns, -rows)


def test_moves_are_bits_of_headings() -> None:
    """The station of the first queue is left to the east and south, and not back into its queue."""
    assert [LAYOUT.may_step(6, heading) for heading in range(4)] == [True, True, False, True]
    assert [LAYOUT.may_step(5, heading) for heading in range(4)] == [True, False, False, False]


def test_every_cell_of_a_station_is_in_its_lane() -> None:
    """The station and its queue, by the station's id; all else in none."""
    lane = LAYOUT.lane
    assert np.flatnonzero(lane == 0).tolist() == [4, 5, 6]
    assert np.flatnonzero(lane == 1).tolist() == [13, 14, 15]
    assert (lane == -1).sum() == 14
    with pytest.raises(ValueError, match="read-only"):
        lane[0] = 1


def test_places_beyond_the_queue_are_its_entry() -> None:
    """The station, the cell next to it, and so on; who finds the queue full waits at the end."""
    cells = LAYOUT.stations[0]
    assert [cells.slot(place) for place in range(5)] == [6, 5, 4, 4, 4]


def test_nobody_waits_in_cells_that_are_kept_clear() -> None:
    """The first in line behind the station waits behind them, and the queue has so many places fewer."""
    cells = StationCells(9, (8, 7, 6, 5), clear=1)
    assert [cells.slot(place) for place in range(5)] == [9, 7, 6, 5, 5]
    assert (cells.places, StationCells(9, (8, 7)).places) == (3, 2)


def test_distances_are_along_rows_and_columns() -> None:
    """In metres, the same there and back."""
    assert [LAYOUT.distance(0, cell) for cell in (0, 3, 4, 7, 19)] == [0, 3, 1, 4, 7]
    assert LAYOUT.distance(19, 0) == 7


def test_people_count_from_one() -> None:
    """Row and column from the north-west corner."""
    assert LAYOUT.where(0) == "row 1, column 1"
    assert LAYOUT.where(7) == where(7, 4) == "row 2, column 4"


def test_the_nearest_of_some_floor_cells_to_a_goal() -> None:
    """Fewest cells over the floor, one-way cells in their direction only; never through storage, queues or stations."""
    layout = parse_map("#...>..#\n...qO...\n........", "row")
    assert layout.nearest({2, 6}, [0, 7]) == (6, 7)
    assert layout.nearest({2, 6}, [0]) == (2, 0)
    assert layout.nearest({5}, [0]) == (5, 0)  # around the station
    assert layout.nearest({5, 11, 16}, [0]) == (16, 0)  # a queue cell is none


def test_a_notebook_shows_every_cell_to_scale() -> None:
    """The rectangles of each colour cover as many cells as there are of the kind; walls are left out."""
    layout = parse_map("#..#\nqqO.\n....\n.Oqq\n#..@", "two stations")
    (shown,) = ElementTree.fromstring(str(layout._repr_html_())).iter("svg")
    assert shown.get("viewBox") == "0 0 4 5"
    lengths = {
        path.get("fill"): sum(map(int, re.findall(r"h(\d+)v1h-\1z", str(path.get("d"))))) for path in shown.iter("path")
    }
    assert lengths == {DRAWN[kind][0]: int((layout.kind == kind).sum()) for kind in DRAWN}
    assert [path.get("d") for path in shown.iter("path")][-1] == "M2 1h1v1h-1zM1 3h1v1h-1z"
    assert "3 storage locations, " in re.sub("<[^>]*>", "", str(layout._repr_html_()))


def test_a_notebook_shows_no_layout_that_it_could_not_draw() -> None:
    """It falls back on the text then."""
    side = 501
    none = np.zeros(side * side, np.int8)
    assert Layout(side, side, none, none, ())._repr_html_() is None
