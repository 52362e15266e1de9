"""Judging one size: as many seeds as it takes, from runs that are complete."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from attrs import evolve

from rmfs_commands.experiments import Watcher
from rmfs_commands.experiments.outcome import Outcome
from rmfs_commands.sizing.judging import Verdict, estimate
from rmfs_commands.sizing.target import Target
from rmfs_commands.sizing.trials import Candidate, Trials, counted
from rmfs_commands.sizing.worlds import Worlds
from rmfs_core import Scenario, run
from rmfs_core.errors import InputError, RunError
from rmfs_core.scenario.model import RuleChoice, RunSection

FAILING_RULE = """
import attrs
from rmfs_core import hookimpl

@attrs.define
class Failing:
    @hookimpl
    def choose_storage_location(self, warehouse, pod):
        raise ValueError("out of ideas")
"""


def trials(scenario: Scenario, target: Target, store: Path, here: Any, told: list[Candidate] | None = None) -> Trials:
    """Return trials in this process."""
    tell = (lambda _: None) if told is None else told.append
    return Trials(Worlds(scenario, target.seeds[:4]), "hall", target, store, here, Watcher(), tell)


def test_clear_cases_take_the_first_seeds_alone(poisson: Scenario, here: Any, tmp_path: Path) -> None:
    """The estimate is that of single runs with the same seeds; each size is judged once, and told of."""
    told: list[Candidate] = []
    judge = trials(poisson, Target("turnover_p95_s", 5000), tmp_path, here, told)
    assert judge.passes(2, 3) and judge.passes(2, 3)
    (one,) = told
    sized = judge.worlds.of_size(2, 3)
    values = [run(sized, seed=seed).metrics["turnover_p95_s"] for seed in (1, 2, 3, 4)]
    assert one == Candidate(2, 3, Verdict.PASSES, 4, estimate(values, 0.95, 3))
    assert len(here.jobs) == 4


def test_a_close_case_takes_all_and_is_undecided(poisson: Scenario, here: Any, tmp_path: Path) -> None:
    """The limit is the mean of all seeds itself."""
    seeds = tuple(range(1, 9))
    exact = trials(poisson, Target("turnover_s", 1e6, seeds=seeds), tmp_path, here).worlds.of_size(2, 2)
    mean = sum(run(exact, seed=seed).metrics["turnover_s"] for seed in seeds) / len(seeds)
    judge = trials(poisson, Target("turnover_s", mean, seeds=seeds), tmp_path, here)
    assert not judge.passes(2, 2)
    found = judge.judged[2, 2]
    assert (found.verdict, found.seeds) == (Verdict.UNDECIDED, 8)


def test_stored_runs_are_not_run_again(poisson: Scenario, here: Any, tmp_path: Path) -> None:
    """Another target asks the same runs."""
    trials(poisson, Target("turnover_p95_s", 5000), tmp_path, here).passes(2, 3)
    judge = trials(poisson, Target("turnover_s", 4000), tmp_path, here)
    assert judge.passes(2, 3)
    assert len(here.jobs) == 4


def test_a_run_with_orders_left_is_not_enough(poisson: Scenario, here: Any, tmp_path: Path) -> None:
    """However short the turn-over of those that were completed."""
    short = evolve(poisson, run=RunSection(until_s=300))
    judge = trials(short, Target("turnover_p95_s", 5000), tmp_path, here)
    assert not judge.passes(2, 3)
    expected = Candidate(2, 3, Verdict.FAILS, 4, None, "seed 1 ends with orders left")
    assert judge.judged[2, 3] == expected


def test_a_run_that_fails_is_not_enough(poisson: Scenario, here: Any, tmp_path: Path) -> None:
    """Its error is the reason, and the runs that failed are counted."""
    (tmp_path / "failing.py").write_text(FAILING_RULE, encoding="utf-8")
    rules = evolve(poisson.rules, pr=RuleChoice("./failing.py:Failing"))
    judge = trials(
        evolve(poisson, rules=rules, folder=str(tmp_path)), Target("turnover_s", 5000), tmp_path / "runs", here
    )
    assert not judge.passes(2, 3)
    found = judge.judged[2, 3]
    assert (found.verdict, found.failed) == (Verdict.FAILS, 4)
    assert "out of ideas" in str(found.reason)


def test_a_run_without_a_result_ends_the_search(poisson: Scenario, here: Any, tmp_path: Path) -> None:
    """That a worker was killed says nothing of the size."""
    here.run = lambda job: Outcome(None, "its worker process died", "WorkerDiedError")
    judge = trials(poisson, Target("turnover_s", 5000), tmp_path, here)
    with pytest.raises(RunError, match="2 stations, 3 robots, seed 1: its worker process died"):
        judge.passes(2, 3)
    assert judge.judged == {}


def test_what_is_impossible_is_not_run(poisson: Scenario, here: Any, tmp_path: Path) -> None:
    """No order is picked within a second."""
    judge = trials(poisson, Target("turnover_p95_s", 1), tmp_path, here)
    assert not judge.passes(2, 3)
    assert str(judge.judged[2, 3].reason).startswith("whatever the rules, it is ")
    assert here.jobs == []


def test_a_metric_that_runs_do_not_have(poisson: Scenario, here: Any, tmp_path: Path) -> None:
    """One that nobody knows, and one that nothing in these runs measures: there is no bundle without replenishment."""
    with pytest.raises(InputError, match=r'there is no metric "turnover_p96_s" \(did you mean `turnover_p95_s`'):
        trials(poisson, Target("turnover_p96_s", 5), tmp_path, here).passes(2, 3)
    with pytest.raises(InputError, match="=5: these runs have no `bundle_turnover_s`: nothing in"):
        trials(poisson, Target("bundle_turnover_s", 5), tmp_path, here).passes(2, 3)


def test_a_size_in_words() -> None:
    """One is one."""
    assert counted(1, 2) == "1 station, 2 robots"
    assert counted(3, 1, " with ") == "3 stations with 1 robot"
