import json
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from bad_rules import write_rule
from calling import exit_code
from cases import cases
from rmfs_commands.details.loading import load_result
from rmfs_commands.run.command import default_folder
from tiny import TINY


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    (tmp_path / "small.toml").write_text(TINY, encoding="utf-8")
    write_rule(tmp_path, "pr", 'raise ValueError("out of ideas")')
    return tmp_path


def test_metrics_are_printed_and_files_are_where_it_says(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("run", "small.toml", "--seed", "3") == 0
    printed = capsys.readouterr()
    assert "small, seed 3: complete" in printed.out
    for text in ("Visits per order", "Pile-on", "Makespan", "Picker utilisation", "Turn-over time", "Decisions, t > 1"):
        assert text in printed.out
    assert "rmfs-runs/small-seed3" in printed.out
    assert max(map(len, (printed.out + printed.err).splitlines())) <= 80
    *_, first, last = printed.out.splitlines()
    assert first == "  result.json, orders.csv, visits.csv, periods.csv, hours.csv, stations.csv,"
    assert last == "  robots.csv, delays.csv"
    assert "small: 6 orders" in printed.err
    assert load_result("rmfs-runs/small-seed3").status == "complete"


def test_a_scenario_toml_is_called_as_its_folder(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for day in ("monday", "tuesday"):
        (folder / day).mkdir()
        shutil.copy("small.toml", f"{day}/scenario.toml")
        assert exit_code("run", f"{day}/scenario.toml") == 0
        assert f"{day}, seed 1: complete" in capsys.readouterr().out
    assert {path.name for path in (folder / "rmfs-runs").iterdir()} == {"monday-seed1", "tuesday-seed1"}


def test_a_run_that_reaches_its_horizon_says_what_it_leaves(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("run", "small.toml", "--set", "run.until_s=60", "--set", "run.warmup_s=90", "--out", "out") == 0
    printed = " ".join(capsys.readouterr().out.split())
    found = load_result("out").metrics
    assert 0 < found["open_orders_end"] <= 6
    assert "seed 1: horizon" in printed
    text = f"of 6 orders complete, {found['open_orders_end']} open, {found['backlog_end']} of them in the backlog"
    assert f"{text}; age of the open orders: mean 0:01:00, oldest 0:01:00." in printed
    assert "not packed" not in printed
    assert "The run was over at 0:01:00, before that: they count nothing." in printed
    assert "Simulated time" in printed
    assert "Makespan" not in printed
    assert found["open_age_sum_h"] == pytest.approx(found["open_orders_end"] / 60)
    assert exit_code("run", "small.toml", "--set", "run.warmup_s=90") == 0
    assert "Metrics count what happens from 0:01:30 on (run.warmup_s).\n" in capsys.readouterr().out


def test_a_packing_run_tells_what_is_not_packed_and_leaves_no_file_to_a_run_without(folder, capsys) -> None:
    changes = ("instance.orders=10", "packing.pack_s=3000", "run.until_s=1000")
    assert exit_code("run", "examples/packing", *(f"--set={one}" for one in changes), "--out", "out") == 0
    printed = " ".join(capsys.readouterr().out.split())
    found = load_result("out").metrics
    assert (found["unpacked_end"], found["unpacked_age_sum_h"]) == (10, pytest.approx(10 * 1000 / 3600))
    assert "10 of 10 orders complete, 0 open; 10 arrived orders not packed." in printed
    assert "packing.csv" in printed
    Path("out/notes.csv").write_text("mine", encoding="utf-8")
    assert exit_code("run", "small.toml", "--out", "out") == 0
    assert "packing.csv" not in capsys.readouterr().out
    assert not Path("out/packing.csv").exists()
    assert Path("out/notes.csv").exists()


@cases(
    "arguments problem",
    (("nowhere.toml",), "nowhere.toml"),
    (("",), 'Error: "": there is no such file'),  # as a shell makes of a variable that is not set
    (("small.toml", "--out", ""), "'--out': expected a name, found nothing"),
    (("small.toml", "--set", "robots.cuont=3"), "cuont"),
    (("small.toml", "--out", "small.toml"), "expected a folder"),
    (("small.toml", "--seed", "-1"), "-1"),
    (("small.toml", "--fast"), "--fast"),
    (("small.toml", "--journal", "a.jsonl", "--seed", "0"), "found --seed with --journal; expected one without"),
    (("small.toml", "--journal", "."), "Error: .: found a folder; expected the file of a journal"),
    (("a.hall.json", "--journal", "a.jsonl", "--set", "seed=2"), "found --set with --journal; expected one without"),
)
def test_wrong_input(folder, capsys, arguments, problem) -> None:
    assert exit_code("run", *arguments) == 2
    printed = capsys.readouterr().err
    assert problem in printed
    assert "Traceback" not in printed
    assert {path.name for path in folder.iterdir()} == {"small.toml", "bad.py"}


def test_a_rule_that_fails(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("run", "small.toml", "--set", "rules.pr=./bad.py:Bad", "--out", "out") == 1
    printed = capsys.readouterr().err
    assert "Loading code from" in printed
    assert "bad.py" in printed
    assert "What was measured until the error is in out" in printed
    assert printed.splitlines()[-1].startswith("Error: ")
    assert "Traceback" not in printed
    assert "With --traceback the same command prints" in printed
    assert load_result("out").status == "failed"
    assert exit_code("run", "small.toml", "--set", "rules.pr=./bad.py:Bad", "--traceback") == 1
    printed = capsys.readouterr().err
    assert "in choose_storage_location" in printed
    assert 'raise ValueError("out of ideas")' in printed


@pytest.mark.skipif(sys.platform == "win32", reason="no POSIX signals")
def test_ctrl_c_keeps_what_was_measured(folder: Path) -> None:
    # Whoever runs tests in the background lets them ignore interrupts.
    heed = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"
    command = [sys.executable, "-c", f"{heed}; from rmfs_commands.cli.main import main; main()", "run", "small.toml"]
    long = ["--set", "instance.orders=20000", "--out", "out"]
    with subprocess.Popen([*command, *long], stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        for line in process.stderr:
            if line.startswith("small: 20,000 orders"):
                break
        time.sleep(0.3)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "Interrupted." in err
    assert "partial" in out
    result = load_result("out")
    assert result.status == "partial"
    assert result.metrics["orders_completed"] < 20_000


def test_what_was_set_is_in_the_name_of_the_folder() -> None:
    assert default_folder("paper-250", 1).name == "paper-250-seed1"
    assert default_folder("s", 2, ("robots.count=4",)).name == "s-seed2-robots.count=4"
    assert default_folder("s", 2, ("rules.poa=./my rule.py:A",)).name == "s-seed2-rules.poa=._my_rule.py_A"
    long = [default_folder("s", 1, (f"rules.poa={'x' * 80}{i}",)).name for i in range(2)]
    assert long[0] != long[1]
    assert max(map(len, long)) < 80


def test_json_is_all_that_is_printed(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = Path("here/it/is")
    assert exit_code("run", "small.toml", "--json", "--out", str(out), "--set", "instance.orders=3", "--trace") == 0
    printed = json.loads(capsys.readouterr().out)
    assert (printed.pop("folder"), printed["metrics"]["orders_total"]) == (str(out), 3)
    assert printed == json.loads((out / "result.json").read_text(encoding="utf-8"))
    assert (out / "trace.jsonl.gz").exists()


def test_robots_and_stations_that_never_meet_are_said_before_and_after(folder, capsys) -> None:
    hours = ("--set", 'stations.open=[["06:00", "10:00"]]', "--set", 'robots.available=[["12:00", "16:00"]]')
    assert exit_code("run", "examples/small", *hours, "--set", "run.until_s=40000", "--out", "never") == 0
    out, err = capsys.readouterr()
    assert "Note: no robot is on duty while a station is open" in " ".join(err.split())
    assert "No order is complete at 40000.000 s: no robot is on duty before 43200.000 s." in " ".join(out.split())
