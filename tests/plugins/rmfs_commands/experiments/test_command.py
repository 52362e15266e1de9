"""`rmfs compare` as a person uses it."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas
import psutil
import pytest

from rmfs_commands.cli.main import main
from rmfs_commands.details.metrics import Metrics
from rmfs_commands.experiments import shipped_experiments
from tiny import TINY

TRIAL = """
description = "A trial."
base = "tiny.toml"
seeds = [1, 2]
baseline = "pod-match"
metrics = ["pile_on", "psv_per_order"]
[[rule_sets]]
name = "pod-match"
[[rule_sets]]
name = "first-come"
rules.poa = "first-come"
"""

FAILING_RULE = """
import attrs
from rmfs_core import hookimpl

@attrs.define
class Failing:
    @hookimpl
    def choose_storage_location(self, warehouse, pod):
        raise ValueError("out of ideas")
"""

HEED = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"
"""Whoever runs tests in the background lets them ignore interrupts."""
COMMAND = [sys.executable, "-c", f"{HEED}; from rmfs_commands.cli.main import main; main()", "compare"]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the current folder, with an experiment, its scenario and a rule that fails."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")
    (tmp_path / "tiny.toml").write_text(TINY, encoding="utf-8")
    (tmp_path / "trial.toml").write_text(TRIAL, encoding="utf-8")
    (tmp_path / "failing.py").write_text(FAILING_RULE, encoding="utf-8")
    return tmp_path


def exit_code(*arguments: str) -> int:
    """Run ``rmfs compare`` and return how it exits."""
    try:
        main(["compare", *arguments])
    except SystemExit as stop:
        return int(stop.code or 0)
    return 0


def test_a_comparison_is_printed_and_files_are_where_it_says(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Without --out the files go to a folder named after the experiment; a second call computes nothing."""
    assert exit_code("trial.toml", "--jobs", "1") == 0
    printed = capsys.readouterr()
    assert "trial: 4 runs, 1 at a time" in printed.err
    for text in ("Visits per order", "Pile-on", "first-come", "baseline", "Relative", "rmfs-runs/trial"):
        assert text in printed.out
    out = folder / "rmfs-runs" / "trial"
    files = {"runs", "summary.csv", "runs.parquet", "report.html", "plots", "tables"}
    assert {path.name for path in out.iterdir()} == files
    assert len(pandas.read_parquet(out / "runs.parquet")) == 4
    before = {path: path.stat().st_mtime_ns for path in (out / "runs").rglob("*")}
    assert exit_code("trial.toml") == 0
    again = capsys.readouterr()
    assert again.out == printed.out
    assert {path: path.stat().st_mtime_ns for path in (out / "runs").rglob("*")} == before


def test_a_stored_run_that_was_changed_is_told_of(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It is computed again, and the comparison is what it was."""
    assert exit_code("trial.toml", "--jobs", "1") == 0
    printed = capsys.readouterr().out
    stored = next((folder / "rmfs-runs" / "trial" / "runs").iterdir())
    (stored / "orders.csv").write_text("mine\n", encoding="utf-8")
    assert exit_code("trial.toml") == 0
    again = capsys.readouterr()
    assert f"{stored.relative_to(folder)}: is not as it was stored: orders.csv was changed" in again.err
    assert again.err.startswith("Computed again: tiny, ")
    assert again.out == printed


def test_bounds_are_shown_when_asked_for(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A column on the terminal, in JSON the numbers; runs that are stored already need not be run again."""
    assert exit_code("trial.toml", "--jobs", "1") == 0
    assert "x bound" not in capsys.readouterr().out
    assert exit_code("trial.toml", "--bounds") == 0
    printed = capsys.readouterr()
    assert printed.err.startswith("trial: bounds of 2 instances and seeds\ntrial: all 4 runs are stored already")
    assert "x bound" in printed.out
    assert exit_code("trial.toml", "--bounds", "--json") == 0
    paired = json.loads(capsys.readouterr().out)["paired"]
    multiples = {(one["metric"], one["rule_set"]): one["times_bound"] for one in paired}
    assert multiples["psv_per_order", "pod-match"] >= 1
    assert multiples["pile_on", "pod-match"] is None


def test_a_rule_that_fails_costs_its_own_runs_alone(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Exit code 1, the error in one line, and the other rule set's runs are done and compared."""
    (folder / "bad.toml").write_text(TRIAL + 'rules.pr = "./failing.py:Failing"\n', encoding="utf-8")
    assert exit_code("bad.toml", "--out", "out", "--jobs", "1") == 1
    printed = capsys.readouterr()
    assert "Loading code from failing.py." in printed.err
    assert "out of ideas" in printed.out
    assert "0 (2 left out)" in printed.out
    assert printed.err.splitlines()[-1] == "Error: 2 of 4 runs failed; out/report.html has their errors."
    assert list(pandas.read_parquet("out/runs.parquet")["status"]) == ["complete"] * 2 + ["failed"] * 2


def test_quiet_prints_nothing(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """With --quiet only the files tell of the comparison."""
    assert exit_code("trial.toml", "--quiet", "--out", "out", "--jobs", "1") == 0
    assert tuple(capfd.readouterr()) == ("", "")
    assert (folder / "out" / "report.html").exists()


def test_the_shipped_experiments_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    """Each is listed with what it is for."""
    assert exit_code("--list") == 0
    lines = [line for line in capsys.readouterr().out.splitlines() if not line.startswith(" ")]
    assert [line.split()[0] for line in lines] == list(shipped_experiments())
    assert all(len(line.split()) > 3 for line in lines)


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        ((), "rmfs compare --list"),
        (("nowhere.toml",), "nowhere.toml"),
        (("tiny.toml",), "unknown key"),
        (("trial.toml", "--jobs", "0"), "--jobs"),
        (("trial.toml", "--out", "tiny.toml"), "expected a folder"),
        (("trial.toml", "--dask", "somewhere"), "expected the address of a scheduler, tcp://host:8786"),
        (("bad.toml", "--no-inline-rules"), "failing.py"),
    ],
)
def test_wrong_input(
    folder: Path, capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...], problem: str
) -> None:
    """Exit code 2, what is wrong on stderr, no traceback, and no report is written."""
    (folder / "bad.toml").write_text(TRIAL + 'rules.pr = "./failing.py:Failing"\n', encoding="utf-8")
    assert exit_code(*arguments) == 2
    printed = capsys.readouterr().err
    assert problem in printed
    assert "Traceback" not in printed
    assert not list(folder.rglob("report.html"))


def long_experiment(folder: Path, seeds: int) -> None:
    """Write an experiment that takes some seconds."""
    text = TRIAL.replace("[1, 2]", f"{{ count = {seeds} }}")
    text = text.replace("[[rule_sets]]", "[axes]\ninstance.orders = [100]\n[[rule_sets]]", 1)
    (folder / "long.toml").write_text(text, encoding="utf-8")


def wait_for_runs(folder: Path, count: int) -> None:
    """Wait until so many runs are stored."""
    until = time.monotonic() + 60
    while time.monotonic() < until:
        if folder.is_dir() and sum(not path.name.startswith(".") for path in folder.iterdir()) >= count:
            return
        time.sleep(0.02)
    pytest.fail(f"there were no {count} runs after a minute")


@pytest.mark.slow
def test_ctrl_c_keeps_what_is_finished(folder: Path) -> None:
    """An interrupt, which a terminal sends to the workers as well, gives exit code 130 at once; runs are kept."""
    long_experiment(folder, 40)
    arguments = ["long.toml", "--out", "out", "--jobs", "2"]
    with subprocess.Popen([*COMMAND, *arguments], stderr=subprocess.PIPE, text=True, process_group=0) as process:
        wait_for_runs(folder / "out" / "runs", 4)
        os.killpg(process.pid, signal.SIGINT)
        _, err = process.communicate(timeout=30)
    assert process.returncode == 130
    assert err.splitlines()[-1] == "Interrupted."
    assert "Finished runs are kept in out/runs" in err
    assert "Traceback" not in err
    assert 4 <= len(list((folder / "out" / "runs").iterdir())) < 80
    assert not (folder / "out" / "report.html").exists()


@pytest.mark.slow
def test_a_killed_comparison_goes_on_where_it_stopped(folder: Path) -> None:
    """After kill -9 in the middle the same command computes the rest alone; the tables are an undisturbed run's."""
    long_experiment(folder, 10)
    assert exit_code("long.toml", "--out", "undisturbed", "--quiet") == 0
    runs = folder / "out" / "runs"
    with subprocess.Popen([*COMMAND, "long.toml", "--out", "out", "--jobs", "2", "--quiet"]) as process:
        wait_for_runs(runs, 5)
        workers = psutil.Process(process.pid).children(recursive=True)
        process.kill()
    _, alive = psutil.wait_procs(workers, timeout=20)
    assert workers
    assert not alive, "workers must not outlive a killed parent"
    stored = {path.name: path.stat().st_mtime_ns for path in runs.iterdir() if not path.name.startswith(".")}
    assert 5 <= len(stored) < 20
    assert exit_code("long.toml", "--out", "out", "--quiet") == 0
    after = {path.name: path.stat().st_mtime_ns for path in runs.iterdir() if not path.name.startswith(".")}
    assert len(after) == 20
    assert {name: after[name] for name in stored} == stored
    assert (folder / "out" / "summary.csv").read_bytes() == (folder / "undisturbed" / "summary.csv").read_bytes()
    tables = [pandas.read_parquet(folder / name / "runs.parquet") for name in ("out", "undisturbed")]
    same = ["instance", "rule_set", "seed", "status", "error", "key", *Metrics().measured()]
    assert tables[0][same].equals(tables[1][same])


def test_json(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The comparison as JSON, and the list of experiments; nothing else on the output."""
    assert exit_code("trial.toml", "--jobs", "1", "--json") == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["experiment"], found["runs"], found["failed"]) == ("trial", 4, 0)
    assert {one["rule_set"] for one in found["paired"]} == set(found["rule_sets"])
    assert exit_code("--list", "--json") == 0
    assert [one["name"] for one in json.loads(capsys.readouterr().out)] == list(shipped_experiments())


@pytest.mark.parametrize("width", [80, 140])
def test_long_names_of_rule_sets_are_whole(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, width: int
) -> None:
    """At 80 columns they stand above their figures where there is no room beside them."""
    monkeypatch.setenv("COLUMNS", str(width))
    name = "a rule set with a name that is as long as somebody wants it to be"
    text = TRIAL.replace('"first-come"', f'"{name}"', 1)
    (folder / "long.toml").write_text(text, encoding="utf-8")
    assert exit_code("long.toml", "--jobs", "1") == 0
    lines = capsys.readouterr().out.splitlines()
    assert any(name in line for line in lines)
    assert max(map(len, lines)) <= width
    assert not any("…" in line for line in lines)
