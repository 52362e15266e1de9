"""Offline searches for better values: over whole schedules of static instances, and over parameters of rules."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rmfs_commands.benchmark.claims import Claim, check_result, run_rules
from rmfs_commands.benchmark.plans import REPLAY, Plan
from rmfs_commands.benchmark.sets import BenchmarkSet, Frozen
from rmfs_core.errors import InputError, RuleError
from rmfs_core.rules import RuleSet

if TYPE_CHECKING:
    from rmfs_commands.experiments import Watcher

Tell = Callable[[str], None]
PACES = (0.8, 1.1, 0.95, 1.25)
"""How long driving takes in the evaluator of schedules, alternately: robots wait for one another."""
COOLER = 0.2
"""Every other round goes on from the best schedule, at this share of the first temperature."""


def improve_schedule(
    one: Frozen, objective: str, minutes: float, seed: int, chosen: BenchmarkSet, out: Path, tell: Tell
) -> Claim:
    """Return the claim of the best schedule that a search finds; its run is in a folder.

    In each round a schedule is annealed under a fast evaluator, for longer than in the round before, and then run: what
    the run reaches counts.

    Parameters
    ----------
    one, objective
        The instance, and the metric.
    minutes
        When to begin no other round; there is one at least.
    seed
        Of the search.
    chosen, out, tell
        The set; where the run of the best schedule is kept; is told of better ones.

    Raises
    ------
    InputError
        When there are no schedules of the instance.
    """
    from rmfs_commands.benchmark.scheduling import HOT_S, STEPS, Problem

    until = time.monotonic() + 60 * minutes
    problem = Problem.of(one, objective)
    schedule = first = problem.first(objective)
    best: tuple[float, float] | None = None
    plan: Plan | None = None
    for number in range(1_000_000):
        tried = schedule
        if number:
            again = number % 2 == 0
            pace, heat = PACES[number % len(PACES)], HOT_S * (COOLER if again else 1)
            begun = schedule if again else first
            tried = problem.improved(begun, seed + number, pace, steps=number * STEPS, hot=heat)
        given = problem.plan(tried)
        reached = _reached(one, given, objective)
        if reached is not None and (best is None or reached < best):
            best, plan, schedule = reached, given, tried
            tell(f"{one.name}, round {number}: {objective} {reached[0]:,.6g}")
        if number and time.monotonic() >= until:
            break
    if plan is None:
        raise InputError(one.name, "no schedule was found whose run completes all orders")
    run_rules(one, _replaying(plan), out)
    return check_result(out, chosen)


def _replaying(plan: Plan) -> dict[str, Any]:
    return {"poa_pps": {"rule": REPLAY, "plan": plan}}


def _reached(one: Frozen, plan: Plan, objective: str) -> tuple[float, float] | None:
    """Return what the run of a plan reached, the turn-over time behind it: of equal ones the sooner is better.

    None if it is not complete, or a pod has no item left that the plan takes from it: another line got it.
    """
    try:
        result = run_rules(one, _replaying(plan))
    except RuleError:
        return None
    if result.status != "complete":
        return None
    return float(result.metrics[objective]), float(result.metrics["turnover_s"])


def improve_rules(
    one: Frozen,
    first: Mapping[str, Any],
    objective: str,
    minutes: float,
    seed: int,
    chosen: BenchmarkSet,
    out: Path,
    tell: Tell,
    watcher: Watcher,
) -> Claim:
    """Return the claim of the best parameters of rules that a search finds, beginning with some.

    It is the search of `rmfs tune`, whose runs have one seed, the instance's own; ``minutes`` says how many runs it
    may take, by the time that the first takes.

    Parameters
    ----------
    one, objective, minutes, seed, chosen, out, tell
        As in `improve_schedule`.
    first
        The rules, tables by key.
    watcher
        Is told of single runs.

    Raises
    ------
    InputError
        When a rule has no parameters with a known range, or Optuna is not installed.
    """
    from rmfs_commands.experiments.running import open_workers
    from rmfs_commands.tuning.searching import Search
    from rmfs_commands.tuning.space import make_space

    scenario = one.with_rules(first)
    keys = ["poa_pps"] if "poa_pps" in first else ["poa", "pps"]
    rules = RuleSet.load(scenario.rules, scenario.folder)
    space = make_space(rules, scenario.rules, keys, [])
    began = time.monotonic()
    run_rules(one, first)
    runs = max(int(60 * minutes / max(time.monotonic() - began, 0.05)), 5)
    tell(f"{one.name}: {runs:,} runs with other parameters.")
    with closing(open_workers(1)) as workers:
        of_runs = out / "runs"
        seeds = (scenario.seed,)
        search = Search(
            scenario, one.name, space, (objective,), (1,), seeds, runs, of_runs, workers, watcher, lambda _: None,
            sampler_seed=seed,
        )  # fmt: skip
        trial = search.best(search.trials(), 1)[0]
    tables = space.changes(trial.values) if trial.values else {}
    changed = {**first, **{key.removeprefix("rules."): table for key, table in tables.items()}}
    run_rules(one, changed, out)
    return check_result(out, chosen)
