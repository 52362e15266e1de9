"""Placements compared by runs of the later days."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from attrs import evolve, frozen

from rmfs_commands.cli.csv_writing import orders_csv
from rmfs_commands.experiments import Base, Experiment, ExperimentResult, RuleSetChoice, run_experiment
from rmfs_commands.experiments.compare import FEWEST_SEEDS, Comparison, summary
from rmfs_commands.experiments.experiment import Axis, AxisPoint
from rmfs_commands.experiments.watching import Watcher
from rmfs_commands.experiments.workers import Workers
from rmfs_commands.instances.departures import before_trucks
from rmfs_commands.results.files import output_folder, to_csv, write_text
from rmfs_commands.slotting.past import Past
from rmfs_commands.slotting.placing import NOW, Contents
from rmfs_core.scenario.model import Scenario
from rmfs_core.world import Layout

OWN = "own"
"""Name of the scenario's own rules."""
RULES = "rules"
VISITS = "psv_per_order"


def changes_of(rules: str) -> dict[str, str]:
    """Return the scenario keys that make a scenario's rules those named: `OWN`, or a rule for both POA and PPS."""
    return {} if rules == OWN else {"rules.poa_pps": rules}


@frozen(eq=False)
class Judged:
    """The runs of the later days, compared.

    Parameters
    ----------
    result
        The runs.
    comparison
        The placements against the pods as they are; an instance set for each set of rules.
    unit
        Each of what the intervals are over: ``day`` or ``seed``.
    """

    result: ExperimentResult
    comparison: Comparison
    unit: str

    def sets(self) -> list[tuple[str, str]]:
        """Return name of the rules and of the instance set of each set of rules."""
        names = [point.label for axis in self.result.experiment.axes for point in axis.points]
        return [(name, f"{RULES}={name}") for name in names]


def pods_csv(past: Past, contents: Contents, cells: Sequence[int], layout: Layout) -> str:
    """Return pods as a file that a scenario reads; cells are where they stand, none where that is anywhere."""
    rows = []
    for number, (pod, of_pod) in enumerate(zip(past.instance.pods, contents, strict=True)):
        place: dict[str, Any] = {}
        if cells:
            row, column = divmod(cells[number], layout.width)
            place = {"row": row + 1, "column": column + 1}
        held = of_pod or [(0, 0)]  # a pod without SKUs is there all the same
        rows += [{"pod": pod.name, "sku": past.instance.skus[sku], "quantity": items} | place for sku, items in held]
    return to_csv(["pod", "sku", "quantity", *(("row", "column") if cells else ())], rows)


def judge(
    scenario: Scenario,
    name: str,
    past: Past,
    pods: Mapping[str, str],
    rules: Sequence[str],
    seeds: int,
    folder: Path,
    *,
    workers: Workers,
    watcher: Watcher,
    metrics: Sequence[str],
    allow_inline_rules: bool = True,
) -> Judged:
    """Run each later day with each placement, set of rules and seed.

    Parameters
    ----------
    scenario, name
        The scenario.
    past
        History that placements were made from, and the later days.
    pods
        Text of the file of pods by name of the placement; `NOW` among them.
    rules
        `OWN`, or a rule that assigns orders and chooses pods jointly.
    seeds
        Runs of each, from the scenario's seed on.
    folder
        Where the days, the pods and the finished runs go.
    """
    departures = scenario.instance.departures
    route = None if departures is None else departures.column
    folder = folder.absolute()
    bases, choices = [], []
    for day in past.later:
        file = output_folder(folder / "days") / f"{day.name.replace(' ', '-')}.csv"
        orders, trucks = before_trucks(day.orders, departures)
        write_text(file, orders_csv(evolve(past.instance, orders=orders), route))
        section = evolve(scenario.instance, orders_file=str(file), start=day.start, departures=trucks)
        bases.append(Base(day.name, evolve(scenario, instance=section)))
    for placement, text in pods.items():
        file = output_folder(folder / "placements") / f"{placement}.csv"
        write_text(file, text)
        choices.append(RuleSetChoice(placement, {"instance.pods_file": str(file)}))
    points = tuple(AxisPoint(one, one, changes_of(one)) for one in rules)
    experiment = Experiment(
        name=f"slot-{name}",
        bases=tuple(bases),
        rule_sets=tuple(choices),
        seeds=tuple(range(scenario.seed, scenario.seed + seeds)),
        baseline=NOW,
        axes=(Axis(RULES, points),),
        metrics=tuple(metrics),
        folder=scenario.folder,
        place=name,
    )
    result = run_experiment(
        experiment,
        store=folder / "runs",
        workers=workers,
        watcher=watcher,
        allow_inline_rules=allow_inline_rules,
    )
    return Judged(result, *_compared(result))


def _compared(result: ExperimentResult) -> tuple[Comparison, str]:
    """Compare placements over days, each of which gives one value, the mean of its seeds; over seeds of few days."""
    days = list(dict.fromkeys(row["scenario"] for row in result.rows))
    over_days, rows = len(days) >= FEWEST_SEEDS, []
    for row in result.rows:
        day, seed = days.index(row["scenario"]), row["seed"]
        unit, other = (day, f"seed {seed}") if over_days else (seed, row["scenario"])
        rows.append(row | {"seed": unit, "instance": f"{row[RULES]}, {other}"})
    metrics = result.experiment.metrics
    return summary(rows, NOW, metrics, by=(RULES,), measures=result.measures), "day" if over_days else "seed"
