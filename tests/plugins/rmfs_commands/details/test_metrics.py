"""Metrics from hand-made events, against numbers worked out by hand."""

import json
from collections.abc import Iterable

import pytest
from attrs import evolve

from rmfs_commands.details.metrics import Metrics
from rmfs_core.events import (
    DecisionMade,
    Event,
    ItemPicked,
    OrderAssigned,
    OrderCompleted,
    RobotMoved,
    VisitStarted,
)
from rmfs_core.info import RunInfo
from rmfs_core.roles import Role
from rmfs_core.scenario.model import RunSection


def assigned(s: int, order: int, station: int, period: int = 1, complete: bool = True) -> OrderAssigned:
    """Return an order's assignment at second ``s``."""
    return OrderAssigned(s * 1000, order, station, skus=(0,), items=1, period=period, complete=complete)


def picked(s: int, order: int, station: int = 0, visit: int = 1) -> ItemPicked:
    """Return a pick that ends at second ``s``: 7 s of picking, 13 s of handling."""
    return ItemPicked(s * 1000, (s - 7) * 1000, (s + 6) * 1000, visit, station, pod=0, order=order, sku=0)


def visit(s: int, number: int) -> VisitStarted:
    """Return a pod's arrival at station 0."""
    return VisitStarted(s * 1000, number, robot=0, pod=0, station=0)


def moved(s: int, distance_m: int, pod: int | None) -> RobotMoved:
    """Return a run of robot 0."""
    return RobotMoved(
        s * 1000, 0, 0, origin=0, to=1, heading=0, wait_ticks=0, turn_ticks=0, distance_m=distance_m, pod=pod
    )


def decided(period: int, decides: str, wall_s: float, stopped_early: bool = False) -> DecisionMade:
    """Return a decision at 0 s."""
    return DecisionMade(0, period, Role.labelled(decides), "rule", 2, 1, 1, "optimal", 1.0, 1.0, stopped_early, wall_s)


def after(run: RunInfo, events: Iterable[Event], status: str = "complete", end_s: int = 0) -> Metrics:
    """Return metrics of a run with these events."""
    metrics = Metrics()
    metrics.run_started(run)
    for event in events:
        metrics.on_event(event)
    metrics.run_ended(end_s * 1000, status)
    return metrics


WHOLE_RUN = (
    assigned(0, order=0, station=0),
    moved(10, 30, pod=None),
    moved(20, 50, pod=0),
    visit(20, 1),
    picked(27, order=0),
    picked(40, order=0),
    OrderCompleted(40_000, 0),
    assigned(45, order=1, station=0, period=2),
    visit(50, 2),
    picked(57, order=1, visit=2),
    picked(70, order=1, visit=2),
    OrderCompleted(70_000, 1),
)


def test_a_run_worked_out_by_hand(tiny: RunInfo) -> None:
    """Two orders, four picks and two visits give the numbers of the definitions."""
    values = after(tiny, WHOLE_RUN, end_s=70).measured()
    assert values["orders_completed"] == values["orders_total"] == 2
    assert (values["picks"], values["pod_station_visits"]) == (4, 2)
    assert (values["psv_per_order"], values["pile_on"]) == (1.0, 2.0)
    assert (values["distance_m"], values["loaded_distance_m"], values["empty_distance_m"]) == (80, 50, 30)
    assert values["distance_per_order_m"] == 40.0
    assert values["turnover_s"] == (40 + 65) / 2
    assert values["turnover_backlog_s"] == (0 + 40) / 2
    assert values["turnover_station_s"] == (40 + 25) / 2
    assert values["makespan_s"] == 70.0
    assert values["orders_per_hour"] == pytest.approx(3600 * 2 / 70)
    assert values["picks_per_hour"] == pytest.approx(3600 * 4 / 70)


def test_a_warm_up_counts_for_nothing(tiny: RunInfo) -> None:
    """From 30 s on: the second order arrives before, so nothing is said of its time; of the first only picks count."""
    warm = evolve(tiny, scenario=evolve(tiny.scenario, run=RunSection(warmup_s=30.0)))
    values = after(warm, WHOLE_RUN, end_s=70).measured()
    assert (values["orders_completed"], values["orders_total"]) == (2, 2)
    assert (values["picks"], values["pod_station_visits"], values["distance_m"]) == (3, 1, 0)
    assert (values["psv_per_order"], values["pile_on"], values["turnover_s"]) == (0.5, 3.0, None)
    assert values["orders_per_hour"] == pytest.approx(3600 * 2 / 40)
    # the first item is in hand until 33 s, the last one beyond the makespan for 6 s
    assert values["picker_utilisation"] == (3 + 13 + 13 + 7) / (2 * 40)
    assert values["makespan_s"] == 70.0


def test_times_after_a_warm_up(tiny: RunInfo) -> None:
    """From 3 s on: the second order arrives after it, at 5 s, is assigned at 45 s and complete at 70 s."""
    warm = evolve(tiny, scenario=evolve(tiny.scenario, run=RunSection(warmup_s=3.0)))
    values = after(warm, WHOLE_RUN, end_s=70).measured()
    assert [values[f"turnover{part}_s"] for part in ("", "_backlog", "_station")] == [65.0, 40.0, 25.0]


def test_a_run_within_its_warm_up(tiny: RunInfo) -> None:
    """It has counted nothing."""
    warm = evolve(tiny, scenario=evolve(tiny.scenario, run=RunSection(warmup_s=900.0)))
    values = after(warm, WHOLE_RUN, end_s=70).measured()
    assert (values["picks"], values["orders_completed"], values["orders_per_hour"]) == (0, 0, None)


def test_pickers_are_busy_up_to_the_makespan_only(tiny: RunInfo) -> None:
    """The last item is handled 6 s beyond its pick; those are no part of the makespan."""
    values = after(tiny, WHOLE_RUN, end_s=70).measured()
    assert values["picker_utilisation"] == (4 * 13 - 6) / (2 * 70)


def test_a_partial_run_has_no_makespan(tiny: RunInfo) -> None:
    """With an order left, time counts to the end of the run, and means are over completed orders."""
    values = after(tiny, WHOLE_RUN[:8], status="partial", end_s=100).measured()
    assert (values["makespan_s"], values["simulated_s"]) == (None, 100.0)
    assert values["orders_completed"] == 1
    assert values["turnover_s"] == 40.0


def test_a_run_in_which_nothing_happens_has_no_means(tiny: RunInfo) -> None:
    """Without orders, visits or time every mean is None, and the values are valid JSON."""
    values = after(tiny, (), status="partial").measured()
    for name in ("psv_per_order", "pile_on", "distance_per_order_m", "turnover_s", "picker_utilisation"):
        assert values[name] is None
    json.dumps(values, allow_nan=False)


@pytest.mark.parametrize(
    ("events", "most"),
    [
        ((assigned(0, 0, 0), assigned(0, 1, 1)), 0),  # whole orders
        ((assigned(0, 0, 0, complete=False), assigned(0, 0, 1)), 1),  # two stations
        ((assigned(0, 0, 0, complete=False),), 1),  # a line left in the backlog
        ((assigned(0, 0, 0, complete=False), assigned(9, 0, 0, period=2)), 1),  # two periods
        ((assigned(0, 0, 0, complete=False), assigned(0, 0, 0)), 0),  # one part, told in two events
        ((assigned(0, 0, 0, complete=False), assigned(0, 1, 0, complete=False)), 2),  # two at once
        # one after the other: the first is complete before the second is split
        (
            (
                assigned(0, 0, 0, complete=False),
                assigned(1, 0, 1, period=2),
                picked(9, 0),
                OrderCompleted(9000, 0),
                assigned(9, 1, 0, period=3, complete=False),
            ),
            1,
        ),
    ],
)
def test_split_orders_open_at_once(tiny: RunInfo, events: tuple[Event, ...], most: int) -> None:
    """An order counts from when it is known to be split until its last item is picked."""
    assert after(tiny, events, status="partial").measured()["split_orders_open_max"] == most


def test_decisions_are_told_apart_by_period(tiny: RunInfo) -> None:
    """Only POA and joint decisions are periods."""
    metrics = after(
        tiny,
        (decided(1, "POA", 2.0), decided(1, "PPS", 1.0), decided(2, "POA+PPS", 0.5, stopped_early=True), *WHOLE_RUN),
        end_s=70,
    )
    assert (metrics.measured()["periods"], metrics.measured()["solves_stopped_early"]) == (2, 1)


def test_every_metric_is_in_the_catalogue(tiny: RunInfo) -> None:
    """The table at the end of a run shows each, under its heading."""
    assert {metric.name for metric in Metrics.measures} == after(tiny, ()).measured().keys()
    assert [metric.group for metric in Metrics.measures if metric.name == "picks"] == ["Pods"]
