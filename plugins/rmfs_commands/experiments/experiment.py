"""An experiment, and the runs that it consists of."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from attrs import evolve, field, frozen

from rmfs_commands.experiments.compare import CATALOGUE
from rmfs_commands.experiments.keys import run_key
from rmfs_commands.experiments.resolving import Changes, located_in, resolve
from rmfs_commands.experiments.sources import sources_of
from rmfs_commands.results.recorders import make_observers
from rmfs_core.errors import InputError
from rmfs_core.results.catalogue import Metric, described_by
from rmfs_core.results.running import versions_of
from rmfs_core.rules import RuleSet
from rmfs_core.scenario import Scenario
from rmfs_core.scenario.rulenames import is_inline, rule_choices
from rmfs_core.wording import did_you_mean, listed, nearest

DEFAULT_METRICS = ("psv_per_order", "pile_on", "distance_per_order_m", "turnover_s", "makespan_s", "picker_utilisation")
PACKING_METRICS = ("packed_s", "consolidation_s", "boxes_max", "packer_utilisation_percent")
SECTION_METRICS = {
    "packing": PACKING_METRICS,
    "instance.departures": ("missed_percent",),
    "costs": ("cost_per_order",),
}
"""Besides, where a scenario has such a section."""
HORIZON_METRICS = ("orders_per_hour", "picks_per_hour", *(name for name in DEFAULT_METRICS if name != "makespan_s"))
"""Those of runs that end at ``run.until_s``, and have no makespan."""
LABELS = ("instance", "scenario", "rule_set", "seed", "status", "error", "error_kind", "key", "run_s")
QUICK_SEEDS = 2
"""Seeds of the quick part of an experiment."""


@frozen
class Base:
    """A scenario that an experiment starts from.

    Parameters
    ----------
    name
        Its name in the table.
    scenario
        The scenario; its own seed does not count.
    """

    name: str
    scenario: Scenario


@frozen
class AxisPoint:
    """One value of an axis.

    Parameters
    ----------
    label
        How messages and tables name it.
    value
        Value in the axis's column of a run's row: the value itself, or the label where it is a table or a list.
    changes
        The scenario keys that it sets.
    """

    label: str
    value: Any
    changes: Changes


@frozen
class Axis:
    """Something that is varied: one scenario key, or several together.

    Parameters
    ----------
    name
        The scenario key (``instance.orders``), or a name of its own where the points set several keys.
    points
        Its values.
    """

    name: str
    points: tuple[AxisPoint, ...]


@frozen
class RuleSetChoice:
    """One of the rule sets to compare.

    Parameters
    ----------
    name
        Its name in tables.
    changes
        The scenario keys that it sets; mostly ``rules.*``.
    """

    name: str
    changes: Changes = field(factory=dict)


@frozen
class Job:
    """One run of an experiment.

    Parameters
    ----------
    instance
        Base scenario and axis values as one text: runs of the same instance and seed see the same orders and pods.
    rule_set
        Name of the rule set.
    seed
        Seed of the run.
    axes
        Value of every axis by its name, and the base's name as ``scenario``.
    scenario
        The resolved scenario, seed included.
    versions
        Versions of everything that takes part, as in result.json.
    key
        Hash of resolved scenario (with the contents of the files it names), seed, versions and sources.
    measures
        Metrics that its observers describe, by name.
    observed
        Whether it has observers that measure something.
    sources
        Digests of the code of everything that takes part, by import package.
    """

    instance: str
    rule_set: str
    seed: int
    axes: Mapping[str, Any]
    scenario: Scenario
    versions: Mapping[str, str]
    key: str
    measures: Mapping[str, Metric] = field(factory=dict)
    observed: bool = False
    sources: Mapping[str, str] = field(factory=dict, repr=False)

    def __str__(self) -> str:
        return f"{self.instance}, {self.rule_set}, seed {self.seed}"


@frozen
class _Loaded:
    """Descriptions of the rules of some runs."""

    versions: dict[str, str]
    measures: dict[str, Metric]
    observed: bool
    sources: dict[str, str]


@frozen
class Experiment:
    """Every base at every combination of axis points, under every rule set, with every seed.

    Parameters
    ----------
    name, description
        For people; the name is that of the output folder too.
    bases
        Scenarios to start from.
    rule_sets
        The subjects of the comparison.
    seeds
        One run for each; common to all rule sets (common random numbers).
    baseline
        Name of the rule set that the others are compared with.
    axes
        Keys that vary, with their values.
    metrics
        Which figures the comparison shows, of the kernel or of an observer.
    by
        Names of axes (or ``scenario``) whose values tell the instance sets of the comparison apart; none: each
        instance is a set of its own.
    fronts
        Pairs of metrics, both among ``metrics``: of each, the comparison shows which rule sets none beats in both.
    folder
        Where files that rule sets and axes name are looked up.
    place
        Its name in messages: its file.
    metrics_place
        Name of its metrics in messages, if it is not ``place`` and ``metrics``.

    Raises
    ------
    InputError
        When something is missing or there twice; the place is the key that is wrong.
    """

    name: str
    bases: tuple[Base, ...]
    rule_sets: tuple[RuleSetChoice, ...]
    seeds: tuple[int, ...]
    baseline: str
    axes: tuple[Axis, ...] = ()
    description: str = ""
    metrics: tuple[str, ...] = DEFAULT_METRICS
    by: tuple[str, ...] = ()
    fronts: tuple[tuple[str, str], ...] = ()
    folder: str = "."
    place: str = "experiment"
    metrics_place: str | None = None

    def __attrs_post_init__(self) -> None:
        names = [rule_set.name for rule_set in self.rule_sets]
        _check_distinct("scenarios", [base.name for base in self.bases])
        _check_distinct("rule_sets", names)
        _check_distinct("seeds", self.seeds)
        _check_distinct("metrics", self.metrics)
        for axis in self.axes:
            _check_distinct(f"axes.{axis.name}", [point.label for point in axis.points])
        if self.baseline not in names:
            raise InputError("baseline", f'there is no rule set "{self.baseline}"{nearest(self.baseline, names)}')
        axes = ["scenario", *(axis.name for axis in self.axes)]
        for name in self.by:
            if name not in axes:
                raise InputError("by", f'there is no axis "{name}"{nearest(name, axes)}')
        for metric in itertools.chain(*self.fronts):
            if metric not in self.metrics:
                raise InputError("fronts", f'"{metric}" is not one of `metrics`{nearest(metric, self.metrics)}')
        self._check_axes()

    def quick(self) -> Experiment:
        """Return a small part of it, to look at before it is run: two seeds, and the first value of each axis."""
        axes = tuple(evolve(axis, points=axis.points[:1]) for axis in self.axes)
        return evolve(self, axes=axes, seeds=self.seeds[:QUICK_SEEDS])

    def _check_axes(self) -> None:
        """Refuse an axis called like a column of the table, and a key that is set twice."""
        self._check_columns((*LABELS, *CATALOGUE, *self.metrics))
        setters: dict[str, str] = {}
        for axis in self.axes:
            for key in dict.fromkeys(key for point in axis.points for key in point.changes):
                if key in setters:
                    raise InputError(f"axes.{axis.name}", f"sets `{key}`, which axis {setters[key]} sets too")
                setters[key] = axis.name
        for rule_set in self.rule_sets:
            for key in rule_set.changes:
                if key in setters:
                    raise InputError(
                        "rule_sets", f'"{rule_set.name}" sets `{key}`, which is an axis; leave one of them out'
                    )

    def _check_columns(self, columns: Collection[str]) -> None:
        for axis in self.axes:
            if axis.name in columns:
                raise InputError(f"axes.{axis.name}", "the summary has a column of that name; expected another name")

    def jobs(self, *, allow_inline_rules: bool = True) -> list[Job]:
        """Return every run, by instance, rule set and seed.

        Parameters
        ----------
        allow_inline_rules
            Whether code may be loaded from ``./file.py:Class`` rules.

        Raises
        ------
        InputError
            When a rule set or an axis makes a scenario wrong; base, axis values and rule set are named. When a metric
            is unknown, and there is no rule or observer that measures something.
        """
        found: list[Job] = []
        standing = [observer for observer, _ in make_observers(quiet=True)]
        of_all = described_by(standing)
        self._check_columns(of_all)
        loaded: dict[tuple[str, ...], _Loaded] = {}  # most have the same rules
        times: dict[str, Scenario] = {}
        for instance, base, points in self._instances():
            values = {"scenario": base.name} | {a.name: p.value for a, p in zip(self.axes, points, strict=True)}
            for rule_set in self.rule_sets:
                place = f'{self.place}, rule set "{rule_set.name}" on {instance}'
                changes: dict[str, Any] = {}
                for point in points:
                    changes |= point.changes
                changes |= rule_set.changes
                scenario = resolve(base.scenario, changes, self.folder, place)
                files, generator = scenario.instance.orders_file, scenario.instance.generator
                chosen = (repr(scenario.rules), scenario.folder, repr((files is None, generator)))
                _check_times(times.setdefault(instance, scenario), scenario, place)
                with located_in(place):
                    if chosen not in loaded:
                        rules = RuleSet.load(scenario.rules, scenario.folder, allow_inline=allow_inline_rules)
                        observed = bool(rules.pm.hook.measured.get_hookimpls())
                        measures = of_all | described_by(rules.instances)
                        versions = versions_of(rules, scenario)
                        loaded[chosen] = _Loaded(versions, measures, observed, sources_of(rules, scenario))
                    code = loaded[chosen]
                    key = run_key(scenario, code.versions, code.sources)
                for seed in self.seeds:
                    of_seed = scenario.with_seed(seed), code.versions, key(seed)
                    of_rules = code.measures, code.observed, code.sources
                    found.append(Job(instance, rule_set.name, seed, values, *of_seed, *of_rules))
        unseen = self.metrics if any(code.observed for code in loaded.values()) else ()
        self.check_metrics({*CATALOGUE, *of_all, *unseen})
        return found

    def check_metrics(self, known: Collection[str]) -> None:
        """Raise `InputError` when a metric is unknown."""
        known = {*known} - {*LABELS}
        for metric in self.metrics:
            if metric not in known:
                own = "; runs.parquet has a column of that name, so an observer cannot measure it"
                problem = f'there is no metric "{metric}"{own if metric in LABELS else _near(metric, known)}'
                raise InputError(self.metrics_place or f"{self.place}, metrics", problem)

    def rule_files(self) -> list[str]:
        """Return the files that code will be loaded from: those of rules next to scenarios or the experiment."""
        named = [
            (base.scenario.folder, choice.rule)
            for base in self.bases
            for _, choice in rule_choices(base.scenario.rules)
        ]
        parts: list[AxisPoint | RuleSetChoice] = [point for axis in self.axes for point in axis.points]
        for part in [*parts, *self.rule_sets]:
            named += [(self.folder, name) for key, value in part.changes.items() for name in _rule_names(key, value)]
        files = (str(Path(folder) / name.rpartition(":")[0]) for folder, name in named if is_inline(name))
        return list(dict.fromkeys(files))

    def _instances(self) -> Iterator[tuple[str, Base, tuple[AxisPoint, ...]]]:
        """Yield label, base and points of every combination."""
        for base in self.bases:
            for points in itertools.product(*(axis.points for axis in self.axes)):
                labels = [point.label for point in points]
                parts = [base.name, *labels] if len(self.bases) > 1 or not labels else labels
                yield ", ".join(parts), base, points


def _check_times(first: Scenario, other: Scenario, place: str) -> None:
    """Refuse rule sets that are measured over different times: their figures cannot be compared."""
    for key in ("until_s", "warmup_s"):
        expected, found = getattr(first.run, key), getattr(other.run, key)
        if found != expected:
            problem = f"`run.{key}` is {found}, of the first rule set {expected}; expected the same of all rule sets"
            raise InputError(place, f"{problem} (set it in the scenario, or as an axis)")


def _rule_names(key: str, value: Any) -> Iterator[str]:
    """Yield the names of the rules that a scenario key's value selects."""
    if key.startswith("rules."):
        for choice in value if isinstance(value, list) else [value]:
            name = choice.get("rule") if isinstance(choice, Mapping) else choice
            if isinstance(name, str):
                yield name


def _near(metric: str, known: Collection[str]) -> str:
    """Return what else may be meant, or where to look: there are too many names for a message."""
    names = sorted(known)
    close = [f"`{name}`" for name in names if metric and metric in name][:3]
    found = f" (did you mean {listed(close, 'or')}?)" if close else "; `rmfs metrics` lists all"
    return did_you_mean(metric, names) or found


def _check_distinct(key: str, names: Sequence[object]) -> None:
    if not names:
        raise InputError(key, "expected at least one, found none")
    seen: set[object] = set()
    for name in names:
        if name in seen:
            raise InputError(key, f"found {name} twice; expected each once")
        seen.add(name)
