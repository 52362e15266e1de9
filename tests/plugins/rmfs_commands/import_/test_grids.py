"""Grids of path finding as text maps."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rmfs_commands.import_.grids import COLUMNS, KINDS, Grid, read_kiva, read_octile, read_weighted
from rmfs_commands.import_.notes import Note, Notes
from rmfs_core.errors import InputError

OCTILE = "type octile\nheight 3\nwidth 5\nmap\n.@S.T\n.....\nG.@.W\n"
KIVA = "3,6\n2\n3\n5000\n......\nree.r@\n..@..r\n"
HEADER = f"Grid size (x, y)\n2,2\n{','.join(COLUMNS)},weight_for_WAIT\n"
WEIGHTED = HEADER + (
    "0,Induct,i1,0,0,1,inf,inf,2,1\n1,Travel,None,0,1,inf,inf,1,1,1\n"
    "2,Eject,e1,1,0,inf,1,inf,inf,1\n3,Obstacle,None,1,1,inf,inf,inf,inf,1\n"
)


def file(folder: Path, text: str) -> Path:
    """Write a file."""
    path = folder / "x.map"
    path.write_text(text, encoding="utf-8")
    return path


def test_maps_of_movingai_are_floor_and_walls(tmp_path: Path) -> None:
    """Swamp can be driven on; trees and water cannot."""
    notes = Notes()
    assert read_octile(file(tmp_path, OCTILE), "movingai", notes) == Grid(".@..@\n.....\n..@.@\n", 5, 3)
    assert [(note.what, note.number) for note in notes.taken] == [
        ("swamp (S)", 1),
        ("trees and water (T, W)", 2),
        ("type of the map, octile", 1),
    ]


def test_maps_of_the_league_have_storage_locations(tmp_path: Path) -> None:
    """Where goods are picked up and delivered."""
    notes = Notes()
    text = OCTILE.replace("G.@.W", "E.@.@")
    assert read_octile(file(tmp_path, text), "lorr", notes).text == ".@#.@\n.....\n#.@.@\n"
    assert notes.taken == [Note("emitter and service points (E, S)", 2, "storage locations")]


def test_maps_of_rhcr_say_where_robots_begin(tmp_path: Path) -> None:
    """At homes, from where they go to endpoints; a map may go without the numbers of the simulation."""
    notes = Notes()
    grid = read_kiva(file(tmp_path, KIVA), notes)
    assert grid == Grid("......\n.##..@\n..@...\n", 6, 3, starts=(6, 10, 17), goals=(7, 8))
    assert [note.number for note in notes.taken] == [2, 3, 3]
    assert read_kiva(file(tmp_path, KIVA.replace("2\n3\n5000\n", "")), Notes()) == grid


def test_weighted_grids_have_one_way_floor(tmp_path: Path) -> None:
    """A line for each cell, counted from the south-west; robots begin at inducts and go to ejects."""
    notes = Notes()
    grid = read_weighted(file(tmp_path, WEIGHTED), notes)
    assert grid == Grid("┌@\n└<\n", 2, 2, starts=(2,), goals=(3,), ways=(9, 0, 3, 4))
    assert notes.taken[0] == Note("ways of a weight other than 1", 1, "ways like all others")


@given(st.data())
def test_every_sign_becomes_the_one_of_its_table(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    """In a map of any size."""
    kind = data.draw(st.sampled_from(["movingai", "lorr"]))
    width = data.draw(st.integers(1, 6))
    row = st.text(sorted(KINDS[kind]), min_size=width, max_size=width)
    rows = data.draw(st.lists(row, min_size=1, max_size=6))
    text = f"type octile\nheight {len(rows)}\nwidth {width}\nmap\n" + "\n".join(rows) + "\n"
    grid = read_octile(file(tmp_path_factory.mktemp("maps"), text), kind, Notes())
    assert grid.text.splitlines() == ["".join(KINDS[kind][sign] for sign in signs) for signs in rows]
    assert (grid.width, grid.height) == (width, len(rows))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            KIVA.replace("3,6", "3;6"),
            ", line 1: expected rows and columns such as `33,46`, 1,000,000 cells at most, found",
        ),
        (KIVA.replace("3,6", "9999,9999"), ", line 1: expected rows and columns"),
        (
            KIVA.replace("3,6", "1,900000"),
            ", line 1: found a map of 1 x 900,000 cells; expected at most 5,000 in a row or",
        ),
        (KIVA.replace("3,6", "4,6"), ": found 3 rows of the map; expected 4, as its first line says"),
        (KIVA.replace("ree.r@", "ree.r"), ", line 6: found 5 cells; expected 6, as the first line says"),
        (KIVA.replace("ree.r@", "xee.r@"), ", line 6: unknown sign 'x'; expected one of . e r @"),
        ("", ", line 1: expected rows and columns"),
    ],
)
def test_wrong_maps_of_rhcr_are_refused(tmp_path: Path, text: str, message: str) -> None:
    """With the line."""
    with pytest.raises(InputError) as caught:
        read_kiva(file(tmp_path, text), Notes())
    assert str(caught.value).startswith(f"{tmp_path}/x.map{message}")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("Grid size\n2,2\n", ", line 1: expected the lines `Grid size (x, y)`, the size, and names of columns"),
        (WEIGHTED.replace("id,", "number,"), ", line 3: expected the columns id,type,station,x,y,weight_to_NORTH"),
        (WEIGHTED.replace("2,2\n", "3,2\n"), ": found 4 cells; expected 6, as line 2 says"),
        (
            WEIGHTED.replace("None,1,1", "None,1,0"),
            ", line 7: found the cell x 1, y 0; expected each of 2 x 2 cells once",
        ),
        (
            WEIGHTED.replace("None,1,1", "None,5,1"),
            ", line 7: found the cell x 5, y 1; expected each of 2 x 2 cells once",
        ),
        (WEIGHTED.replace("None,1,1", "None,one,1"), ", line 7: expected a whole number, found 'one'"),
        (
            WEIGHTED.replace("0,0,1,", "0,0,-1,"),
            ", line 4: expected a weight such as 1, or inf where there is no way, found",
        ),
        (WEIGHTED + "4,Travel\n", ", line 8: found 2 fields; expected 10, as in line 3"),
    ],
)
def test_wrong_weighted_grids_are_refused(tmp_path: Path, text: str, message: str) -> None:
    """With the line."""
    with pytest.raises(InputError) as caught:
        read_weighted(file(tmp_path, text), Notes())
    assert str(caught.value).startswith(f"{tmp_path}/x.map{message}")
