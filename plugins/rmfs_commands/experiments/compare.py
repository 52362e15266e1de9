"""Paired comparison of rule sets with a baseline.

Runs of the same instance and seed see the same orders, pods and robots (common random numbers), so that a rule set is
judged by its differences from the baseline, pair by pair. Instances share the orders' random numbers of a seed, too:
what is independent is the seeds. So each seed gives one value, the mean over the instances of a set, and over these go
the mean, its Student t interval, and the p-value of the paired t test, corrected for the number of rule sets compared
after Holm (1979, A simple sequentially rejective multiple test procedure, Scandinavian Journal of Statistics 6(2),
65-70).
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from functools import cached_property, lru_cache
from statistics import fmean
from typing import Any, NamedTuple

from attrs import evolve, field, frozen

from rmfs_commands.details.catalogue import HOOK_TIMES, METRICS, better
from rmfs_commands.results.figures import TIMING
from rmfs_core.errors import InputError
from rmfs_core.results.catalogue import Metric
from rmfs_core.wording import nearest

Rows = Sequence[Mapping[str, Any]]

CATALOGUE = {metric.name: metric for group in (*METRICS.values(), TIMING, HOOK_TIMES) for metric in group}
"""The metrics that every run begins with, and wall-clock figures; observers measure more."""

BOUND = "bound."
"""Before a metric's name: the column of what no rules can beat in it, see `rmfs_commands.bounds`."""

OVERALL = "overall"
CONFIDENCE = 0.95
COUNTED = ("complete", "horizon")
"""How runs end that are compared: every order is complete, or ``run.until_s`` was reached as asked."""
LEFT = ("backlog_end", "open_age_sum_h", "unpacked_end")
"""Metrics that are compared wherever a run ended at its horizon and has them, so that orders left are seen."""
MAKESPANS = ("makespan_s", "packed_makespan_s")
"""Metrics that a run with orders left does not have: their mean would be over the quick runs only."""
FEWEST_SEEDS = 3
"""With fewer seeds there are neither intervals nor p-values."""
AWAY_FROM_ZERO = 0.1
"""A baseline's figures are well away from 0 where each is at least this share of their mean on the same instance."""
FEW_PERCENT = 0.02
"""A mean of ratios and the ratio of the means that differ by at most this tell the same."""
_ROUNDING = 1e-9
"""Values that differ by less than this share of the largest are the same except for errors of rounding."""


@frozen
class Interval:
    """A mean with its 95 % interval and p-value; None where they would tell nothing, see `interval`.

    Parameters
    ----------
    mean
        Mean of the values.
    low, high
        Bounds of the Student t interval: 95 % for this mean alone.
    p
        Two-sided p-value of the t test that the mean is 0; at most 0.05 when 0 is outside of ``low`` to ``high``.
    low_holm, high_holm
        Bounds that hold for all means of the family at once with 95 % (after Bonferroni), and end at 0 where Holm's
        test tells on which side of 0 the mean lies though they would go beyond.
    p_holm
        The p-value corrected for the size of the family; at most 0.05 when 0 is not within ``low_holm`` to
        ``high_holm``, or their end.
    """

    mean: float | None
    low: float | None = None
    high: float | None = None
    p: float | None = None
    low_holm: float | None = None
    high_holm: float | None = None
    p_holm: float | None = None


@frozen
class Paired:
    """A rule set against the baseline, in one metric on one instance set.

    Parameters
    ----------
    instances
        The instance set, or ``"overall"``.
    metric, rule_set
        The subjects of the comparison.
    seeds
        Number of seeds that count: each gives one value, the mean over its pairs.
    pairs
        Number of their pairs of runs of the same instance and seed. (For the baseline: of its runs.)
    left_out
        Pairs that do not count: a side failed, was interrupted or has no such figure, or that is so of another
        instance of the seed, whose mean would be over other instances than those of other seeds. (An instance without
        any pair is left out alone.)
    why
        How many of them for which reason.
    mean, baseline_mean
        Means over the seeds. Where no run of the baseline has such a figure, ``mean`` is over the rule set's own runs.
    difference
        Rule set minus baseline.
    relative
        The same as a share of the baseline's figure, mean over the pairs of a seed. Where, for any rule set in the
        metric and instance set, some of the baseline's figures on an instance are close to 0 (see `AWAY_FROM_ZERO`), or
        so much smaller than others that the mean of the ratios is far from the ratio of the means
        (`_tells_of_ratios`), the difference as a share of their mean, if that is well away from 0; else not defined.
    of_mean
        Whether ``relative`` is a share of the mean.
    bound
        Bound that no rules can beat, mean over the seeds; None where a run has no bound.
    times_bound
        The figure as a multiple of the bound, mean over the pairs of a seed; not defined when a bound is 0.
    """

    instances: str
    metric: str
    rule_set: str
    seeds: int
    pairs: int
    left_out: int
    mean: float | None
    baseline_mean: float | None
    difference: Interval = Interval(None)
    relative: Interval = Interval(None)
    bound: float | None = None
    times_bound: float | None = None
    why: Mapping[str, int] = field(factory=dict)
    of_mean: bool = False

    @property
    def p_holm(self) -> float | None:
        """The difference's p-value, corrected over the rule sets compared in this metric and instance set."""
        return self.difference.p_holm


@frozen
class Counted:
    """How the runs of a rule set on an instance set ended.

    Parameters
    ----------
    instances, rule_set
        Which runs.
    runs
        All of them; ``complete``, ``horizon``, ``partial`` and ``failed`` add up to it.
    stood_still
        Those of the failed ones in which nothing could happen any more.
    stopped_early
        Runs with at least one solve that a limit ended before its proof.
    """

    instances: str
    rule_set: str
    runs: int
    complete: int
    horizon: int
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
        The subjects of the comparison, in the order shown.
    paired
        By instance set, metric and rule set.
    counted
        By instance set and rule set.
    by
        Columns whose values tell the instance sets apart.
    measures
        Metrics that observers describe, by name.
    fronts
        Pairs of metrics in which rule sets are compared.
    fixed
        Instance sets whose orders are the same for every seed: seeds are no replications of the demand.
    """

    baseline: str
    instance_sets: tuple[str, ...]
    rule_sets: tuple[str, ...]
    metrics: tuple[str, ...]
    paired: tuple[Paired, ...]
    counted: tuple[Counted, ...]
    by: tuple[str, ...] = ("instance",)
    measures: Mapping[str, Metric] = field(factory=dict)
    fronts: tuple[tuple[str, str], ...] = ()
    fixed: tuple[str, ...] = ()

    @cached_property
    def tested(self) -> bool:
        """Whether any difference has an interval and a p-value."""
        return any(one.difference.p is not None or one.relative.p is not None for one in self.paired)

    @cached_property
    def horizon(self) -> bool:
        """Whether any run ended at its horizon."""
        return any(one.horizon for one in self.counted)

    @cached_property
    def all_count(self) -> bool:
        """Whether all runs are complete, or have reached their horizon."""
        return not any(one.partial or one.failed for one in self.counted)

    def censored(self, metric: str) -> bool:
        """Whether a metric is of completed orders alone, and a horizon has left some open."""
        return self.horizon and self.described(metric).of_completed

    def described(self, metric: str) -> Metric:
        """Return how a metric is shown: under its name when nobody describes it."""
        return CATALOGUE.get(metric) or self.measures.get(metric) or Metric(metric)

    def holds(self, instances: str, row: Mapping[str, Any]) -> bool:
        """Whether a run belongs to an instance set."""
        return instances in (OVERALL, _label(row, self.by))

    @cached_property
    def _by_metric(self) -> Mapping[tuple[str, str], list[Paired]]:
        found: dict[tuple[str, str], list[Paired]] = {}
        for one in self.paired:
            found.setdefault((one.instances, one.metric), []).append(one)
        return found

    def of(self, instances: str, metric: str) -> list[Paired]:
        """Return the rule sets in one metric on one instance set."""
        return self._by_metric.get((instances, metric), [])

    def ended(self, instances: str) -> list[Counted]:
        """Return how the runs of the rule sets on one instance set ended."""
        return [one for one in self.counted if one.instances == instances]

    def front(self, instances: str, first: str, second: str) -> list[tuple[Paired, Paired]]:
        """Return the rule sets that none beats in two metrics at once, by the first, the best first.

        Less is better but in metrics known for the opposite, such as ``pile_on``.
        Those with pairs left out are not compared with the others: their means are over other runs.
        """
        both = zip(self.of(instances, first), self.of(instances, second), strict=True)
        found: list[tuple[float, float, tuple[Paired, Paired]]] = [
            (_sign(first) * one.mean, _sign(second) * other.mean, (one, other))
            for one, other in both
            if one.mean is not None and other.mean is not None and not (one.left_out or other.left_out)
        ]
        found.sort(key=lambda entry: entry[:2])
        front: list[tuple[Paired, Paired]] = []
        best = (math.inf, math.inf)
        for *means, pair in found:
            if means[1] < best[1] or tuple(means) == best:  # equal in both: neither beats the other
                front.append(pair)
                best = (means[0], means[1])
        return front

    def bounded(self, metric: str) -> bool:
        """Whether it is known of some rule set what it cannot beat in a metric."""
        return any(one.bound is not None for one in self.paired if one.metric == metric)


def _sign(metric: str) -> int:
    """Return -1 for a metric of which more is better, otherwise 1."""
    return -1 if better(metric) == "more" else 1


def summary(
    rows: Rows,
    baseline: str,
    metrics: Sequence[str],
    *,
    by: Sequence[str] = ("instance",),
    measures: Mapping[str, Metric] | None = None,
    fronts: Sequence[tuple[str, str]] = (),
    fixed: Collection[str] = (),
) -> Comparison:
    """Compare every rule set with the baseline.

    Parameters
    ----------
    rows
        One a run: ``instance``, ``rule_set``, ``seed``, ``status``, ``error_kind`` and figures by name; bounds under
        the names of their metrics behind `BOUND`.
    baseline
        Name of the rule set to compare with.
    metrics
        Which figures.
    by
        Columns whose values tell the instance sets apart.
    measures
        Metrics that observers describe, by name.
    fronts
        Pairs of metrics in which rule sets are compared.
    fixed
        Instances whose orders are the same for every seed.

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
        by_rule_set: dict[str, list[Mapping[str, Any]]] = {rule_set: [] for rule_set in rule_sets}
        for row in members:
            by_rule_set[row["rule_set"]].append(row)
        for metric in metrics:
            paired += _family(name, by_rule_set, metric, baseline)
    counted = tuple(_count(name, members, rule_set) for name, members in sets.items() for rule_set in rule_sets)
    return Comparison(
        baseline,
        tuple(sets),
        rule_sets,
        tuple(metrics),
        tuple(paired),
        counted,
        tuple(by),
        measures or {},
        tuple(fronts),
        tuple(name for name, members in sets.items() if any(row["instance"] in fixed for row in members)),
    )


def _label(row: Mapping[str, Any], by: Sequence[str]) -> str:
    if tuple(by) == ("instance",):
        return str(row["instance"])
    return ", ".join(f"{name.rpartition('.')[2]}={row[name]}" for name in by)


def _figures(rows: Rows, metric: str, *, defined: bool = True) -> dict[tuple[str, int], float | None]:
    """Return a rule set's figure by instance and seed; None where the run does not count or has none."""
    return {
        (row["instance"], row["seed"]): row.get(metric) if defined and row["status"] in COUNTED else None
        for row in rows
    }


class _Pair(NamedTuple):
    """Figures of rule set and baseline on an instance, and what neither can beat."""

    own: float
    base: float
    bound: float | None


Pairs = Sequence[_Pair]
"""Those of a seed, an instance each."""


def _by_seed(own_rows: Rows, base_rows: Rows, metric: str, *, defined: bool) -> tuple[list[Pairs], Counter[str]]:
    """Return the pairs of each seed that counts, and the number of pairs left out for each reason."""
    ours, theirs = (_figures(rows, metric, defined=defined) for rows in (own_rows, base_rows))
    bounds = _figures(own_rows, f"{BOUND}{metric}")
    all_of_them = ours.keys() | theirs.keys()
    pairs = {
        key: _Pair(own, other, bounds[key])
        for key, own in ours.items()
        if own is not None and (other := theirs.get(key)) is not None
    }
    instances = {instance for instance, _ in pairs}
    broken = {seed for instance, seed in all_of_them - pairs.keys() if instance in instances}
    seeds: dict[int, list[_Pair]] = {}
    for (_, seed), pair in pairs.items():
        if seed not in broken:
            seeds.setdefault(seed, []).append(pair)
    left = [key for key in sorted(all_of_them) if key not in pairs or key[1] in broken]
    both = [{(row["instance"], row["seed"]): row for row in rows} for rows in (own_rows, base_rows) if left]
    sides = ([row for side in both if (row := side.get(key)) is not None] for key in left)
    return list(seeds.values()), Counter(_why(side, metric, defined=defined) for side in sides)


def _why(runs: Rows, metric: str, *, defined: bool) -> str:
    """Say why a pair of runs does not count."""
    status = [run["status"] for run in runs]
    if "failed" in status:
        return "a run failed"
    if "partial" in status:
        return "a run was interrupted"
    lacking = [run for run in runs if not defined or run.get(metric) is None]
    if not lacking:
        return "a pair of another instance of the seed is left out"
    if metric in MAKESPANS and (not defined or all(metric in run for run in lacking)):
        return "runs of the instance set leave orders at the horizon, so that there is no mean makespan"
    if not all(run.get("orders_completed", 1) for run in lacking):
        return "a run completes no order in the time that counts"
    return "a run has no such figure"


def _family(name: str, by_rule_set: Mapping[str, Rows], metric: str, baseline: str) -> list[Paired]:
    """Compare the rule sets with the baseline in one metric on one instance set."""
    defined = metric not in MAKESPANS or not any(
        row["status"] == "horizon" and row.get(metric, 0) is None for rows in by_rule_set.values() for row in rows
    )
    alone = defined and all(_has_no(row, metric) for row in by_rule_set[baseline])
    found, differences, pairs_of, amounts, bases = [], [], [], [], []
    of_ratios = True  # of all rule sets, so that they can be compared
    for rule_set, rows in by_rule_set.items():
        seeds, why = _by_seed(rows, rows if alone else by_rule_set[baseline], metric, defined=defined)
        number = sum(map(len, seeds))
        own = _mean([fmean(pair.own for pair in pairs) for pairs in seeds])
        other = _mean([fmean(pair.base for pair in pairs) for pairs in seeds])
        its = None if alone else other
        one = Paired(name, metric, rule_set, len(seeds), number, why.total(), own, its, why=why)
        found.append(_with_bound(one, seeds))
        compared = seeds if rule_set != baseline and not alone else []
        of_ratios = of_ratios and all(_tells_of_ratios(pairs) for pairs in zip(*compared, strict=True))
        bases.append(interval([fmean(pair.base for pair in pairs) for pairs in compared]))
        differences.append([fmean(figure - base for figure, base, _ in pairs) for pairs in compared])
        pairs_of.append(compared)
        amounts.append(all(own >= 0 and base >= 0 for pairs in compared for own, base, _ in pairs))
    compared_all = []
    ratios = [
        [fmean(figure / base - 1 for figure, base, _ in pairs) for pairs in compared if of_ratios]
        for compared in pairs_of
    ]
    of_all = zip(found, intervals(differences), intervals(ratios), bases, amounts, strict=True)
    for one, difference, share, base, amount in of_all:
        of_mean = share.mean is None and base.low is not None and base.high is not None and base.low * base.high > 0
        of_base = _scaled(difference, base.mean or 1.0) if of_mean else share
        limited = _at_least(-1.0, of_base) if amount else of_base
        compared_all.append(evolve(one, difference=difference, relative=limited, of_mean=of_mean))
    return compared_all


def _has_no(run: Mapping[str, Any], metric: str) -> bool:
    """Whether a run that counts has orders and no such figure, as one that splits no order has no consolidation."""
    return run["status"] in COUNTED and run.get("orders_completed", 1) > 0 and run.get(metric) is None


def _tells_of_ratios(pairs: Sequence[_Pair]) -> bool:
    """Whether the baseline's figures on an instance are well away from 0, so that ratios to them have a mean.

    All of them lie on the same side of 0, none is close to it, and the mean of the ratios differs from the ratio of the
    means by at most half of the larger, or by `FEW_PERCENT`.
    """
    bases = [pair.base for pair in pairs]
    amounts = [abs(base) for base in bases]
    if not abs(sum(bases)) == sum(amounts) > 0 or min(amounts) < AWAY_FROM_ZERO * fmean(amounts):
        return False
    of_ratios = fmean((pair.own - pair.base) / abs(pair.base) for pair in pairs)
    of_means = fmean(pair.own - pair.base for pair in pairs) / fmean(amounts)
    return abs(of_ratios - of_means) <= max(max(abs(of_ratios), abs(of_means)) / 2, FEW_PERCENT)


def _scaled(found: Interval, base: float) -> Interval:
    """Return a difference as a share of a mean, with the p-values of the difference."""
    shares = {
        name: bound / abs(base)
        for name in ("mean", "low", "high", "low_holm", "high_holm")
        if (bound := getattr(found, name)) is not None
    }
    return evolve(found, **shares)


def _at_least(least: float, found: Interval) -> Interval:
    """Return an interval without what lies below the least that its values can be."""
    low, low_holm = (None if bound is None else max(bound, least) for bound in (found.low, found.low_holm))
    return evolve(found, low=low, low_holm=low_holm)


def _with_bound(one: Paired, seeds: Sequence[Pairs]) -> Paired:
    """Return a rule set's figures with what no rules can beat, if that is known of all its runs."""
    bounds = [[pair.bound for pair in pairs if pair.bound is not None] for pairs in seeds]
    if sum(map(len, bounds)) < one.pairs:
        return one
    bound = _mean([fmean(of_seed) for of_seed in bounds])
    if not all(map(all, bounds)):
        return evolve(one, bound=bound)
    times = [
        fmean(pair.own / least for pair, least in zip(pairs, of_seed, strict=True))
        for pairs, of_seed in zip(seeds, bounds, strict=True)
    ]
    return evolve(one, bound=bound, times_bound=_mean(times))


def _mean(values: Sequence[float]) -> float | None:
    return fmean(values) if values else None


def interval(values: Sequence[float]) -> Interval:
    """Return the mean of independent values with its 95 % Student t interval and the p-value of it being 0.

    Fewer than `FEWEST_SEEDS` values have neither, nor have values that are all the same (except for rounding errors):
    their variance is not known, and the test is not defined.
    """
    from scipy.special import stdtr  # imported here: it takes a while

    mean = _mean(values)
    if mean is None or len(values) < FEWEST_SEEDS or _all_the_same(values):
        return Interval(mean)
    low, high = _bounds(values, CONFIDENCE)
    return Interval(mean, low, high, float(2 * stdtr(len(values) - 1, -abs(mean) / _error(values))))


def _all_the_same(values: Sequence[float]) -> bool:
    return max(values) - min(values) <= _ROUNDING * max(map(abs, values))


def intervals(family: Sequence[Sequence[float]]) -> list[Interval]:
    """Return several means, each as `interval` does, with what holds for all of them at once."""
    found = [interval(values) for values in family]
    tested = [(place, one.p) for place, one in enumerate(found) if one.p is not None]
    for (place, _), p in zip(tested, holm([p for _, p in tested]), strict=True):
        low, high = _bounds(family[place], 1 - (1 - CONFIDENCE) / len(tested))
        if p <= 1 - CONFIDENCE:
            low, high = (max(low, 0.0), high) if fmean(family[place]) > 0 else (low, min(high, 0.0))
        found[place] = evolve(found[place], low_holm=low, high_holm=high, p_holm=p)
    return found


def _error(values: Sequence[float]) -> float:
    mean = fmean(values)  # `statistics.stdev` calculates with fractions, which takes ten times as long
    return math.sqrt(math.fsum((value - mean) ** 2 for value in values) / (len(values) - 1) / len(values))


def _bounds(values: Sequence[float], confidence: float) -> tuple[float, float]:
    mean, half = fmean(values), _quantile((1 + confidence) / 2, len(values) - 1) * _error(values)
    return mean - half, mean + half


@lru_cache(maxsize=1000)
def _quantile(share: float, degrees: int) -> float:
    from scipy.special import stdtrit

    return float(stdtrit(degrees, share))


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


def _count(name: str, rows: Rows, rule_set: str) -> Counted:
    own = [row for row in rows if row["rule_set"] == rule_set]
    status = [row["status"] for row in own]
    return Counted(
        name,
        rule_set,
        len(own),
        status.count("complete"),
        status.count("horizon"),
        status.count("partial"),
        status.count("failed"),
        sum(row.get("error_kind") == "StandstillError" for row in own),
        sum(bool(row.get("solves_stopped_early")) for row in own),
    )
