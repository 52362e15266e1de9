"""The formats of MovingAI: maps and scenarios as they are read, and what is wrong with them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rmfs_commands.cli.map_drawing import draw_map
from rmfs_commands.plan import Trip, movingai, read_map, read_trips
from rmfs_commands.plan.movingai import open_layout
from rmfs_commands.testing import small_layout
from rmfs_core.errors import InputError
from rmfs_core.world import EAST, NORTH, SOUTH, WEST, CellKind

ROOM = "type octile\nheight 4\nwidth 8\nmap\n........\n.@@..@@.\n...G.S..\nTT....OO\n"


def written(folder: Path, text: str, name: str = "room.map") -> Path:
    """Write a file."""
    (folder / name).write_text(text, encoding="utf-8")
    return folder / name


def test_a_map_is_floor_and_walls(tmp_path: Path) -> None:
    """Points, G and S are free; robots step in all four directions between free cells, and never off the map."""
    layout = read_map(written(tmp_path, ROOM))
    assert (layout.width, layout.height, layout.stations) == (8, 4, ())
    assert [int(cell) for cell in np.flatnonzero(layout.kind == CellKind.WALL)] == [9, 10, 13, 14, 24, 25, 30, 31]
    assert set(layout.kind.tolist()) == {CellKind.WALL, CellKind.FLOOR}
    assert layout.moves[0] == 1 << EAST | 1 << SOUTH
    assert layout.moves[7] == 1 << WEST | 1 << SOUTH
    assert layout.moves[26] == 1 << EAST | 1 << NORTH
    assert layout.moves[11] == 1 << EAST | 1 << NORTH | 1 << SOUTH
    assert not layout.moves[9]


def test_what_may_be_left_may_be_entered_from_there() -> None:
    """Every step has its way back."""
    free = np.random.default_rng(1).random((6, 9)) < 0.7
    layout = open_layout(free)
    for cell in range(54):
        for heading, step in ((EAST, 1), (NORTH, -9), (WEST, -1), (SOUTH, 9)):
            if layout.may_step(cell, heading):
                assert layout.may_step(cell + step, (heading + 2) % 4)
                assert free.flat[cell]
                assert free.flat[cell + step]


def test_other_maps_are_text_maps(tmp_path: Path) -> None:
    """A warehouse's map has storage locations and stations."""
    given = small_layout(stations=2)
    layout = read_map(written(tmp_path, draw_map(given), "hall.txt"))
    assert layout.storage_locations == given.storage_locations
    assert layout.stations == given.stations


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        (
            "type octile\nheight x\nwidth 8\nmap\n",
            "room.map: expected a line `height N`, N from 1 to 5,000, found 'x'",
        ),
        ("type octile\nwidth 8\nmap\n", "room.map: expected a line `height N`, N from 1 to 5,000, found ''"),
        (
            "type octile\nheight 0\nwidth 8\nmap\n",
            "room.map: expected a line `height N`, N from 1 to 5,000, found '0'",
        ),
        (
            f"type octile\nheight {'9' * 5000}\nwidth 8\nmap\n",
            f"room.map: expected a line `height N`, N from 1 to 5,000, found '{'9' * 79}",
        ),
        (
            "type octile\nheight 1\nwidth 3000000\nmap\n",
            "room.map: expected a line `width N`, N from 1 to 5,000, found '3000000'",
        ),
        (
            "type octile\nheight 4000\nwidth 4000\nmap\n",
            "room.map: found a map of 4,000 x 4,000 cells; expected at most 5,000 in a row or column and 4,000,000 in "
            "all",
        ),
        (
            "type octile\nheight 1\nwidth 8\n....",
            "room.map, line 4: expected the line `map` after type, height and width",
        ),
        (
            "type octile\nheight 2\nwidth 2\nmap\n..\n",
            "room.map: found 1 row of the map; expected 2, as its height says",
        ),
        (
            "type octile\nheight 1\nwidth 3\nmap\n..\n",
            "room.map, line 5: found 2 cells; expected 3, as the map's width says",
        ),
        (
            "type octile\nheight 1\nwidth 2\nmap\n.x\n",
            "room.map, line 5: unknown sign 'x'; expected one of . G S @ O T W",
        ),
        ("", "room.map: the map is empty; expected rows of characters such as `#` and `.`"),
    ],
)
def test_wrong_maps_are_refused(text: str, problem: str, tmp_path: Path) -> None:
    """One sentence with the place."""
    with pytest.raises(InputError) as caught:
        read_map(written(tmp_path, text))
    assert str(caught.value) == f"{tmp_path}/{problem}"


SCEN = "version 1\n0\troom.map\t8\t4\t0\t0\t7\t2\t9\n\n0\tmy room.map\t8\t4\t7\t2\t0\t2\t9\n"


def test_trips_are_read_in_order(tmp_path: Path) -> None:
    """Cells are given as x and y; empty lines are none, names of maps may have blanks between tabs."""
    layout = read_map(written(tmp_path, ROOM))
    scen = written(tmp_path, SCEN, "room.scen")
    assert read_trips(scen, layout) == read_trips(scen, layout, 2) == (Trip(0, 23), Trip(23, 16))
    assert read_trips(scen, layout, 1) == (Trip(0, 23),)
    blanks = written(tmp_path, "version 1.0\n0 room.map 8 4 1 0 2 0 1\n", "blanks.scen")
    assert read_trips(blanks, layout) == (Trip(1, 2),)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "room.scen, line 1: expected the line `version 1`, as in MovingAI's scenarios"),
        ("version 1\n", "room.scen: found 0 trips; expected at least 2, one for each robot"),
        (
            "version 1\n0 room.map 8 4 0\n",
            "room.scen, line 2: found 5 fields; expected bucket, map, width, height, start x",
        ),
        (
            "version 1\n0 room.map 9 4 0 0 1 0 1\n",
            "room.scen, line 2: found a map of 9 x 4 cells; the map given has 8 x 4",
        ),
        (
            "version 1\n0 room.map 8 4 0 0 8 0 1\n",
            "room.scen, line 2: found the cell x 8, y 0, which is not on the map",
        ),
        ("version 1\n\n0 room.map 8 4 0 0 1 1 1\n", "room.scen, line 3: found the cell x 1, y 1, which is a wall"),
        (
            "version 1\n0 room.map 8 4 0 0 -1 0 1\n",
            "room.scen, line 2: expected a whole number from 0 to 5,000, found '-1'",
        ),
        (
            f"version 1\n0 room.map {'9' * 12} 4 0 0 1 0 1\n",
            f"room.scen, line 2: expected a whole number from 0 to 5,000, found '{'9' * 12}'",
        ),
    ],
)
def test_wrong_scenarios_are_refused(text: str, problem: str, tmp_path: Path) -> None:
    """One sentence with the place."""
    layout = read_map(written(tmp_path, ROOM))
    with pytest.raises(InputError) as caught:
        read_trips(written(tmp_path, text, "room.scen"), layout, 2)
    assert str(caught.value).startswith(f"{tmp_path}/{problem}")


def test_a_file_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    """None there, a folder, or no text."""
    for name, problem in (("none.map", "No such file or directory"), (".", "Is a directory")):
        with pytest.raises(InputError, match=f"cannot be read: {problem}"):
            read_map(tmp_path / name)
    (tmp_path / "latin.map").write_bytes(b"type \xff")
    with pytest.raises(InputError, match="cannot be read: it is no UTF-8 text"):
        read_map(tmp_path / "latin.map")


def test_a_file_without_end_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """A device is read as far as a file may go, and no farther."""
    monkeypatch.setattr(movingai, "MOST_SIGNS", 1000)
    with pytest.raises(InputError, match=r"^/dev/zero: found more than 1,000 signs; expected at most that many"):
        read_map("/dev/zero")
