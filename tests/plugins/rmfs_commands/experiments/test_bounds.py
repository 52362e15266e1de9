"""Bounds beside the figures of runs, and where they are kept."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from rmfs_commands.bounds import BOUNDED, bounds_of
from rmfs_commands.experiments import Experiment, Watcher, run_experiment

Write = Callable[..., Experiment]

SEVERAL = """
base = "tiny.toml"
seeds = [1, 2]
baseline = "pod-match"
[[rule_sets]]
name = "pod-match"
[[rule_sets]]
name = "first-come"
rules.poa = "first-come"
[[rule_sets]]
name = "slow pickers"
stations.handle_s = 40.0
"""


class Listener(Watcher):
    """Hears how many bounds are sought, each time."""

    def __init__(self) -> None:
        self.sought: list[int] = []

    def bounding(self, instances: int) -> None:
        """Keep the number."""
        self.sought.append(instances)


def test_each_run_has_the_bounds_of_its_world(experiment: Write, tmp_path: Path) -> None:
    """Rules do not change them; a seed does, and slower pickers. They are sought once, and no figure is below."""
    heard = Listener()
    result = run_experiment(experiment(SEVERAL), store=tmp_path / "runs", jobs=1, bounds=True, watcher=heard)
    assert heard.sought == [4]
    rows = {(row["rule_set"], row["seed"]): row for row in result.rows}
    for job, row in zip(experiment(SEVERAL).jobs(), result.rows, strict=True):
        assert {metric: row[f"bound.{metric}"] for metric in BOUNDED} == {
            bound.metric: bound.value for bound in bounds_of(job.scenario)
        }
        assert all(row[metric] >= row[f"bound.{metric}"] for metric in BOUNDED)
    least = {key: row["bound.makespan_s"] for key, row in rows.items()}
    assert least["pod-match", 1] == least["first-come", 1] < least["slow pickers", 1]
    assert least["pod-match", 1] != least["pod-match", 2]


def test_rules_that_move_pods_and_stock_that_is_replenished(experiment: Write, tmp_path: Path) -> None:
    """Both have bounds of their own."""
    bundles = 'instance.replenishment = { process = "poisson", bundles_per_hour = 60.0, bundle_items = 2 }'
    text = SEVERAL.partition('name = "slow')[0] + 'name = "moving"\nrules.move = "utility"\n[[rule_sets]]\n'
    text += f'name = "bundles"\nrules.roa = "first-bundle"\nrules.rps = "emptiest-pod"\n{bundles}\n'
    text += "stations.also_replenish = true\n"
    jobs, result = experiment(text).jobs(), run_experiment(experiment(text), store=tmp_path, jobs=1, bounds=True)
    for job, row in zip(jobs, result.rows, strict=True):
        assert {metric: row[f"bound.{metric}"] for metric in BOUNDED} == {
            bound.metric: bound.value for bound in bounds_of(job.scenario)
        }
    assert {row["bound.pod_station_visits"] is None for row in result.rows if row["rule_set"] == "bundles"} == {True}


def test_they_are_kept_with_the_runs(experiment: Write, tmp_path: Path) -> None:
    """Asked for again they are read; one that was changed by hand, or cannot be read, is sought again."""
    first = run_experiment(experiment(), store=tmp_path / "runs", jobs=1, bounds=True)
    one, other = sorted((tmp_path / "runs" / "bounds").iterdir())
    heard = Listener()
    again = run_experiment(experiment(), store=tmp_path / "runs", jobs=1, bounds=True, watcher=heard)
    assert (again.rows, again.computed, heard.sought) == (first.rows, 0, [])
    content = json.loads(one.read_text("utf-8"))
    content["bounds"]["bound.makespan_s"] = 1.0
    one.write_text(json.dumps(content), "utf-8")
    other.write_text("mine", "utf-8")
    again = run_experiment(experiment(), store=tmp_path / "runs", jobs=1, bounds=True, watcher=heard)
    assert (again.rows, again.computed, heard.sought) == (first.rows, 0, [2])


def test_without_being_asked_for_there_are_none(experiment: Write, tmp_path: Path) -> None:
    """Neither in the rows nor in the store."""
    result = run_experiment(experiment(), store=tmp_path / "runs", jobs=1)
    assert not any(name.startswith("bound.") for row in result.rows for name in row)
    assert not (tmp_path / "runs" / "bounds").exists()


@pytest.mark.parametrize("key", ["instance.pods = 5000", "robots.count = 5000"])
def test_a_world_that_cannot_be_has_none(experiment: Write, tmp_path: Path, key: str) -> None:
    """Its runs fail, and say why; those of other rule sets have their bounds."""
    text = SEVERAL.replace("stations.handle_s = 40.0", key)
    result = run_experiment(experiment(text), store=tmp_path / "runs", jobs=1, bounds=True)
    bounded = {row["rule_set"]: "bound.makespan_s" in row for row in result.rows}
    assert bounded == {"pod-match": True, "first-come": True, "slow pickers": False}
    assert {row["rule_set"] for row in result.failed} == {"slow pickers"}
