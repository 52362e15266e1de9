"""`rmfs plan`: path planning by itself."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from rmfs_commands.cli.main import main
from rmfs_commands.cli.map_drawing import draw_map
from rmfs_commands.testing import small_layout

ROOM = "type octile\nheight 4\nwidth 8\nmap\n........\n.@@..@@.\n........\nTT....OO\n"
SCEN = "version 1\n0\troom.map\t8\t4\t0\t0\t7\t2\t9\n0\troom.map\t8\t4\t7\t2\t0\t2\t9\n"


@pytest.fixture
def room(tmp_path: Path) -> Path:
    """A MovingAI map."""
    (tmp_path / "room.map").write_text(ROOM, encoding="utf-8")
    return tmp_path / "room.map"


def ask(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> tuple[int, str, str]:
    """Run `rmfs plan`; return exit code, output and errors, without the notice of a checkout's first search."""
    code = 0
    try:
        main(["plan", *arguments])
    except SystemExit as stop:
        code = int(stop.code or 0)
    out, err = capsys.readouterr()
    return code, out, "".join(line for line in err.splitlines(True) if not line.startswith("Compiling searches"))


@pytest.mark.parametrize("pp", ["sipp", pytest.param("whca-n", marks=pytest.mark.slow)])
def test_all_robots_of_a_random_plan_arrive(
    pp: str, room: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Four robots in a room arrive without collision; the files say how, and are the same the second time."""
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


def test_a_scenario_names_the_trips(room: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The second robot leaves the first one's goal; both get there."""
    scen = room.with_suffix(".scen")
    scen.write_text(SCEN, encoding="utf-8")
    code, text, _ = ask([str(room), "--scen", str(scen), "--agents", "2"], capsys)
    assert code == 0
    assert "7,2" in text


def test_free_flow_is_planned_through_its_hook(room: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A rule that ignores other robots is planned with too; its collisions are said, and are no failure."""
    code, text, _ = ask([str(room), "--agents", "6", "--pp", "free-flow"], capsys)
    assert code == 0
    assert "First collision: robots" in text


def test_text_maps_are_read(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """On a warehouse's map robots drive between storage locations, all of them."""
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


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        (
            "type octile\nheight 1\nwidth 3\nmap\n..\n",
            "bad.map, line 5: found 2 cells; expected 3, as the map's width says",
        ),
        ("type octile\nheight 1\nwidth 2\nmap\n..\n", "bad.map: found room for 1 robot with start and goal"),
    ],
)
def test_wrong_maps_are_refused(text: str, problem: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """One sentence with the place, exit code 2."""
    (tmp_path / "bad.map").write_text(text, encoding="utf-8")
    code, _, error = ask([str(tmp_path / "bad.map")], capsys)
    assert code == 2
    assert error.startswith(f"Error: {tmp_path}/{problem}")
    assert error.count("\n") == 1


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("version 1\n0 room.map 8 4 0\n", "room.scen, line 2: found 5 fields"),
        (
            "version 1\n0 room.map 8 4 0 0 1 0 1\n0 room.map 8 4 0 0 2 0 1\n",
            "room.scen: robots 1 and 2 have the same start, row 1, column 1",
        ),
    ],
)
def test_wrong_scenarios_are_refused(text: str, problem: str, room: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """One sentence with the place, exit code 2."""
    scen = room.with_suffix(".scen")
    scen.write_text(text, encoding="utf-8")
    code, _, error = ask([str(room), "--scen", str(scen), "--agents", "2"], capsys)
    assert code == 2
    assert error.startswith(f"Error: {room.parent}/{problem}")


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["--pp", "sip"], '--pp sip: there is no rule "sip"'),
        (["--pp", "demand"], "decides PPS; expected a rule for PP"),
        (["--pp", "whca-n", "--set", "window=3"], "--set window=3: rule"),
        (["--pp", "whca-n", "--set", "window_s=-3"], "expected a number > 0"),
        (["--set", "a.b=3"], "--set a.b=3: expected a parameter of the rule"),
        (["--agents", "50"], "found room for"),
    ],
)
def test_wrong_options_are_refused(
    arguments: list[str], problem: str, room: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One sentence, exit code 2."""
    code, _, error = ask([str(room), *arguments], capsys)
    assert code == 2
    assert problem in error


def unplannable(*_: object) -> None:
    """Stand in for the search where there shall be none."""
    pytest.fail("the search began")


def test_an_interrupted_search_leaves_no_folder(
    room: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It was made before the search, to see that it can be."""

    def interrupted(*_: object) -> None:
        assert (tmp_path / "out").is_dir()
        raise KeyboardInterrupt

    monkeypatch.setattr("rmfs_commands.plan.plan_by_priorities", interrupted)
    assert ask([str(room), "--agents", "2", "--out", str(tmp_path / "out")], capsys)[0] == 130
    assert not (tmp_path / "out").exists()


def test_where_the_files_cannot_go_is_said_before_the_search(
    room: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A file in the way of the folder, or a folder in the way of a file: exit code 2, and no robot is planned for."""
    monkeypatch.setattr("rmfs_commands.plan.plan_by_priorities", unplannable)
    (tmp_path / "taken" / "paths.csv").mkdir(parents=True)
    in_the_way = f"{room}/out: found a file in the way; expected a folder, or nothing"
    for out, problem in (
        (room / "out", in_the_way),
        (tmp_path / "taken", f"{tmp_path}/taken/paths.csv: cannot be written: a folder has that name"),
    ):
        assert ask([str(room), "--agents", "2", "--out", str(out)], capsys) == (2, "", f"Error: {problem}\n")


def test_a_map_of_one_row_without_end_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """One sentence, not a table that no memory has room for."""
    (tmp_path / "row.txt").write_text("." * 3_000_000 + "\n", encoding="utf-8")
    expected = "expected at most 5,000 in a row or column and 4,000,000 in all"
    problem = f"{tmp_path}/row.txt: found a map of 3,000,000 x 1 cells; {expected}"
    assert ask([str(tmp_path / "row.txt"), "--agents", "2"], capsys) == (2, "", f"Error: {problem}\n")


def test_a_file_that_is_not_there_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The map's name and the system's reason."""
    code, _, error = ask([str(tmp_path / "none.map")], capsys)
    assert (code, error) == (2, f"Error: {tmp_path}/none.map: cannot be read: No such file or directory\n")


@pytest.mark.parametrize(
    ("reserves", "problem", "code"),
    [
        ("windows", " a path that hits a reservation: robot ", 1),
        ("window", "has reserves = 'window'; expected 'full paths', 'windows', 'fleet' or None", 2),
    ],
)
def test_a_rule_that_heeds_nobody_is_named(
    reserves: str,
    problem: str,
    code: int,
    room: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A path through another robot's reservation, and a misspelt attribute: one sentence."""
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
    """What plan.json has, and every robot's trip; nothing else on the output."""
    code, text, _ = ask([str(room), "--agents", "3", "--pp", "free-flow", "--out", str(tmp_path), "--json"], capsys)
    assert code == 0
    document = json.loads(text)
    trips = document.pop("trips")
    assert document == json.loads((tmp_path / "plan.json").read_text(encoding="utf-8"))
    assert [trip["robot"] for trip in trips] == [1, 2, 3]
    assert sum(trip["arrives_s"] for trip in trips) == pytest.approx(document["costs"]["sum_of_costs_s"])
