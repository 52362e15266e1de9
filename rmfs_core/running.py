"""Running a scenario from start to end: the library's front door."""

from __future__ import annotations

import hashlib
import os
import time
from collections.abc import Sequence
from pathlib import Path

from attrs import frozen

from rmfs_core.errors import InputError, RunError
from rmfs_core.files import output_folder
from rmfs_core.instance import make_instance
from rmfs_core.layout import make_layout
from rmfs_core.observers import Metrics, Tables, TraceWriter
from rmfs_core.plugins import RuleSet
from rmfs_core.results import DECISIONS_FILE, RESULT_FILE, TABLE_FILES, TRACE_FILE, Result
from rmfs_core.scenario import Scenario, load_scenario, located
from rmfs_core.simulation.engine import Simulation
from rmfs_core.states.recording import DecisionRecorder


def run(
    scenario: Scenario | str | Path,
    *,
    seed: int | None = None,
    overrides: Sequence[str] = (),
    out: str | Path | None = None,
    trace: bool = False,
    record_decisions: bool = False,
    observers: Sequence[object] = (),
    allow_inline_rules: bool = True,
) -> Result:
    """Simulate a scenario.

    Parameters
    ----------
    scenario
        A scenario, its file, or the name of a shipped one.
    seed
        Replaces the scenario's seed.
    overrides
        ``key=value`` each, replacing values of the file; not for a `Scenario` object (see `attrs.evolve`).
    out
        Folder to write the result's files to. Files of an earlier run there are replaced; its trace and decisions are
        deleted.
    trace
        Whether to record the event trace too, ``trace.jsonl.gz`` in ``out``.
    record_decisions
        Whether to record what each rule saw and decided too, ``decisions.jsonl.gz`` in ``out``.
    observers
        Objects whose ``@hookimpl`` methods are told of every event, besides those that the scenario names.
    allow_inline_rules
        Whether code may be loaded from ``./file.py:Class`` rules beside the scenario.

    Returns
    -------
    Result
        Status ``"complete"``, or ``"partial"`` when orders are left because ``run.until_s`` was reached or a keyboard
        interrupt ended the run (``result.interrupted``; it is not raised again).

    Raises
    ------
    InputError
        When something is wrong with the scenario or the arguments; before anything is simulated.
    RunError
        When a rule misbehaves or the run stands still. Its ``result`` has what was measured until then, status
        ``"failed"``, and is saved in ``out`` like any other.
    """
    for option, wanted in (("trace", trace), ("record_decisions", record_decisions)):
        if wanted and out is None:
            raise InputError(option, "what is recorded needs a folder to be written to; expected `out` with it")
    resolved = _resolve(scenario, seed, overrides)
    measured = _prepare(resolved, observers, allow_inline_rules)
    folder = None if out is None else _folder_for_results(out, resolved)
    writers: dict[str, TraceWriter | DecisionRecorder] = {}
    if folder is not None and trace:
        writers[TRACE_FILE] = TraceWriter(folder / TRACE_FILE)
    if folder is not None and record_decisions:
        recorder = DecisionRecorder(folder / DECISIONS_FILE)
        writers[DECISIONS_FILE] = measured.simulation.decisions.recorder = recorder
    for writer in writers.values():
        measured.simulation.rules.register_observer(writer)
    try:
        outcome = _simulate(measured.simulation)
        result = _conclude(measured, outcome, folder)
    finally:
        for writer in writers.values():
            writer.discard()
    if folder is not None:
        for file in (TRACE_FILE, DECISIONS_FILE):
            if file not in writers:
                (folder / file).unlink(missing_ok=True)
    if isinstance(outcome.error, RunError):
        outcome.error.result = result
    if outcome.error is not None:
        raise outcome.error
    return result


@frozen(eq=False)
class _Measured:
    """A simulation and what measures it."""

    simulation: Simulation
    metrics: Metrics
    tables: Tables
    versions: dict[str, str]


def _folder_for_results(out: str | Path, scenario: Scenario) -> Path:
    """Return the output folder, unless results would replace what is no result."""
    folder = output_folder(out)
    names = [name for name, _ in TABLE_FILES.values()]
    for key in ("orders_file", "pods_file"):
        given = getattr(scenario.instance, key)
        if given is not None and (Path(scenario.folder) / given).resolve() in [(folder / n).resolve() for n in names]:
            raise InputError(str(folder), f"results would replace `instance.{key}`, {given}; expected another folder")
    foreign = [name for name in names if (folder / name).exists()]
    if foreign and not (folder / RESULT_FILE).exists():
        raise InputError(
            str(folder),
            f"found a file {foreign[0]} that no run of rmfs has written; expected a folder for results alone",
        )
    return folder


@frozen
class _Outcome:
    """How a simulation ended."""

    status: str
    wall_s: float
    error: Exception | None = None
    interrupted: bool = False


def _resolve(scenario: Scenario | str | Path, seed: int | None, overrides: Sequence[str]) -> Scenario:
    if not isinstance(scenario, Scenario):
        return load_scenario(scenario, overrides, seed)
    if overrides:
        raise InputError("overrides", "expected a scenario file with them; change a Scenario with attrs.evolve")
    return scenario if seed is None else scenario.with_seed(seed)


def _prepare(scenario: Scenario, observers: Sequence[object], allow_inline_rules: bool) -> _Measured:
    with located(scenario):
        rules = RuleSet.load(scenario.rules, scenario.folder, allow_inline=allow_inline_rules)
        instance, layout = make_instance(scenario), make_layout(scenario)
    metrics, tables = Metrics(), Tables()
    # Who is registered last is told first: whatever another observer does wrong, metrics and tables have it already.
    for observer in (*observers, tables, metrics):
        rules.register_observer(observer)
    rules.check()
    versions = _versions(rules, scenario.folder)
    return _Measured(Simulation(scenario, instance, layout, rules), metrics, tables, versions)


def _versions(rules: RuleSet, folder: str) -> dict[str, str]:
    """Versions of the distributions, and of each file beside the scenario its digest: it has no other version."""
    files = {
        Path(os.path.relpath(file, folder)).as_posix(): f"sha256:{hashlib.sha256(Path(file).read_bytes()).hexdigest()}"
        for file in rules.inline_files
    }
    return {**rules.distributions, **files}


def _simulate(simulation: Simulation) -> _Outcome:
    started = time.perf_counter()
    error: Exception | None = None
    interrupted = False
    try:
        simulation.run()
        status = simulation.status
    except KeyboardInterrupt:
        status, interrupted = "partial", True
    except (
        Exception
    ) as problem:  # not a rule's fault, or it would be a RunError; what was measured is kept all the same
        status, error = "failed", problem
    return _Outcome(status, time.perf_counter() - started, error, interrupted)


def _conclude(measured: _Measured, outcome: _Outcome, folder: Path | None) -> Result:
    """Tell the observers that the run is over, and save; an observer that fails at that takes nothing away."""
    simulation = measured.simulation
    try:
        simulation.rules.pm.hook.run_ended(tick=simulation.now, status=outcome.status)
    finally:
        result = _result(measured, outcome)
        if folder is not None:
            result.save(folder)
    return result


def _result(measured: _Measured, outcome: _Outcome) -> Result:
    simulation, metrics, tables = measured.simulation, measured.metrics, measured.tables
    metrics.run_ended(simulation.now, outcome.status)
    return Result(
        scenario=simulation.scenario,
        seed=simulation.scenario.seed,
        versions=measured.versions,
        status=outcome.status,
        metrics=metrics.values(),
        timing={
            **metrics.timing(outcome.wall_s),
            "hook_s": simulation.hook_seconds,
            "profile_s": {
                **simulation.profile,
                "events": max(outcome.wall_s - sum(simulation.profile.values()), 0.0),
            },
        },
        orders=tables.orders,
        visits=tables.visits,
        periods=tables.periods,
        error=None if outcome.error is None else str(outcome.error),
        interrupted=outcome.interrupted,
        hook_calls=dict(simulation.asker.calls),
    )
