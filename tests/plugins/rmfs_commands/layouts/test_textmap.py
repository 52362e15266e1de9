"""Text maps."""

import pytest

from rmfs_commands.cli.map_drawing import draw_map
from rmfs_commands.layouts import parse_map
from rmfs_core.errors import InputError
from rmfs_core.world import EAST, NORTH, SOUTH, WEST, check_layout
from rmfs_core.world.grid import LONGEST_SIDE

TINY = """
..#
.qO
...
"""


def test_a_drawn_map_is_read_cell_by_cell() -> None:
    """Storage, floor, queue and station get their kinds and moves; a queue is entered from the floor only."""
    layout = parse_map(TINY, "tiny")
    check_layout(layout, "tiny")
    assert (layout.width, layout.height) == (3, 3)
    assert layout.storage_locations == (2,)
    assert layout.stations[0].station == 5
    assert layout.stations[0].queue == (4,)
    assert layout.may_step(4, EAST)
    assert not layout.may_step(4, WEST)
    assert layout.may_step(3, EAST)  # into the queue
    assert layout.may_step(5, SOUTH)  # out of the station
    assert not layout.may_step(5, WEST)


def test_one_way_aisles_are_one_way() -> None:
    """A robot leaves a one-way cell in its direction only, and never enters one against it."""
    layout = parse_map("v<<<\nv##^\n>>>^\n.qO.\n....", "ring")
    assert layout.may_step(1, WEST)
    assert not layout.may_step(1, EAST)
    assert not layout.may_step(0, EAST)
    assert layout.may_step(1, SOUTH)  # into storage
    assert layout.may_step(5, NORTH)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "map: the map is empty; expected rows of characters such as `#` and `.`"),
        ("#.\n.x", "map, row 2, column 2: unknown sign 'x'; expected one of # O I q"),
        ("#..\n..O", "map, row 2, column 3: the station has no queue; expected at least one queue cell (`q`)"),
        ("#.qq\n.qqO", "the queue branches to row 1, column 4 and row 2, column 3; give the direction"),
        ("#..q\n.qO.\n....", "map, row 1, column 4: the queue cell leads to no station"),
        (
            "@#..\n.╔→O\n.@.@",
            "map, row 2, column 2: the queue cell leads to row 2, column 3 and row 3, column 2; expected",
        ),
        (
            "#...\n.→╚O",
            "map, row 2, column 3: the queue cell leads to row 2, column 4 and row 1, column 3; expected two",
        ),
        (
            ".→╚O",
            "map, row 1, column 3: the queue cell leads to row 1, column 4 and beyond the map; expected two cells",
        ),
        ("#....\n.→╔→O\n..↓..\n..→→O", "map, row 2, column 3: the queue cell leads to row 2, column 4 and row 3, col"),
        (
            "#.....\n.╔→↓..\n.↓╔←..\n.→→→→O",
            "map, row 2, column 2: the queue cell leads to row 2, column 3 and row 3, c",
        ),
        (
            "#....\n.→⇒→O",
            "map, row 2, column 3: found a queue cell where nobody waits (⇒ ⇐ ⇑ ⇓) out of place; expected",
        ),
        ("#..\n.⇒O", "map, row 2, column 3: found a queue cell where nobody waits (⇒ ⇐ ⇑ ⇓) out of place; expected"),
        ("#╔→↓\n.→→→O", "map, row 2, column 4: the queue branches to row 1, column 4 and row 2, column 3; give"),
    ],
)
def test_wrong_maps_are_refused_with_the_cell(text: str, message: str) -> None:
    """Each mistake in a map is one sentence with the place."""
    with pytest.raises(InputError) as caught:
        parse_map(text, "map")
    assert message in str(caught.value)


FOLDED = """
#.......
..→→→→↓.
..↓←←╗←.
.└→→→↓..
.....O..
........
"""


def test_a_queue_may_have_a_shortcut_and_a_second_entrance() -> None:
    """The cells stay one chain; a way on past some of them, and the arm of a floor cell, lead ahead in it."""
    layout = parse_map(FOLDED, "folded")
    check_layout(layout, "folded")
    (cells,) = layout.stations
    assert [cell % 8 for cell in cells.queue] == [5, 4, 3, 2, 2, 3, 4, 5, 6, 6, 5, 4, 3, 2]
    shortcut, entrance = cells.queue[7], cells.queue[3]
    assert [h for h in range(4) if layout.may_step(shortcut, h)] == [WEST, SOUTH]
    assert layout.neighbour(shortcut, SOUTH) == cells.queue[0]
    assert layout.may_step(entrance - 1, EAST)
    assert layout.may_step(entrance - 1, NORTH)
    assert not layout.may_step(cells.queue[4] - 1, EAST)  # a cell that leads everywhere is no entrance
    assert draw_map(layout) == draw_map(parse_map(draw_map(layout), "drawn"))
    assert "╗" in draw_map(layout)


def test_cells_before_a_station_may_be_kept_clear() -> None:
    """They are part of the chain and driven through, but no place to wait in."""
    layout = parse_map("#......\n.→→⇒⇒O.\n.......", "clear")
    check_layout(layout, "clear")
    (cells,) = layout.stations
    assert (cells.queue, cells.clear, cells.places) == ((11, 10, 9, 8), 2, 2)
    assert [layout.may_step(cell, EAST) for cell in cells.queue] == [True] * 4
    assert draw_map(layout).splitlines()[1].strip("┌│") == "→→⇒⇒O"


@pytest.mark.parametrize(
    ("width", "height"), [(3000, 3000), (3_000_000, 1), (1, 3_000_000), (LONGEST_SIDE + 1, 2), (1, LONGEST_SIDE + 1)]
)
def test_a_map_that_no_memory_has_room_for_is_refused(width: int, height: int) -> None:
    """All in all, or in a row or column: a single line may be as long as a file."""
    expected = "expected at most 5,000 in a row or column and 4,000,000 in all"
    with pytest.raises(InputError) as caught:
        parse_map("#\n" * (height - 1) + "#" * width, "hall.txt")
    assert str(caught.value) == f"hall.txt: found a map of {width:,} x {height:,} cells; {expected}"


def test_the_longest_row_that_may_be_is_read() -> None:
    """One cell fewer than what is refused."""
    assert parse_map("." * LONGEST_SIDE, "hall.txt").width == LONGEST_SIDE


def test_replenishment_stations_come_after_picking_stations() -> None:
    """Whatever the order of rows: those where orders are picked have the first ids."""
    layout = parse_map("#...\n..qI\n....\n..qO\n....", "map")
    assert [cells.station for cells in layout.stations] == [15, 7]
    assert layout.replenishing == 1
    assert layout.lane[7] == 1
    assert draw_map(layout).count("I") == 1
    assert parse_map(draw_map(layout), "drawn").stations == layout.stations
