"""What an experiment leaves behind: tables for programs, a report and plots for people."""

import csv
import re
from pathlib import Path
from typing import Any

import pandas
import pytest
from attrs import evolve
from rich.console import Console

from rmfs_core.results.catalogue import Metric
from rmfs_core.scenario import load_scenario
from rmfs_experiments import Axis, AxisPoint, Base, Experiment, ExperimentResult, RuleSetChoice
from rmfs_experiments.report import print_comparison, write_report

FAILURE = "rule <b>bad</b> & worse: no idea"


@pytest.fixture
def result() -> ExperimentResult:
    """Return an experiment of two instances, three rule sets and three seeds, with made-up figures; one run failed."""
    experiment = Experiment(
        name="trial",
        description="Is <more> better?",
        bases=(Base("small", load_scenario("examples/small")),),
        axes=(Axis("instance.orders", tuple(AxisPoint(f"orders={n}", n, {"instance.orders": n}) for n in (50, 100))),),
        rule_sets=tuple(RuleSetChoice(name) for name in ("base", "good", "bad")),
        seeds=(1, 2, 3),
        baseline="base",
        metrics=("pile_on", "picker_utilisation", "split_orders_open_max"),
    )
    rows: list[dict[str, Any]] = []
    for orders in (50, 100):
        for place, rule_set in enumerate(("base", "good", "bad")):
            for seed in (1, 2, 3):
                figures = {
                    "pile_on": 2.0 + place + seed / 10,
                    "picker_utilisation": 0.5 + place / 10 + seed / 100,
                    "split_orders_open_max": place * seed,
                    "decision_s_first": None,
                }
                rows.append(
                    {
                        "instance": f"orders={orders}",
                        "scenario": "small",
                        "instance.orders": orders,
                        "rule_set": rule_set,
                        "seed": seed,
                        "status": "complete",
                        "error": None,
                        "error_kind": None,
                        **figures,
                        "key": f"{orders}{place}{seed}",
                    }
                )
    failed = {"status": "failed", "error": FAILURE, "error_kind": "RuleError"}
    rows[-1] = {name: rows[-1][name] for name in ("instance", "instance.orders", "rule_set", "seed", "key")} | failed
    return ExperimentResult(experiment, rows, {"rmfs": "0.1.0"}, 18)


def test_pandas_reads_the_runs(result: ExperimentResult, tmp_path: Path) -> None:
    """runs.parquet has one row a run and one column a figure; what a run has not measured is missing."""
    write_report(result, result.comparison(), tmp_path)
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
    write_report(result, result.comparison(), tmp_path)
    assert list(pandas.read_parquet(tmp_path / "runs.parquet")["mixed"].iloc[:2]) == ["1", "start"]


def test_the_summary_has_every_comparison(result: ExperimentResult, tmp_path: Path) -> None:
    """summary.csv has a row for each instance set, metric and rule set, with how many runs failed."""
    write_report(result, result.comparison(), tmp_path)
    with (tmp_path / "summary.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 3 * 3 * 3
    (one,) = [r for r in rows if (r["instances"], r["metric"], r["rule_set"]) == ("overall", "pile_on", "bad")]
    assert (one["pairs"], one["left_out"], one["runs"], one["failed"]) == ("5", "1", "6", "1")
    assert float(one["difference"]) == pytest.approx(2.0)
    (base,) = [r for r in rows if (r["instances"], r["metric"], r["rule_set"]) == ("overall", "pile_on", "base")]
    assert (base["difference"], base["p"]) == ("", "")


def test_the_report_needs_nothing_else(result: ExperimentResult, tmp_path: Path) -> None:
    """report.html loads nothing: every picture is in it; texts from outside are escaped; failures are told."""
    write_report(result, result.comparison(), tmp_path)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert page.count('src="data:image/svg+xml;base64,') == 1 + 3
    assert not re.search(r'(src|href)="(?!data:|#)', page)
    assert "http" not in re.sub(r"base64,[A-Za-z0-9+/=]+", "", page)
    assert "Is &lt;more&gt; better?" in page
    assert "rule &lt;b&gt;bad&lt;/b&gt; &amp; worse: no idea" in page
    assert "5 (1 left out)" in page


def test_the_same_runs_give_the_same_files(result: ExperimentResult, tmp_path: Path) -> None:
    """Report, tables and plots hold no dates and no random ids."""
    for name in ("one", "two"):
        write_report(result, result.comparison(), tmp_path / name)
    files = sorted(path.relative_to(tmp_path / "one") for path in (tmp_path / "one").rglob("*.*"))
    assert len(files) == 3 + 2 * 4
    for file in files:
        assert (tmp_path / "one" / file).read_bytes() == (tmp_path / "two" / file).read_bytes(), file


def printed(result: ExperimentResult, width: int) -> str:
    """Return what the terminal shows."""
    console = Console(width=width, record=True, quiet=False, file=None, force_terminal=False)
    with console.capture() as capture:
        print_comparison(console, result, result.comparison())
    return capture.get()


def test_the_terminal_shows_runs_and_comparisons(result: ExperimentResult) -> None:
    """At 100 columns every figure has its interval, and a failed run its error; no line is longer."""
    text = printed(result, 100)
    assert f"Failed: orders=100, bad, seed 3: {FAILURE}" in text
    assert re.search(r"good +3 +3\.200 +\+1\.000 \[\+1\.000, \+1\.000\] +\+45\.5 % \[", text)
    assert re.search(r"bad +2 \(1 left out\) +4\.150 ", text)
    assert "Picker utilisation (%)" in text
    assert max(map(len, text.splitlines())) <= 100


def test_a_narrow_terminal_has_relative_differences_alone(result: ExperimentResult) -> None:
    """At 80 columns no name or interval is broken."""
    text = printed(result, 80)
    assert re.search(r"good +6 +3\.200 +\+45\.5 % \[\+43\.6, \+47\.5\] +< 0\.001", text)
    assert max(map(len, text.splitlines())) <= 80


def test_metrics_of_observers_are_shown_as_they_describe_them(result: ExperimentResult, tmp_path: Path) -> None:
    """Label, unit, digits and meaning where there are some, else the name; a dash where no run has the figure."""
    for row in result.rows:
        if row["status"] != "failed" and row["rule_set"] != "good":
            row |= {"balance": -row["pile_on"], "bare": 0.5}
    described = {"balance": Metric("balance", "Balance of work", "kJ", 1, "What it costs.")}
    shown = evolve(result, experiment=evolve(result.experiment, metrics=("balance", "bare")), measures=described)
    comparison = shown.comparison()
    write_report(shown, comparison, tmp_path)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert ">Balance of work (kJ)</h2>" in page
    assert "What it costs." in page
    assert ">bare</h2>" in page
    text = printed(shown, 100)
    block = text.partition("Balance of work (kJ)")[2]
    assert re.search(r"orders=50 *\n +base +-2\.20 +baseline *\n +good +0 \(3 left out\) +- +-", block)
    with (tmp_path / "summary.csv").open(encoding="utf-8", newline="") as stream:
        rows = [row for row in csv.DictReader(stream) if row["metric"] == "balance" and row["rule_set"] == "good"]
    assert [row["mean"] for row in rows] == ["", "", ""]
    assert pandas.read_parquet(tmp_path / "runs.parquet")["balance"].isna().sum() == 7


def test_an_observers_metric_is_called_what_it_likes(
    result: ExperimentResult, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its plot is a file beside that of all differences; its label is neither markup nor a formula."""
    label = "Price [s] [/nope] in $^$"
    rows = [row | {"differences": row["seed"] * 1.5} for row in result.rows]
    experiment = evolve(result.experiment, metrics=("differences", "pile_on"))
    measures = {"differences": Metric("differences", label)}
    one = evolve(result, rows=rows, experiment=experiment, measures=measures)
    comparison = one.comparison()
    write_report(one, comparison, tmp_path)
    print_comparison(Console(width=120), one, comparison)
    assert label in capsys.readouterr().out
    plots = {path.name for path in (tmp_path / "plots").glob("*.svg")}
    assert plots == {"differences.svg", "metrics.differences.svg", "pile_on.svg"}
    assert len(set(re.findall(r'<img src="([^"]+)"', (tmp_path / "report.html").read_text("utf-8")))) == 3
