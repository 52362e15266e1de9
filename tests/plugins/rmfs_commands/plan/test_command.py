"""`rmfs plan`, and the formats of path finding."""

import csv
import json
import re
from pathlib import Path

import numpy as np
import pytest

from calling import exit_code, refusal
from cases import cases
from rmfs_commands.cli.map_drawing import draw_map
from rmfs_commands.plan import Trip, movingai, read_map, read_trips
from rmfs_commands.plan.movingai import open_layout
from rmfs_commands.testing import small_layout
from rmfs_core.errors import InputError
from rmfs_core.world import EAST, NORTH, SOUTH, WEST, CellKind

ROOM = "type octile\nheight 4\nwidth 8\nmap\n........\n.@@..@@.\n........\nTT....OO\n"
SCEN = "version 1\n0\troom.map\t8\t4\t0\t0\t7\t2\t9\n0\troom.map\t8\t4\t7\t2\t0\t2\t9\n"


@pytest.fixture
def room(tmp_path: Path) -> Path:
    (tmp_path / "room.map").write_text(ROOM, encoding="utf-8")
    return tmp_path / "room.map"


def ask(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> tuple[int, str, str]:
    """Run `rmfs plan`; return exit code, output and errors, without the notice of a checkout's first search."""
    code = exit_code("plan", *arguments)
    out, err = capsys.readouterr()
    return code, out, "".join(line for line in err.splitlines(True) if not line.startswith("Compiling searches"))


@pytest.mark.parametrize("pp", ["sipp", pytest.param("whca-n", marks=pytest.mark.slow)])
def test_all_robots_of_a_random_plan_arrive(
    pp: str, room: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    written = []
    for folder in ("one", "two"):
        out = tmp_path / folder
        code, text, error = ask([str(room), "--agents", "4", "--seed", "3", "--pp", pp, "--out", str(out)], capsys)
        assert (code, error) == (0, "")
        assert "Arrived 4 of 4" in text
        written.append([(out / name).read_bytes() for name in ("plan.json", "paths.csv")])
    assert written[0] == written[1]
    document = json.loads(written[0][0])
    assert (document["costs"]["arrived"], document["collisions"]) == (4, [])
    rows = list(csv.DictReader(written[0][1].decode().splitlines()))
    ends = {row["robot"]: float(row["end_s"]) for row in rows}
    assert sum(ends.values()) == pytest.approx(document["costs"]["sum_of_costs_s"])
    assert max(ends.values()) == document["costs"]["makespan_s"]


def test_trips_of_scenarios_and_maps(room: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    scen = room.with_suffix(".scen")
    scen.write_text(SCEN, encoding="utf-8")
    code, text, _ = ask([str(room), "--scen", str(scen), "--agents", "2"], capsys)
    assert code == 0
    assert "7,2" in text
    code, text, _ = ask([str(room), "--agents", "6", "--pp", "free-flow"], capsys)
    assert code == 0
    assert "First collision: robots" in text
    (tmp_path / "hall.txt").write_text(draw_map(small_layout(stations=2)), encoding="utf-8")
    code, text, _ = ask([str(tmp_path / "hall.txt"), "--agents", "20"], capsys)
    assert code == 0
    assert "Arrived 20 of 20" in text


def test_who_finds_no_path_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Two robots cannot pass each other in a corridor: both are named, exit code 1; such a plan has no makespan."""
    (tmp_path / "c.map").write_text("type octile\nheight 1\nwidth 4\nmap\n....\n", encoding="utf-8")
    (tmp_path / "c.scen").write_text("version 1\n0 c.map 4 1 0 0 3 0 3\n0 c.map 4 1 3 0 0 0 3\n", encoding="utf-8")
    asked = [str(tmp_path / "c.map"), "--scen", str(tmp_path / "c.scen"), "--agents", "2"]
    code, text, error = ask(asked, capsys)
    assert code == 1
    assert error == "Error: sipp found no path to the goal for 2 of 2 robots: 1, 2.\n"
    assert "Arrived 0 of 2; makespan -; sum of costs" in text
    assert json.loads(ask([*asked, "--json"], capsys)[1])["costs"]["makespan_s"] is None


def test_maps_and_trips_that_cannot_be_planned_are_one_sentence(
    room: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "bad.map").write_text("type octile\nheight 1\nwidth 2\nmap\n..\n", encoding="utf-8")
    scen = room.with_suffix(".scen")
    scen.write_text("version 1\n0 room.map 8 4 0 0 1 0 1\n0 room.map 8 4 0 0 2 0 1\n", encoding="utf-8")
    for arguments, problem in (
        ([str(tmp_path / "bad.map")], "bad.map: found room for 1 robot with start and goal"),
        (
            [str(room), "--scen", str(scen), "--agents", "2"],
            "room.scen: robots 1 and 2 have the same start, row 1, column 1",
        ),
    ):
        code, _, error = ask(arguments, capsys)
        assert code == 2
        assert error.startswith(f"Error: {tmp_path}/{problem}")
        assert error.count("\n") == 1


@cases(
    "arguments problem",
    (["--pp", "sip"], '--pp sip: there is no rule "sip"'),
    (["--pp", "demand"], "decides PPS; expected a rule for PP"),
    (["--pp", "whca-n", "--set", "window=3"], "--set window=3: rule"),
    (["--pp", "whca-n", "--set", "window_s=-3"], "expected a number > 0"),
    (["--set", "a.b=3"], "--set a.b=3: expected a parameter of the rule"),
    (["--agents", "50"], "found room for"),
)
def test_wrong_options_are_refused(
    arguments: list[str], problem: str, room: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code, _, error = ask([str(room), *arguments], capsys)
    assert code == 2
    assert problem in error


def unplannable(*_: object) -> None:
    pytest.fail("the search began")


def test_an_interrupted_search_leaves_no_folder(
    room: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> None:
        assert (tmp_path / "out").is_dir()
        raise KeyboardInterrupt

    monkeypatch.setattr("rmfs_commands.plan.plan_by_priorities", interrupted)
    assert ask([str(room), "--agents", "2", "--out", str(tmp_path / "out")], capsys)[0] == 130
    assert not (tmp_path / "out").exists()


def test_where_the_files_cannot_go_is_said_before_the_search(
    room: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rmfs_commands.plan.plan_by_priorities", unplannable)
    (tmp_path / "taken" / "paths.csv").mkdir(parents=True)
    in_the_way = f"{room}/out: found a file in the way; expected a folder, or nothing"
    for out, problem in (
        (room / "out", in_the_way),
        (tmp_path / "taken", f"{tmp_path}/taken/paths.csv: cannot be written: a folder has that name"),
    ):
        assert ask([str(room), "--agents", "2", "--out", str(out)], capsys) == (2, "", f"Error: {problem}\n")


@cases(
    "reserves problem code",
    ("windows", " a path that hits a reservation: robot ", 1),
    ("window", "has reserves = 'window'; expected 'full paths', 'windows', 'fleet' or None", 2),
)
def test_a_rule_that_heeds_nobody_is_named(
    reserves: str,
    problem: str,
    code: int,
    room: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    (room.parent / "mine.py").write_text(
        "from attrs import define\nfrom rmfs_core import Path, hookimpl\n\n\n@define\nclass Mine:\n"
        f"    reserves = {reserves!r}\n\n    @hookimpl\n    def plan_path(self, warehouse, robot, goal):\n"
        "        return Path(warehouse.travel.fastest_path(robot.cell, robot.heading, goal, loaded=False))\n",
        encoding="utf-8",
    )
    monkeypatch.chdir(room.parent)
    found, _, error = ask([room.name, "--pp", "./mine.py:Mine"], capsys)
    assert (found, error.count("\n")) == (code, 1)
    assert problem in error


def test_json(room: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, text, _ = ask([str(room), "--agents", "3", "--pp", "free-flow", "--out", str(tmp_path), "--json"], capsys)
    assert code == 0
    document = json.loads(text)
    trips = document.pop("trips")
    assert document == json.loads((tmp_path / "plan.json").read_text(encoding="utf-8"))
    assert [trip["robot"] for trip in trips] == [1, 2, 3]
    assert sum(trip["arrives_s"] for trip in trips) == pytest.approx(document["costs"]["sum_of_costs_s"])


SIGNS = "type octile\nheight 4\nwidth 8\nmap\n........\n.@@..@@.\n...G.S..\nTT....OO\n"


def written(folder: Path, text: str, name: str = "room.map") -> Path:
    (folder / name).write_text(text, encoding="utf-8")
    return folder / name


def test_a_map_is_floor_and_walls(tmp_path: Path) -> None:
    layout = read_map(written(tmp_path, SIGNS))
    assert (layout.width, layout.height, layout.stations) == (8, 4, ())
    assert [int(cell) for cell in np.flatnonzero(layout.kind == CellKind.WALL)] == [9, 10, 13, 14, 24, 25, 30, 31]
    assert set(layout.kind.tolist()) == {CellKind.WALL, CellKind.FLOOR}
    assert layout.moves[0] == 1 << EAST | 1 << SOUTH
    assert layout.moves[7] == 1 << WEST | 1 << SOUTH
    assert layout.moves[26] == 1 << EAST | 1 << NORTH
    assert layout.moves[11] == 1 << EAST | 1 << NORTH | 1 << SOUTH
    assert not layout.moves[9]


def test_maps_of_both_kinds(tmp_path: Path) -> None:
    free = np.random.default_rng(1).random((6, 9)) < 0.7
    layout = open_layout(free)
    for cell in range(54):
        for heading, step in ((EAST, 1), (NORTH, -9), (WEST, -1), (SOUTH, 9)):
            if layout.may_step(cell, heading):
                assert layout.may_step(cell + step, (heading + 2) % 4)
                assert free.flat[cell]
                assert free.flat[cell + step]
    given = small_layout(stations=2)
    layout = read_map(written(tmp_path, draw_map(given), "hall.txt"))
    assert layout.storage_locations == given.storage_locations
    assert layout.stations == given.stations


@cases(
    "text problem",
    ("type octile\nheight x\nwidth 8\nmap\n", "room.map: expected a line `height N`, N from 1 to 5,000, found 'x'"),
    ("type octile\nwidth 8\nmap\n", "room.map: expected a line `height N`, N from 1 to 5,000, found ''"),
    ("type octile\nheight 0\nwidth 8\nmap\n", "room.map: expected a line `height N`, N from 1 to 5,000, found '0'"),
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
        "room.map: found a map of 4,000 x 4,000 cells; expected at most 5,000 in a row or column and 4,000,000 in all",
    ),
    ("type octile\nheight 1\nwidth 8\n....", "room.map, line 4: expected the line `map` after type, height and width"),
    ("type octile\nheight 2\nwidth 2\nmap\n..\n", "room.map: found 1 row of the map; expected 2, as its height says"),
    (
        "type octile\nheight 1\nwidth 3\nmap\n..\n",
        "room.map, line 5: found 2 cells; expected 3, as the map's width says",
    ),
    ("type octile\nheight 1\nwidth 2\nmap\n.x\n", "room.map, line 5: unknown sign 'x'; expected one of . G S @ O T W"),
    ("", "room.map: the map is empty; expected rows of characters such as `#` and `.`"),
)
def test_wrong_maps_are_refused(text: str, problem: str, tmp_path: Path) -> None:
    assert refusal(lambda: read_map(written(tmp_path, text))) == f"{tmp_path}/{problem}"


TRIPS = "version 1\n0\troom.map\t8\t4\t0\t0\t7\t2\t9\n\n0\tmy room.map\t8\t4\t7\t2\t0\t2\t9\n"


def test_trips_are_read_in_order(tmp_path: Path) -> None:
    layout = read_map(written(tmp_path, SIGNS))
    scen = written(tmp_path, TRIPS, "room.scen")
    assert read_trips(scen, layout) == read_trips(scen, layout, 2) == (Trip(0, 23), Trip(23, 16))
    assert read_trips(scen, layout, 1) == (Trip(0, 23),)
    blanks = written(tmp_path, "version 1.0\n0 room.map 8 4 1 0 2 0 1\n", "blanks.scen")
    assert read_trips(blanks, layout) == (Trip(1, 2),)


@cases(
    "text problem",
    ("", "room.scen, line 1: expected the line `version 1`, as in MovingAI's scenarios"),
    ("version 1\n", "room.scen: found 0 trips; expected at least 2, one for each robot"),
    (
        "version 1\n0 room.map 8 4 0\n",
        "room.scen, line 2: found 5 fields; expected bucket, map, width, height, start x",
    ),
    ("version 1\n0 room.map 9 4 0 0 1 0 1\n", "room.scen, line 2: found a map of 9 x 4 cells; the map given has 8 x 4"),
    ("version 1\n0 room.map 8 4 0 0 8 0 1\n", "room.scen, line 2: found the cell x 8, y 0, which is not on the map"),
    ("version 1\n\n0 room.map 8 4 0 0 1 1 1\n", "room.scen, line 3: found the cell x 1, y 1, which is a wall"),
    (
        "version 1\n0 room.map 8 4 0 0 -1 0 1\n",
        "room.scen, line 2: expected a whole number from 0 to 5,000, found '-1'",
    ),
    (
        f"version 1\n0 room.map {'9' * 12} 4 0 0 1 0 1\n",
        f"room.scen, line 2: expected a whole number from 0 to 5,000, found '{'9' * 12}'",
    ),
)
def test_wrong_scenarios_are_refused(text: str, problem: str, tmp_path: Path) -> None:
    layout = read_map(written(tmp_path, SIGNS))
    assert refusal(lambda: read_trips(written(tmp_path, text, "room.scen"), layout, 2)).startswith(
        f"{tmp_path}/{problem}"
    )


def test_files_that_cannot_be_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, problem in (("none.map", "No such file or directory"), (".", "Is a directory")):
        with pytest.raises(InputError, match=f"cannot be read: {problem}"):
            read_map(tmp_path / name)
    (tmp_path / "latin.map").write_bytes(b"type \xff")
    with pytest.raises(InputError, match="cannot be read: it is no UTF-8 text"):
        read_map(tmp_path / "latin.map")
    monkeypatch.setattr(movingai, "MOST_SIGNS", 1000)
    with pytest.raises(InputError, match=r"^/dev/zero: found more than 1,000 signs; expected at most that many"):
        read_map("/dev/zero")


def test_a_page_shows_the_plan(tmp_path: Path) -> None:
    """Each robot has a path, a goal, and moves from its start to there."""
    (tmp_path / "hall.map").write_text("......\n......\n", encoding="utf-8")
    trips = "version 1\n0\thall.map\t6\t2\t0\t0\t5\t1\t6\n0\thall.map\t6\t2\t5\t0\t0\t1\t6\n"
    (tmp_path / "two.scen").write_text(trips, encoding="utf-8")
    file = tmp_path / "plan.html"
    arguments = ("--agents", "2", "--scen", str(tmp_path / "two.scen"), "--html", str(file))
    assert exit_code("plan", str(tmp_path / "hall.map"), *arguments) == 0
    page = file.read_text(encoding="utf-8")
    assert "2 of 2 robots arrive; collisions: 0." in page
    assert page.count("<polyline") == page.count("<title>robot ") == 2
    (across, down, *_) = re.findall(r'<animate attributeName="c[xy]"[^>]* values="([^"]*)"', page)
    assert [text.split(";")[0] for text in (across, down)] == ["0.5", "0.5"]
    assert [text.split(";")[-1] for text in (across, down)] == ["5.5", "1.5"]
