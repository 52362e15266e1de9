"""Running a scenario from start to end: the library's front door."""

from __future__ import annotations

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
from rmfs_core.results import TRACE_FILE, Result
from rmfs_core.scenario import Scenario, load_scenario
from rmfs_core.simulation.engine import Simulation


def run(
    scenario: Scenario | str | Path,
    *,
    seed: int | None = None,
    overrides: Sequence[str] = (),
    out: str | Path | None = None,
    trace: bool = False,
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
        Folder to write the result's files to. Files of an earlier run there are replaced; its trace is deleted.
    trace
        Whether to record the event trace too, ``trace.jsonl.gz`` in ``out``.
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
    scenario = _resolve(scenario, seed, overrides)
    if trace and out is None:
        raise InputError("trace", "a trace needs a folder to be written to; expected `out` with it")
    rules = RuleSet.load(scenario.rules, scenario.folder, allow_inline=allow_inline_rules)
    instance, layout = make_instance(scenario), make_layout(scenario)
    for observer in observers:
        rules.register_observer(observer)
    metrics, tables = Metrics(), Tables()
    # Observers are told last registered first: whatever another observer does wrong, these have counted already.
    rules.register_observer(metrics)
    rules.register_observer(tables)
    rules.check()
    simulation = Simulation(scenario, instance, layout, rules)
    folder = None if out is None else output_folder(out)
    writer = None
    if folder is not None and trace:
        writer = TraceWriter(folder / TRACE_FILE)
        rules.register_observer(writer)
    try:
        outcome = _simulate(simulation)
        # Observers that fail at the end take nothing away from what was measured.
        try:
            rules.pm.hook.run_ended(tick=simulation.now, status=outcome.status)
        finally:
            result = _result(simulation, metrics, tables, outcome)
            if folder is not None:
                result.save(folder)
                if writer is None:
                    (folder / TRACE_FILE).unlink(missing_ok=True)
    finally:
        if writer is not None:
            writer.discard()
    if isinstance(outcome.error, RunError):
        outcome.error.result = result
    if outcome.error is not None:
        raise outcome.error
    return result


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


def _result(simulation: Simulation, metrics: Metrics, tables: Tables, outcome: _Outcome) -> Result:
    metrics.run_ended(simulation.now, outcome.status)
    return Result(
        scenario=simulation.scenario,
        seed=simulation.scenario.seed,
        versions=dict(simulation.rules.distributions),
        status=outcome.status,
        metrics=metrics.values(),
        timing={**metrics.timing(outcome.wall_s), "hook_s": simulation.hook_seconds},
        orders=tables.orders,
        visits=tables.visits,
        periods=tables.periods,
        error=None if outcome.error is None else str(outcome.error),
        interrupted=outcome.interrupted,
    )
