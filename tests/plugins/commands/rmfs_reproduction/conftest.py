"""Rows of runs, made by hand."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from rmfs_experiments import Job
from rmfs_reproduction.parts import PARTS, experiment_of

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
    """Return every run of a whole reproduction, by part."""
    return {part.name: experiment_of(part).jobs() for part in PARTS}
