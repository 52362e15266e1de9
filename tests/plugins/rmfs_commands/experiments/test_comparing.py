"""Paired comparison: figures, bounds, and `rmfs compare`."""

import json
import math
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pandas
import psutil
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from calling import exit_code
from cases import cases
from rmfs_commands.bounds import BOUNDED, bounds_of
from rmfs_commands.details.catalogue import MEASURES
from rmfs_commands.details.metrics import Metrics
from rmfs_commands.experiments import Experiment, Watcher, run_experiment, shipped_experiments
from rmfs_commands.experiments.compare import interval, intervals, summary
from rmfs_commands.experiments.keys import digest_of, rules_of
from rmfs_commands.experiments.report.numbers import left_out
from rmfs_commands.experiments.report.plots import make_plots
from rmfs_core.errors import InputError
from rmfs_core.scenario import scenario_from_dict
from tiny import TWO_RULES


def row(rule_set: str, seed: int, value: float | None, instance: str = "one", **more: Any) -> dict[str, Any]:
    return {"instance": instance, "rule_set": rule_set, "seed": seed, "status": "complete", "m": value, **more}


def test_differences_are_paired_by_instance_and_seed() -> None:
    rows = [row("base", seed, 10.0 * seed) for seed in (1, 2, 3)]
    rows += [row("other", seed, 11.0 * seed) for seed in (3, 1, 2)]
    base, other = summary(rows, "base", ["m"]).paired
    assert (base.rule_set, base.mean, base.difference.mean) == ("base", 20.0, None)
    assert (other.pairs, other.left_out, other.mean, other.baseline_mean) == (3, 0, 22.0, 20.0)
    assert other.difference.mean == 2.0
    assert other.difference.high == pytest.approx(2 + 4.302653 / math.sqrt(3), abs=1e-6)
    assert other.difference.low == pytest.approx(2 - 4.302653 / math.sqrt(3), abs=1e-6)
    assert other.relative.mean == pytest.approx(0.1)
    assert other.difference.p == pytest.approx(0.0741799, abs=1e-6)
    assert other.p_holm == other.difference.p


def test_rule_sets_with_the_same_pairs_left_out_share_a_sentence() -> None:
    lacking = {"a": (1, 2), "b": (1, 2), "c": (3,)}
    rows = [row(name, seed, None if seed in lacking.get(name, ()) else 5.0) for name in "zabc" for seed in range(5)]
    reason = "as a run has no such figure"
    assert left_out(summary(rows, "z", ["m"]), ["one"]) == [
        f"Left out, one, from each of 2 rule sets (a and b): 2 pairs, {reason}.",
        f"Left out, one, c: 1 pair, {reason}.",
    ]


def test_p_values_are_corrected_over_the_rule_sets() -> None:
    """Three rule sets against the baseline: the smallest p-value counts three times, the next twice, the last once."""
    values = {"base": [5.0, 6.0, 7.0, 9.0], "a": [6.0, 8.0, 8.5, 11.0], "b": [5.5, 6.0, 7.5, 9.5], "c": [5, 7, 6, 9.5]}
    rows = [row(name, seed, value) for name, column in values.items() for seed, value in enumerate(column)]
    found = {one.rule_set: one for one in summary(rows, "base", ["m"]).paired}
    p = {name: stats.ttest_rel(values[name], values["base"]).pvalue for name in "abc"}
    assert p["a"] < p["b"] < p["c"]
    assert found["a"].difference.p == pytest.approx(p["a"])
    assert found["a"].p_holm == pytest.approx(3 * p["a"])
    assert found["b"].p_holm == pytest.approx(2 * p["b"])
    assert found["c"].p_holm == pytest.approx(max(p["c"], 2 * p["b"]))
    assert found["base"].p_holm is None


def test_a_front_has_what_none_beats_in_both() -> None:
    """(1, 5), (2, 3) twice and (4, 2); not (3, 3), with as much of one and more of the other, nor the incomplete."""
    figures = {"base": (3.0, 3.0), "a": (2.0, 3.0), "b": (4.0, 2.0), "c": (1.0, 5.0), "d": (5.0, 2.0), "e": (0.0, 0.0)}
    figures["f"] = figures["a"]
    rows = [row(name, 1, m, n=n) for name, (m, n) in figures.items()]
    rows += [row(name, 2, m, n=n) for name, (m, n) in figures.items() if name != "e"]
    comparison = summary(rows, "base", ["m", "n"], fronts=[("m", "n")])
    assert [pair[0].rule_set for pair in comparison.front("one", "m", "n")] == ["c", "a", "f", "b"]


@pytest.mark.parametrize("values", [[], [3.0], [0.0] * 3, [2.0] * 20, [0.3, 0.1 + 0.2, 0.3], [1.0, 3.0]])
def test_what_tells_nothing_has_no_interval(values: list[float]) -> None:
    found = interval(values)
    assert found.mean == (pytest.approx(sum(values) / len(values)) if values else None)
    assert (found.low, found.high, found.p) == (None, None, None)
    of_all = intervals([values, [1.0, 2.0, 3.0]])
    assert (of_all[0].low_holm, of_all[0].p_holm) == (None, None)
    assert of_all[1].p_holm == of_all[1].p


def test_nothing_is_more_than_all_less() -> None:
    """Intervals of relative differences end at -100 % where figures are amounts; not where they may be negative."""
    shares = {1: 0.01, 2: 0.6, 3: 0.02, 4: 0.9}
    rows = [row("base", seed, 10.0) for seed in shares] + [row("other", seed, 10.0 * s) for seed, s in shares.items()]
    other = summary(rows, "base", ["m"]).paired[1]
    plain = intervals([[share - 1 for share in shares.values()]])[0]
    assert plain.low < -1
    assert (other.relative.low, other.relative.low_holm, other.relative.high) == (-1.0, -1.0, plain.high)
    rows[-1]["m"] = -9.0
    other = summary(rows, "base", ["m"]).paired[1]
    assert other.relative.low < -1


@cases(
    "metric more why",
    ("m", {"status": "horizon"}, None),
    ("m", {"status": "partial"}, "a run was interrupted"),
    ("m", {"status": "failed"}, "a run failed"),
    ("m", {"m": None}, "a run has no such figure"),
    ("m", {"m": None, "orders_completed": 0}, "a run completes no order in the time that counts"),
)
def test_which_runs_count_and_why_others_do_not(metric: str, more: dict[str, Any], why: str | None) -> None:
    rows = [row(name, seed, 10.0, makespan_s=10.0) for name in ("base", "other") for seed in (1, 2, 3)]
    rows[-1] |= {"m": 40.0} | more
    comparison = summary(rows, "base", [metric])
    other = comparison.paired[1]
    assert (other.seeds, other.left_out) == ((2, 1) if why else (3, 0))
    assert other.mean == (10.0 if why else 20.0)
    assert [reason for reason, number in other.why.items() if number == 1] == list(other.why)
    assert all(reason.startswith(why or "-") for reason in other.why)
    assert comparison.horizon == (more.get("status") == "horizon")


def test_where_the_baseline_has_no_such_figure_the_others_have_their_means() -> None:
    """A rule set that splits no order has no time of consolidation, which tells nothing against those that do."""
    rows = [row("base", seed, None) for seed in (1, 2, 3)] + [row("other", seed, 10.0 * seed) for seed in (1, 2, 3)]
    base, other = summary(rows, "base", ["m"]).paired
    shown = (base.mean, base.seeds, other.mean, other.baseline_mean, other.seeds, other.left_out)
    assert shown == (None, 0, 20.0, None, 3, 0)
    assert other.difference.mean is other.relative.mean is None
    assert [plot.name for plot in make_plots(rows, summary(rows, "base", ["m"]))] == ["m"]  # and none of differences
    rows[0]["status"] = "failed"
    assert summary(rows, "base", ["m"]).paired[1].mean is None


@pytest.mark.parametrize("metric", ["makespan_s", "packed_makespan_s"])
def test_no_mean_makespan_is_of_the_quick_runs_only(metric: str) -> None:
    """Two of three seeds finish before the horizon: their mean tells nothing of the third."""
    rows = [row(name, seed, 10.0, **{metric: 10.0}) for name in ("base", "other", "third") for seed in (1, 2, 3)]
    assert [one.mean for one in summary(rows, "base", [metric]).paired] == [10.0] * 3
    rows += [one | {"instance": "short"} for one in rows]
    rows[5] |= {"status": "horizon", metric: None}
    left = summary(rows, "base", [metric])
    assert [one.mean for one in left.of("one", metric)] == [None] * 3
    assert [one.mean for one in left.of("short", metric)] == [10.0] * 3
    assert [one.mean for one in left.of("overall", metric)] == [None] * 3
    why = "runs of the instance set leave orders at the horizon, so that there is no mean makespan"
    assert [one.why for one in left.of("one", metric)] == [{why: 3}] * 3


def test_which_metrics_of_observers_are_of_completed_orders() -> None:
    of_completed = {one.name for one in MEASURES if one.of_completed}
    per_order = {"packed_s", "packed_p95_s", "consolidation_s", "consolidation_p95_s", "packing_wait_s"}
    assert of_completed >= per_order | {"items_per_line", "orders_per_visit"}
    assert of_completed.isdisjoint({"packed_makespan_s", "orders_packed", "late_percent"})


def different(values: list[float]) -> bool:
    return max(values) - min(values) > 1e-6


@given(st.lists(st.lists(st.floats(-10, 10), min_size=3, max_size=6).filter(different), min_size=1, max_size=5))
def test_bounds_and_p_values_never_contradict_each_other(family: list[list[float]]) -> None:
    for one in intervals(family):
        assert (one.low <= 0 <= one.high) == (one.p > 0.05)
        assert (one.low_holm < 0 < one.high_holm) == (one.p_holm > 0.05)


@cases(
    "base share of_mean",
    ([2.0, 4.0, 5.0], (1 / 2 + 2 / 4 + 3 / 5) / 3, False),
    ([0.0, 4.0, 4.0], None, False),
    ([0.0, 4.0, 5.0, 4.0, 5.0, 4.0], 12 / 22, True),
    ([0.01, 1.0, 0.0], None, False),
    ([0.04, 0.04, 0.5, 0.5, 0.5, 0.5], 12 / 2.08, True),
    ([-2.0, 4.0, 5.0], None, False),
    ([0.0, 0.0, 0.0], None, False),
)
def test_relative_differences_are_of_baselines_well_away_from_zero(base, share, of_mean) -> None:
    """One figure close to 0 makes them differences over the mean, with the p of these; a mean close to 0, none."""
    rows = [row("base", seed, figure) for seed, figure in enumerate(base)]
    rows += [row("other", seed, figure + 1 + seed % 3) for seed, figure in enumerate(base)]
    other = summary(rows, "base", ["m"]).paired[1]
    assert other.difference.mean == pytest.approx(2.0)
    assert (other.relative.mean, other.of_mean) == (None if share is None else pytest.approx(share), of_mean)
    if of_mean:
        assert other.relative.mean == pytest.approx(2.0 * len(base) / sum(base))
        assert other.relative.high == pytest.approx((other.difference.high or 0) * len(base) / sum(base))
        assert other.relative.p_holm == other.difference.p_holm


@cases("same of_mean", (4.0, True), (1.5, False))
def test_all_rule_sets_have_the_same_kind_of_relative_difference(same: float, of_mean: bool) -> None:
    """One whose ratios have another mean than the ratio of the means has all of them compared by means."""
    base, steady = [1.0, 5.0, 5.0, 5.0], [1.1, 5.5, 5.5, 5.5]
    figures = {"base": base, "steady": steady, "other": [same, 5.5, 5.5, 5.5]}
    rows = [row(name, seed, figure) for name, own in figures.items() for seed, figure in enumerate(own)]
    _, one, other = summary(rows, "base", ["m"]).paired
    assert one.of_mean is other.of_mean is of_mean
    assert one.relative.mean == pytest.approx(0.1)


def test_instance_sets_and_overall() -> None:
    rows = [
        row(name, seed, 10.0 * size + (name == "other") * size, f"orders={size}, skus={skus}", size=size)
        for name in ("base", "other")
        for size in (1, 2)
        for skus in (5, 6)
        for seed in (1, 2)
    ]
    by_instance = summary(rows, "base", ["m"])
    assert (len(by_instance.instance_sets), by_instance.of("overall", "m")[1].pairs) == (5, 8)
    assert by_instance.of("overall", "m")[1].difference.mean == 1.5
    by_size = summary(rows, "base", ["m"], by=["size"])
    assert by_size.instance_sets == ("size=1", "size=2", "overall")
    assert by_size.of("size=2", "m")[1].pairs == 4
    assert sum(by_size.holds("size=2", one) for one in rows) == 8
    assert all(by_size.holds("overall", one) for one in rows)


def test_a_baseline_that_is_not_there_is_named() -> None:
    with pytest.raises(InputError, match="did you mean `base`"):
        summary([row("base", 1, 1.0)], "bse", ["m"])


def test_a_bound_is_of_all_runs_or_of_none() -> None:
    rows = [row(name, seed, 60.0, **{"bound.m": 20.0}) for name in ("base", "other", "third") for seed in (1, 2, 3)]
    rows[3]["bound.m"] = None
    rows[6]["bound.m"] = 0.0
    found = {one.rule_set: (one.bound, one.times_bound) for one in summary(rows, "base", ["m"]).paired}
    assert found["base"] == (20.0, 3.0)
    assert found["other"] == (None, None)
    assert found["third"] == (pytest.approx(40 / 3), None)
    rows[3]["status"] = "failed"
    assert summary(rows, "base", ["m"]).paired[1].times_bound == 3.0
    assert not summary([row("base", 1, 60.0)], "base", ["m"]).bounded("m")


Write = Callable[..., Experiment]

TRIAL = f'description = "A trial."\nmetrics = ["pile_on", "psv_per_order"]\n{TWO_RULES}'
SEVERAL = TRIAL + '[[rule_sets]]\nname = "slow pickers"\nstations.handle_s = 40.0\n'


class Listener(Watcher):
    def __init__(self) -> None:
        self.sought: list[int] = []

    def bounding(self, instances: int) -> None:
        self.sought.append(instances)


def test_each_run_has_the_bounds_of_its_world(experiment: Write, tmp_path: Path) -> None:
    bundles = 'instance.replenishment = { process = "poisson", bundles_per_hour = 60.0, bundle_items = 2 }'
    text = SEVERAL + '[[rule_sets]]\nname = "moving"\nrules.move = "utility"\n[[rule_sets]]\nname = "bundles"\n'
    text += f'rules.roa = "first-bundle"\nrules.rps = "emptiest-pod"\n{bundles}\nstations.also_replenish = true\n'
    heard = Listener()
    result = run_experiment(experiment(text), store=tmp_path / "runs", jobs=1, bounds=True, watcher=heard)
    assert heard.sought == [8]
    for job, row in zip(experiment(text).jobs(), result.rows, strict=True):
        assert {metric: row[f"bound.{metric}"] for metric in BOUNDED if f"bound.{metric}" in row} == {
            bound.metric: bound.value for bound in bounds_of(job.scenario)
        }
        bounds = {metric: row.get(f"bound.{metric}") for metric in BOUNDED if metric in row}
        assert all(bound is None or row[metric] >= bound for metric, bound in bounds.items())
    least = {(row["rule_set"], row["seed"]): row["bound.makespan_s"] for row in result.rows}
    assert least["pod-match", 1] == least["first-come", 1] < least["slow pickers", 1]
    assert least["pod-match", 1] != least["pod-match", 2]
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


@pytest.mark.parametrize("key", ["instance.pods = 5000", "robots.count = 5000"])
def test_a_world_that_cannot_be_has_none(experiment: Write, tmp_path: Path, key: str) -> None:
    text = SEVERAL.replace("stations.handle_s = 40.0", key)
    result = run_experiment(experiment(text), store=tmp_path / "runs", jobs=1, bounds=True)
    bounded = {row["rule_set"]: "bound.makespan_s" in row for row in result.rows}
    assert bounded == {"pod-match": True, "first-come": True, "slow pickers": False}
    assert {row["rule_set"] for row in result.failed} == {"slow pickers"}


HEED = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"
"""Whoever runs tests in the background lets them ignore interrupts."""
COMMAND = [sys.executable, "-c", f"{HEED}; from rmfs_commands.cli.main import main; main()", "compare"]


@pytest.fixture
def trial(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the current folder, with an experiment, its scenario and a rule that fails."""
    monkeypatch.chdir(folder)
    monkeypatch.setenv("COLUMNS", "100")
    (folder / "trial.toml").write_text(TRIAL, encoding="utf-8")
    return folder


compare = partial(exit_code, "compare")


def test_a_comparison_is_printed_and_files_are_where_it_says(trial: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert compare("trial.toml", "--jobs", "1") == 0
    printed = capsys.readouterr()
    assert "trial: 4 runs, 1 at a time" in printed.err
    for text in ("Visits per order", "Pile-on", "first-come", "baseline", "Relative", "rmfs-runs/trial"):
        assert text in printed.out
    out = trial / "rmfs-runs" / "trial"
    files = {"runs", "summary.csv", "runs.parquet", "report.html", "experiment.json", "plots", "tables"}
    assert {path.name for path in out.iterdir()} == files
    repeats = json.loads((out / "experiment.json").read_text(encoding="utf-8"))
    assert {"rmfs", "python", "numpy"} <= repeats["versions"].keys()
    assert len(repeats["seeds"]) * len(repeats["scenarios"]) == 4
    for one in repeats["scenarios"]:
        ran = scenario_from_dict(one["scenario"] | {"seed": 1}, name="it")
        assert digest_of(rules_of(ran)) == one["rules_sha256"]
        assert f"{one['rule_set']} {one['rules_sha256']}" in (out / "report.html").read_text(encoding="utf-8")
    assert len(pandas.read_parquet(out / "runs.parquet")) == 4
    before = {path: path.stat().st_mtime_ns for path in (out / "runs").rglob("*")}
    assert compare("trial.toml") == 0
    assert capsys.readouterr().out == printed.out
    assert {path: path.stat().st_mtime_ns for path in (out / "runs").rglob("*")} == before


def test_a_stored_run_that_was_changed_is_told_of(trial: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert compare("trial.toml", "--jobs", "1") == 0
    printed = capsys.readouterr().out
    stored = next((trial / "rmfs-runs" / "trial" / "runs").glob("*/*"))
    (stored / "orders.csv").write_text("mine\n", encoding="utf-8")
    assert compare("trial.toml") == 0
    again = capsys.readouterr()
    assert f"{stored.relative_to(trial)}: is not as it was stored: orders.csv was changed" in again.err
    assert again.err.startswith("Computed again: tiny, ")
    assert again.out == printed


def test_bounds_are_shown_when_asked_for(trial: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert compare("trial.toml", "--jobs", "1") == 0
    assert "x bound" not in capsys.readouterr().out
    assert compare("trial.toml", "--bounds") == 0
    printed = capsys.readouterr()
    assert printed.err.startswith("trial: bounds of 2 instances and seeds\ntrial: all 4 runs are stored already")
    assert "x bound" in printed.out
    assert compare("trial.toml", "--bounds", "--json") == 0
    paired = json.loads(capsys.readouterr().out)["paired"]
    multiples = {(one["metric"], one["rule_set"]): one["times_bound"] for one in paired}
    assert multiples["psv_per_order", "pod-match"] >= 1
    assert multiples["pile_on", "pod-match"] is None
    (trial / "short.toml").write_text(TRIAL + '[axes]\n"run.until_s" = [1]\n', encoding="utf-8")
    assert compare("short.toml", "--bounds") == 0
    assert "No bounds: runs that end at run.until_s, fail or begin in a state have none, nor" in capsys.readouterr().err


def test_a_rule_that_fails_costs_its_own_runs_alone(trial: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (trial / "bad.toml").write_text(TRIAL + 'rules.pr = "./bad.py:Raising"\n', encoding="utf-8")
    assert compare("bad.toml", "--out", "out", "--jobs", "1") == 1
    printed = capsys.readouterr()
    assert "Loading code from bad.py." in printed.err
    assert "no idea" in printed.out
    assert "0 (2 left out)" in printed.out
    assert printed.err.splitlines()[-1] == "Error: 2 of 4 runs failed; out/report.html has their errors."
    table = pandas.read_parquet("out/runs.parquet")
    assert list(table["status"]) == ["complete"] * 2 + ["failed"] * 2
    assert (list(table["error_kind"][2:]), table["picks"].min() > 0) == (["RuleError"] * 2, True)
    assert compare("bad.toml", "--out", "out", "--jobs", "1") == 1  # it would end the same way again
    assert "all 4 runs are stored already" in capsys.readouterr().err


def test_the_shipped_experiments_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert compare("--list") == 0
    lines = [line for line in capsys.readouterr().out.splitlines() if not line.startswith(" ")]
    assert [line.split()[0] for line in lines] == list(shipped_experiments())
    assert all(len(line.split()) > 3 for line in lines)


@cases(
    "arguments problem",
    ((), "rmfs compare --list"),
    (("nowhere.toml",), "nowhere.toml"),
    (("tiny.toml",), "unknown key"),
    (("trial.toml", "--jobs", "0"), "--jobs"),
    (("trial.toml", "--out", "tiny.toml"), "expected a folder"),
    (("trial.toml", "--dask", "somewhere"), "expected the address of a scheduler, tcp://host:8786"),
)
def test_wrong_input(trial: Path, capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...], problem: str) -> None:
    assert compare(*arguments) == 2
    printed = capsys.readouterr().err
    assert problem in printed
    assert "Traceback" not in printed
    assert not list(trial.rglob("report.html"))


def long_experiment(folder: Path, seeds: int) -> None:
    text = TRIAL.replace("[1, 2]", f"{{ count = {seeds} }}")
    text = text.replace("[[rule_sets]]", "[axes]\ninstance.orders = [100]\n[[rule_sets]]", 1)
    (folder / "long.toml").write_text(text, encoding="utf-8")


def wait_for_runs(folder: Path, count: int) -> None:
    until = time.monotonic() + 60
    while time.monotonic() < until:
        if sum(not path.parent.name.startswith(".") for path in folder.glob("*/*")) >= count:
            return
        time.sleep(0.02)
    pytest.fail(f"there were no {count} runs after a minute")


@pytest.mark.slow
def test_ctrl_c_keeps_what_is_finished(trial: Path) -> None:
    long_experiment(trial, 40)
    arguments = ["long.toml", "--out", "out", "--jobs", "2"]
    with subprocess.Popen([*COMMAND, *arguments], stderr=subprocess.PIPE, text=True, process_group=0) as process:
        wait_for_runs(trial / "out" / "runs", 4)
        os.killpg(process.pid, signal.SIGINT)
        _, err = process.communicate(timeout=30)
    assert (process.returncode, err.splitlines()[-1]) == (130, "Interrupted.")
    assert "Finished runs are kept in out/runs" in err
    assert "Traceback" not in err
    assert 4 <= len(list((trial / "out" / "runs").glob("*/*"))) < 80
    assert not (trial / "out" / "report.html").exists()


@pytest.mark.slow
def test_a_killed_comparison_goes_on_where_it_stopped(trial: Path) -> None:
    """After kill -9 in the middle the same command computes the rest alone; the tables are an undisturbed run's."""
    long_experiment(trial, 10)
    assert compare("long.toml", "--out", "undisturbed", "--quiet") == 0
    runs = trial / "out" / "runs"
    with subprocess.Popen([*COMMAND, "long.toml", "--out", "out", "--jobs", "2", "--quiet"]) as process:
        wait_for_runs(runs, 5)
        workers = psutil.Process(process.pid).children(recursive=True)
        process.kill()
    _, alive = psutil.wait_procs(workers, timeout=20)
    assert workers
    assert not alive, "workers must not outlive a killed parent"
    stored = {path.name: path.stat().st_mtime_ns for path in runs.glob("[!.]*/*")}
    assert 5 <= len(stored) < 20
    assert compare("long.toml", "--out", "out", "--quiet") == 0
    after = {path.name: path.stat().st_mtime_ns for path in runs.glob("[!.]*/*")}
    assert (len(after), {name: after[name] for name in stored}) == (20, stored)
    assert (trial / "out" / "summary.csv").read_bytes() == (trial / "undisturbed" / "summary.csv").read_bytes()
    tables = [pandas.read_parquet(trial / name / "runs.parquet") for name in ("out", "undisturbed")]
    same = ["instance", "rule_set", "seed", "status", "error", "key", *Metrics().measured()]
    assert tables[0][same].equals(tables[1][same])


def test_json(trial: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert compare("trial.toml", "--jobs", "1", "--json") == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["experiment"], found["runs"], found["failed"]) == ("trial", 4, 0)
    assert {one["rule_set"] for one in found["paired"]} == set(found["rule_sets"])
    text = TRIAL.replace('"psv_per_order"', '"hook_s.assign_orders"').replace(
        'baseline = "pod-match"', 'baseline = "x"'
    )
    (trial / "other.toml").write_text(text, encoding="utf-8")
    stored = ("--out", "rmfs-runs/trial", "--json")
    assert compare("other.toml", "--baseline", "first-come", *stored) == 2  # the file itself is wrong
    (trial / "other.toml").write_text(text.replace('"x"', '"pod-match"'), encoding="utf-8")
    capsys.readouterr()
    assert compare("other.toml", "--baseline", "first-come", *stored) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["baseline"] == "first-come"
    (seconds,) = (one for one in found["paired"] if one["metric"].startswith("hook_s") and one["difference"]["mean"])
    assert (seconds["rule_set"], seconds["seeds"]) == ("pod-match", 2)
    assert seconds["mean"] > 0
    assert compare("other.toml", "--baseline", "firstcome", *stored) == 2
    assert "did you mean `first-come`" in capsys.readouterr().err
    assert compare("--list", "--json") == 0
    assert [one["name"] for one in json.loads(capsys.readouterr().out)] == list(shipped_experiments())
