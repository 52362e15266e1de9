"""The metrics that a run reports are held against its trace."""

from __future__ import annotations

from typing import Any

import pytest

from rmfs_trace.reader import Trace
from rmfs_validation import faults_of
from rmfs_validation.metrics import recompute

METRICS = (
    "orders_completed",
    "picks",
    "pod_station_visits",
    "psv_per_order",
    "pile_on",
    "distance_m",
    "loaded_distance_m",
    "turnover_s",
    "turnover_backlog_s",
    "turnover_station_s",
    "makespan_s",
    "simulated_s",
    "picker_utilisation",
    "periods",
    "split_orders_open_max",
)


@pytest.mark.parametrize("name", METRICS)
def test_an_altered_metric_is_found(recorded: Trace, recorded_result: dict[str, Any], name: str) -> None:
    """A metric that is not what the events amount to is named, and so is one that is missing."""
    metrics = recorded_result["metrics"]
    altered = {**recorded_result, "metrics": {**metrics, name: metrics[name] * 1.001 + 0.001}}
    (fault,) = faults_of(recorded, altered)
    assert (fault.kind, fault.sentence.split()[0]) == ("metric", name)
    del altered["metrics"][name]
    (fault,) = faults_of(recorded, altered)
    assert (fault.kind, fault.sentence.split()[0]) == ("metric", name)


def test_every_metric_is_recomputed(recorded: Trace, recorded_result: dict[str, Any]) -> None:
    """Whatever a result reports as a metric, the trace is enough to check it."""
    assert recompute(recorded).keys() == recorded_result["metrics"].keys()


def test_a_result_of_another_run_is_found(recorded: Trace, recorded_result: dict[str, Any]) -> None:
    """Trace and result have one scenario and one status."""
    for change_of in ({"status": "failed"}, {"scenario": {**recorded_result["scenario"], "seed": 99}}):
        (fault,) = faults_of(recorded, {**recorded_result, **change_of})
        assert fault.kind == "other-run"
