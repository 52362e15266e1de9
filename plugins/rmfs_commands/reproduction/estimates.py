"""Means over instances and seeds, with 95 % confidence intervals, from rows of which each is a run."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from math import fsum, sqrt
from statistics import fmean, stdev
from typing import Any

from attrs import frozen

Row = Mapping[str, Any]
Rows = Sequence[Row]
Measure = Callable[[Row], float | None]


@frozen
class Estimate:
    """A mean over seeds.

    Parameters
    ----------
    mean
        Mean over the seeds of the mean over a seed's runs.
    half_width
        Half of the 95 % confidence interval over seeds (Student t); None with fewer than two seeds.
    runs
        Runs that went in.
    expected
        Runs there should be; runs that did not complete count here only.
    """

    mean: float
    half_width: float | None
    runs: int
    expected: int


def estimate(values: Iterable[tuple[int, float | None]]) -> Estimate | None:
    """Return the estimate from pairs of seed and value; the value of a run that cannot count is None.

    None when no value counts.
    """
    by_seed: dict[int, list[float]] = defaultdict(list)
    expected = 0
    for seed, value in values:
        expected += 1
        if value is not None:
            by_seed[seed].append(value)
    return _over_seeds([fmean(of_seed) for of_seed in by_seed.values()], sum(map(len, by_seed.values())), expected)


def _over_seeds(figures: Sequence[float], runs: int, expected: int) -> Estimate | None:
    """Return the estimate from one figure a seed."""
    return Estimate(fmean(figures), _half_width(figures), runs, expected) if figures else None


def _half_width(means: Sequence[float]) -> float | None:
    if len(means) < 2:
        return None
    from scipy.stats import t

    return float(t.ppf(0.975, len(means) - 1)) * stdev(means) / sqrt(len(means))


def select(rows: Rows, **labels: object) -> list[Row]:
    """Return the rows that have these labels (``rule_set="sequential"``)."""
    return [row for row in rows if all(row[label] == value for label, value in labels.items())]


def complete(row: Row) -> bool:
    """Whether a run picked all of its orders; no other run counts for a figure."""
    return bool(row["status"] == "complete")


def mean_of(rows: Rows, measure: Measure) -> Estimate | None:
    """Return the estimate of a measure over the rows."""
    return estimate((row["seed"], measure(row) if complete(row) else None) for row in rows)


def relative(rows: Rows, baseline: Rows, measure: Measure) -> Estimate | None:
    """Return the estimate of the mean over the instances relative to the baseline's mean, on the same seed.

    A run counts when the baseline's on the same instance and seed does, so that both means are of the same instances.
    """
    of_baseline = {(row["instance"], row["seed"]): measure(row) for row in baseline if complete(row)}
    pairs: dict[int, list[tuple[float, float]]] = defaultdict(list)
    for row in rows:
        value, base = measure(row), of_baseline.get((row["instance"], row["seed"]))
        if complete(row) and value is not None and base is not None:
            pairs[row["seed"]].append((value, base))
    figures, runs = [], 0
    for of_seed in pairs.values():
        total, of_baseline_total = (fsum(side) for side in zip(*of_seed, strict=True))
        if of_baseline_total:
            figures.append(total / of_baseline_total)
            runs += len(of_seed)
    return _over_seeds(figures, runs, len(rows))


def metric(name: str) -> Measure:
    """Return the measure that reads a column of the rows; a run that ended without a result lacks it."""

    def read(row: Row) -> float | None:
        value: float | None = row.get(name)
        return value

    return read
