"""The answer of a search, for people and as files."""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from attrs import asdict, evolve, frozen

from rmfs_commands.experiments import Base, Experiment, ExperimentResult, RuleSetChoice, run_experiment
from rmfs_commands.experiments.compare import Comparison
from rmfs_commands.experiments.report import (
    PARQUET_FILE,
    PLOTS_FOLDER,
    REPEATING_FILE,
    REPORT_FILE,
    SUMMARY_FILE,
    TABLES_FOLDER,
    numbers,
    print_comparison,
    write_report,
)
from rmfs_commands.results.files import json_ready, output_folder, staged, to_csv, to_json, write_text
from rmfs_commands.tuning.searching import Search, Trial
from rmfs_commands.tuning.space import Space
from rmfs_core.scenario.tomltext import shown
from rmfs_core.wording import counted, listed

if TYPE_CHECKING:
    from rich.console import Console

FRAGMENT_FILE, TRIALS_FILE, ANSWER_FILE = "tuned.toml", "trials.csv", "answer.json"
NOW, TUNED = "now", "tuned"
MOST_OF_FRONT = 5
"""Trials of a front that are compared on the seeds held back."""


@frozen(eq=False)
class Found:
    """The answer of a search, and what is left of its gain on seeds that it never saw.

    Parameters
    ----------
    search
        The search.
    trials
        All of its trials, the scenario's own values first.
    best
        Those compared, by name; none where the scenario's own values are best.
    result, comparison
        The runs on the seeds held back; None where nothing is compared.
    told
        Sentences.
    """

    search: Search
    trials: Sequence[Trial]
    best: dict[str, Trial]
    result: ExperimentResult | None
    comparison: Comparison | None
    told: tuple[str, ...]


def space_lines(space: Space) -> Iterator[str]:
    """Yield a line for each parameter, and one for all that are left out."""
    for one in space.parameters:
        yield f"Searched: {one.key} in {one.shown}{' on a log scale' if one.log else ''}, {shown(one.now)} now."
    if space.left:
        yield f"Left as they are, without a known range: {listed(space.left)} (--parameter gives one)."


def trial_line(trial: Trial, objectives: Sequence[str]) -> str:
    """Return the line that describes a finished trial."""
    values = ", ".join(f"{key} = {shown(value)}" for key, value in trial.values.items()) or "the scenario's own values"
    if trial.problem is not None:
        return f"Trial {trial.number}: {values}: {trial.problem}"
    figures = ", ".join(f"{name} {mean:,.4g}" for name, mean in zip(objectives, trial.means, strict=True))
    left = ", given up" if trial.given_up else ""
    return f"Trial {trial.number}: {values}: {figures or 'not run'} ({counted(trial.seeds, 'seed')}{left})"


def judge(search: Search, trials: Sequence[Trial], held_back: Sequence[int]) -> Found:
    """Compare the best trials with the scenario's own values on seeds held back from the search."""
    winners = [one for one in search.best(trials, MOST_OF_FRONT) if one.number]
    ran = sum(one.seeds for one in trials) * search.instances
    about = f"{counted(len(trials) - 1, 'trial')} in {counted(ran, 'run')} on {counted(len(search.seeds), 'seed')}"
    if search.axes:
        about += f" of {counted(search.instances, 'instance')}"
    if not winners:
        finished = any(one.seeds == len(search.seeds) and one.problem is None for one in trials[1:])
        none = "Nothing is better than the scenario's own values" if finished else "No trial was run on all seeds"
        return Found(search, trials, {}, None, None, (f"{none}: {about}.",))
    names = [TUNED] if len(winners) == 1 else [f"{TUNED} {number}" for number in range(1, len(winners) + 1)]
    best = dict(zip(names, winners, strict=True))
    experiment = Experiment(
        name=f"tune-{search.name}",
        bases=(Base(search.name, search.scenario),),
        rule_sets=(
            RuleSetChoice(NOW),
            *(RuleSetChoice(name, search.space.changes(one.values)) for name, one in best.items()),
        ),
        seeds=tuple(held_back),
        baseline=NOW,
        axes=search.axes,
        metrics=search.objectives,
        fronts=((search.objectives[0], search.objectives[1]),) if len(search.objectives) == 2 else (),
        folder=search.scenario.folder,
        place=search.name,
    )
    result = run_experiment(
        experiment,
        store=search.store,
        workers=search.workers,
        watcher=search.watcher,
        allow_inline_rules=search.allow_inline_rules,
    )
    comparison = result.comparison()
    told = [f"Searched: {about}. Compared on seeds {held_back[0]} to {held_back[-1]}, which the search never saw."]
    told += [numbers.REPEATS] if result.repeats else []
    for name, one in best.items():
        values = ", ".join(f"{key} = {shown(value)}" for key, value in one.values.items())
        told.append(f"{name}: {values}.")
        told += _kept(comparison, search.objectives, trials[0], name, one)
    described = evolve(result, experiment=evolve(experiment, description=" ".join(told)))
    return Found(search, trials, best, described, comparison, tuple(told))


def _kept(comparison: Comparison, objectives: Sequence[str], own: Trial, name: str, one: Trial) -> Iterator[str]:
    """Yield, for each objective, what the search saw and what is left of it on the seeds held back."""
    for metric, before, after in zip(objectives, own.means, one.means, strict=True):
        label = numbers.title(comparison.described(metric))
        paired = next(p for p in comparison.of(comparison.instance_sets[-1], metric) if p.rule_set == name)
        saw = f"{100 * (after / before - 1):+.1f} %" if before else f"{after - before:+.4g}"
        saw = saw.replace("-", numbers.MINUS)
        if paired.difference.mean is None:
            yield f"{label}: {saw} in the search; on the seeds held back there is no figure."
            continue
        left = numbers.relative(paired) if before and paired.relative.mean is not None else ""
        left = left or numbers.difference(comparison.described(metric), paired.difference)
        yield f"{label}: {saw} in the search, {left} on the seeds held back."


def write(found: Found, folder: Path) -> list[str]:
    """Write the section of the scenario, the trials, the answer and the comparison; return the names of the files."""
    about = "".join(f"# {line}\n" for line in found.told)
    sections = [(name, found.search.space.fragment(one.values)) for name, one in found.best.items()]
    (_, first), *others = sections or [("", "")]
    commented = "".join(
        f"\n# or {name}:\n{''.join(f'# {line}' for line in text.splitlines(keepends=True))}" for name, text in others
    )
    rows = list(_rows(found))
    texts = {
        FRAGMENT_FILE: f"{about}{first}{commented}",
        TRIALS_FILE: to_csv(list(rows[0]), rows),
        ANSWER_FILE: to_json(json_ready(content_of(found)), indent=2) + "\n",
    }
    with staged(output_folder(folder)) as path:
        for name, text in texts.items():
            write_text(path / name, text)
    written = REPORT_FILE, SUMMARY_FILE, PARQUET_FILE, REPEATING_FILE
    for name in written:  # of an earlier search
        (folder / name).unlink(missing_ok=True)
    for name in (PLOTS_FOLDER, TABLES_FOLDER):
        shutil.rmtree(folder / name, ignore_errors=True)
    if found.result is None or found.comparison is None:
        return list(texts)
    write_report(found.result, found.comparison, folder)
    return [*texts, *written]


def _rows(found: Found) -> Iterator[dict[str, Any]]:
    keys = [one.key for one in found.search.space.parameters]
    for one in found.trials:
        means = one.means if one.seeds else [None] * len(found.search.objectives)
        yield {
            "trial": one.number,
            **{key: one.values.get(key) for key in keys},
            **dict(zip(found.search.objectives, means, strict=True)),
            "seeds": one.seeds,
            "given_up": one.given_up,
            "problem": one.problem,
        }


def content_of(found: Found) -> dict[str, Any]:
    """Return the answer for machines."""
    search = found.search
    compared = [] if found.comparison is None else found.comparison.paired
    return {
        "scenario": search.name,
        "axes": {axis.name: [point.value for point in axis.points] for axis in search.axes},
        "objectives": search.objectives,
        "parameters": [
            {"key": one.key, "now": one.now, "low": one.low, "high": one.high, "choices": one.choices}
            for one in search.space.parameters
        ],
        "trials": len(found.trials) - 1,
        "best": {name: one.values for name, one in found.best.items()},
        "told": found.told,
        "held_back": [
            {"rule_set": one.rule_set, "metric": one.metric, "mean": one.mean, "difference": asdict(one.difference)}
            for one in compared
        ],
    }


def show(console: Console, found: Found) -> None:
    """Print the answer."""
    if found.result is not None and found.comparison is not None:
        print_comparison(console, found.result, found.comparison)
    console.print()
    for line in found.told:
        console.print(line, markup=False)
