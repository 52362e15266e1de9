"""Running a scenario from start to end: the library's front door."""

from __future__ import annotations

import hashlib
import os
import signal
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from os.path import realpath  # which ends where links lead round
from pathlib import Path
from threading import current_thread, main_thread
from typing import Any

from attrs import define, evolve, frozen

from rmfs_core.errors import InputError, RmfsError, RunError, is_interrupt
from rmfs_core.results.catalogue import Metric, described_by
from rmfs_core.results.files import output_folder, staged
from rmfs_core.results.metrics import Metrics
from rmfs_core.results.recorders import (
    delete_left_over,
    files_of,
    make_observers,
    make_recorders,
    versions_of_observers,
)
from rmfs_core.results.result import RESULT_FILE, TABLE_FILES, Result
from rmfs_core.results.tables import Tables
from rmfs_core.rules import RuleSet, with_objects
from rmfs_core.scenario import Scenario, load_scenario, located
from rmfs_core.scenario.overrides import data_files
from rmfs_core.simulation.engine import Simulation
from rmfs_core.wording import one_line
from rmfs_core.world import make_instance, make_layout


def run(
    scenario: Scenario | str | Path,
    *,
    seed: int | None = None,
    overrides: Sequence[str] = (),
    rules: Mapping[str, object] | None = None,
    out: str | Path | None = None,
    record: Sequence[str] = (),
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
        ``key=value`` each, replacing values of the file; not for a `Scenario` object (see `attrs.evolve`). Files
        that they name are looked up in the current directory.
    rules
        Rules as objects, in place of the scenario's, by the keys of its section ``rules``: ``{"poa": MyRule(x=3)}``; a
        list for ``filters``. Each is used as it is, so what it remembers of one run it brings into the next. The result
        names its class and those parameters that are plain values; only an installed rule's name leads back to it, of
        any other ``versions`` says that it was an object.
    out
        Folder to write the result's files to, all at the end. Files of an earlier run there stay until then, and are
        replaced; what its recorders wrote is deleted.
    record
        Names of recorders, entry points of the group ``rmfs.recorders``, whose files shall be in ``out`` too.
    observers
        Objects whose ``@hookimpl`` methods are told of every event, besides those that the scenario names.
    allow_inline_rules
        Whether code may be loaded from files: rules such as ``./file.py:Class``.

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
    if record and out is None:
        raise InputError(record[0], "what is recorded needs a folder to be written to; expected `out` with it")
    resolved = _resolve(scenario, seed, overrides)
    resolved = evolve(resolved, rules=with_objects(resolved.rules, rules or {}))
    recorders, standing = make_recorders(record), make_observers()
    told = [*((observer, None) for observer in observers), *recorders, *standing]
    again = out is not None and os.path.exists(Path(out) / RESULT_FILE)  # noqa: PTH110 (also of a name too long)
    with ExitStack() as stack:
        if out is not None and not os.path.exists(out):  # noqa: PTH110 (also of a name too long)
            stack.callback(_remove_empty, Path(out))
        measured = _prepare(resolved, rules, told, allow_inline_rules, out, stack)
        outcome = _simulate(measured.simulation)
        result = _conclude(measured, outcome)
        if measured.folder is not None:
            result.save(measured.folder)
    if out is not None and again:
        delete_left_over(Path(out), files_of(observer for observer, _ in (*recorders, *standing)))
    if isinstance(outcome.error, RunError):
        outcome.error.result = result
    if outcome.error is not None:
        raise outcome.error
    return result


def _remove_empty(folder: Path) -> None:
    """Remove a folder that nothing was written to."""
    with suppress(OSError):
        folder.rmdir()


@frozen(eq=False)
class _Measured:
    """A simulation and what measures it."""

    simulation: Simulation
    metrics: Metrics
    tables: Tables
    versions: dict[str, str]
    described: dict[str, Metric]
    folder: Path | None


def _folder_for_results(out: str | Path, scenario: Scenario, files: Sequence[str]) -> Path:
    """Return the output folder, unless results, or the files of recorders, would replace what is no result."""
    folder = output_folder(out)
    names = [*(name for name, _ in TABLE_FILES.values()), *files]
    for path, given in data_files(scenario).items():
        if realpath(Path(scenario.folder) / given) in [realpath(folder / name) for name in names]:
            key = ".".join(path)
            raise InputError(str(folder), f"results would replace `{key}`, {given}; expected another folder")
    for name in names:
        if (folder / name).is_dir():
            raise InputError(str(folder / name), "cannot be written: a folder has that name")
    foreign = [name for name in names if (folder / name).exists()]
    if foreign and not (folder / RESULT_FILE).exists():
        found = f"found a file {foreign[0]} that no run of rmfs has written"
        raise InputError(str(folder), f"{found}; expected a folder for results alone")
    return folder


@define
class _Outcome:
    """How a simulation ended."""

    status: str
    wall_s: float
    error: BaseException | None = None
    interrupted: bool = False


def _resolve(scenario: Scenario | str | Path, seed: int | None, overrides: Sequence[str]) -> Scenario:
    if not isinstance(scenario, Scenario):
        return load_scenario(scenario, overrides, seed)
    if overrides:
        raise InputError("overrides", "expected a scenario file with them; change a Scenario with attrs.evolve")
    return scenario if seed is None else scenario.with_seed(seed)


def _prepare(
    scenario: Scenario,
    objects: Mapping[str, object] | None,
    told: Sequence[tuple[Any, str | None]],
    allow_inline_rules: bool,
    out: str | Path | None,
    stack: ExitStack,
) -> _Measured:
    with located(scenario):
        rules = RuleSet.load(scenario.rules, scenario.folder, allow_inline=allow_inline_rules, objects=objects)
        instance, layout = make_instance(scenario), make_layout(scenario)
    metrics, tables = Metrics(), Tables()
    # Who is registered last is told first: whatever another observer does wrong, metrics and tables have it already.
    for observer, name in (*told, (tables, None), (metrics, None)):
        rules.register_observer(observer, name)
    described = described_by(rules.instances)
    files = files_of(observer for observer, described in told if described is not None)
    folder = None if out is None else stack.enter_context(staged(_folder_for_results(out, scenario, files)))
    simulation = Simulation(scenario, instance, layout, rules, folder)
    return _Measured(simulation, metrics, tables, versions_of(rules, scenario.folder), described, folder)


def versions_of(rules: RuleSet, folder: str) -> dict[str, str]:
    """Return the versions of everything that takes part in a run: of a rule's file its digest, it has no other.

    A file in the scenario's ``folder`` is named as seen from there, any other by its absolute path.
    """
    found = versions_of_observers() | dict(rules.distributions)
    for file in map(Path, rules.inline_files):
        name = file.relative_to(folder) if file.is_relative_to(folder) else file
        found[name.as_posix()] = f"sha256:{hashlib.sha256(file.read_bytes()).hexdigest()}"
    return found


def _simulate(simulation: Simulation) -> _Outcome:
    started = time.perf_counter()
    outcome = _Outcome("partial", 0.0)
    try:
        with _interrupts_between_events(simulation):
            simulation.run()
        outcome.status, outcome.interrupted = simulation.status, simulation.interrupted
    except BaseException as error:  # not only a rule's fault, a RunError: what was measured is kept all the same
        outcome.interrupted = is_interrupt(error)
        if not outcome.interrupted:
            outcome.status, outcome.error = "failed", error
    outcome.wall_s = time.perf_counter() - started
    return outcome


@contextmanager
def _interrupts_between_events(simulation: Simulation) -> Iterator[None]:
    """Let Ctrl-C end a run when all are told of an event, not in the middle of it; pressed again, at once."""

    def interrupt(_signal: int, _frame: object) -> None:
        simulation.interrupted = True
        signal.signal(signal.SIGINT, signal.default_int_handler)

    ours = current_thread() is main_thread() and signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if ours:
        signal.signal(signal.SIGINT, interrupt)
    try:
        yield
    finally:
        if ours:
            signal.signal(signal.SIGINT, signal.default_int_handler)


def _conclude(measured: _Measured, outcome: _Outcome) -> Result:
    """Tell the observers that the run is over; one that fails at that makes it a failed run, and takes nothing away."""
    simulation, metrics, tables = measured.simulation, measured.metrics, measured.tables
    found, errors = simulation.context.observers.end(outcome.status)
    outcome.interrupted |= any(map(is_interrupt, errors))
    error = next((error for error in (outcome.error, *errors) if error is not None and not is_interrupt(error)), None)
    outcome.error, outcome.status = error, "failed" if error else outcome.status
    if outcome.interrupted and outcome.status == "complete":  # not all that is measured may be there
        outcome.status = "partial"
    asker, profile = simulation.context.asker, simulation.context.profile
    return Result(
        scenario=simulation.scenario,
        seed=simulation.scenario.seed,
        versions=measured.versions,
        status=outcome.status,
        metrics=found,
        described=measured.described,
        timing={
            **metrics.timing(outcome.wall_s),
            "hook_s": dict(asker.seconds),
            "profile_s": {**profile, "events": max(outcome.wall_s - sum(profile.values()), 0.0)},
        },
        orders=tables.orders,
        visits=tables.visits,
        periods=tables.periods,
        error=str(error) if isinstance(error, RmfsError) else None if error is None else one_line(error),
        interrupted=outcome.interrupted,
        hook_calls=dict(asker.calls),
    )
