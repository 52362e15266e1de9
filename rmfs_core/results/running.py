"""Running a scenario from start to end: the library's front door."""

from __future__ import annotations

import gc
import hashlib
import signal
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, nullcontext
from pathlib import Path
from threading import current_thread, main_thread
from typing import Any

from attrs import define, evolve

from rmfs_core import entrypoints
from rmfs_core.clock import to_seconds
from rmfs_core.errors import InputError, RmfsError, RunError, is_interrupt
from rmfs_core.results.catalogue import Metric, described_by
from rmfs_core.results.result import Result
from rmfs_core.rules import RuleSet, with_objects
from rmfs_core.scenario import Scenario, load_scenario, located
from rmfs_core.simulation.engine import Simulation
from rmfs_core.simulation.setup import begin
from rmfs_core.wording import one_line
from rmfs_core.world import make_instance, make_layout
from rmfs_core.world.instance_making import generator_of
from rmfs_core.world.layout_making import layout_maker


@contextmanager
def _collecting_seldom() -> Iterator[None]:
    """Look for cycles of objects less often: those of a run live as long as it does."""
    looks = gc.get_threshold()
    gc.set_threshold(looks[0] and max(looks[0], 50_000), *looks[1:])  # 0: never
    try:
        yield
    finally:
        gc.set_threshold(*looks)


@_collecting_seldom()
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
    save_state: str | Path | None = None,
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
        Rules as objects, instead of the scenario's, by the keys of its section ``rules``: ``{"poa": MyRule(x=3)}``; a
        list for ``filters``. Each is used as it is, so what it remembers of one run it brings into the next. The result
        names its class and those parameters that are plain values; only an installed rule's name leads back to it, of
        any other ``versions`` says that it was an object.
    out
        Folder to write the result's files to, all at the end. Files of an earlier run there stay until then, and are
        replaced; what its recorders wrote is deleted.
    record
        Names of recorders, entry points of the group ``rmfs.recorders``, whose files shall be in ``out`` too.
    observers
        Objects whose ``@hookimpl`` methods are told of every event, in addition to the scenario's observers.
    allow_inline_rules
        Whether code may be loaded from files: rules such as ``./file.py:Class``.
    save_state
        File for the state in which ``run.until_s`` ends the run, from which another goes on (``instance.state_file``).

    Returns
    -------
    Result
        Status ``"complete"``; ``"horizon"`` when ``run.until_s`` was reached with orders left; ``"partial"`` when a
        keyboard interrupt ended the run (``result.interrupted``; it is not raised again).

    Raises
    ------
    InputError
        When something is wrong with the scenario or the arguments; before anything is simulated.
    RunError
        When a rule misbehaves or the run stands still. Its ``result`` has what was measured until then, status
        ``"failed"``, and is saved in ``out`` like any other.
    """
    if record and out is None:
        raise InputError(record[0], "recordings need a folder to be written to; expected `out`, too")
    resolved = _resolve(scenario, seed, overrides)
    resolved = evolve(resolved, rules=with_objects(resolved.rules, rules or {}))
    making = entrypoints.format_module("recorders")
    recorders, standing = making.make_recorders(record), making.make_observers()
    savers = [] if save_state is None else [entrypoints.format_module("states").saver(save_state, resolved)]
    told = [*((observer, None) for observer in (*observers, *savers)), *recorders, *reversed(standing)]
    writing: Any = nullcontext(lambda _: None)
    if out is not None:
        writing = entrypoints.format_module("results").writing(out, resolved, [one for one, _ in standing])
    with writing as folder_for:
        prepared = prepare(resolved, rules or {}, told, allow_inline_rules, folder_for)
        for saver in savers:
            prepared.simulation.at_horizon = saver.save
        prepared.simulate()
        result = prepared.conclude()
        if isinstance(prepared.error, InputError) and not prepared.simulation.started:
            raise prepared.error  # of the state that it begins in, or a recorder
        if prepared.folder is not None:
            result.save(prepared.folder)
    if isinstance(prepared.error, RunError):
        prepared.error.result = result
    if prepared.error is not None:
        raise prepared.error
    return result


@define(eq=False)
class PreparedRun:
    """A simulation with what measures it, and how it ended.

    Parameters
    ----------
    simulation, tables, versions, described
        The run, and what its `Result` has of it.
    folder
        Where observers write; None where no results are kept.
    status, wall_s, error, interrupted
        As the result has them.
    """

    simulation: Simulation
    tables: Any
    versions: dict[str, str]
    described: dict[str, Metric]
    folder: Path | None
    status: str = "partial"
    wall_s: float = 0.0
    error: BaseException | None = None
    interrupted: bool = False

    def simulate(self) -> None:
        """Let the simulation run, and take note of how it ended."""
        started = time.perf_counter()
        try:
            with _undisturbed(self.simulation):
                self.simulation.run()
            self.status = self.simulation.status
            self.interrupted = self.status == "partial"
        except BaseException as error:  # not only a rule's fault, a RunError: what was measured is kept all the same
            self.interrupted = self.simulation.interrupted or is_interrupt(error)
            if not is_interrupt(error):
                self.status, self.error = "failed", error
        self.wall_s = time.perf_counter() - started

    def conclude(self) -> Result:
        """Tell observers that the run is over; one that fails at that makes it a failed run, and takes nothing away."""
        scenario, context = self.simulation.scenario, self.simulation.context
        found, errors = context.observers.end(self.status)
        self.interrupted |= any(map(is_interrupt, errors))
        raised = (error for error in (self.error, *errors) if error is not None and not is_interrupt(error))
        self.error = error = next(raised, None)
        self.status = "failed" if error else "partial" if self.interrupted else self.status  # not all may be measured
        self.simulation.rules.sources.close()
        orders, periods = self.tables.orders, self.tables.periods
        spans = to_seconds(context.began), scenario.run.warmup_s or 0, to_seconds(context.warehouse.now)
        return Result(
            scenario=scenario,
            seed=scenario.seed,
            versions=self.versions,
            status=self.status,
            metrics=found,
            described=self.described,
            timing={
                **entrypoints.format_module("results").timing(self.wall_s, *spans, orders, periods),
                "hook_s": dict(context.asker.seconds),
                "profile_s": {**context.profile, "events": max(self.wall_s - sum(context.profile.values()), 0.0)},
            },
            orders=orders,
            visits=self.tables.visits,
            periods=periods,
            error=str(error) if isinstance(error, RmfsError) else None if error is None else one_line(error),
            interrupted=self.interrupted,
            hook_calls=dict(context.asker.calls),
            summary=self.simulation.info.summary,
            notes=[*self.simulation.notes()] if self.status in ("horizon", "partial") else [],
        )


@contextmanager
def _undisturbed(simulation: Simulation) -> Iterator[None]:
    """Let Ctrl-C end a run between two events, pressed again at once."""

    def first(_signal: int, _frame: object) -> None:
        simulation.interrupted = True
        signal.signal(signal.SIGINT, before)

    before = signal.getsignal(signal.SIGINT)
    known = before is signal.default_int_handler or getattr(before, "ends_runs", False)  # the handler of `rmfs`
    if ours := known and current_thread() is main_thread():
        signal.signal(signal.SIGINT, first)
    try:
        yield
    finally:
        if ours:
            signal.signal(signal.SIGINT, before)


def _resolve(scenario: Scenario | str | Path, seed: int | None, overrides: Sequence[str]) -> Scenario:
    if not isinstance(scenario, Scenario):
        return load_scenario(scenario, overrides, seed)
    if overrides:
        raise InputError("overrides", "expected a scenario file with them; change a Scenario with attrs.evolve")
    return scenario if seed is None else scenario.with_seed(seed)


@_collecting_seldom()
def prepare(
    scenario: Scenario,
    objects: Mapping[str, object],
    told: Sequence[tuple[object, str | None]],
    allow_inline_rules: bool = True,
    folder_for: Callable[[Sequence[object]], Path | None] = lambda _: None,
) -> PreparedRun:
    """Return a run that has not begun.

    Parameters
    ----------
    scenario, objects, allow_inline_rules
        As `RuleSet.load` has them.
    told
        Observers, and what messages call them; None: what one raises is raised as it is. The last is told first.
    folder_for
        Returns the folder for results, given the recorders and observers of every run, which write files there.
    """
    with located(scenario):
        rules = RuleSet.load(scenario.rules, scenario.folder, allow_inline=allow_inline_rules, objects=objects)
    with ExitStack() as failing:
        failing.callback(rules.sources.close)
        with located(scenario):
            scenario = evolve(scenario, rules=rules.with_file_names(scenario.rules))
            instance, layout = make_instance(scenario), make_layout(scenario)
            if (begun := begin(scenario, instance, layout)) is not None:
                scenario, instance = begun.scenario, begun.instance
        rows = entrypoints.format_module("tables").Tables()
        for observer, name in (*told, (rows, None)):  # whatever another does wrong, the tables have it already
            rules.register_observer(observer, name)
        described = described_by(reversed(rules.instances))
        folder = folder_for([observer for observer, name in told if name is not None])
        simulation = Simulation(scenario, instance, layout, rules, folder, begun)
        prepared = PreparedRun(simulation, rows, versions_of(rules, scenario), described, folder)
        failing.pop_all()
    return prepared


def versions_of(rules: RuleSet, scenario: Scenario) -> dict[str, str]:
    """Return the versions of everything that takes part in a run, and digests of files of code and of parameters.

    A file in the scenario's folder is named as seen from there, any other by its absolute path.
    """
    folder, watching = scenario.folder, entrypoints.offers(entrypoints.OBSERVERS).values()
    found = dict(entrypoints.origin(entry) for entry, *_ in watching) | dict(rules.distributions)
    found |= dict([entrypoints.origin(layout_maker(scenario.layout)[0])])
    if scenario.instance.orders_file is None:
        found |= dict([entrypoints.origin(generator_of(scenario.instance)[0])])
    found |= {one.name: one.digest() for one in rules.files}
    for file in map(Path, rules.inline_files):
        name = file.relative_to(folder) if file.is_relative_to(folder) else file
        found[name.as_posix()] = f"sha256:{hashlib.sha256(file.read_bytes()).hexdigest()}"
    return found
