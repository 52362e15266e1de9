"""A third party's package can do all that rmfs's own do: a distribution built, installed and used with rmfs."""

import csv
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pandas
import pytest

ACME = Path(__file__).resolve().parent / "third_party" / "acme"
SCENARIO = """
[instance]
orders = 20
[rules]
poa = "pod-match"
pps = "demand"
pp = "free-flow"
observers = ["acme-first-picks"]
"""
EXPERIMENT = """
base = "watched.toml"
seeds = [1, 2]
baseline = "pod-match"
metrics = ["makespan_s", "acme_all_busy_s", "acme_busy_stations", "acme_legs"]
[[rule_sets]]
name = "pod-match"
[[rule_sets]]
name = "first-come"
rules.poa = "first-come"
[[rule_sets]]
name = "unwatched"
rules.observers = []
"""
RMFS = ("python", "-c", "from rmfs_commands.cli.main import main; main()")
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def place(environment: Callable[..., Any], built: Callable[[Path], tuple[Path, Path]]) -> Any:
    """Return an environment with acme beside rmfs, and the results of a run that its observer and recorder watched."""
    place = environment(borrowed=True)
    place.install(built(ACME)[1])
    (place.folder / "watched.toml").write_text(SCENARIO, encoding="utf-8")
    printed = place.call(*RMFS, "run", "watched.toml", "--out", "day", "--record", "acme-log", "--trace")
    (place.folder / "printed.txt").write_text(printed, encoding="utf-8")
    return place


def test_its_command_is_one_of_ours(place: Any) -> None:
    listed = place.call(*RMFS, "--help")
    assert "  acme-first   Print when each station had its first pick" in listed
    assert "  acme-broken  (not usable: " in listed
    assert "  validate     " in listed
    lines = place.call(*RMFS, "acme-first", "day").splitlines()
    assert len(lines) == 4
    assert lines[0].startswith("station 1: ")
    for arguments, problem in (
        (("acme-first", "nowhere"), "Error: nowhere/result.json: cannot be read"),
        (("acme-broken", "x"), 'Error: rmfs acme-broken: command "acme-broken" (acme 2.0) cannot be imported'),
    ):
        done = place.run(*RMFS, *arguments)
        assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
        assert done.stderr.startswith(problem)


def test_its_observer_and_recorder_write_beside_the_results(place: Any) -> None:
    files = {path.name for path in (place.folder / "day").iterdir()}
    assert files == {
        *("result.json", "orders.csv", "visits.csv", "periods.csv", "trace.jsonl.gz"),
        *("hours.csv", "stations.csv", "robots.csv", "delays.csv"),
        *("first-picks.csv", "acme-log.txt", "acme-turns.txt"),
    }
    assert "acme-log.txt" in (place.folder / "printed.txt").read_text("utf-8")
    asked = dict(line.split() for line in (place.folder / "day" / "acme-log.txt").read_text("utf-8").splitlines())
    assert int(asked["free-flow"]) > int(asked["pod-match"]) > 0


def test_its_layouts_are_layouts(place: Any) -> None:
    (place.folder / "hall.runs").write_text("6# 5.\n7. 2q 1O 1.\n6# 5.\n", encoding="utf-8")
    small = [f"--set={key}" for key in ("instance.orders=5", "robots.count=2", "instance.pods=5", "instance.skus=5")]
    for name, key, locations in (("acme-aisle", "block_length=9", 18), ("acme-runs", "map_file=hall.runs", 12)):
        given = (f"--set=layout.generator={name}", f"--set=layout.{key}")
        place.call(*RMFS, "run", "watched.toml", "--out", name, "--trace", *small, *given)
        result = json.loads((place.folder / name / "result.json").read_text("utf-8"))
        assert (result["status"], result["versions"]["acme"]) == ("complete", "2.0")
        assert "no fault" in place.call(*RMFS, "validate", name)
        assert place.call(*RMFS, "scenario", "map", "watched.toml", *given).count("#") == locations


def test_its_metrics_are_metrics(place: Any) -> None:
    content = json.loads((place.folder / "day" / "result.json").read_text("utf-8"))
    assert content["versions"]["acme"] == "2.0"
    assert content["metrics"]["acme_busy_stations"] == 4
    shown = [" ".join(line.split()) for line in (place.folder / "printed.txt").read_text("utf-8").splitlines()]
    assert any(line.endswith(f"All stations busy {content['metrics']['acme_all_busy_s']:.1f} s") for line in shown)
    assert any(line.endswith("acme_busy_stations 4") for line in shown)
    assert "no fault" in place.call(*RMFS, "validate", "day")


def test_its_metrics_are_compared(place: Any) -> None:
    (place.folder / "trial.toml").write_text(EXPERIMENT, encoding="utf-8")
    printed = place.call(*RMFS, "compare", "trial.toml", "--out", "compared", "--jobs", "1")
    assert "All stations busy (s)" in printed
    assert "\nacme_busy_stations" in printed
    with (place.folder / "compared" / "summary.csv").open(encoding="utf-8", newline="") as stream:
        rows = {(row["metric"], row["rule_set"]): row for row in csv.DictReader(stream)}
    assert float(rows["acme_all_busy_s", "first-come"]["mean"]) > 0
    assert rows["acme_all_busy_s", "unwatched"]["mean"] == ""
    runs = pandas.read_parquet(place.folder / "compared" / "runs.parquet")
    assert list(runs["acme_busy_stations"].dropna()) == [4] * 4
    assert runs["acme_all_busy_s"].isna().sum() == 2
    page = (place.folder / "compared" / "report.html").read_text(encoding="utf-8")
    assert ">All stations busy (s)</h2>" in page
    assert "When the last station had its first pick." in page
    assert ">acme_busy_stations</h2>" in page
    assert rows["acme_legs", "unwatched"]["mean"] == rows["acme_legs", "pod-match"]["mean"] != ""
    (place.folder / "typo.toml").write_text(EXPERIMENT.replace("acme_busy_", "acme_buzy_"), encoding="utf-8")
    done = place.run(*RMFS, "compare", "typo.toml", "--out", "compared", "--quiet")
    assert done.returncode == 2
    assert done.stderr.startswith('Error: typo.toml, line 5, metrics: there is no metric "acme_buzy_stations"')
    assert "`acme_busy_stations`" in done.stderr
