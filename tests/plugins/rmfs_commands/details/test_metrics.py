"""Metrics that every run leaves, and the observer that counts them."""

import csv
import json
from collections.abc import Iterable
from pathlib import Path

import pytest
from attrs import evolve

import rmfs_core
from calling import refusal
from cases import cases
from rmfs_commands.details.catalogue import DETAILS, LATENESS, MEASURES, METRICS, on_time
from rmfs_commands.details.delays import COLUMNS, Delays
from rmfs_commands.details.loading import load_result
from rmfs_commands.details.measures import Measures
from rmfs_commands.details.metrics import Metrics
from rmfs_commands.details.robots import Robots
from rmfs_commands.details.spans import Number
from rmfs_commands.validation.checking import validate_trace
from rmfs_core import InputError
from rmfs_core.events import (
    DecisionMade,
    Event,
    ItemPicked,
    OrderAssigned,
    OrderCompleted,
    PodLifted,
    QueueJoined,
    RobotMoved,
    RobotsOnDuty,
    TaskAssigned,
    VisitEnded,
    VisitStarted,
)
from rmfs_core.info import RunInfo
from rmfs_core.roles import Role
from rmfs_core.scenario.model import RunSection
from rmfs_core.world import Instance, OrderData


def test_metrics_have_names_and_say_what_they_mean() -> None:
    names = [metric.name for metric in (*DETAILS, *LATENESS)]
    assert len(set(names)) == len(names)
    assert not {metric.name for group in METRICS.values() for metric in group} & {metric.name for metric in MEASURES}
    for name, metric in ((metric.name, metric) for metric in (*MEASURES, *Metrics.measures)):
        assert metric.meaning.endswith("."), name
        assert (metric.unit == "s") == name.endswith("_s"), name


ORDERS = (
    OrderData("a", arrival_tick=0, lines=((0, 1),), due_tick=15_000),  # complete at 10 s: in time
    OrderData("b", arrival_tick=0, lines=((0, 3), (1, 1)), due_tick=15_000, priority=2),  # at 20 s: 5 s late
    OrderData("c", arrival_tick=10_000, lines=((0, 1),), due_tick=5_000),  # due before it arrives; at 40 s: 35 s late
    OrderData("d", arrival_tick=0, lines=((0, 1),)),  # never due; at 40 s
    OrderData("e", arrival_tick=0, lines=((0, 1),), due_tick=30_000),  # not complete at 50 s: late
    OrderData("f", arrival_tick=0, lines=((0, 1),), due_tick=60_000),  # not complete, but there is time
)


def values(run: RunInfo, orders: tuple[OrderData, ...] = ORDERS, begin_s: int = 0) -> dict[str, Number]:
    """Return the metrics of a run of 50 s in which the first four orders are assigned at 5 s or when they arrive."""
    measures = Measures(evolve(run, instance=Instance(("x", "y"), orders, ())), begin_s * 1000)
    for i, tick in enumerate((5_000, 5_000, 10_000, 5_000)):
        measures.handlers[OrderAssigned](OrderAssigned(tick, i, 0, (0,), 1, 1, complete=True))
    for visit, tick in enumerate((3_000, 30_000), 1):
        measures.handlers[VisitStarted](VisitStarted(tick, visit, robot=0, pod=0, station=0))
    for i, tick in enumerate((10_000, 20_000, 40_000, 40_000)):
        measures.handlers[OrderCompleted](OrderCompleted(tick, i))
    return measures.values(50_000)


def test_percentiles_and_lateness(tiny: RunInfo) -> None:
    found = values(tiny)
    assert (found["turnover_median_s"], found["turnover_p95_s"]) == (25.0, 38.5)
    assert (found["turnover_backlog_median_s"], found["turnover_backlog_p95_s"]) == (5.0, 5.0)
    assert (found["turnover_station_median_s"], found["turnover_station_p95_s"]) == (22.5, 34.25)
    assert (found["items_per_line"], found["orders_per_visit"]) == (7 / 5, 2.0)
    found = values(tiny)
    assert (found["late_orders"], found["late_percent"], found["on_time_percent"]) == (3, 75.0, 25.0)
    assert (found["tardiness_s"], found["tardiness_p95_s"]) == (40 / 3, pytest.approx(32))
    early = (evolve(ORDERS[0], due_tick=60_000), *ORDERS[1:])  # of those that are due then only it is known
    assert values(tiny, early)["late_percent"] == 100
    priorities = {name: value for name, value in found.items() if "priority" in name}
    assert priorities == {"on_time_percent_priority_0": 100 / 3, "on_time_percent_priority_2": 0.0}
    assert not any(
        "late" in name or "time" in name for name in values(tiny, tuple(evolve(o, due_tick=None) for o in ORDERS))
    )
    assert on_time(12).name == "on_time_percent_priority_12"
    groups = {metric.name: metric.group for metric in MEASURES}
    assert groups[on_time(0).name] == "Due times"
    assert groups["turnover_p95_s"] is None


def test_a_warm_up(tiny: RunInfo) -> None:
    """Of times those of orders that arrive after it count; orders complete after it count per visit."""
    found = values(tiny, begin_s=10)
    assert (found["turnover_median_s"], found["late_orders"], found["tardiness_s"]) == (30.0, 1, 35.0)
    assert found["orders_per_visit"] == 4.0
    warm = evolve(tiny, scenario=evolve(tiny.scenario, run=RunSection(warmup_s=3.0)))
    measured = after(warm, WHOLE_RUN, end_s=70).measured()
    assert [measured[f"turnover{part}_s"] for part in ("", "_backlog", "_station")] == [65.0, 40.0, 25.0]
    warm = evolve(tiny, scenario=evolve(tiny.scenario, run=RunSection(warmup_s=900.0)))
    measured = after(warm, WHOLE_RUN, end_s=70).measured()
    assert (measured["picks"], measured["orders_completed"], measured["orders_per_hour"]) == (0, 0, None)


def assigned(s: int, order: int, station: int, period: int = 1, complete: bool = True) -> OrderAssigned:
    return OrderAssigned(s * 1000, order, station, skus=(0,), items=1, period=period, complete=complete)


def picked(s: int, order: int, station: int = 0, visit: int = 1) -> ItemPicked:
    return ItemPicked(s * 1000, (s - 7) * 1000, (s + 6) * 1000, visit, station, pod=0, order=order, sku=0)


def visit(s: int, number: int) -> VisitStarted:
    return VisitStarted(s * 1000, number, robot=0, pod=0, station=0)


def moved(s: int, distance_m: int, pod: int | None) -> RobotMoved:
    return RobotMoved(
        s * 1000, 0, 0, origin=0, to=1, heading=0, wait_ticks=0, turn_ticks=0, distance_m=distance_m, pod=pod
    )


def decided(period: int, decides: str, wall_s: float, stopped_early: bool = False) -> DecisionMade:
    return DecisionMade(0, period, Role.labelled(decides), "rule", 2, 1, 1, "optimal", 1.0, 1.0, stopped_early, wall_s)


def after(run: RunInfo, events: Iterable[Event], status: str = "complete", end_s: int = 0) -> Metrics:
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
    values = after(tiny, WHOLE_RUN, end_s=70).measured()
    assert values["orders_completed"] == values["orders_total"] == 2
    assert (values["picks"], values["pod_station_visits"]) == (4, 2)
    assert (values["psv_per_order"], values["pile_on"]) == (1.0, 2.0)
    assert (values["distance_m"], values["loaded_distance_m"], values["empty_distance_m"]) == (80, 50, 30)
    assert (values["distance_per_order_m"], values["turnover_s"]) == (40.0, (40 + 65) / 2)
    assert values["turnover_backlog_s"] == (0 + 40) / 2
    assert (values["turnover_station_s"], values["makespan_s"]) == ((40 + 25) / 2, 70.0)
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


def test_runs_that_end_early(tiny: RunInfo) -> None:
    values = after(tiny, WHOLE_RUN, end_s=70).measured()
    assert values["picker_utilisation"] == (4 * 13 - 6) / (2 * 70)
    values = after(tiny, WHOLE_RUN[:8], status="partial", end_s=100).measured()
    assert (values["makespan_s"], values["simulated_s"]) == (None, 100.0)
    assert (values["orders_completed"], values["turnover_s"]) == (1, 40.0)
    values = after(tiny, (), status="partial").measured()
    for name in ("psv_per_order", "pile_on", "distance_per_order_m", "turnover_s", "picker_utilisation"):
        assert values[name] is None
    json.dumps(values, allow_nan=False)


@cases(
    "events most",
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
)
def test_split_orders_open_at_once(tiny: RunInfo, events: tuple[Event, ...], most: int) -> None:
    assert after(tiny, events, status="partial").measured()["split_orders_open_max"] == most


def test_the_catalogue(tiny: RunInfo) -> None:
    metrics = after(
        tiny,
        (decided(1, "POA", 2.0), decided(1, "PPS", 1.0), decided(2, "POA+PPS", 0.5, stopped_early=True), *WHOLE_RUN),
        end_s=70,
    )
    assert (metrics.measured()["periods"], metrics.measured()["solves_stopped_early"]) == (2, 1)
    assert {metric.name for metric in Metrics.measures} == after(tiny, ()).measured().keys()
    assert [metric.group for metric in Metrics.measures if metric.name == "picks"] == ["Pods"]


SETTINGS = ("instance.orders=12", "rules.pp=free-flow", "instance.arrivals.process=poisson")
DUE = (
    "instance.arrivals.orders_per_hour=200",
    "instance.due.allowance_s=300",
    "instance.due.priority_share=0.4",
    "instance.due.priority_allowance_s=60",
    "run.warmup_s=100",
)


def rows(folder: Path, name: str) -> list[dict[str, str]]:
    return list(csv.DictReader((folder / name).read_text(encoding="utf-8").splitlines()))


def test_files_metrics_and_their_validation(tmp_path: Path) -> None:
    result = rmfs_core.run("examples/small", overrides=[*SETTINGS, *DUE], out=tmp_path, record=["trace"])
    metrics = json.loads((tmp_path / "result.json").read_text(encoding="utf-8"))["metrics"]
    names = {metric.name for metric in (*DETAILS, *LATENESS)} - {"orders_cancelled"}  # where any may be
    assert names <= metrics.keys() & result.described.keys()
    assert sum(int(row["orders_in"]) for row in rows(tmp_path, "hours.csv")) == 12
    measured_s = result.metrics["simulated_s"] - 100
    for name, parts in (("stations.csv", ("busy_s", "waiting_s", "idle_s")), ("robots.csv", ())):
        for row in rows(tmp_path, name):
            times = [float(row[column]) for column in parts or [column for column in row if column.endswith("_s")]]
            assert sum(times) == pytest.approx(measured_s, abs=1e-6)
    for order, delay in zip(rows(tmp_path, "orders.csv"), rows(tmp_path, "delays.csv"), strict=True):
        assert (order["order"], order["turnover_s"]) == (delay["order"], delay["turnover_s"])
        assert float(order["lateness_s"]) == pytest.approx(float(order["completed_s"]) - float(order["due_s"]))
    assert validate_trace(tmp_path) == []


def test_results_come_back(tmp_path: Path) -> None:
    due = rmfs_core.run("examples/small", overrides=[*SETTINGS, *DUE], out=tmp_path / "due")
    plain = rmfs_core.run(
        "examples/small", overrides=["instance.orders=3", "rules.pp=free-flow"], out=tmp_path / "plain"
    )
    assert load_result(tmp_path / "due").orders == due.orders
    assert list(due.orders[0])[-3:] == ["due_s", "priority", "lateness_s"]
    assert "due_s" not in plain.orders[0]
    assert load_result(tmp_path / "plain").orders == plain.orders
    assert not {metric.name for metric in LATENESS} & plain.metrics.keys()
    result = rmfs_core.run("examples/small", overrides=["instance.orders=5"], out=tmp_path)
    read = load_result(tmp_path)
    assert (read.metrics, read.orders, read.visits) == (result.metrics, result.orders, result.visits)
    assert (read.periods, read.timing, read.versions) == (result.periods, result.timing, result.versions)
    assert (read.scenario, read.seed, read.status) == (result.scenario, result.seed, result.status)
    assert read.described["makespan_s"] == result.described["makespan_s"]


def test_foreign_files_are_not_replaced(tmp_path: Path) -> None:
    (tmp_path / "stations.csv").write_text("mine", encoding="utf-8")
    with pytest.raises(InputError, match=r"found a file stations\.csv that no run of rmfs has written"):
        rmfs_core.run("examples/small", overrides=["instance.orders=1"], out=tmp_path)


@cases(
    "name content problem",
    ("result.json", "{", "result.json, line 1: this is no valid JSON"),
    ("result.json", "[]", "the key `scenario` is missing"),
    ("orders.csv", "order\n", "orders.csv, line 1: expected the columns"),
    ("visits.csv", "visit,pod,station,robot,start_s,end_s,picks\n1,p,1,1,0.0,x,3\n", "visits.csv, line 2"),
    ("visits.csv", "visit,pod,station,robot,start_s,end_s,picks\n1,p\n", "visits.csv, line 2"),
    ("periods.csv", None, "periods.csv: cannot be read"),
)
def test_a_broken_result(tmp_path: Path, name: str, content: str | None, problem: str) -> None:
    rmfs_core.run("examples/small", overrides=["instance.orders=5"], out=tmp_path / "out")
    (tmp_path / "out" / name).unlink()
    if content is not None:
        (tmp_path / "out" / name).write_text(content)
    assert problem in refusal(lambda: load_result(tmp_path / "out"))


WAY = (
    TaskAssigned(7_000, robot=0, pod=0),
    RobotMoved(11_000, 7_000, 0, origin=0, to=3, heading=0, wait_ticks=0, turn_ticks=0, distance_m=3, pod=None),
    PodLifted(15_000, 13_000, robot=0, pod=0, cell=3),
    QueueJoined(30_000, robot=0, pod=0, station=0),
    VisitStarted(42_000, visit=1, robot=0, pod=0, station=0),
    ItemPicked(49_000, 42_000, 55_000, visit=1, station=0, pod=0, order=0, sku=0),
    OrderCompleted(49_000, 0),
)


def part(tick_s: int, *, complete: bool) -> OrderAssigned:
    return OrderAssigned(tick_s * 1000, 0, 0, skus=(0,), items=1, period=1, complete=complete)


def row_of(run: RunInfo, *events: Event) -> list[float | None]:
    robots = Robots(run, 0)
    delays = Delays(run, 0, robots)
    for event in sorted(events, key=lambda event: event.tick):
        for handlers in (robots.handlers, delays.handlers):
            if type(event) in handlers:
                handlers[type(event)](event)
    row, other = delays.rows()
    assert set(other.values()) == {"second", None}
    assert row["turnover_s"] is None or sum(row[column] for column in COLUMNS) == row["turnover_s"]
    return [row[column] for column in COLUMNS]


@cases(
    "last_part_s expected",
    (3, [2, 1, 2, 2, 6, 2, 15, 12, 7]),  # before the pod is fetched; until 5 s no robot is free
    (10, [2, 8, 0, 0, 3, 2, 15, 12, 7]),  # on the way to it
    (12, [2, 10, 0, 0, 2, 1, 15, 12, 7]),  # beneath it
    (20, [2, 18, 0, 0, 0, 0, 10, 12, 7]),  # while it drives
    (35, [2, 33, 0, 0, 0, 0, 0, 7, 7]),  # while it queues
    (45, [2, 43, 0, 0, 0, 0, 0, 0, 4]),  # while it stands at the station
)
def test_an_order_of_two_parts(tiny: RunInfo, last_part_s: int, expected: list[float]) -> None:
    """The first part is assigned at 2 s; what the last pod did before the last part was assigned counts as nothing.

    The other robot never works; this one is free from 5 s on.
    """
    shift = RobotsOnDuty(0, number=0), RobotsOnDuty(5_000, number=1)
    assert row_of(tiny, *shift, part(2, complete=False), part(last_part_s, complete=True), *WAY) == expected


def test_where_an_orders_time_went(tiny: RunInfo) -> None:
    before = (
        *WAY[:1],
        PodLifted(8_000, 7_000, robot=0, pod=0, cell=3),
        QueueJoined(8_500, robot=0, pod=0, station=1),
        VisitStarted(9_000, visit=1, robot=0, pod=0, station=1),
        VisitEnded(20_000, visit=1, pod=0, station=1, picks=1, next_station=0),
    )
    assert row_of(tiny, part(2, complete=True), *before, *WAY[3:]) == [2, 0, 0, 18, 0, 0, 10, 12, 7]
    assert row_of(tiny, part(0, complete=True), *WAY[5:]) == [0] * 8 + [49]
    assert row_of(tiny, part(2, complete=True), *WAY[:5]) == [None] * 9
