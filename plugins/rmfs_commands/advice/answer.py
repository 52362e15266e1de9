"""The answer of the runs: a table of the rule sets, and which to take."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from attrs import evolve, frozen

from rmfs_commands.advice.candidates import COST, OWN
from rmfs_commands.cli.screen import new_table
from rmfs_commands.experiments import Comparison, ExperimentResult, Paired
from rmfs_commands.experiments.compare import FEWEST_SEEDS, Interval
from rmfs_commands.experiments.report.numbers import MARK, MINUS, NONE, REPEATS, value
from rmfs_core.results.catalogue import Metric
from rmfs_core.wording import counted, listed

if TYPE_CHECKING:
    from rich.table import Table

_SO_FAR = "Arrival to {}, or to the end of the run for orders that are not then, mean over both."
SO_FAR = {
    "turnover_s": Metric("turnover_so_far_s", "Turn-over time so far", "s", 1, _SO_FAR.format("completion")),
    "packed_s": Metric("packed_so_far_s", "Time to packed so far", "s", 1, _SO_FAR.format("packed")),
}
"""The metric that replaces a mean over orders that are done, where a horizon leaves some."""
SURE = 0.05
"""A difference whose p-value is no more than this is told from none."""
HEADINGS = ("Visits", "Time", "95th")
"""Of the metrics in the table: a line of it has 80 columns."""
AS_GOOD = "*"
"""Sign before the figures of the best rule set, and of rule sets from which the runs show no difference."""
TURNOVER, PACKED = "turn-over time (order lead time)", "the time from arrival to packed"


@frozen
class Best:
    """Which rule sets have least of a metric.

    Parameters
    ----------
    metric
        The metric.
    least
        The rule set with the lowest mean: of those that are shown to be better than the scenario's own, if any is.
    others
        Rule sets that the runs show no difference from.
    take
        The one of these to take: the scenario's own if it is among them.
    against
        All compared with that, by name.
    now
        All compared with the scenario's own, by name; none where that does not complete its runs.
    """

    metric: str
    least: str
    others: tuple[str, ...]
    take: str
    against: dict[str, Paired]
    now: dict[str, Paired]

    @property
    def names(self) -> tuple[str, ...]:
        """All of them, the lowest mean first."""
        return (self.least, *self.others)


def with_open_orders(result: ExperimentResult) -> ExperimentResult:
    """Return a result whose mean time has the orders in it that a horizon left, where it left any.

    A mean over completed, or packed, orders alone would praise rules that leave the slow ones.
    """
    experiment = result.experiment
    visits, time, *others = experiment.metrics
    if not any(row["status"] == "horizon" for row in result.rows):
        return result
    metric = SO_FAR[time]
    rows = [row | _so_far(row, time) for row in result.rows]
    metrics, fronts = (visits, metric.name, *others), tuple((first, metric.name) for first, _ in experiment.fronts)
    measures = {**result.measures, metric.name: metric}
    return evolve(result, experiment=evolve(experiment, metrics=metrics, fronts=fronts), rows=rows, measures=measures)


def against_whole(result: ExperimentResult) -> ExperimentResult:
    """Return a result whose baseline completes all of its runs, where any rule set does.

    Rule sets are compared by pairs with the baseline: with failed ones there would be no figures of the others.
    """
    names = [one.name for one in result.experiment.rule_sets]
    failed = _failed(result.comparison())
    whole = [name for name in names if name not in failed]
    if not whole or result.experiment.baseline in whole:
        return result
    return evolve(result, experiment=evolve(result.experiment, baseline=whole[0]))


def best_of_each(result: ExperimentResult) -> list[Best]:
    """Return the rule sets with least visits, and with least time."""
    return [one for metric in result.experiment.metrics[:2] if (one := best(result, metric)) is not None]


def _so_far(row: dict[str, Any], time: str) -> dict[str, float]:
    """Return a run's mean time so far, if it got so far as to have figures."""
    if row["status"] not in ("complete", "horizon"):
        return {}
    left, age, number = ("open_orders_end", "open_age_sum_h", "orders_completed")
    if time == "packed_s":
        left, age, number = ("unpacked_end", "unpacked_age_sum_h", "orders_packed")
    done, still = row[number], row[left]
    total = done * (row[time] or 0.0) + 3600 * row[age]
    return {SO_FAR[time].name: total / (done + still)} if done + still else {}


def best(result: ExperimentResult, metric: str, among: Collection[str] | None = None) -> Best | None:
    """Return the rule sets with least of a metric; None when there is no run that counts.

    Each other one is compared with that of the lowest mean by paired t tests, as `rmfs compare` does, but after
    Bonferroni instead of Holm: then a difference is told where an interval of the table would leave out 0. Your own
    rules are none of them where the table tells of another rule set that it is better. Rule sets that are not ``among``
    some cannot be the best, where these are given.
    """
    found = _whole(result.comparison(), metric)
    found = found if among is None else {name: one for name, one in found.items() if name in among}
    if not found:
        return None
    least = min(found, key=lambda name: found[name].mean or 0.0)
    against = _against(result, least, metric)
    alike = [name for name, one in against.items() if name != least and not _told_apart(one, len(against) - 1)]
    others = [name for name in alike if name in found]
    own = next((name for name in found if name.endswith(OWN)), None)
    now = {} if own is None else _against(result, own, metric)
    if own in others:
        told = [name for name in found if name != own and _told_better(now[name], len(against) - 1)]
        if not told:
            return Best(metric, least, tuple(others), own, now, now)
        alike = [name for name in (least, *others) if name != own]
        if better := [name for name in alike if name in told]:
            least = min(better, key=lambda name: found[name].mean or 0.0)
            against = _against(result, least, metric)
        others = [name for name in alike if name != least]
    return Best(metric, least, tuple(others), least, against, now)


def cheapest(result: ExperimentResult, limit: tuple[str, float] | None) -> Iterator[str]:
    """Yield with which rule set an order costs least, where the scenario names costs.

    ``limit``: a metric, and the most that its mean may be for a rule set to be chosen.
    """
    if COST not in result.experiment.metrics:
        return
    among, whose = None, ""
    if limit is not None:
        metric, most = limit
        among = {name for name, one in _whole(result.comparison(), metric).items() if (one.mean or 0.0) <= most}
        whose = f" among the rule sets with a mean {metric} of at most {most:g}"
        if not among:
            yield f"No rule set has a mean {metric} of at most {most:g}."
            return
    if (found := best(result, COST, among)) is None:
        return
    known = result.comparison().described(COST)
    taken, alike = found.against[found.take], [_plain(name) for name in found.names if name != found.take]
    shown = f"{value(known, taken.mean)} ({_plain(found.take)}{' as now' if found.take.endswith(OWN) else ''})"
    yield f"Least cost per order{whose}: {shown}."
    if alike:
        yield f"The runs show no difference in cost from {listed(alike)}."


def _against(result: ExperimentResult, baseline: str, metric: str) -> dict[str, Paired]:
    """Return every rule set compared with one, by name."""
    return _whole(evolve(result, experiment=evolve(result.experiment, baseline=baseline)).comparison(), metric)


def _whole(comparison: Comparison, metric: str) -> dict[str, Paired]:
    """Return the rule sets of which all runs count."""
    every = comparison.of(comparison.instance_sets[-1], metric)
    failed = _failed(comparison)
    return {one.rule_set: one for one in every if one.mean is not None and one.rule_set not in failed}


def _failed(comparison: Comparison) -> set[str]:
    """Return the rule sets of which a run does not count."""
    return {one.rule_set for one in comparison.counted if one.failed or one.partial}


def _told_apart(one: Paired, family: int) -> bool:
    found = [p for p in (one.difference.p, one.relative.p) if p is not None]
    return bool(found) and family * max(found) <= SURE


def _told_better(one: Paired, family: int) -> bool:
    """Whether the interval of the table, or of the difference where that has none, lies below 0."""
    shown = one.difference if one.relative.p is None else one.relative
    return shown.p is not None and shown.mean is not None and shown.mean < 0 and family * shown.p <= SURE


def table_of(result: ExperimentResult, found: Sequence[Best]) -> Table:
    """Return the table of the rule sets: every metric with its mean, the first two with differences as well."""
    from rich.text import Text

    comparison = result.comparison()
    table = new_table(result.experiment.description)
    table.add_column("Rule set")
    for number, heading in enumerate(_headings(comparison)):
        table.add_column(heading, justify="right")
        if number < len(found):
            table.add_column("vs now", justify="right")
    table.add_column("Front")
    front, now = _front(result), comparison.baseline.endswith(OWN)
    for name in comparison.rule_sets:
        cells = []
        for number, metric in enumerate(comparison.metrics[: len(HEADINGS)]):
            one = _whole(comparison, metric).get(name)
            marked = comparison.tested and number < len(found) and name in found[number].names
            mark = AS_GOOD if marked else ""
            cells.append(NONE if one is None else f"{mark}{value(comparison.described(metric), one.mean)}")
            if number < len(found):
                if one is None or name.endswith(OWN):
                    cells.append("")
                else:
                    cells.append(share(one.relative) if now else NONE)
        table.add_row(Text(name), *cells, "front" if name in front else "")
    return table


def _headings(comparison: Comparison) -> list[str]:
    """Return what the columns of metrics are called, marked where orders left at a horizon are missing."""
    both = zip(HEADINGS, comparison.metrics[: len(HEADINGS)], strict=True)
    return [
        f"{name}{MARK if metric != 'psv_per_order' and comparison.censored(metric) else ''}" for name, metric in both
    ]


def caption(result: ExperimentResult) -> str:
    """Return what the columns of the table are."""
    metrics, marked = result.experiment.metrics, [one for one in _headings(result.comparison()) if one.endswith(MARK)]
    packed = "packed_p95_s" in metrics
    time, done = (PACKED, "packed") if packed else (TURNOVER, "completed")
    what = f"Time, 95th: mean and 95th percentile of {time} in s."
    if metrics[1] in {one.name for one in SO_FAR.values()}:
        what = (
            f"Time: mean of {time} so far in s: to the end of the run for orders that are not {done} then. 95th: 95th "
            "percentile."
        )
    sentences = [
        f"Visits: pod-station visits per order. {what}",
        *([f"{listed(marked)}: of {done} orders only."] if marked else []),
        "Front: no other rule set has a lower mean in one of them and no higher mean in the other.",
    ]
    if result.comparison().tested:
        sentences.append(f"A figure with {AS_GOOD}: the best, or these seeds show no difference from it.")
        sentences.append("Intervals: 95 % for all rule sets at once.")
    return " ".join(sentences)


def _front(result: ExperimentResult) -> set[str]:
    """Return the rule sets that none beats in both visits and time."""
    comparison = result.comparison()
    return {one.rule_set for one, _ in comparison.front(comparison.instance_sets[-1], *comparison.fronts[0])}


def share(found: Interval) -> str:
    """Return a relative difference in whole percent with its interval, if it has one: `-39 % [-44, -34]`."""
    if found.mean is None:
        return NONE
    shown = f"{_signed(found.mean)} %"
    if found.low_holm is None or found.high_holm is None:
        return shown
    return f"{shown} [{_signed(found.low_holm)}, {_signed(found.high_holm)}]"


def _signed(part: float) -> str:
    return f"{100 * part:+.0f}".replace("-", MINUS) if round(100 * part) else "0"


def more(found: Interval, less: str, what: str) -> str:
    """Return a relative difference in words: `59 % [37, 81] more time`; a negative one is ``less``."""
    sign = -1 if (found.mean or 0) < 0 else 1
    ends = (found.low_holm, found.high_holm)[::sign]
    mean, *interval = (None if end is None else f"{100 * sign * end:.0f}" for end in (found.mean, *ends))
    shown = f"{mean} %" if None in interval else f"{mean} % [{', '.join(map(_minus, interval))}]"
    return f"{shown} {'more' if sign > 0 else less} {what}"


def _minus(number: str | None) -> str:
    return "0" if number in ("-0", None) else number.replace("-", MINUS)


def sentences_of(found: Sequence[Best], seeds: int, *, repeats: bool = False) -> Iterator[str]:
    """Yield which rule set to take, in a sentence, and what the runs leave open.

    Parameters
    ----------
    found
        The best in visits, and in time.
    seeds
        How many runs there are of each rule set.
    repeats
        Whether these are the same run.
    """
    if len(found) < 2:
        yield "No rule set completes all of its runs, so there is nothing to advise."
        return
    if repeats:
        few, soon = found[0].least, found[-1].least
        takes = "and takes" if few == soon else f"and {_named(soon)} takes"
        yield f"In this run {_named(few)} makes the fewest visits {takes} the least time. {REPEATS}"
        return
    if seeds < FEWEST_SEEDS:
        number = counted(seeds, "seed")
        yield f"{number} cannot show a difference between rule sets: take {FEWEST_SEEDS} or more with --seeds."
        return
    fewest, soonest = found[0], found[-1]
    alike = [name for name in soonest.names if name in fewest.names]
    both = [name for name in alike if name.endswith(OWN) or name in (fewest.least, soonest.least)]
    quick, few = soonest.take, fewest.take
    own = any(name.endswith(OWN) for name in soonest.against)
    shown = f"{counted(seeds, 'seed')} show{'s' if seeds == 1 else ''} no difference between the rule sets"
    if len(soonest.against) == 1:
        yield f"Only {_plain(quick)} completes all of its runs, so there is nothing to compare it with."
    elif len(alike) == len(soonest.against):
        yield f"Keep your rules: {shown}; more --seeds may." if own else f"{shown} that complete all of their runs."
    elif both:
        take = next((f"Keep {_plain(name)}" for name in both if name.endswith(OWN)), f"Take {both[0]}")
        yield f"{take}: no other rule set is shown to make fewer visits or to take less time."
        if take == f"Take {both[0]}" and own:
            time, visits = (one.now[both[0]].relative for one in (soonest, fewest))
            says = f"takes {more(time, 'less', 'time')} and makes {more(visits, 'fewer', 'visits')}"
            yield f"Against your rules it {says}."
    else:
        yield (
            f"Take {_named(quick)} where orders have to leave soon, {_named(few)} where each pod visit costs: "
            f"the second takes {more(soonest.against[few].relative, 'less', 'time')}, "
            f"the first makes {more(fewest.against[quick].relative, 'fewer', 'visits')}."
        )
    if not own:
        yield "Your own rules do not complete all of their runs."


def _named(name: str) -> str:
    return f"{_plain(name)} (as now)" if name.endswith(OWN) else name


def _plain(name: str) -> str:
    return name.removesuffix(OWN)


def content_of(result: ExperimentResult, found: Sequence[Best], notes: Sequence[str]) -> dict[str, Any]:
    """Return the answer as plain values."""
    comparison = result.comparison()
    front, now = _front(result), comparison.baseline.endswith(OWN)
    rows: list[dict[str, Any]] = []
    for name in comparison.rule_sets:
        changes = next(one.changes for one in result.experiment.rule_sets if one.name == name)
        row: dict[str, Any] = {"rule_set": name, "set": dict(changes), "front": name in front}
        for metric in comparison.metrics:
            one = _whole(comparison, metric).get(name)
            row[metric] = one and one.mean
            row[f"{metric}_relative"] = one and [
                getattr(one.relative, end) if now else None for end in ("mean", "low_holm", "high_holm")
            ]
        rows.append(row)
    return {
        "seeds": list(result.experiment.seeds),
        "rule_sets": rows,
        "best": {one.metric: list(one.names) for one in found},
        "notes": list(notes),
        "errors": [{name: row[name] for name in ("rule_set", "seed", "error")} for row in result.failed],
    }
