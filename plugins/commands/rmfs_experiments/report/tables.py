"""The tables for other programs: summary.csv and runs.parquet."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rmfs_core.results.files import AtomicFile, to_csv
from rmfs_experiments.compare import Comparison, Interval
from rmfs_experiments.experiment import LABELS
from rmfs_experiments.running import ExperimentResult

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
    "partial",
    "failed",
    "stood_still",
    "stopped_early",
    "bound",
    "times_bound",
)
"""Columns of summary.csv, see `rmfs_experiments.compare`: `Paired`, `Interval` and `Counted`.

``p`` belongs to ``difference_low`` and ``difference_high``, ``p_holm`` to those with ``_holm``; so for ``relative``.
"""


def summary_csv(comparison: Comparison) -> str:
    """Return the comparison as CSV: one row an instance set, metric and rule set."""
    rows = ({name: _no_formula(value) for name, value in row.items()} for row in _summary_rows(comparison))
    return to_csv(SUMMARY_COLUMNS, list(rows))


def _no_formula(value: Any) -> Any:
    """Return a text that no spreadsheet takes for a formula."""
    if not isinstance(value, str):
        return value
    text = value.replace("\r", " ")
    return f"'{text}" if text.lstrip().startswith(("=", "+", "-", "@")) else text


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
            "partial": count.partial,
            "failed": count.failed,
            "stood_still": count.stood_still,
            "stopped_early": count.stopped_early,
            "bound": one.bound,
            "times_bound": one.times_bound,
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
