"""The search: values that a sampler proposes, run on common seeds, and given up as soon as they are surely worse.

Optuna's tree-structured Parzen estimator proposes (Bergstra et al. 2011, Algorithms for hyper-parameter optimization,
NeurIPS 24; for several objectives Ozaki et al. 2022, https://doi.org/10.1613/jair.1.13188). A trial begins with a few
of the seeds and goes on with more (`looks`); one that a finished trial beats in every objective is given up, as in
racing (Maron and Moore 1994, Hoeffding races, NeurIPS 6) with a one-sided paired t test. Proposals come in batches of
a fixed size and finished runs are stored: a search that is repeated, with any number of workers, makes the same
trials, and none of its runs twice. Optuna rather than SMAC3: it is asked for values and told of results in batches, for
one or several objectives, and is pure Python.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import product
from math import prod
from pathlib import Path
from statistics import fmean
from typing import TYPE_CHECKING, Any

from attrs import define, field, frozen

from rmfs_commands.details.catalogue import better
from rmfs_commands.experiments import Axis, Base, Experiment, RuleSetChoice, Watcher, run_experiment
from rmfs_commands.experiments.compare import CATALOGUE, COUNTED
from rmfs_commands.experiments.workers import Workers
from rmfs_commands.results.figures import TIMING
from rmfs_commands.sizing.judging import looks
from rmfs_commands.tuning.space import Parameter, Space, Values
from rmfs_core.errors import InputError, RunError
from rmfs_core.scenario import Scenario
from rmfs_core.wording import did_you_mean

if TYPE_CHECKING:
    import optuna

BATCH = 4
"""Trials that are proposed at a time, whatever number of workers there are."""
STARTING = 12
"""Trials at random values before the sampler learns from them."""
SURELY = 0.05
"""A trial is given up where the p-value of being worse is below this."""
SIGNS = {"less": 1, "more": -1}
DIGITS = 4
"""Of a number that is tried, so that a scenario can be read."""
MOST_REPEATS = 25
"""Batches in a row without a new trial, after which a search ends: there is nothing else to try."""


@define(eq=False)
class Trial:
    """Values that were tried.

    Parameters
    ----------
    number
        From 1; 0 is the scenario as it is.
    values
        By key of the parameter.
    figures
        One a seed so far, for each objective.
    problem
        Why there are no figures of some run.
    given_up
        Whether it was left before its last seed.
    """

    number: int
    values: Values
    figures: list[list[float]] = field(factory=list)
    problem: str | None = None
    given_up: bool = False

    @property
    def seeds(self) -> int:
        """Seeds that were run."""
        return len(self.figures[0]) if self.figures else 0

    @property
    def means(self) -> list[float]:
        """Mean of each objective over these."""
        return [fmean(of_seeds) for of_seeds in self.figures]


@frozen(eq=False)
class Search:
    """A search for values of parameters.

    Parameters
    ----------
    scenario, name
        The scenario, and its name in messages.
    space
        The parameters.
    objectives
        Names of the metrics.
    signs
        1 for a metric of which less is better, else -1.
    seeds
        One run of a trial for each.
    runs
        Most runs of all trials, stored ones included.
    store
        Folder of finished runs.
    workers
        Who runs them.
    watcher
        Is told of single runs.
    tell
        Is told of every trial that is over.
    allow_inline_rules
        Whether code may be loaded from files.
    sampler_seed
        Of what is proposed; None: the scenario's seed.
    axes
        Keys of the scenario that vary: a figure of a seed is the mean over all instances.
    """

    scenario: Scenario
    name: str
    space: Space
    objectives: tuple[str, ...]
    signs: tuple[int, ...]
    seeds: tuple[int, ...]
    runs: int
    store: Path
    workers: Workers
    watcher: Watcher
    tell: Callable[[Trial], None]
    allow_inline_rules: bool = True
    sampler_seed: int | None = None
    axes: tuple[Axis, ...] = ()

    @property
    def instances(self) -> int:
        """Number of instances, each a run of a trial on a seed."""
        return prod(len(axis.points) for axis in self.axes)

    def trials(self) -> list[Trial]:
        """Return all trials, the scenario's own values first.

        Raises
        ------
        InputError
            When runs have no such metric, or the scenario's own runs do not count.
        """
        own = Trial(0, {})
        self._run([own], len(self.seeds))
        if own.problem is not None:
            raise RunError(f"the scenario's own values give nothing to compare with: {own.problem}")
        self.tell(own)
        found, used, repeats = [own], len(self.seeds) * self.instances, 0
        distributions = {one.key: _distribution(one) for one in self.space.parameters}
        study, done = self._study(), dict[str, Trial]()
        if all(one.holds_now for one in self.space.parameters):
            now = {one.key: _alike(one.now, one) for one in self.space.parameters}
            done[repr(now)] = own
            study.add_trial(_told(now, distributions, len(self.objectives)))
        first = looks(len(self.seeds))[0] * self.instances
        listed = prod(len(one.choices) for one in self.space.parameters)  # 0 where numbers have a range
        if 0 < listed * first <= self.runs - used:
            for row in product(*(one.choices for one in self.space.parameters)):
                study.enqueue_trial(dict(zip(distributions, row, strict=True)))
        while (size := min(BATCH, (self.runs - used) // first)) > 0 and repeats < MOST_REPEATS:
            asked = [study.ask(distributions) for _ in range(size)]
            batch: list[Trial] = []
            for one in asked:
                values = {key: _rounded(value) for key, value in one.params.items()}
                if (key := repr(values)) not in done:
                    done[key] = Trial(len(found) + len(batch), values)
                    batch.append(done[key])
            used += self._race(batch, found, self.runs - used)
            repeats = 0 if batch else repeats + 1
            for one in asked:
                trial = done[repr({key: _rounded(value) for key, value in one.params.items()})]
                self._learn(study, one, trial, own)
        return found

    def _race(self, batch: list[Trial], found: list[Trial], left: int) -> int:
        """Run trials until each is finished, given up or has a problem; return how many runs that took."""
        racing, used = batch, 0
        finished = [one for one in found if one.seeds == len(self.seeds)]
        for n_seeds in looks(len(self.seeds)):
            wanted = sum(n_seeds - one.seeds for one in racing) * self.instances
            if used + wanted > left:
                for one in racing:
                    one.given_up = True
                break
            used += wanted
            self._run(racing, n_seeds)
            racing = [one for one in racing if one.problem is None]
            if n_seeds < len(self.seeds):
                for one in racing:
                    one.given_up = any(self.is_worse(one, other) for other in finished)
                racing = [one for one in racing if not one.given_up]
        for one in batch:
            self.tell(one)
        found += batch
        return used

    def is_worse(self, one: Trial, other: Trial) -> bool:
        """Whether one trial is surely worse than another in every objective, over the seeds of both."""
        from scipy.stats import ttest_1samp  # imported here: it takes a while

        for sign, own, others in zip(self.signs, one.figures, other.figures, strict=True):
            differences = [sign * (a - b) for a, b in zip(own, others, strict=False)]
            if min(differences) == max(differences):
                if differences[0] <= 0:
                    return False
            elif not ttest_1samp(differences, 0.0, alternative="greater").pvalue < SURELY:
                return False
        return True

    def _run(self, trials: Sequence[Trial], n_seeds: int) -> None:
        """Run the first seeds of trials, and keep their figures, or why there are none."""
        named = {str(trial.number): trial for trial in trials if self._fits(trial)}
        if not named:
            return
        rows = run_experiment(
            self._experiment(named, n_seeds),
            store=self.store,
            workers=self.workers,
            watcher=self.watcher,
            allow_inline_rules=self.allow_inline_rules,
        ).rows
        for name, trial in named.items():
            own = [row for row in rows if row["rule_set"] == name]
            for row in own:
                lacking = [metric for metric in self.objectives if row.get(metric) is None]
                if row["status"] not in COUNTED or lacking:
                    why = row.get("error") or (f"no {lacking[0]}" if lacking else row["status"])
                    if row.get("error_kind") == "VersionError":  # no answer about any values
                        raise RunError(f"{why}; the same command goes on with the finished runs that are of one code")
                    trial.problem = f"seed {row['seed']}: {why}"
                    break
            else:
                trial.figures = [
                    [fmean(row[metric] for row in own if row["seed"] == seed) for seed in self.seeds[:n_seeds]]
                    for metric in self.objectives
                ]

    def _fits(self, trial: Trial) -> bool:
        """Whether the rules take a trial's values together; if not, keep why."""
        if trial.values and not trial.seeds:
            try:
                self._experiment({str(trial.number): trial}, 1).jobs(allow_inline_rules=self.allow_inline_rules)
            except InputError as error:
                trial.problem = str(error)
        return trial.problem is None

    def _experiment(self, trials: dict[str, Trial], n_seeds: int) -> Experiment:
        return Experiment(
            name="tune",
            bases=(Base(self.name, self.scenario),),
            rule_sets=tuple(RuleSetChoice(name, self.space.changes(one.values)) for name, one in trials.items()),
            seeds=self.seeds[:n_seeds],
            baseline=next(iter(trials)),
            axes=self.axes,
            metrics=self.objectives,
            folder=self.scenario.folder,
            place=self.name,
            metrics_place="--objective",
        )

    def _study(self) -> optuna.Study:
        """Return a study of Optuna that proposes values and knows nothing yet."""
        import optuna

        optuna.logging.set_verbosity(optuna.logging.WARNING)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
            seed = self.scenario.seed if self.sampler_seed is None else self.sampler_seed
            sampler = optuna.samplers.TPESampler(
                n_startup_trials=STARTING, multivariate=True, constant_liar=True, seed=seed
            )
        return optuna.create_study(directions=["minimize"] * len(self.objectives), sampler=sampler)

    def _learn(self, study: optuna.Study, asked: optuna.Trial, trial: Trial, own: Trial) -> None:
        """Tell the sampler by how much a trial differs from the scenario's own values, on its seeds."""
        import optuna

        if trial.problem is not None or not trial.seeds:
            study.tell(asked, state=optuna.trial.TrialState.FAIL)
            return
        pairs = zip(self.signs, trial.figures, own.figures, strict=True)
        study.tell(asked, [sign * fmean(a - b for a, b in zip(x, y, strict=False)) for sign, x, y in pairs])

    def best(self, trials: Sequence[Trial], most: int) -> list[Trial]:
        """Return the finished trials that none beats in all objectives: the best, or a front by the first objective.

        Parameters
        ----------
        trials
            All of them.
        most
            How many of a front: its ends, and others in even steps.
        """
        finished = [one for one in trials if one.seeds == len(self.seeds) and one.problem is None]
        scored = [([sign * mean for sign, mean in zip(self.signs, one.means, strict=True)], one) for one in finished]
        scored.sort(key=lambda entry: (entry[0], entry[1].number))
        front: list[tuple[list[float], Trial]] = []
        for score, one in scored:
            if not any(all(a <= b for a, b in zip(other, score, strict=True)) for other, _ in front):
                front.append((score, one))
        kept = [one for _, one in front]
        if len(kept) <= most:
            return kept
        return [kept[round(i * (len(kept) - 1) / (most - 1))] for i in range(most)]


def objectives_of(texts: Iterable[str]) -> dict[str, int]:
    """Return the metrics that texts name, each with 1 where less of it is better, else -1.

    Parameters
    ----------
    texts
        ``turnover_s``, or ``my_metric=more`` where nobody knows.

    Raises
    ------
    InputError
        When it is not said which way is better, and not known, or when it is measured by the clock.
    """
    found = {}
    for text in texts:
        name, equals, way = text.partition("=")
        if name.startswith("hook_s.") or name in (metric.name for metric in TIMING):
            raise InputError(
                "--objective", f"expected a metric of the simulation, found {name}, of the computer's clock"
            )
        way = way if equals else better(name) or ""
        if way not in SIGNS:
            near = "" if name in CATALOGUE else did_you_mean(name, CATALOGUE)
            problem = f"it is not known whether more or less of `{name}`{near} is better"
            raise InputError("--objective", f"{problem}; expected {name}=less or {name}=more, found {text}")
        found[name] = SIGNS[way]
    return found


def _distribution(one: Parameter) -> optuna.distributions.BaseDistribution:
    from optuna import distributions

    if one.low is None or one.high is None:
        return distributions.CategoricalDistribution(one.choices)
    if one.whole:
        return distributions.IntDistribution(int(one.low), int(one.high), log=one.log)
    return distributions.FloatDistribution(one.low, one.high, log=one.log)


def _alike(value: Any, one: Parameter) -> Any:
    """Return a scenario's value as the sampler proposes it: a number of a range of numbers is no whole one."""
    return value if one.low is None or one.whole else float(value)


def _told(values: Values, distributions: Mapping[str, Any], objectives: int) -> optuna.trial.FrozenTrial:
    """Return the scenario's own values as a trial that differs from them by 0."""
    import optuna

    return optuna.trial.create_trial(params=dict(values), distributions=dict(distributions), values=[0.0] * objectives)


def _rounded(value: Any) -> Any:
    return float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value
