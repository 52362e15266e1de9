"""Rules in the same worlds, one run after another, and what each measured."""

from __future__ import annotations

from collections.abc import Callable

import pytest

import rmfs_core
from rmfs_commands.bench.bench import QUALITY, WARM_UP_ORDERS, bench, contestant
from rmfs_commands.details.catalogue import METRICS
from rmfs_core.errors import InputError
from rmfs_core.roles import Role
from rmfs_core.scenario import RuleChoice

FEW = ["instance.orders=9"]
COUNTING = """
import json
from pathlib import Path

@define
class Counts:
    "PR: the first free location; notes how many orders its run has."

    file: str

    @hookimpl
    def run_started(self, run):
        with Path(self.file).open("a") as file:
            file.write(f"{len(run.instance.orders)} {run.scenario.seed}\\n")

    @hookimpl
    def choose_storage_location(self, warehouse):
        return min(warehouse.free_storage_locations)


@define
class Both:
    "POA and PPS, and neither well."

    @hookimpl
    def assign_orders(self, warehouse):
        return []

    @hookimpl
    def select_pods(self, warehouse):
        return []
"""


def test_a_contestant_says_what_it_decides() -> None:
    """And what it is compared in: joint rules stand beside POA rules."""
    first, joint, pps = (contestant(name, RuleChoice(name)) for name in ("first-come", "integrated", "demand"))
    assert [(one.role, one.decides, one.field) for one in (first, joint, pps)] == [
        (Role.POA, "POA", "POA, POA+PPS"),
        (Role.POA_PPS, "POA+PPS", "POA, POA+PPS"),
        (Role.PPS, "PPS", "PPS"),
    ]
    assert first.distribution == "rmfs"


def test_a_rule_for_several_decisions_is_told_in_which(install: Callable[..., None]) -> None:
    """Otherwise it is refused, and so is a parameter that is none."""
    install("acme", {"both": "acme_rules:Both"}, acme_rules=COUNTING)
    assert contestant("both", RuleChoice("both"), decides=Role.PPS).role is Role.PPS
    with pytest.raises(InputError, match="decides POA and PPS; say which of them is asked"):
        contestant("both", RuleChoice("both"))
    with pytest.raises(InputError, match="window"):
        contestant("whca-n", RuleChoice("whca-n", {"window": 3}))


def test_every_rule_runs_in_every_world_with_every_seed() -> None:
    """In that order; what is about to run is told before."""
    told: list[str] = []
    rules = [contestant(name, RuleChoice(name)) for name in ("first-come", "pod-match")]
    runs = list(bench(rules, ["small"], [1, 2], overrides=FEW, before=told.append))
    assert [(run.rule, run.world, run.seed, run.status) for run in runs] == [
        (rule, "small", seed, "complete") for rule in ("first-come", "pod-match") for seed in (1, 2)
    ]
    assert told == [f"small: {run.rule}, seed {run.seed}" for run in runs]
    assert all(run.calls > 0 and run.seconds > 0 and run.error is None for run in runs)


def test_what_is_measured_is_what_a_run_reports() -> None:
    """The same metrics as those of the scenario with these rules."""
    (run,) = bench([contestant("random", RuleChoice("random"), decides=Role.PR)], ["small"], [5], overrides=FEW)
    rules = ("poa=pod-match", "pps=demand", "pr=random", "ta=nearest-robot", "pp=free-flow")
    expected = rmfs_core.run("examples/small", seed=5, overrides=[*FEW, *(f"rules.{rule}" for rule in rules)])
    assert run.metrics == {name: expected.metrics[name] for name in QUALITY}
    assert QUALITY.keys() <= {metric.name for group in METRICS.values() for metric in group}


def test_a_rule_warms_up_in_a_small_copy_of_the_world(install: Callable[..., None], tmp_path: object) -> None:
    """Once before its turn, unmeasured, with a few orders; then come the runs that count."""
    install("acme", {"counts": "acme_rules:Counts"}, acme_rules=COUNTING)
    file = tmp_path / "runs.txt"  # type: ignore[operator]
    one = contestant("counts", RuleChoice("counts", {"file": str(file)}))
    assert len(list(bench([one], ["small"], [3, 4], overrides=FEW))) == 2
    orders = [line.split() for line in file.read_text().splitlines()]
    assert [int(number) for number, _ in orders] == [WARM_UP_ORDERS, 9, 9]
    assert [seed for _, seed in orders[1:]] == ["3", "4"]


def test_a_failed_run_is_measured_too(install: Callable[..., None]) -> None:
    """What failed is in its error; what was completed until then is in its figures."""
    install("acme", {"both": "acme_rules:Both"}, acme_rules=COUNTING)
    one = contestant("both", RuleChoice("both"), decides=Role.POA)
    (run,) = bench([one], ["small"], [1], overrides=FEW)
    assert run.status == "failed"
    assert run.error is not None
    assert "stands still" in run.error
    assert run.metrics["psv_per_order"] is None


@pytest.mark.parametrize(
    ("rules", "override", "key"),
    [
        (["pod-match", "first-come"], "rules.poa=first-come", "poa"),
        (["integrated"], "rules.pps=demand", "pps"),
        (["integrated", "demand"], "rules.pps.rule=demand", "pps"),
        (["most-covered"], "rules.filters=[]", "filters"),
    ],
)
def test_an_override_that_no_run_would_show_is_refused(rules: list[str], override: str, key: str) -> None:
    """A rule for what all contestants decide; where one of them leaves it alone it counts."""
    parameters = {"most-covered": {"n": 2}}
    ones = [contestant(name, RuleChoice(name, parameters.get(name, {}))) for name in rules]
    with pytest.raises(InputError) as caught:
        list(bench(ones, ["small"], [1], overrides=[override]))
    assert str(caught.value) == (
        f"--set {override}: every rule that is compared takes the place of `rules.{key}`; "
        "expected a rule for another decision"
    )
