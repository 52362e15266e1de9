"""The metrics that a run reports are held against its trace."""

from __future__ import annotations

from typing import Any

import pytest
from attrs import evolve

from rmfs_commands.trace.reader import Trace
from rmfs_commands.validation import faults_of
from rmfs_commands.validation.details import recompute_details
from rmfs_commands.validation.metrics import recompute

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
    found = recompute(recorded) | recompute_details(recorded)
    assert found.keys() == recorded_result["metrics"].keys()


def test_a_result_of_another_run_is_found(recorded: Trace, recorded_result: dict[str, Any]) -> None:
    """Trace and result have one scenario and one status."""
    for change_of in ({"status": "failed"}, {"scenario": {**recorded_result["scenario"], "seed": 99}}):
        (fault,) = faults_of(recorded, {**recorded_result, **change_of})
        assert fault.kind == "other-run"


@pytest.mark.parametrize(
    ("altered", "kind"),
    [
        ({"seed": True}, "other-run"),
        ({"timing": {"wall_s": True}}, "metric"),
        ({"timing": {"hook_s": {"plan_path": False}}}, "metric"),
        ({"metrics": {"mine": True}}, "metric"),
    ],
)
def test_true_is_no_number(recorded: Trace, recorded_result: dict[str, Any], altered: Any, kind: str) -> None:
    """Though Python takes it for 1, which the seed of this run is."""
    assert recorded_result["seed"] == 1
    (section,) = altered
    if section != "seed":
        altered = {section: recorded_result[section] | altered[section]}
    (fault,) = faults_of(recorded, recorded_result | altered)
    assert fault.kind == kind


def test_the_metrics_of_a_day(day: Trace) -> None:
    """One order of three items in one visit, worked out by hand.

    The robot drives 2 m to its pod, 1 + 3 + 1 m to the station and 1 + 4 + 2 m back. The order is assigned at once and
    complete with the last pick at 48.028 s, 33 s after the first one began: two items are handled for 13 s by then, and
    the third is picked for 7 s.
    """
    found = recompute(day)
    assert (found["distance_m"], found["loaded_distance_m"], found["empty_distance_m"]) == (14, 12, 2)
    assert (found["turnover_backlog_s"], found["turnover_station_s"], found["turnover_s"]) == (0, 48.028, 48.028)
    assert (found["picks"], found["pod_station_visits"], found["pile_on"], found["psv_per_order"]) == (3, 1, 3, 1)
    assert (found["makespan_s"], found["simulated_s"]) == (48.028, 48.028)
    assert found["picker_utilisation"] == pytest.approx(33 / 48.028)
    assert found["picks_per_hour"] == pytest.approx(3 * 3600 / 48.028)
    assert (found["periods"], found["split_orders_open_max"], found["orders_total"]) == (1, 0, 1)


def test_a_day_that_is_not_over(day: Trace) -> None:
    """Without a complete order there is no makespan and no mean; time runs to the end of the trace."""
    found = recompute(evolve(day, events=day.events[:15], status="partial"))
    assert (found["orders_completed"], found["picks"], found["simulated_s"]) == (0, 2, 61.098)
    assert found["makespan_s"] is found["turnover_s"] is found["psv_per_order"] is None


def test_an_order_is_split_in_two_ways(day: Trace) -> None:
    """Until it is complete: with a line left in the backlog, or with parts of two periods."""
    tea = evolve(day.events[1], skus=(0,), items=1, complete=False)
    jam = evolve(day.events[1], skus=(1,), items=2, period=2)
    assert recompute(evolve(day, events=(day.events[0], tea, *day.events[2:])))["split_orders_open_max"] == 1
    split = evolve(day, events=(day.events[0], tea, jam, *day.events[2:]))
    assert recompute(split)["split_orders_open_max"] == 1
    longer_warm = evolve(split, scenario={**split.scenario, "run": {"warmup_s": 1e6}})
    assert recompute(longer_warm)["split_orders_open_max"] == 0
    assert recompute(evolve(day, events=(day.events[0], *day.events[1:])))["split_orders_open_max"] == 0
