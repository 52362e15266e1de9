"""Instances of path finding: grids as text maps, and a trip for each robot."""

import json
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from calling import refusal
from cases import cases
from rmfs_commands.import_.grids import COLUMNS, Grid, read_kiva, read_octile, read_weighted
from rmfs_commands.import_.notes import Note, Notes
from rmfs_commands.import_.trips import import_lorr, import_movingai, import_rhcr
from rmfs_commands.plan import Trip, read_map, read_trips
from rmfs_core.errors import InputError

OCTILE = "type octile\nheight 3\nwidth 5\nmap\n.@S.T\n.....\nG.@.W\n"
KIVA = "3,6\n2\n3\n5000\n......\nree.r@\n..@..r\n"
HEADER = f"Grid size (x, y)\n2,2\n{','.join(COLUMNS)},weight_for_WAIT\n"
ONCE = "; expected each of 2 x 2 cells once"
WEIGHTED = HEADER + (
    "0,Induct,i1,0,0,1,inf,inf,2,1\n1,Travel,None,0,1,inf,inf,1,1,1\n"
    "2,Eject,e1,1,0,inf,1,inf,inf,1\n3,Obstacle,None,1,1,inf,inf,inf,inf,1\n"
)


def file(folder: Path, text: str) -> Path:
    path = folder / "x.map"
    path.write_text(text, encoding="utf-8")
    return path


def test_maps_of_each_kind(tmp_path: Path) -> None:
    notes = Notes()
    assert read_octile(file(tmp_path, OCTILE), "movingai", notes) == Grid(".@..@\n.....\n..@.@\n", 5, 3)
    assert [(note.what, note.number) for note in notes.taken] == [
        ("swamp (S)", 1),
        ("trees and water (T, W)", 2),
        ("type of the map, octile", 1),
    ]
    notes = Notes()
    text = OCTILE.replace("G.@.W", "E.@.@")
    assert read_octile(file(tmp_path, text), "lorr", notes).text == ".@#.@\n.....\n#.@.@\n"
    assert notes.taken == [Note("emitter and service points (E, S)", 2, "storage locations")]
    notes = Notes()
    grid = read_kiva(file(tmp_path, KIVA), notes)
    assert grid == Grid("......\n.##..@\n..@...\n", 6, 3, starts=(6, 10, 17), goals=(7, 8))
    assert [note.number for note in notes.taken] == [2, 3, 3]
    assert read_kiva(file(tmp_path, KIVA.replace("2\n3\n5000\n", "")), Notes()) == grid
    notes = Notes()
    grid = read_weighted(file(tmp_path, WEIGHTED), notes)
    assert grid == Grid("┌@\n└<\n", 2, 2, starts=(2,), goals=(3,), ways=(9, 0, 3, 4))
    assert notes.taken[0] == Note("ways of a weight other than 1", 1, "ways like all others")


@cases(
    "reader text message",
    (
        read_kiva,
        KIVA.replace("3,6", "3;6"),
        ", line 1: expected rows and columns such as `33,46`, 1,000,000 cells at most, found",
    ),
    (read_kiva, KIVA.replace("3,6", "9999,9999"), ", line 1: expected rows and columns"),
    (
        read_kiva,
        KIVA.replace("3,6", "1,900000"),
        ", line 1: found a map of 1 x 900,000 cells; expected at most 5,000 in a row or",
    ),
    (read_kiva, KIVA.replace("3,6", "4,6"), ": found 3 rows of the map; expected 4, as its first line says"),
    (read_kiva, KIVA.replace("ree.r@", "ree.r"), ", line 6: found 5 cells; expected 6, as the first line says"),
    (read_kiva, KIVA.replace("ree.r@", "xee.r@"), ", line 6: unknown sign 'x'; expected one of . e r @"),
    (
        read_weighted,
        "Grid size\n2,2\n",
        ", line 1: expected the lines `Grid size (x, y)`, the size, and names of columns",
    ),
    (
        read_weighted,
        WEIGHTED.replace("id,", "number,"),
        ", line 3: expected the columns id,type,station,x,y,weight_to_NORTH",
    ),
    (read_weighted, WEIGHTED.replace("2,2\n", "3,2\n"), ": found 4 cells; expected 6, as line 2 says"),
    (read_weighted, WEIGHTED.replace("None,1,1", "None,1,0"), f", line 7: found the cell x 1, y 0{ONCE}"),
    (read_weighted, WEIGHTED.replace("None,1,1", "None,5,1"), f", line 7: found the cell x 5, y 1{ONCE}"),
    (read_weighted, WEIGHTED.replace("None,1,1", "None,one,1"), ", line 7: expected a whole number, found 'one'"),
    (
        read_weighted,
        WEIGHTED.replace("0,0,1,", "0,0,-1,"),
        ", line 4: expected a weight such as 1, or inf where there is no passage, found",
    ),
    (read_weighted, WEIGHTED + "4,Travel\n", ", line 8: found 2 fields; expected 10, as in line 3"),
)
def test_wrong_maps_are_refused(tmp_path: Path, reader: Callable[..., Grid], text: str, message: str) -> None:
    assert refusal(lambda: reader(file(tmp_path, text), Notes())).startswith(f"{tmp_path}/x.map{message}")


WALLED = "type octile\nheight 3\nwidth 4\nmap\n...@\n.@@.\n...@\n"
FILES = {"mapFile": "maps/a.map", "agentFile": "a.agents", "taskFile": "a.tasks", "teamSize": 3, "numTasksReveal": 1.5}


def scen(*trips: tuple[int, int, int, int]) -> str:
    lines = ("\t".join(map(str, (0, "a.map", 4, 3, *trip, 1.5))) for trip in trips)
    return "version 1\n" + "".join(f"{line}\n" for line in lines)


def problem(folder: Path, agents: str, tasks: str, told: Mapping[str, object] | None = None) -> Path:
    (folder / "maps").mkdir(exist_ok=True)
    (folder / "maps" / "a.map").write_text(WALLED, encoding="utf-8")
    (folder / "a.agents").write_text(agents, encoding="utf-8")
    (folder / "a.tasks").write_text(tasks, encoding="utf-8")
    (folder / "a.json").write_text(json.dumps({**FILES, **(told or {})}), encoding="utf-8")
    return folder / "a.json"


def trips_of(folder: Path, files: Mapping[str, str]) -> tuple[Trip, ...]:
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    return read_trips(folder / "trips.scen", read_map(folder / "map.txt"))


def test_trips_of_each_kind(tmp_path: Path) -> None:
    (tmp_path / "a.map").write_text(WALLED, encoding="utf-8")
    (tmp_path / "a.scen").write_text(scen((0, 0, 2, 2), (2, 0, 2, 2), (1, 0, 3, 1), (2, 2, 0, 0)), encoding="utf-8")
    imported = import_movingai(tmp_path / "a.map", tmp_path / "a.scen")
    assert trips_of(tmp_path, imported.files) == (Trip(0, 10), Trip(10, 0))
    assert [(note.what, note.number) for note in imported.notes.taken[1:]] == [
        ("trips whose start or goal another has", 1),
        ("trips without a way in four directions", 1),
        ("optimal lengths of trips", 2),
    ]
    assert imported.command == "plan {}/map.txt --scen {}/trips.scen --agents 2"
    assert import_movingai(tmp_path / "a.map", None).command == "plan {}/map.txt --agents 3"  # as many as have room
    (tmp_path / "k.map").write_text("2,8\n" + "rrr.eeee\n" * 2, encoding="utf-8")
    imported = import_rhcr(tmp_path / "k.map", 1)
    trips = trips_of(tmp_path, imported.files)
    assert sorted(trip.start for trip in trips) == [0, 1, 2, 8, 9, 10]
    assert len({trip.goal for trip in trips}) == 6
    assert {trip.goal for trip in trips} <= {4, 5, 6, 7, 12, 13, 14, 15}
    assert import_rhcr(tmp_path / "k.map", 1) == imported
    assert import_rhcr(tmp_path / "k.map", 2).files != imported.files
    agents, tasks = "# made\n3\n0\n2\n8\n", "# made\n4\n10,0\n10,9\n10,9\n1,2\n"
    imported = import_lorr(problem(tmp_path, agents, tasks))
    assert trips_of(tmp_path, imported.files) == (Trip(0, 10), Trip(2, 9), Trip(8, 1))
    assert imported.notes.taken == [
        Note("other keys of the problem (delays, counters, tasks shown at a time)", 1, "left out"),
        Note("tasks whose first location another robot goes to", 1, "trips to the first that is left"),
        Note("tasks without a location that is left and in reach", 1, "left out"),
        Note("further locations of tasks", 3, "left out"),
    ]


def test_one_way_cells_against_each_other_are_noted(tmp_path: Path) -> None:
    rows = "0,Travel,None,0,0,inf,inf,inf,1,1\n1,Travel,None,1,0,inf,1,inf,1,1\n"
    (tmp_path / "g.grid").write_text(HEADER.replace("2,2", "2,1") + rows, encoding="utf-8")
    imported = import_rhcr(tmp_path / "g.grid", 1)
    assert imported.files == {"map.txt": ">─\n"}
    assert imported.notes.taken == [Note("ways that a text map cannot say", 1, "left out")]


@cases(
    "agents tasks told message",
    ("3\n0\n2\n8\n", "1\n10\n", {"mapFile": 5}, "a.json, mapFile: expected the name of a file, found 5"),
    ("3\n0\n2\n8\n", "1\n10\n", {"mapFile": "/etc/x"}, "a.json, mapFile: expected a file in the problem's folder"),
    ("3\n0\n2\n8\n", "1\n10\n", {"agentFile": "b/../../x"}, "a.json, agentFile: expected a file in the problem's"),
    ("3\n0\n2\n8\n", "1\n10\n", {"taskFile": "\ud800"}, "\ud800: cannot be read: 'utf-8' codec can't encode"),
    ("3\n0\n2\n8\n", "1\n10\n", {"taskFile": "a\0b"}, "a\0b: cannot be read: embedded null byte"),
    ("3\n0\n2\n8\n", "1\n10\n", {"taskFile": ""}, "a.json, taskFile: expected the name of a file, found ''"),
    ("3\n0\n2\n8\n", "1\n10\n", {"teamSize": True}, "a.json, teamSize: expected a whole number from 1 to 100,000"),
    ("3\n0\n2\n8\n", "1\n10\n", {"agentFile": "no"}, "no: cannot be read: No such file or directory"),
    ("3\n0\n2\n", "1\n10\n", {}, "a.agents: found 2 lines of locations; expected 3"),
    ("3\n0\n2\n8\n", "2\n10\n", {}, "a.tasks: found 1 line of locations; expected 2"),
    ("3\n0\nx\n8\n", "1\n10\n", {}, "a.agents, line 3: expected the number of a cell, found 'x'"),
    ("3\n0\n,\n8\n", "1\n10\n", {}, "a.agents, line 3: expected at least one location, found none"),
    ("3\n0\n3\n8\n", "1\n10\n", {}, "a.json: robot 2 begins at location 3, which is no free cell of"),
    (
        "3\n0\n2\n0\n",
        "1\n10\n",
        {},
        "a.json: found robots 1 and 3 both at location 0; expected a location of its own for each robot",
    ),
    ("3\n0\n2\n8\n", "1\n10,99\n", {}, "a.json: a task is at location 99, which is no free cell of"),
    ("", "1\n10\n", {}, "a.agents: expected the number of entries in the first line, then"),
)
def test_wrong_problems_are_refused(tmp_path, agents, tasks, told, message) -> None:
    assert refusal(lambda: import_lorr(problem(tmp_path, agents, tasks, told))).startswith(f"{tmp_path}/{message}")


@cases("text message", ("{1}", "a.json, line 1: this is no valid JSON"), ("{" * 100_000, "this is no valid JSON"))
def test_what_is_no_json_is_refused(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "a.json").write_text(text, encoding="utf-8")
    assert message in refusal(lambda: import_lorr(tmp_path / "a.json"))


def test_maps_without_floor_or_with_a_mark(tmp_path: Path) -> None:
    (tmp_path / "a.map").write_text("type octile\nheight 1\nwidth 2\nmap\n@@\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"a\.map: found no free cell; expected some"):
        import_movingai(tmp_path / "a.map", None)
    file = problem(tmp_path, "3\n0\n2\n8\n", "1\n10\n", {})
    plain = import_lorr(file)
    for name in ("a.json", "maps/a.map", "a.agents", "a.tasks"):
        text = (tmp_path / name).read_text(encoding="utf-8")
        (tmp_path / name).write_text(text, encoding="utf-8-sig")
    assert import_lorr(file) == plain
