"""An experiment from start to end: what is not stored yet is run, and all rows are put together."""

from __future__ import annotations

from collections.abc import Generator, Iterable
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from contextlib import closing, nullcontext
from pathlib import Path

from attrs import field, frozen

from rmfs_commands.experiments.bounds import add_bounds
from rmfs_commands.experiments.compare import CATALOGUE, LEFT, Comparison, summary
from rmfs_commands.experiments.experiment import Experiment, Job
from rmfs_commands.experiments.outcome import Outcome
from rmfs_commands.experiments.rows import Row, labels, row_without_result
from rmfs_commands.experiments.store import RunStore
from rmfs_commands.experiments.watching import Watcher
from rmfs_commands.experiments.workers import WorkerDiedError, Workers
from rmfs_commands.instances.csv_files import warn
from rmfs_core.errors import InputError
from rmfs_core.results.catalogue import Metric
from rmfs_core.scenario import Scenario


@frozen(eq=False)
class ExperimentResult:
    """Outcome of an experiment.

    Parameters
    ----------
    experiment
        The experiment that was run.
    rows
        One a run, in the order of `Experiment.jobs`: labels, ``status``, ``error``, every metric and timing figure.
        A figure is missing where the run ended without a result.
    versions
        Versions of everything that took part in some run, by name.
    computed
        How many runs were computed now; the others were stored already.
    measures
        Metrics that observers describe, by name.
    fixed
        Instances whose orders are the same for every seed, as they come from a file.
    scenarios
        The scenario of each instance and rule set; its seed does not count.
    """

    experiment: Experiment
    rows: list[Row] = field(repr=False)
    versions: dict[str, str] = field(factory=dict, repr=False)
    computed: int = 0
    measures: dict[str, Metric] = field(factory=dict, repr=False)
    fixed: frozenset[str] = frozenset()
    scenarios: dict[tuple[str, str], Scenario] = field(factory=dict, repr=False)

    @property
    def failed(self) -> list[Row]:
        """Rows of the runs that failed."""
        return [row for row in self.rows if row["status"] == "failed"]

    @property
    def repeats(self) -> bool:
        """Whether each rule set has the same figures on all of several seeds: more of them tell nothing."""
        figures: dict[tuple[object, object], set[tuple[object, ...]]] = {}
        for row in (row for row in self.rows if row["status"] != "failed"):
            found = tuple(row.get(metric) for metric in self.experiment.metrics)
            figures.setdefault((row["instance"], row["rule_set"]), set()).add(found)
        return len(self.experiment.seeds) > 1 and {len(found) for found in figures.values()} == {1}

    def table(self) -> dict[str, list[object]]:
        """Return the rows as columns, every column of the same length, None where a run has no such figure."""
        names = list(dict.fromkeys(name for row in self.rows for name in row))
        return {name: [row.get(name) for row in self.rows] for name in names}

    def comparison(self) -> Comparison:
        """Return the rule sets compared with the baseline, as the experiment asks; with orders left, where some are.

        Raises
        ------
        InputError
            When it asks for a metric that no run has measured, though not all of them failed.
        """
        one = self.experiment
        if len(self.failed) < len(self.rows):
            one.check_metrics({*CATALOGUE, *self.measures, *_metrics(self.rows)})
        by = one.by or ("instance",)
        ended = [row for row in self.rows if row["status"] == "horizon"]
        left = [name for name in LEFT if any(name in row for row in ended)]
        return summary(
            self.rows,
            one.baseline,
            tuple(dict.fromkeys((*one.metrics, *left))),
            by=by,
            measures=self.measures,
            fronts=one.fronts,
            fixed=self.fixed,
        )


def run_experiment(
    experiment: Experiment,
    *,
    store: str | Path,
    jobs: int | None = None,
    dask: str | None = None,
    watcher: Watcher | None = None,
    allow_inline_rules: bool = True,
    bounds: bool = False,
    workers: Workers | None = None,
) -> ExperimentResult:
    """Run what is not stored yet; return all rows.

    Every run is stored as soon as it is finished. One whose files are not as they were stored is run again. A run
    whose worker dies is repeated once, then it is a failed row; it is not stored, nor is one that ended without a
    result, so that they are tried again the next time. Runs that a rule's misbehaviour ended are stored: they would end
    the same way again.

    Parameters
    ----------
    experiment
        The experiment to run.
    store
        Folder of finished runs; one folder a run. Several experiments may share it: the same run is computed once.
    jobs
        Runs at a time; None: one for each core.
    dask
        Address of a Dask scheduler (``tcp://host:8786``) whose workers run them instead; ``jobs`` is then how many are
        handed over at a time, two for each thread of the cluster if None.
    watcher
        Is told what happens.
    allow_inline_rules
        Whether code may be loaded from ``./file.py:Class`` rules.
    bounds
        Whether the rows have what no rules can beat, too: ``bound.psv_per_order`` next to ``psv_per_order``.
    workers
        Who runs them, instead of workers of its own (see `open_workers`): for one experiment after another. They are
        closed when it ends early.

    Raises
    ------
    InputError
        When a scenario is wrong, or the store cannot be written to; before anything is run. When the comparison asks
        for a metric that nobody measures: as soon as there is a run of all observers that measure something.
    RunError
        When the Dask scheduler is lost.
    KeyboardInterrupt
        As it came; what finished is stored.
    """
    watcher = watcher or Watcher()
    all_jobs = experiment.jobs(allow_inline_rules=allow_inline_rules)
    different = {job.key: job for job in all_jobs}
    runs = RunStore(store)
    rows: dict[str, Row] = {}
    expected = _Expected(experiment, all_jobs)
    for job in different.values():
        row = _stored(job, runs, watcher)
        if row is not None:
            rows[job.key] = row
            expected.see(job, row)
    order = {seed: place for place, seed in enumerate(experiment.seeds)}
    todo = [job for job in different.values() if job.key not in rows]
    todo.sort(key=lambda job: order[job.seed])  # so that the first tell how long all take
    if todo:
        with (
            nullcontext(workers) if workers else closing(open_workers(jobs, dask, len(todo))) as slots,
            closing(_outcomes(todo, slots, watcher)) as outcomes,
        ):
            watcher.started(len(different), len(rows), slots.count)
            try:
                for job, outcome in outcomes:
                    for told in outcome.warnings:
                        warn(told)
                    rows[job.key] = row = _row(job, runs, outcome)
                    watcher.run_finished(job, row)
                    expected.see(job, row)
            finally:
                watcher.ended()
    all_rows = [rows[job.key] if different[job.key] is job else rows[job.key] | labels(job) for job in all_jobs]
    if bounds:
        add_bounds(all_jobs, all_rows, runs.folder, watcher)
    versions = {name: version for job in all_jobs for name, version in job.versions.items()}
    measures = {name: metric for job in all_jobs for name, metric in job.measures.items()}
    files = [(job.instance, job.scenario.instance) for job in all_jobs]
    fixed = frozenset(name for name, given in files if given.orders_file is not None and given.scale is None)
    scenarios = {(job.instance, job.rule_set): job.scenario for job in all_jobs}
    sorted_versions = dict(sorted(versions.items()))
    return ExperimentResult(experiment, all_rows, sorted_versions, len(todo), measures, fixed, scenarios)


def _stored(job: Job, runs: RunStore, watcher: Watcher) -> Row | None:
    """Return the row of a run that is there as it was stored; who watches is told of one that is not."""
    if job not in runs:
        return None
    try:
        return runs.row(job)
    except InputError as problem:
        watcher.run_dropped(job, str(problem))
        return None


class _Expected:
    """Metrics that are compared but not yet known: what observers measure is seen when a run of theirs is finished."""

    def __init__(self, experiment: Experiment, jobs: Iterable[Job]) -> None:
        self._experiment = experiment
        self._unseen = {repr(job.scenario.rules) for job in jobs if job.observed}
        self._known = {*CATALOGUE, *(name for job in jobs for name in job.measures)}

    def see(self, job: Job, row: Row) -> None:
        """Look at a finished run; when it is the last that was waited for, raise InputError for an unknown metric."""
        if row["status"] == "failed" or not job.observed or repr(job.scenario.rules) not in self._unseen:
            return
        self._unseen.discard(repr(job.scenario.rules))
        self._known |= _metrics([row])
        if not self._unseen:
            self._experiment.check_metrics(self._known)


def _metrics(rows: Iterable[Row]) -> set[str]:
    return {name for row in rows for name in row if name.isidentifier()}


def open_workers(jobs: int | None = None, dask: str | None = None, runs: int | None = None) -> Workers:
    """Return workers as `run_experiment` has them, for no more than so many runs at a time; who asks closes them."""
    # Imported here, since only a process that runs something needs them.
    if dask is not None:
        from rmfs_commands.experiments.cluster import ClusterWorkers

        return ClusterWorkers(dask, jobs)
    from joblib import cpu_count

    from rmfs_commands.experiments.local import LocalWorkers

    count = jobs or cpu_count()
    return LocalWorkers(count if runs is None else min(runs, count))


def _outcomes(todo: list[Job], workers: Workers, watcher: Watcher) -> Generator[tuple[Job, Outcome], None, None]:
    """Yield each job with what came of it as soon as it is there; a caller that stops asking stops the workers."""
    with ThreadPoolExecutor(workers.count) as threads:
        jobs: dict[Future[Outcome], Job] = {threads.submit(_attempt, job, workers, watcher): job for job in todo}
        try:
            for future in as_completed(list(jobs)):
                yield jobs.pop(future), future.result()
        finally:
            threads.shutdown(wait=False, cancel_futures=True)
            if jobs:
                workers.close()  # threads that still wait for a worker learn that it is gone


def _attempt(job: Job, workers: Workers, watcher: Watcher) -> Outcome:
    """Run a job; once more when its worker dies."""
    watcher.run_started(job)
    try:
        return workers.run(job)
    except WorkerDiedError as died:
        if died.repeated or workers.closed:
            return _given_up(died)
        watcher.run_repeated(job, str(died))
    try:
        return workers.run(job)
    except WorkerDiedError as died:
        return _given_up(died)


def _given_up(died: WorkerDiedError) -> Outcome:
    return Outcome(None, f"{died}; given up after the repetition", type(died).__name__)


def _row(job: Job, runs: RunStore, outcome: Outcome) -> Row:
    """Store what came of a run, if it has a result; return its row, the same as if it were read from the store."""
    if outcome.result is not None:
        return runs.save(job, outcome)
    return row_without_result(job, outcome.error or "", outcome.error_kind or "")
