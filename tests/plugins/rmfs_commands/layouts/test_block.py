"""The block layout."""

import pytest
from attrs import evolve

from rmfs_commands.cli.map_drawing import draw_map
from rmfs_commands.layouts import block_map, parse_map
from rmfs_core.errors import InputError
from rmfs_core.scenario.model import LayoutSection
from rmfs_core.world import CellKind, check_layout


def test_the_papers_layout() -> None:
    """9 x 7 blocks of 2 x 4 are 504 storage locations; four stations with 12 queue cells each lie in the east."""
    layout = parse_map(block_map(LayoutSection(), 12), "map")
    check_layout(layout, "map")
    assert len(layout.storage_locations) == 504
    assert [len(cells.queue) for cells in layout.stations] == [12] * 4
    assert all(cells.station % layout.width == layout.width - 1 for cells in layout.stations)


def test_the_smallest_layout_looks_like_this() -> None:
    """One column of three blocks, one station: ring counter-clockwise, queue folded twice, exit towards the hall."""
    section = LayoutSection(block_rows=3, block_columns=1, block_length=2, hall_width=1, stations_east=1, queue="plain")
    assert block_map(section, 6) == ("v<<<@@\nv##^@@\nv##^@@\n┌>>└→↓\nv##^↓←\nv##^→↓\nv<<┘<O\nv##^@@\nv##^@@\n>>>^@@\n")


def test_queues_as_in_rawsim_o() -> None:
    """A shortcut from the second lane's first cell into the third lane's last, and an entrance from the ring."""
    section = LayoutSection(block_rows=3, block_columns=1, block_length=2, hall_width=1, queue="shortcut")
    east = block_map(evolve(section, stations_east=1), 6)
    assert east == "v<<<@@\nv##^@@\nv##^@@\n┌>>└→↓\nv##^↓╗\nv##└→↓\nv<<┘<O\nv##^@@\nv##^@@\n>>>^@@\n"
    west = block_map(evolve(section, block_rows=4, stations_east=0, stations_west=1), 6)
    assert "↓←┐<<┘\n╔↓v##^\n↓←┐##^\nO>┌>>^\n" in west


@pytest.mark.parametrize("form", ["plain", "shortcut"])
@pytest.mark.parametrize("rows", [3, 4, 5, 6, 9])
@pytest.mark.parametrize("hall", [1, 2, 3, 5])
@pytest.mark.parametrize("queue", [1, 2, 3, 12])
def test_every_block_layout_is_fit_for_use(rows: int, hall: int, queue: int, form: str) -> None:
    """Whatever the numbers, everything can be reached, queues are long enough, and the drawing reads back the same."""
    fitting = (rows - 1) // 2
    section = LayoutSection(
        block_rows=rows, block_columns=3, hall_width=hall, stations_east=fitting, stations_west=fitting, queue=form
    )
    text = block_map(section, queue)
    layout = parse_map(text, "map")
    check_layout(layout, "map")
    assert draw_map(layout) == text
    assert len(layout.stations) == 2 * fitting
    assert all(len(cells.queue) >= queue for cells in layout.stations)
    assert (layout.kind == CellKind.STORAGE).sum() == rows * 3 * 8


def test_too_many_stations_are_refused() -> None:
    """A side has room for one station to every two inner rows of blocks."""
    with pytest.raises(
        InputError, match=r"layout\.stations_east: found 3 stations beside 5 rows of blocks; at most 2 fit"
    ):
        block_map(LayoutSection(block_rows=5, stations_east=3), 12)
    with pytest.raises(InputError, match="found no picking station"):
        block_map(LayoutSection(stations_east=0), 12)


def test_queues_that_no_memory_has_room_for_are_refused() -> None:
    """Before a cell is drawn."""
    with pytest.raises(InputError, match=r"stations\.queue_length: found queues of 100,000 cells beside 100 rows of"):
        block_map(LayoutSection(block_rows=100), 100_000)


def test_replenishment_stations_lie_behind_the_picking_stations_of_their_side() -> None:
    """On a side of their own, or south of them; together no more than fit."""
    west = block_map(LayoutSection(block_rows=5, stations_east=1, replenishment_west=2), 3)
    assert [row.strip("@")[0] for row in west.splitlines() if "I" in row] == ["I", "I"]
    east = "".join(block_map(LayoutSection(block_rows=7, stations_east=2, replenishment_east=1), 3).split())
    assert [sign for sign in east if sign in "IO"] == ["O", "O", "I"]
    with pytest.raises(InputError, match=r"layout.replenishment_east: found 4 stations beside 7 rows"):
        block_map(LayoutSection(block_rows=7, stations_east=2, replenishment_east=2), 3)
