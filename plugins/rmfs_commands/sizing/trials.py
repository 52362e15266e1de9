"""Runs of one size after the other, with as many seeds as it takes to judge it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from attrs import evolve, field, frozen

from rmfs_commands.experiments import Base, Experiment, Row, RuleSetChoice, Watcher, run_experiment
from rmfs_commands.experiments.workers import Workers
from rmfs_commands.sizing.judging import Estimate, Verdict, estimate, looks
from rmfs_commands.sizing.target import Target
from rmfs_commands.sizing.worlds import Worlds
from rmfs_core.errors import RunError

COST = "cost_per_order"
"""The metric of what an order costs."""


@frozen
class Candidate:
    """A size that was judged.

    Parameters
    ----------
    first, second
        The size: stations and robots, or packers and boxes.
    verdict
        Whether it is enough.
    seeds
        Runs that say so, one a seed; 0 where none is needed.
    estimate
        The metric's mean over these, with its interval; None where a run did not complete.
    reason
        Why no estimate is needed.
    failed
        Runs that an error ended.
    costs
        Cost per order in each of these runs; empty where the scenario names no costs.
    boxes
        The most boxes that split orders had at the same time in these runs; None where none was measured.
    """

    first: int
    second: int
    verdict: Verdict
    seeds: int = 0
    estimate: Estimate | None = None
    reason: str | None = None
    failed: int = 0
    costs: tuple[float, ...] = ()
    boxes: float | None = None


@frozen(eq=False)
class Trials:
    """Judges sizes, each once.

    Parameters
    ----------
    worlds
        The sizes.
    name
        Its name in messages.
    target
        The target asked for.
    store
        Folder of finished runs.
    workers
        Who runs them.
    watcher
        Is told of runs.
    tell
        Is told of every size that was judged.
    allow_inline_rules
        Whether code may be loaded from files.
    """

    worlds: Worlds
    name: str
    target: Target
    store: Path
    workers: Workers
    watcher: Watcher
    tell: Callable[[Candidate], None]
    allow_inline_rules: bool = True
    judged: dict[tuple[int, int], Candidate] = field(factory=dict, init=False)

    def passes(self, first: int, second: int) -> bool:
        """Whether a size is enough.

        Raises
        ------
        InputError
            When runs have no such metric.
        RunError
            When a run ends without any result, as when its worker is killed: it says nothing of the size.
        """
        size = first, second
        if size not in self.judged:
            self.judged[size] = self._judge(first, second)
            self.tell(self.judged[size])
        return self.judged[size].verdict is Verdict.PASSES

    def _judge(self, first: int, second: int) -> Candidate:
        target = self.target
        found = Candidate(first, second, Verdict.FAILS)
        obstacle = self.worlds.obstacle(first, second, target)
        if obstacle is not None:
            return evolve(found, reason=obstacle)
        looked = looks(len(target.seeds))
        for n_seeds in looked:
            rows = self._runs(first, second, target.seeds[:n_seeds])
            lost = next((row for row in rows if row["status"] == "failed" and "run_s" not in row), None)
            if lost is not None:  # a worker's death says nothing of the size, and what follows would rest on it
                raise RunError(f"{self.worlds.things.counted(first, second)}, seed {lost['seed']}: {lost['error']}")
            found = evolve(found, seeds=n_seeds)
            complete = [row for row in rows if row["status"] == "complete"]
            if complete and not any(target.metric in row for row in complete):
                target.refuse("nothing in them measures it")
            problems = [problem for row in rows if (problem := _problem(row, target.metric)) is not None]
            if problems:
                failed = sum(row["status"] == "failed" for row in rows)
                reason = problems[0]
                return evolve(found, verdict=Verdict.FAILS, estimate=None, reason=reason, failed=failed)
            of_seeds = estimate([row[target.metric] for row in rows], target.confidence, len(looked))
            costs = tuple(row[COST] for row in rows if row.get(COST) is not None)
            boxes = max((row["boxes_max"] for row in rows if row.get("boxes_max") is not None), default=None)
            verdict = of_seeds.verdict(target.most)
            found = evolve(found, estimate=of_seeds, verdict=verdict, costs=costs, boxes=boxes)
            if found.verdict is not Verdict.UNDECIDED:
                break
        return found

    def _runs(self, first: int, second: int, seeds: Sequence[int]) -> list[Row]:
        size = self.worlds.things.counted(first, second)
        experiment = Experiment(
            name="size",
            bases=(Base(self.name, self.worlds.scenario),),
            rule_sets=(RuleSetChoice(size, self.worlds.changes(first, second)),),
            seeds=tuple(seeds),
            baseline=size,
            metrics=(self.target.metric,),
            folder=self.worlds.scenario.folder,
            place=self.name,
            metrics_place=self.target.option,
        )
        return run_experiment(
            experiment,
            store=self.store,
            workers=self.workers,
            watcher=self.watcher,
            allow_inline_rules=self.allow_inline_rules,
        ).rows


def _problem(row: Row, metric: str) -> str | None:
    """Say why a run gives no figure that counts."""
    seed, status = row["seed"], row["status"]
    if status == "failed":
        return f"seed {seed} failed: {row['error']}"
    if status in ("horizon", "partial"):
        return f"seed {seed} ends with orders left"
    return None if row.get(metric) is not None else f"seed {seed} has no {metric}"
