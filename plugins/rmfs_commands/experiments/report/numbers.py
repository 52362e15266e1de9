"""Figures of a comparison as people read them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from attrs import evolve

from rmfs_commands.details.catalogue import better
from rmfs_commands.experiments.compare import CONFIDENCE, FEWEST_SEEDS, Comparison, Interval, Paired
from rmfs_commands.results.figures import show
from rmfs_core.results.catalogue import Metric
from rmfs_core.wording import counted, first_few, listed

NONE = "-"
MINUS = "\N{MINUS SIGN}"
_DIFFERENCES = 'Difference: rule set minus "{}" on the same instances and seeds, mean over the seeds.'
_TEST = (
    "In brackets: 95 % confidence interval that holds for all rule sets at once. p: paired t test over the seeds, "
    "corrected after Holm for the number of rule sets."
)
NO_TEST = (
    f"With fewer than {FEWEST_SEEDS} seeds, or with the same difference in every seed, there is neither interval nor "
    "p: they would tell nothing."
)
_FIXED = (
    "come from a file and are the same for every seed: seeds change only where pods and robots start, and what rules "
    "draw. Intervals and p hold for these orders, not for those of other days."
)
REPEATS = "Every seed gives the same run, so more seeds tell nothing."
_COMPLETE = "Only complete runs count."
_HORIZON = "Only runs that are complete or reached their horizon (run.until_s) count."
MARK = "*"
"""At the title of a metric in which orders left at a horizon are missing."""
OF_MEAN = "\N{DAGGER}"
"""Behind a relative difference that is one of means."""
OF_MEAN_WHY = (
    "some of the baseline's figures are close to 0, or the mean of the ratios is far from the ratio of the means"
)
"""Why a relative difference is one of means."""
OF_MEAN_NOTE = f"{OF_MEAN} Difference as a share of the baseline's mean, with its p: {OF_MEAN_WHY}."
CENSORED = (
    f"{MARK} Of completed or packed orders only: what the orders left at the horizon would change is not known. They "
    "often wait long, or are large; their number and age are compared, too."
)


def caption(comparison: Comparison) -> str:
    """Return what the figures next to a baseline are, and what p holds for."""
    what = _DIFFERENCES.format(comparison.baseline)
    sentences = [
        f"{what} {_TEST}" if comparison.tested else what,
        counted_runs(comparison),
        *([CENSORED] if any(map(comparison.censored, comparison.metrics)) else []),
        *([OF_MEAN_NOTE] if any(one.of_mean for one in comparison.paired) else []),
    ]
    others = (one for one in comparison.paired if one.rule_set != comparison.baseline)
    if any(one.difference.mean is not None and one.difference.p is None for one in others):
        sentences.insert(1, NO_TEST)
    return " ".join([*sentences, *filter(None, [fixed(comparison)])])


def fixed(comparison: Comparison) -> str | None:
    """Return what p says nothing of where seeds do not repeat the demand; None where they do, or there is no p."""
    if not comparison.fixed or not comparison.tested:
        return None
    everywhere = len(comparison.fixed) == len(comparison.instance_sets)
    return f"Orders{'' if everywhere else f' of {first_few(comparison.fixed)}'} {_FIXED}"


def title(metric: Metric) -> str:
    """Return a metric's label with its unit: ``Makespan (s)``."""
    label = metric.label.strip()
    if metric.label.startswith(" "):  # a part of the figure above it in a table of all metrics
        label = metric.meaning.partition(". ")[0].rstrip(".")
    return f"{label} ({metric.unit})" if metric.unit else label


def answer(comparison: Comparison, metric: str) -> str | None:
    """Return a sentence on which rule set is best in a metric over all instances; None where neither way is better.

    Rule sets with pairs left out are not compared with the others: their means are over other runs.
    """
    way, shown_as = better(metric), comparison.described(metric)
    found = comparison.of(comparison.instance_sets[-1], metric)
    means = {one.rule_set: one.mean for one in found if one.mean is not None and not one.left_out}
    if way is None or len(means) < 2 or comparison.baseline not in means:
        return None
    ranked = sorted(means, key=lambda name: (means[name] * (-1 if way == "more" else 1), name != comparison.baseline))
    best, base, one_of = ranked[0], comparison.baseline, {one.rule_set: one for one in found}
    label = title(shown_as).partition(" (")[0]
    label = label if label[:2].isupper() else f"{label[:1].lower()}{label[1:]}"
    unit = f" {shown_as.unit}" if shown_as.unit else ""
    has = f"has the {'highest' if way == 'more' else 'lowest'} {label}"
    mean = f"{value(shown_as, means[best])}{unit}"
    other = one_of[ranked[1] if best == base else best]
    share = other.relative.mean is not None and shown_as.unit != "%" and other_sign(shown_as, other) is None
    points = " points" if shown_as.unit == "%" else unit
    by = relative(other, bounds=False) if share else f"{difference(shown_as, other.difference, bounds=False)}{points}"
    p = (other.relative if share else other.difference).p_holm
    told = "" if p is None else f" (p {'' if p < 0.001 else '= '}{probability(p)})"
    if means[ranked[0]] == means[ranked[1]] and best == base:
        return f"No rule set is better than {base}, the baseline, in {label}: {mean}."
    if best == base:
        return f"{base}, the baseline, {has}: {mean}; next is {other.rule_set} with {by}{told}."
    if p is None or p > 1 - CONFIDENCE:
        doubt = "no test tells whether that is chance" if p is None else "that may be chance"
        return f"{best} {has}: {mean}, {by} against {base}{told}; {doubt}."
    return f"{best} {has}: {mean}, {by} against {base}{told}."


def counted_runs(comparison: Comparison) -> str:
    """Return a sentence on which runs count."""
    return _HORIZON if comparison.horizon else _COMPLETE


def aim(metric: str) -> str:
    """Return what an axis says of a metric: ``less is better``; nothing where neither way is."""
    way = better(metric)
    return f"{way} is better" if way else ""


def heading(comparison: Comparison, metric: str) -> str:
    """Return a metric's title in a comparison, marked where orders left at a horizon are missing in it."""
    return f"{title(comparison.described(metric))}{MARK if comparison.censored(metric) else ''}"


def why(one: Paired) -> str | None:
    """Return how many pairs were left out for which reason: ``2 pairs, as a run failed``; None of none."""
    return "; ".join(f"{counted(number, 'pair')}, as {reason}" for reason, number in sorted(one.why.items())) or None


def left_out(comparison: Comparison, shown: Sequence[str]) -> list[str]:
    """Return a sentence on pairs left out, and why: once for all rule sets and metrics of which it is so."""
    metrics: dict[tuple[str, str, str], list[str]] = {}
    for one in (one for metric in comparison.metrics for name in shown for one in comparison.of(name, metric)):
        if one.rule_set != comparison.baseline and (reasons := why(one)):
            metrics.setdefault((one.instances, one.rule_set, reasons), []).append(heading(comparison, one.metric))
    alike: dict[tuple[str, str, tuple[str, ...]], list[str]] = {}
    for (instances, rule_set, reasons), titles in metrics.items():
        alike.setdefault((instances, reasons, tuple(titles)), []).append(rule_set)
    sentences = []
    for (instances, reasons, of), names in alike.items():
        whose = names[0] if len(names) == 1 else f"from each of {len(names)} rule sets ({first_few(names)})"
        of_metrics = "" if len(of) == len(comparison.metrics) else f" (in {listed(of)})"
        sentences.append(f"Left out, {instances}, {whose}: {reasons}{of_metrics}.")
    return sentences


def value(metric: Metric, number: float | None) -> str:
    """Return a metric's value, one digit finer than a single run's: it is a mean."""
    return show(_finer(metric), number)


def difference(metric: Metric, found: Interval, *, bounds: bool = True) -> str:
    """Return a difference with its interval next to Holm's p: ``-0.17 [-0.21, -0.13]``; or without."""
    finer = _finer(metric)
    return _with_bounds(found, lambda number: signed(show(finer, number)), bounds=bounds)


def has_relative(comparison: Comparison, metric: str, shown: Sequence[str]) -> bool:
    """Whether relative differences of a metric are shown: not of percentages, which differ by percentage points."""
    return comparison.described(metric).unit != "%" and any(
        one.relative.mean is not None for name in shown for one in comparison.of(name, metric)
    )


def difference_heading(metric: Metric) -> str:
    """Return what the column of differences is called."""
    return "Difference (points)" if metric.unit == "%" else "Difference"


def relative(one: Paired, *, bounds: bool = True) -> str:
    """Return a relative difference in percent, with an interval next to Holm's p; marked where of a mean."""
    shown = _with_bounds(one.relative, lambda number: signed(f"{100 * number:,.1f}"), " %", bounds=bounds)
    return f"{shown} {OF_MEAN}" if one.of_mean else shown


def times(multiple: float | None) -> str:
    """Return how many times the bound a figure is."""
    return NONE if multiple is None else f"{multiple:,.2f}"


def probability(p: float | None) -> str:
    """Return a p-value with three digits."""
    if p is None:
        return NONE
    return "< 0.001" if p < 0.001 else f"{p:.3f}"


def other_sign(metric: Metric, one: Paired) -> str | None:
    """Return a sentence where the relative difference has another sign than that of the means; else None."""
    mean, share = one.difference.mean, one.relative.mean
    if mean is None or share is None or mean * share >= 0:
        return None
    p = "" if one.difference.p_holm is None else f", p {probability(one.difference.p_holm)}"
    return (
        f"{one.rule_set}, {one.instances}: the means differ by {difference(metric, one.difference)}{p}, the other way "
        "round than the relative difference, in which small and large figures count alike."
    )


def other_signs(comparison: Comparison, metric: str, shown: Sequence[str]) -> list[str]:
    """Return what `other_sign` says of a metric on some instance sets."""
    pairs = (one for name in shown for one in comparison.of(name, metric))
    return [sentence for one in pairs if (sentence := other_sign(comparison.described(metric), one))]


def seeds(one: Paired) -> str:
    """Return the number of seeds, and how many pairs were left out."""
    return f"{one.seeds} ({one.left_out} left out)" if one.left_out else str(one.seeds)


def _finer(metric: Metric) -> Metric:
    return evolve(metric, digits=metric.digits + 1)


def signed(text: str) -> str:
    """Give a number a plus or a proper minus; none to what is rounded to zero."""
    digits = text.lstrip("-")
    if not digits.strip("0.,"):
        return digits
    return f"{MINUS}{digits}" if text.startswith("-") else f"+{digits}"


def _with_bounds(found: Interval, shown: Callable[[float], str], unit: str = "", *, bounds: bool) -> str:
    if found.mean is None:
        return NONE
    if not bounds:
        return f"{shown(found.mean)}{unit}"
    if found.low_holm is None or found.high_holm is None:
        return f"{shown(found.mean)}{unit} (no interval)"
    return f"{shown(found.mean)}{unit} [{shown(found.low_holm)}, {shown(found.high_holm)}]"
