"""Paired comparison of rule sets with a baseline.

Runs of the same instance and seed see the same orders, pods and robots (common random numbers), so that a rule set is
judged by its differences from the baseline, pair by pair: their mean, the Student t interval of that mean, and the
p-value of the paired t test, corrected for the number of rule sets compared after Holm (1979, A simple sequentially
rejective multiple test procedure, Scandinavian Journal of Statistics 6(2), 65-70).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from statistics import fmean, stdev
from typing import Any

from attrs import evolve, field, frozen

from rmfs_core.errors import InputError
from rmfs_core.results.catalogue import METRICS, TIMING, Metric
from rmfs_core.wording import nearest

Rows = Sequence[Mapping[str, Any]]

CATALOGUE = {metric.name: metric for group in (*METRICS.values(), TIMING) for metric in group}
"""Every figure of the kernel; observers measure more."""

OVERALL = "overall"
CONFIDENCE = 0.95


@frozen
class Interval:
    """A mean with its 95 % interval and p-value; None where they are not defined (fewer than two values).

    Parameters
    ----------
    mean
        Mean of the values.
    low, high
        Bounds of the Student t interval.
    p
        Two-sided p-value of the t test that the mean is 0.
    """

    mean: float | None
    low: float | None = None
    high: float | None = None
    p: float | None = None


@frozen
class Paired:
    """A rule set against the baseline, in one metric on one instance set.

    Parameters
    ----------
    instances
        The instance set, or ``"overall"``.
    metric, rule_set
        What is compared.
    pairs
        Number of pairs of runs of the same instance and seed in which both sides have the figure. (For the baseline:
        number of its runs that have it.)
    left_out
        Pairs in which a side failed or has no such figure.
    mean, baseline_mean
        Means over the pairs.
    difference
        Rule set minus baseline.
    relative
        The same as a share of the baseline's figure, mean over the pairs; not defined when a baseline's figure is 0.
    p_holm
        The difference's p-value, corrected over the rule sets compared in this metric and instance set.
    """

    instances: str
    metric: str
    rule_set: str
    pairs: int
    left_out: int
    mean: float | None
    baseline_mean: float | None
    difference: Interval
    relative: Interval
    p_holm: float | None = None


@frozen
class Counted:
    """How the runs of a rule set on an instance set ended.

    Parameters
    ----------
    instances, rule_set
        Which runs.
    runs
        All of them; ``complete``, ``partial`` and ``failed`` add up to it.
    stood_still
        Those of the failed ones in which nothing could happen any more.
    stopped_early
        Runs with at least one solve that a limit ended before its proof.
    """

    instances: str
    rule_set: str
    runs: int
    complete: int
    partial: int
    failed: int
    stood_still: int
    stopped_early: int


@frozen
class Comparison:
    """Every rule set against the baseline.

    Parameters
    ----------
    baseline
        Its name.
    instance_sets
        Labels of the instance sets, ``"overall"`` last when there are several.
    rule_sets, metrics
        What is compared, in the order in which it is shown.
    paired
        By instance set, metric and rule set.
    counted
        By instance set and rule set.
    by
        Columns whose values tell the instance sets apart.
    measures
        Metrics that observers describe, by name.
    """

    baseline: str
    instance_sets: tuple[str, ...]
    rule_sets: tuple[str, ...]
    metrics: tuple[str, ...]
    paired: tuple[Paired, ...]
    counted: tuple[Counted, ...]
    by: tuple[str, ...] = ("instance",)
    measures: Mapping[str, Metric] = field(factory=dict)

    def described(self, metric: str) -> Metric:
        """Return how a metric is shown: under its name when nobody describes it."""
        return CATALOGUE.get(metric) or self.measures.get(metric) or Metric(metric)

    def holds(self, instances: str, row: Mapping[str, Any]) -> bool:
        """Whether a run belongs to an instance set."""
        return instances in (OVERALL, _label(row, self.by))

    def of(self, instances: str, metric: str) -> list[Paired]:
        """Return the rule sets in one metric on one instance set."""
        return [one for one in self.paired if (one.instances, one.metric) == (instances, metric)]


def summary(
    rows: Rows,
    baseline: str,
    metrics: Sequence[str],
    *,
    by: Sequence[str] = ("instance",),
    measures: Mapping[str, Metric] | None = None,
) -> Comparison:
    """Compare every rule set with the baseline.

    Parameters
    ----------
    rows
        One a run: ``instance``, ``rule_set``, ``seed``, ``status``, ``error_kind`` and figures by name.
    baseline
        Name of the rule set to compare with.
    metrics
        Which figures.
    by
        Columns whose values tell the instance sets apart.
    measures
        Metrics that observers describe, by name.

    Raises
    ------
    InputError
        When no row is the baseline's.
    """
    rule_sets = tuple(dict.fromkeys(row["rule_set"] for row in rows))
    if baseline not in rule_sets:
        raise InputError("baseline", f'there is no rule set "{baseline}"{nearest(baseline, rule_sets)}')
    sets: dict[str, list[Mapping[str, Any]]] = {}
    for row in rows:
        sets.setdefault(_label(row, by), []).append(row)
    if len(sets) > 1:
        sets[OVERALL] = list(rows)
    paired: list[Paired] = []
    for name, members in sets.items():
        for metric in metrics:
            paired += _with_holm([_pair(name, members, metric, rule_set, baseline) for rule_set in rule_sets])
    counted = tuple(_count(name, members, rule_set) for name, members in sets.items() for rule_set in rule_sets)
    return Comparison(
        baseline, tuple(sets), rule_sets, tuple(metrics), tuple(paired), counted, tuple(by), measures or {}
    )


def _label(row: Mapping[str, Any], by: Sequence[str]) -> str:
    if tuple(by) == ("instance",):
        return str(row["instance"])
    return ", ".join(f"{name.rpartition('.')[2]}={row[name]}" for name in by)


def _figures(rows: Iterable[Mapping[str, Any]], rule_set: str, metric: str) -> dict[tuple[str, int], float | None]:
    """Return a rule set's figure by instance and seed; None where the run failed or has none."""
    return {
        (row["instance"], row["seed"]): None if row["status"] == "failed" else row.get(metric)
        for row in rows
        if row["rule_set"] == rule_set
    }


def _pair(name: str, rows: Rows, metric: str, rule_set: str, baseline: str) -> Paired:
    ours, theirs = _figures(rows, rule_set, metric), _figures(rows, baseline, metric)
    pairs = list(_both(ours, theirs))
    mean = fmean(own for own, _ in pairs) if pairs else None
    baseline_mean = fmean(other for _, other in pairs) if pairs else None
    difference = relative = Interval(None)
    if rule_set != baseline:
        difference = interval([own - other for own, other in pairs])
        if all(other != 0 for _, other in pairs):
            relative = interval([own / other - 1 for own, other in pairs])
    left_out = len(ours.keys() | theirs.keys()) - len(pairs)
    return Paired(name, metric, rule_set, len(pairs), left_out, mean, baseline_mean, difference, relative)


def _both(
    ours: Mapping[tuple[str, int], float | None], theirs: Mapping[tuple[str, int], float | None]
) -> Iterator[tuple[float, float]]:
    for key, own in ours.items():
        other = theirs.get(key)
        if own is not None and other is not None:
            yield own, other


def interval(values: Sequence[float]) -> Interval:
    """Return the mean of independent values with its 95 % Student t interval and the p-value of it being 0.

    One value has no interval. Values that are all the same have one of width 0, and a p-value of 1 if they are 0, of
    0 if they are not.
    """
    from scipy.stats import t  # imported here: half a second

    count = len(values)
    if count == 0:
        return Interval(None)
    mean = fmean(values)
    if count == 1:
        return Interval(mean)
    error = stdev(values) / math.sqrt(count)
    if error == 0:
        return Interval(mean, mean, mean, 1.0 if mean == 0 else 0.0)
    half = float(t.ppf((1 + CONFIDENCE) / 2, count - 1)) * error
    return Interval(mean, mean - half, mean + half, float(2 * t.sf(abs(mean) / error, count - 1)))


def holm(p_values: Sequence[float]) -> list[float]:
    """Return p-values corrected for there being several, after Holm (1979).

    The k-th smallest of m is multiplied by m - k + 1, and is at least as large as those before it, at most 1.
    """
    corrected = [0.0] * len(p_values)
    largest = 0.0
    for rank, place in enumerate(sorted(range(len(p_values)), key=lambda i: p_values[i])):
        largest = max(largest, min(1.0, p_values[place] * (len(p_values) - rank)))
        corrected[place] = largest
    return corrected


def _with_holm(family: Sequence[Paired]) -> list[Paired]:
    tested = [one for one in family if one.difference.p is not None]
    corrected = holm([one.difference.p for one in tested if one.difference.p is not None])
    p_of = {one.rule_set: p for one, p in zip(tested, corrected, strict=True)}
    return [evolve(one, p_holm=p_of.get(one.rule_set)) for one in family]


def _count(name: str, rows: Rows, rule_set: str) -> Counted:
    own = [row for row in rows if row["rule_set"] == rule_set]
    status = [row["status"] for row in own]
    return Counted(
        name,
        rule_set,
        len(own),
        status.count("complete"),
        status.count("partial"),
        status.count("failed"),
        sum(row.get("error_kind") == "StandstillError" for row in own),
        sum(bool(row.get("solves_stopped_early")) for row in own),
    )
