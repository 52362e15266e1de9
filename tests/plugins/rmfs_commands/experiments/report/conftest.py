from __future__ import annotations

from typing import Any

import pytest
from attrs import evolve

from rmfs_commands.experiments import Axis, AxisPoint, Base, Experiment, ExperimentResult, RuleSetChoice
from rmfs_core.scenario import load_scenario

FAILURE = "rule <b>bad</b> & worse: no idea"


@pytest.fixture
def result() -> ExperimentResult:
    """Return an experiment of two instances, three rule sets and three seeds, with made-up figures; one run failed."""
    experiment = Experiment(
        name="trial",
        description="Is <more> better?",
        bases=(Base("small", load_scenario("examples/small")),),
        axes=(Axis("instance.orders", tuple(AxisPoint(f"orders={n}", n, {"instance.orders": n}) for n in (50, 100))),),
        rule_sets=tuple(RuleSetChoice(name) for name in ("base", "good", "bad")),
        seeds=(1, 2, 3),
        baseline="base",
        metrics=("pile_on", "picker_utilisation", "split_orders_open_max"),
    )
    rows: list[dict[str, Any]] = []
    for orders in (50, 100):
        for place, rule_set in enumerate(("base", "good", "bad")):
            for seed in (1, 2, 3):
                figures = {
                    "pile_on": 2.0 + place + seed / 10,
                    "picker_utilisation": 0.5 + place / 10 + seed / 100,
                    "split_orders_open_max": place * seed,
                    "decision_s_first": None,
                }
                rows.append(
                    {
                        "instance": f"orders={orders}",
                        "scenario": "small",
                        "instance.orders": orders,
                        "rule_set": rule_set,
                        "seed": seed,
                        "status": "complete",
                        "error": None,
                        "error_kind": None,
                        **figures,
                        "key": f"{orders}{place}{seed}",
                    }
                )
    failed = {"status": "failed", "error": FAILURE, "error_kind": "RuleError"}
    rows[-1] = {name: rows[-1][name] for name in ("instance", "instance.orders", "rule_set", "seed", "key")} | failed
    return ExperimentResult(experiment, rows, {"rmfs": "0.1.0"}, 18)


@pytest.fixture
def with_front(result: ExperimentResult) -> ExperimentResult:
    """Return the same with a front of two metrics."""
    return evolve(result, experiment=evolve(result.experiment, fronts=(("pile_on", "picker_utilisation"),)))


@pytest.fixture
def bounded(result: ExperimentResult) -> ExperimentResult:
    """Return the same with what no rules can beat in pile-on, as if less of it were better."""
    for row in result.rows:
        row["bound.pile_on"] = 1.25
    return result
