"""Rows of runs, made by hand, and a report on them."""

from collections.abc import Callable
from typing import Any

import pytest

from rmfs_commands.experiments import Job
from rmfs_commands.reproduction.extensions import PREFILTER, prefiltered
from rmfs_commands.reproduction.instance_sets import METHODS, SIX_ORDERS
from rmfs_commands.reproduction.paper import load_paper
from rmfs_commands.reproduction.parts import PARTS, experiment_of
from rmfs_commands.reproduction.report import Report, make_report
from rmfs_core.scenario import load_scenario

Row = dict[str, Any]
MakeRow = Callable[..., Row]


@pytest.fixture(scope="session")
def row() -> MakeRow:
    """Return a function that makes the row of a run of 50 orders; what is not given is a plain figure."""

    def make(
        rule_set: str = "sequential", seed: int = 1, instance: str = "one", orders: int = 50, **figures: Any
    ) -> Row:
        return {
            "instance": instance,
            "instance.orders": orders,
            "rule_set": rule_set,
            "seed": seed,
            "status": "complete",
            "error": None,
            "error_kind": None,
            "psv_per_order": 1.0,
            "distance_per_order_m": 100.0,
            "pile_on": 2.0,
            "turnover_s": 600.0,
            "turnover_backlog_s": 400.0,
            "turnover_station_s": 200.0,
            "picks_per_hour": 500.0,
            "makespan_s": 1000.0,
            "pod_station_visits": 50,
            "solves_stopped_early": 0,
            "decision_s_first": 0.5,
            "decision_s_later": 0.1,
            "decision_s_per_order": 0.002,
            "decision_percent_of_simulated": 0.01,
            "wall_s": 1.5,
            "run_s": 2.0,
            "key": f"{instance}-{orders}-{rule_set}-{seed}",
        } | figures

    return make


@pytest.fixture(scope="session")
def jobs() -> dict[str, list[Job]]:
    return {part.name: experiment_of(part).jobs() for part in PARTS}


@pytest.fixture(scope="session")
def report(row: MakeRow) -> Report:
    """Return the report on two seeds of everything; one run of the large part failed."""
    unfiltered = ("sequential", "split-among-stations")
    rule_sets = {
        "instances": (*METHODS, SIX_ORDERS),
        "packing": (*unfiltered, "packing-10"),
        "prefilter": (*unfiltered, *map(prefiltered, PREFILTER)),
        "large": METHODS,
    }
    parts = {
        part: [
            row(rule_set, seed, orders=orders, psv_per_order=1 + seed / 10)
            for rule_set in names
            for seed in (1, 2)
            for orders in ((50, 150, 250) if part == "instances" else (250,))
        ]
        for part, names in rule_sets.items()
    }
    parts["examples"] = [row(instance=name) for name in load_paper()["examples"].values]
    parts["large"][0] |= {"status": "failed", "error": "robot 3 | waits for 4", "error_kind": "StandstillError"}
    return make_report(parts, [load_scenario("paper-250")], {"Command": "rmfs reproduce"})
