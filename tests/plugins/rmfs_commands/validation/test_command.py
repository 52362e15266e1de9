"""`rmfs validate`: faults as a table, and the exit code."""

from __future__ import annotations

import gzip
import json
from pathlib import Path

import pytest

import rmfs_core
from corruptions import Raw
from rmfs_commands.cli.main import main
from rmfs_commands.testing import validate_trace
from rmfs_core import InputError


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Folder of a recorded run."""
    settings = ("instance.orders=8", "rules.pp=free-flow")
    rmfs_core.run("examples/small", overrides=settings, out=tmp_path, record=["trace"])
    return tmp_path


def alter_metric(folder: Path) -> None:
    """Report more picks than there were."""
    file = folder / "result.json"
    content = json.loads(file.read_text(encoding="utf-8"))
    content["metrics"]["picks"] += 1
    file.write_text(json.dumps(content), encoding="utf-8")


def code_of(*arguments: str) -> int:
    """Return the exit code of a command line."""
    try:
        main(["validate", *arguments])
    except SystemExit as stop:
        return int(stop.code or 0)
    return 0


def test_a_good_run(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """No faults: exit code 0, and what was not checked is said."""
    assert code_of(str(folder)) == 0
    first, second = capsys.readouterr().out.splitlines()
    assert first.startswith("no faults in ")
    assert first.endswith(" events")
    assert second.startswith(
        "NOT CHECKED: WHETHER ROBOTS COLLIDE. The trace says that its PP rule ignores other robots;"
    )


def test_the_trace_alone(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A trace file is enough; metrics are compared when there is a result."""
    (folder / "result.json").unlink()
    assert code_of(str(folder / "trace.jsonl.gz")) == 0
    assert "no result.json" in capsys.readouterr().out


def test_a_trace_of_another_version(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What its scenario makes is not made anew; that is said."""
    raw = Raw.read(folder / "trace.jsonl.gz")
    raw.header["versions"]["numpy"] = "1.0"
    raw.write(folder / "trace.jsonl.gz")
    (folder / "result.json").unlink()
    assert code_of(str(folder)) == 0
    assert "Not checked: whether the run starts from what its scenario makes" in capsys.readouterr().out


def test_faults_are_shown(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A fault has a row with its time, kind and sentence; exit code 1."""
    alter_metric(folder)
    assert code_of(str(folder)) == 1
    out = capsys.readouterr().out
    assert "metric" in out
    assert "picks is reported as" in out
    assert "1 fault in " in out


def test_many_faults_are_cut_off(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Not more faults are shown than asked for; the number of the others is told."""
    assert code_of(str(folder), "--collisions", "--limit", "1") == 1
    assert "more; --limit shows more of them." in capsys.readouterr().out
    assert code_of(str(folder), "--no-collisions") == 0
    assert "NOT CHECKED: WHETHER ROBOTS COLLIDE, as --no-collisions asks." in capsys.readouterr().out


def test_a_run_without_a_trace(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The folder, and how to record one."""
    assert code_of(str(tmp_path)) == 2
    assert capsys.readouterr().err == f"Error: {tmp_path}: has no trace.jsonl.gz; `rmfs run --trace` records one\n"


def test_what_cannot_be_read(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A missing or damaged file is one line of error; exit code 2."""
    assert code_of(str(tmp_path / "nowhere")) == 2
    (folder / "result.json").write_text("{", encoding="utf-8")
    assert code_of(str(folder)) == 2
    (folder / "trace.jsonl.gz").write_bytes(b"no trace")
    assert code_of(str(folder)) == 2
    assert [line[:7] for line in capsys.readouterr().err.splitlines()] == ["Error: "] * 3


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("robots", [{"cell": 10**6, "heading": 1}]),
        ("stations", []),
        ("motion", {"acceleration_m_per_s2": 0, "top_speed_m_per_s": 1.5, "full_turn_s": 2.5, "lift_s": 2.2}),
        ("scenario", {"rules": {}, "stations": {}}),
    ],
)
def test_a_header_that_makes_no_sense_is_refused(folder: Path, key: str, value: object) -> None:
    """What names cells or stations that are not there cannot be checked: the input is wrong."""
    file = folder / "trace.jsonl.gz"
    lines = gzip.decompress(file.read_bytes()).decode().splitlines(keepends=True)
    header = {**json.loads(lines[0]), key: value}
    file.write_bytes(gzip.compress("".join([json.dumps(header) + "\n", *lines[1:]]).encode()))
    with pytest.raises(InputError):
        validate_trace(folder)


def test_json(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The report as JSON, with the same exit code."""
    assert code_of(str(folder), "--json") == 0
    report = json.loads(capsys.readouterr().out)
    assert (report["faults"], report["collisions_checked"], report["metrics_checked"]) == ([], False, True)
    alter_metric(folder)
    assert code_of(str(folder), "--json") == 1
    (fault,) = json.loads(capsys.readouterr().out)["faults"]
    assert fault["kind"] == "metric"
