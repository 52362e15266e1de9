"""`rmfs compare RUN RUN`: two finished runs next to each other."""

import json
from pathlib import Path

import pytest

import rmfs_core
from calling import exit_code, refused
from rmfs_commands.cli.main import main
from rmfs_core.scenario import load_scenario


def runs(folder: Path, *overrides: str) -> list[str]:
    """Make a run, and one with other keys; return their folders."""
    found = [str(folder / "one"), str(folder / "other")]
    for out, more in zip(found, ((), overrides), strict=True):
        rmfs_core.run(load_scenario("examples/small", ["instance.orders=3", *more]), out=out)
    return found


def test_metrics_and_what_differs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folders = runs(tmp_path, "rules.pps=completes", "robots.count=2")
    assert exit_code("compare", *folders, "--json") == 0
    found = json.loads(capsys.readouterr().out)
    assert found["names"] == folders
    assert found["differs"] == {"rules.pps": ["demand", "completes"], "robots.count": [4, 2]}
    read = [json.loads((Path(out) / "result.json").read_text(encoding="utf-8"))["metrics"] for out in folders]
    assert found["metrics"]["turnover_s"] == [one["turnover_s"] for one in read]
    assert exit_code("compare", *folders) == 0
    shown = capsys.readouterr().out
    assert "Both runs have the same orders, pods and stations." in shown
    assert 'rules.pps: "demand" and "completes"' in shown


def test_another_seed_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("compare", *runs(tmp_path, "seed=9")) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert "may have other orders, pods or stations, because they differ in seed." in told


def test_of_files_only_the_names_are_known(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folders = runs(tmp_path, "robots.count=2")
    for folder in folders:
        file = Path(folder) / "result.json"
        told = json.loads(file.read_text(encoding="utf-8"))
        told["scenario"]["instance"] |= {"orders_file": "orders.csv", "arrivals": {"profile": "day.csv"}}
        file.write_text(json.dumps(told), encoding="utf-8")
    assert exit_code("compare", *folders) == 0
    shown = " ".join(capsys.readouterr().out.split())
    assert "same files in instance.arrivals.profile, instance.orders_file; their contents are not compared." in shown
    assert "the same orders" not in shown


def test_wrong_calls_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    one = runs(tmp_path)[0]
    assert "there is no result.json" in refused(capsys, main, ["compare", one, str(tmp_path)])
    for more in (["--quick"], ["--width", "7.7"], ["--no-inline-rules"]):
        assert "no options but --json and --quiet" in refused(capsys, main, ["compare", one, one, *more])
    (tmp_path / "result.json").write_text('{"metrics": {}, "seed": 1, "status": "complete", "versions": {}}')
    assert "expected `scenario`, `seed`, `status` and `versions`" in refused(
        capsys, main, ["compare", one, str(tmp_path)]
    )
    assert "expected an experiment, a file or one of" in refused(capsys, main, ["compare", one, one, one])
