"""`rmfs import`: files of each format, and what then runs."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import pytest

from rawsimo_files import xgenc, xinst, xsett
from rmfs_commands.cli.main import main
from rmfs_core.world import parse_map

HALL = ".......\n.##.##.\n.......\n.##→→→O\n.......\n"
OCTILE = "type octile\nheight 3\nwidth 6\nmap\n......\n.E@@S.\n......\n"
KIVA = "3,6\n2\n2\n5000\n......\nr.ee.r\n......\n"
PROBLEM = {"mapFile": "a.map", "agentFile": "a.agents", "taskFile": "a.tasks", "teamSize": 2}
TEXTS = {
    "hall.xinst": xinst(parse_map(HALL, "hall"), {0: (2, 2), 1: (4, 3)}, [(1, 1)]),
    "few.xsett": xsett(run={"SimulationDuration": 200}, InitialInventory=0.2),
    "few.xgenc": xgenc({0: 1, 1: 2}),
    "kiva.map": KIVA,
    "a.map": OCTILE,
    "a.agents": "2\n0\n12\n",
    "a.tasks": "2\n7,10\n10,7\n",
    "a.json": json.dumps(PROBLEM),
    "m.map": OCTILE.replace("E", "."),
    "m.scen": "version 1\n0\tm.map\t6\t3\t0\t0\t5\t2\t8\n1\tm.map\t6\t3\t5\t0\t0\t2\t8\n",
}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the current folder, with files of each format."""
    for name, text in TEXTS.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("files", "kind", "wrote"),
    [
        (
            ["hall.xinst", "few.xsett", "few.xgenc"],
            "RAWSim-O",
            ["import.json", "map.txt", "orders.csv", "pods.csv", "robots.csv", "scenario.toml"],
        ),
        (["kiva.map"], "RHCR", ["import.json", "map.txt", "trips.scen"]),
        (["a.json"], "League of Robot Runners", ["import.json", "map.txt", "trips.scen"]),
        (["m.map", "m.scen"], "MovingAI", ["import.json", "map.txt", "trips.scen"]),
    ],
)
def test_the_command_that_is_shown_runs(
    folder: Path, capsys: pytest.CaptureFixture[str], files: list[str], kind: str, wrote: list[str]
) -> None:
    """On what was written, for files of every format."""
    main(["import", *files, "--out", "made"])
    said = capsys.readouterr().out
    assert said.startswith(f"Read from {kind}: ")
    assert sorted(file.name for file in (folder / "made").iterdir()) == wrote
    assert f"Wrote {', '.join(wrote)} to made." in said
    arguments = said.splitlines()[-1].removeprefix("Run it with: rmfs ").split()
    main([*arguments, *(["--quiet", "--out", "run"] if arguments[0] == "run" else ["--pp", "free-flow"])])
    assert ("Arrived 2 of 2" in capsys.readouterr().out) == (arguments[0] == "plan")
    assert (folder / "run" / "result.json").exists() == (arguments[0] == "run")


def test_the_command_that_is_shown_can_be_pasted(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Into a shell, whatever the folder is called; a small map has room for few robots."""
    main(["import", "m.map", "--out", "my {} map"])
    words = shlex.split(capsys.readouterr().out.splitlines()[-1].removeprefix("Run it with: rmfs "))
    assert words == ["plan", "my {} map/map.txt", "--agents", "8"]
    main([*words, "--pp", "free-flow"])
    assert "8 robots, free-flow" in capsys.readouterr().out


def test_the_report_is_json_too(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Printed, and beside what was written; the same files give the same bytes."""
    main(["import", "kiva.map", "--out", "made", "--json"])
    told = json.loads(capsys.readouterr().out)
    assert told.pop("folder") == "made"
    assert told == json.loads((folder / "made" / "import.json").read_text(encoding="utf-8"))
    assert (told["format"], told["read"]["trips"]) == ("RHCR", 2)
    assert told["without_counterpart"][0] == {"what": "endpoints (e)", "number": 2, "instead": "storage locations"}
    main(["import", "kiva.map", "--out", "again", "--json"])
    for file in (folder / "made").iterdir():
        assert file.read_bytes() == (folder / "again" / file.name).read_bytes()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["m.scen"], "Error: m.scen: found files of different formats, or one missing; expected those of one instance"),
        (["none.xinst"], "Error: none.xinst: cannot be read: No such file or directory"),
        (["few.xsett"], "Error: few.xsett: found no warehouse; expected an .xinst or .xlayo beside it"),
        (
            ["m.map", "--format", "rhcr"],
            "Error: --format: found files that RHCR does not have together; they look",
        ),
    ],
)
def test_wrong_files_are_one_sentence(
    folder: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], message: str
) -> None:
    """With exit code 2; nothing is written then."""
    with pytest.raises(SystemExit) as end:
        main(["import", *arguments, "--out", "made"])
    assert end.value.code == 2
    said = capsys.readouterr().err
    assert said.startswith(message)
    assert len(said.splitlines()) == 1
    assert not (folder / "made").exists()


def test_files_are_replaced_when_asked(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Not else."""
    main(["import", "kiva.map", "--out", "made"])
    with pytest.raises(SystemExit):
        main(["import", "kiva.map", "--out", "made"])
    assert "found a file of that name; --force replaces it" in capsys.readouterr().err
    main(["import", "kiva.map", "--out", "made", "--force", "--seed", "2"])
    assert (folder / "made" / "trips.scen").exists()
