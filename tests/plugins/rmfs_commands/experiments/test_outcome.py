"""One run, whatever comes of it."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from attrs import evolve

import rmfs_core
from rmfs_commands.experiments import Experiment
from rmfs_commands.experiments.outcome import simulate

Write = Callable[..., Experiment]
RAISING = """
base = "tiny.toml"
seeds = [1]
baseline = "bad"
[[rule_sets]]
name = "bad"
rules.pr = "./bad.py:Raising"
"""


def test_other_versions_at_a_worker_are_no_result(experiment: Write) -> None:
    """A worker with another version of a rule must not compute runs for this one."""
    job = experiment().jobs()[0]
    outcome = simulate(evolve(job, versions={**job.versions, "rmfs": "0.0.9"}))
    assert outcome.result is None
    assert outcome.error == f"the worker has rmfs {job.versions['rmfs']}, expected 0.0.9"


def test_other_code_at_a_worker_is_no_result(experiment: Write) -> None:
    """Nor must one that has an older copy of a package, or a newer one."""
    job = experiment().jobs()[0]
    outcome = simulate(evolve(job, sources={**job.sources, "rmfs_rules.demand": "sha256:0"}))
    assert outcome.result is None
    assert (
        outcome.error == "the worker has other code of rmfs_rules.demand; expected that which the experiment began with"
    )


def test_a_run_that_completes(experiment: Write, folder: object) -> None:
    """Its result is that of the scenario, and its time that of the whole run."""
    outcome = simulate(experiment().jobs()[1])
    assert outcome.result is not None
    assert outcome.result.metrics == rmfs_core.run(f"{folder}/tiny.toml", seed=2).metrics
    assert (outcome.error, outcome.error_kind) == (None, None)
    assert outcome.run_s >= outcome.result.timing["wall_s"] > 0


def test_a_run_that_fails_has_what_was_measured_until_then(experiment: Write) -> None:
    """The rule's error is named, with its class; the figures are kept."""
    outcome = simulate(experiment(RAISING).jobs()[0])
    assert outcome.result is not None
    assert outcome.result.status == "failed"
    assert outcome.error_kind == "RuleError"
    assert outcome.error is not None
    assert "no idea" in outcome.error


def test_a_run_that_cannot_begin_is_an_outcome(experiment: Write) -> None:
    """What is wrong with its input is told as it is."""
    job = experiment().jobs()[0]
    stations = evolve(job.scenario.stations, item_capacity=1, oversize="refuse")
    outcome = simulate(evolve(job, scenario=evolve(job.scenario, stations=stations)))
    assert (outcome.result, outcome.error_kind) == (None, "InputError")
    assert outcome.error is not None
    assert "item_capacity" in outcome.error


def test_no_error_gets_through(experiment: Write, monkeypatch: pytest.MonkeyPatch) -> None:
    """One that nobody foresaw is named by its class."""

    def fail(scenario: object) -> None:
        raise ZeroDivisionError("by zero")

    monkeypatch.setattr("rmfs_commands.experiments.outcome.run", fail)
    outcome = simulate(experiment().jobs()[0])
    assert (outcome.result, outcome.error, outcome.error_kind) == (
        None,
        "ZeroDivisionError: by zero",
        "ZeroDivisionError",
    )
