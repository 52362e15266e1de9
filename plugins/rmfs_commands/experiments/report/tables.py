"""The tables for other programs and for papers: summary.csv, runs.parquet, and tables/ in LaTeX."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rmfs_commands.cli.grids import Grid, no_formula
from rmfs_commands.experiments.compare import Comparison, Interval
from rmfs_commands.experiments.experiment import LABELS
from rmfs_commands.experiments.report import numbers
from rmfs_commands.experiments.report.plots import front_name, plot_name, shown_sets
from rmfs_commands.experiments.running import ExperimentResult
from rmfs_commands.results.files import AtomicFile, to_csv

SUMMARY_COLUMNS = (
    "instances",
    "metric",
    "rule_set",
    "baseline",
    "seeds",
    "pairs",
    "left_out",
    "mean",
    "baseline_mean",
    "difference",
    "difference_low",
    "difference_high",
    "p",
    "difference_low_holm",
    "difference_high_holm",
    "p_holm",
    "relative",
    "relative_low",
    "relative_high",
    "relative_p",
    "relative_low_holm",
    "relative_high_holm",
    "relative_p_holm",
    "runs",
    "complete",
    "horizon",
    "partial",
    "failed",
    "stood_still",
    "stopped_early",
    "bound",
    "times_bound",
    "censored",
    "why_left_out",
)
"""Columns of summary.csv, see `rmfs_commands.experiments.compare`: `Paired`, `Interval` and `Counted`.

``p`` belongs to ``difference_low`` and ``difference_high``, ``p_holm`` to those with ``_holm``; so for ``relative``.
"""


def summary_csv(comparison: Comparison) -> str:
    """Return the comparison as CSV: one row an instance set, metric and rule set."""
    rows = [
        {name: no_formula(value) if isinstance(value, str) else value for name, value in row.items()}
        for row in _summary_rows(comparison)
    ]
    return to_csv(SUMMARY_COLUMNS, rows)


def _summary_rows(comparison: Comparison) -> Iterator[dict[str, Any]]:
    counted = {(one.instances, one.rule_set): one for one in comparison.counted}
    for one in comparison.paired:
        count = counted[one.instances, one.rule_set]
        yield {
            "instances": one.instances,
            "metric": one.metric,
            "rule_set": one.rule_set,
            "baseline": comparison.baseline,
            "seeds": one.seeds,
            "pairs": one.pairs,
            "left_out": one.left_out,
            "mean": one.mean,
            "baseline_mean": one.baseline_mean,
            **_interval("difference_", "", one.difference),
            **_interval("relative_", "relative_", one.relative),
            "runs": count.runs,
            "complete": count.complete,
            "horizon": count.horizon,
            "partial": count.partial,
            "failed": count.failed,
            "stood_still": count.stood_still,
            "stopped_early": count.stopped_early,
            "bound": one.bound,
            "times_bound": one.times_bound,
            "censored": int(comparison.censored(one.metric)),
            "why_left_out": numbers.why(one),
        }


def _interval(name: str, of_p: str, found: Interval) -> dict[str, float | None]:
    return {
        name.rstrip("_"): found.mean,
        f"{name}low": found.low,
        f"{name}high": found.high,
        f"{of_p}p": found.p,
        f"{name}low_holm": found.low_holm,
        f"{name}high_holm": found.high_holm,
        f"{of_p}p_holm": found.p_holm,
    }


def grids(comparison: Comparison) -> dict[str, Grid]:
    """Return the tables for a paper by the name of their files: one for each metric, and one for each front."""
    found = {plot_name(metric): _metric_grid(comparison, metric) for metric in comparison.metrics}
    return found | {front_name(*pair): _front_grid(comparison, *pair) for pair in comparison.fronts}


def _metric_grid(comparison: Comparison, metric: str) -> Grid:
    shown_as, bounded = comparison.described(metric), comparison.bounded(metric)
    bound = ("x bound",) if bounded else ()
    shares = numbers.has_relative(comparison, metric, shown_sets(comparison))
    p = ("p (Holm)",) * comparison.tested
    last = (numbers.difference_heading(shown_as), *p, *["Relative"] * shares)
    found = [one for instances in shown_sets(comparison) for one in comparison.of(instances, metric)]
    several, same = len(shown_sets(comparison)) > 1, len({numbers.seeds(one) for one in found}) == 1
    names = ("Instances", "Rule set") if several else ("Rule set",)
    columns = (*names, *([] if same else ["Seeds"]), "Mean", *bound, *last)
    rows = []
    for one in found:
        differences: tuple[str, ...] = ("",) * len(last)
        if one.rule_set != comparison.baseline:
            absolute = numbers.difference(shown_as, one.difference, bounds=comparison.tested)
            of_p = (numbers.probability(one.difference.p_holm),) * len(p)
            differences = (absolute, *of_p, *[numbers.relative(one, bounds=False)] * shares)
        times = (numbers.times(one.times_bound),) if bounded else ()
        which = (one.instances if one.rule_set == comparison.rule_sets[0] else "",) if several else ()
        seeds = () if same else (numbers.seeds(one),)
        rows.append((*which, one.rule_set, *seeds, numbers.value(shown_as, one.mean), *times, *differences))
    means = any(one.mean is not None for one in found)
    over = f" over {numbers.seeds(found[0])} seeds" if same and means else ""
    caption = f"{numbers.heading(comparison, metric)}: means{over}, and differences from {comparison.baseline}"
    if any(one.difference.low_holm is not None for one in found):
        caption += " with simultaneous 95 % confidence intervals and p-values of paired t tests after Holm"
    caption += "." if means else ". No rule set has a mean: pairs of all seeds are left out."
    notes = [numbers.CENSORED] if comparison.censored(metric) else []
    notes += [numbers.OF_MEAN_NOTE] if shares and any(one.of_mean for one in found) else []
    caption = " ".join([caption, *notes])
    return Grid(caption, (numbers.caption(comparison),), columns, rows, range(len(names), len(columns)))


def _front_grid(comparison: Comparison, first: str, second: str) -> Grid:
    titles = [numbers.heading(comparison, metric) for metric in (first, second)]
    metrics = comparison.described(first), comparison.described(second)
    several = len(shown_sets(comparison)) > 1
    rows = [
        (
            *([instances] * several),
            pair[0].rule_set,
            *(numbers.value(metric, one.mean) for metric, one in zip(metrics, pair, strict=True)),
        )
        for instances in shown_sets(comparison)
        for pair in comparison.front(instances, first, second)
    ]
    columns = (*["Instances"] * several, "Rule set", *titles)
    title = f"Rule sets that none beats in both {titles[0]} and {titles[1]}: means."
    title += f" {numbers.CENSORED}" if any(map(comparison.censored, (first, second))) else ""
    return Grid(title, (), columns, rows, range(len(columns) - 2, len(columns)))


def write_parquet(result: ExperimentResult, path: Path) -> None:
    """Write one row a run, whole or not at all."""
    import pyarrow
    from pyarrow import parquet

    columns = {name: _array(pyarrow, name, values) for name, values in result.table().items()}
    with AtomicFile(path) as stream:
        parquet.write_table(pyarrow.table(columns), stream)


def _array(pyarrow: Any, name: str, values: list[object]) -> Any:
    """Return a column; texts where the values are of several kinds, as an axis's may be, or larger than 64 bits."""
    if all(value is None for value in values):
        return pyarrow.array(values, pyarrow.string() if name in LABELS else pyarrow.float64())
    try:
        return pyarrow.array(values)
    except (pyarrow.ArrowInvalid, pyarrow.ArrowTypeError, OverflowError):
        return pyarrow.array([None if value is None else str(value) for value in values])
