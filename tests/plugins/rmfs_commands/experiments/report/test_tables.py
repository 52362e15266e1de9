"""The tables for other programs: summary.csv and runs.parquet."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import pandas
import pytest
from attrs import evolve

from rmfs_commands.experiments import ExperimentResult
from rmfs_commands.experiments.report.tables import SUMMARY_COLUMNS, grids, summary_csv, write_parquet
from rmfs_core.results.catalogue import Metric

FAILURE = "rule <b>bad</b> & worse: no idea"
"""Error of the run that failed."""


def test_pandas_reads_the_runs(result: ExperimentResult, tmp_path: Path) -> None:
    """runs.parquet has one row a run and one column a figure; what a run has not measured is missing."""
    write_parquet(result, tmp_path / "runs.parquet")
    runs = pandas.read_parquet(tmp_path / "runs.parquet")
    assert runs.shape == (18, 13)
    means = runs.groupby(["instance.orders", "rule_set"])["pile_on"].mean()
    assert means[50, "good"] == pytest.approx(3.2)
    assert runs["pile_on"].isna().sum() == 1
    assert runs["error"].iloc[-1] == FAILURE
    assert runs["seed"].dtype == "int64"
    assert runs["decision_s_first"].dtype == "float64"


def test_axis_values_of_several_kinds_are_texts(result: ExperimentResult, tmp_path: Path) -> None:
    """A column of numbers and texts is written as texts."""
    for row, value in zip(result.rows, [1, "start", None] * 6, strict=True):
        row["mixed"] = value
    write_parquet(result, tmp_path / "runs.parquet")
    assert list(pandas.read_parquet(tmp_path / "runs.parquet")["mixed"].iloc[:2]) == ["1", "start"]


def test_numbers_that_no_column_has_are_texts(result: ExperimentResult, tmp_path: Path) -> None:
    """An observer may measure a whole number of more than 64 bits."""
    for row in result.rows:
        row["huge"] = 2**64
    write_parquet(result, tmp_path / "runs.parquet")
    assert set(pandas.read_parquet(tmp_path / "runs.parquet")["huge"]) == {"18446744073709551616"}


def test_the_summary_has_every_comparison(result: ExperimentResult) -> None:
    """summary.csv has a row for each instance set, metric and rule set, with how many runs failed."""
    rows = list(csv.DictReader(summary_csv(result.comparison()).splitlines()))
    assert tuple(rows[0]) == SUMMARY_COLUMNS
    assert len(rows) == 3 * 3 * 3
    (one,) = [r for r in rows if (r["instances"], r["metric"], r["rule_set"]) == ("overall", "pile_on", "bad")]
    assert (one["seeds"], one["pairs"], one["left_out"], one["runs"], one["failed"]) == ("2", "4", "2", "6", "1")
    assert float(one["difference"]) == pytest.approx(2.0)
    assert (one["p"], one["relative_low_holm"], one["relative_p_holm"]) == ("", "", "")  # two seeds
    (one,) = [r for r in rows if (r["instances"], r["metric"], r["rule_set"]) == ("orders=50", "pile_on", "good")]
    assert (one["seeds"], one["pairs"], one["left_out"], one["runs"], one["failed"]) == ("3", "3", "0", "3", "0")
    assert float(one["relative_low_holm"]) < float(one["relative_low"]) < float(one["relative"])
    assert 0 < float(one["relative_p"]) <= float(one["relative_p_holm"]) < 0.05
    (base,) = [r for r in rows if (r["instances"], r["metric"], r["rule_set"]) == ("overall", "pile_on", "base")]
    assert (base["difference"], base["p"]) == ("", "")


@pytest.mark.parametrize("name", ["=cmd|' /C calc'!A0", "+1", "-1", "@sum(a)", "\t=x", " =x"])
def test_no_name_is_a_formula(result: ExperimentResult, tmp_path: Path, name: str) -> None:
    """In the summary, which spreadsheets open, an apostrophe is before it; the data of the runs have it as it is."""
    for row in result.rows:
        row["rule_set"] = f"{name}{row['rule_set']}"
        row["instance"] = f"{name}{row['instance']}"
    rule_sets = tuple(evolve(one, name=f"{name}{one.name}") for one in result.experiment.rule_sets)
    one = evolve(result, experiment=evolve(result.experiment, baseline=f"{name}base", rule_sets=rule_sets))
    rows = list(csv.DictReader(io.StringIO(summary_csv(one.comparison()), newline="")))
    assert rows[0]["instances"] == f"'{name}orders=50"
    assert {row["rule_set"] for row in rows} == {f"'{name}{end}" for end in ("base", "good", "bad")}
    assert rows[0]["baseline"] == f"'{name}base"
    assert float(rows[1]["difference"]) == pytest.approx(1.0)
    write_parquet(one, tmp_path / "runs.parquet")
    assert pandas.read_parquet(tmp_path / "runs.parquet")["rule_set"].iloc[0] == f"{name}base"


def test_a_metric_that_no_run_has_is_empty(result: ExperimentResult, tmp_path: Path) -> None:
    """Of an observer that one rule set is without: no mean, and missing in its rows."""
    for row in result.rows:
        if row["status"] != "failed" and row["rule_set"] != "good":
            row["balance"] = -row["pile_on"]
    described = {"balance": Metric("balance", "Balance of work", "kJ", 1, "What it costs.")}
    shown = evolve(result, experiment=evolve(result.experiment, metrics=("balance",)), measures=described)
    rows = list(csv.DictReader(summary_csv(shown.comparison()).splitlines()))
    assert [row["mean"] for row in rows if row["rule_set"] == "good"] == ["", "", ""]
    write_parquet(shown, tmp_path / "runs.parquet")
    assert pandas.read_parquet(tmp_path / "runs.parquet")["balance"].isna().sum() == 7


def test_bounds_are_in_both_tables(bounded: ExperimentResult, tmp_path: Path) -> None:
    """Of each run in runs.parquet, and their means in summary.csv; empty where there are none."""
    rows = list(csv.DictReader(summary_csv(bounded.comparison()).splitlines()))
    of = {(row["instances"], row["metric"], row["rule_set"]): (row["bound"], row["times_bound"]) for row in rows}
    bound, times = map(float, of["orders=50", "pile_on", "good"])
    assert (bound, times) == (1.25, pytest.approx(2.56))
    assert of["orders=50", "picker_utilisation", "good"] == ("", "")
    write_parquet(bounded, tmp_path / "runs.parquet")
    assert set(pandas.read_parquet(tmp_path / "runs.parquet")["bound.pile_on"].dropna()) == {1.25}


def test_tables_for_papers(result: ExperimentResult) -> None:
    """One for each metric, with what the terminal shows; the baseline has no differences from itself."""
    found = grids(result.comparison())
    assert set(found) == set(result.experiment.metrics)
    grid = found["pile_on"]
    assert grid.columns[:4] == ("Instances", "Rule set", "Seeds", "Mean")
    (baseline,) = [row for row in grid.rows if row[0] == "overall" and row[1] == result.experiment.baseline]
    assert set(baseline[4:]) == {""}
