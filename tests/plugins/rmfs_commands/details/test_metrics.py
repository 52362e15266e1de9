"""Metrics and tables that every run leaves, and the figures in them that are worked out by hand."""

import csv
import json
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pytest
from attrs import evolve

import rmfs_core
from calling import exit_code, refusal
from cases import cases
from rmfs_commands.details import costs, departures
from rmfs_commands.details.catalogue import DETAILS, LATENESS, MEASURES, METRICS
from rmfs_commands.details.energy import Energy
from rmfs_commands.details.hours import Hours
from rmfs_commands.details.loading import load_result
from rmfs_commands.details.metrics import Metrics
from rmfs_commands.details.stations import Stations
from rmfs_commands.processes.events import StationDown, StationUp
from rmfs_commands.validation.checking import validate_trace
from rmfs_core import InputError
from rmfs_core.events import (
    DecisionMade,
    Event,
    ItemPicked,
    OrderArrived,
    OrderAssigned,
    OrderCompleted,
    QueueJoined,
    RobotMoved,
    StationClosed,
    StationOpened,
    VisitStarted,
)
from rmfs_core.info import RunInfo
from rmfs_core.roles import Role
from rmfs_core.scenario.model import FailuresSection, StationsSection
from rmfs_core.world import OrderData


def test_metrics_have_names_and_say_what_they_mean() -> None:
    names = [metric.name for metric in (*DETAILS, *LATENESS)]
    assert len(set(names)) == len(names)
    assert not {metric.name for group in METRICS.values() for metric in group} & {metric.name for metric in MEASURES}
    for name, metric in ((metric.name, metric) for metric in (*MEASURES, *Metrics.measures)):
        assert metric.meaning.endswith("."), name
        assert not re.search(r"\bof it\b|(?<!at )\b[Tt]he same\b|\bsuch\b", metric.meaning), name  # said alone
        assert (metric.unit == "s") == name.endswith("_s"), name


def fed(table: Any, events: Iterable[Event]) -> Any:
    """Return what counts events, when it has heard those that it listens to."""
    for event in events:
        table.handlers.get(type(event), lambda _: None)(event)
    return table


def driven(start_s: int, wait_s: int, end_s: int, distance_m: int, pod: int | None) -> RobotMoved:
    ticks = (1000 * s for s in (end_s, start_s))
    return RobotMoved(
        *ticks, 0, 0, to=1, heading=0, wait_ticks=1000 * wait_s, turn_ticks=0, distance_m=distance_m, pod=pod
    )


def assigned(s: int, order: int, station: int, period: int = 1, complete: bool = True) -> OrderAssigned:
    return OrderAssigned(s * 1000, order, station, skus=(0,), items=1, period=period, complete=complete)


def picked(s: int, order: int, station: int = 0, visit: int = 1) -> ItemPicked:
    return ItemPicked(s * 1000, (s - 7) * 1000, (s + 6) * 1000, visit, station, pod=0, order=order, sku=0)


def visit(s: int, number: int) -> VisitStarted:
    return VisitStarted(s * 1000, number, robot=0, pod=0, station=0)


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
    driven(0, 0, 10, 30, pod=None),
    driven(0, 0, 20, 50, pod=0),
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


def test_results_come_back(tmp_path: Path) -> None:
    due = rmfs_core.run("examples/small", overrides=[*SETTINGS, *DUE], out=tmp_path / "due")
    assert load_result(tmp_path / "due").orders == due.orders
    assert list(due.orders[0])[-3:] == ["due_s", "priority", "lateness_s"]
    result = rmfs_core.run("examples/small", overrides=["instance.orders=5"], out=tmp_path)
    read = load_result(tmp_path)
    assert "due_s" not in result.orders[0]
    assert not {metric.name for metric in LATENESS} & result.metrics.keys()
    assert (read.metrics, read.orders, read.visits) == (result.metrics, result.orders, result.visits)
    assert (read.periods, read.timing, read.versions) == (result.periods, result.timing, result.versions)
    assert (read.scenario, read.seed, read.status) == (result.scenario, result.seed, result.status)
    assert read.summary == result.summary
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


H = 3_600_000
EVENTS: tuple[Event, ...] = (
    OrderArrived(0, 0),
    OrderArrived(H - 1, 1),
    OrderAssigned(H, 0, station=0, skus=(0,), items=1, period=1, complete=True),
    VisitStarted(H + 5, visit=1, robot=0, pod=0, station=0),
    driven(2 * 3600, 0, 3 * 3600, 12, None),
    ItemPicked(3 * H + 7, 3 * H, 3 * H + 9, visit=1, station=0, pod=0, order=0, sku=0),
    OrderCompleted(3 * H + 7, 0),
)


def test_hours(tiny: RunInfo) -> None:
    assert len(Hours(tiny).rows(2 * H, {})) == 2  # a run that ends with an hour
    rows = fed(Hours(tiny), EVENTS).rows(3 * H + 7, fed(Energy(tiny, 0), EVENTS).metres())
    assert [(row["hour"], row["start_s"]) for row in rows] == [(0, 0), (1, 3600), (2, 7200), (3, 10_800)]
    counted = ("orders_in", "orders_out", "picks", "visits", "distance_m", "backlog")
    assert [[row[name] for name in counted] for row in rows] == [
        [2, 0, 0, 0, 0, 2],
        [0, 0, 0, 1, 0, 1],
        [0, 0, 0, 0, 0, 1],
        [0, 1, 1, 0, 12, 1],
    ]


AT_STATIONS: tuple[Event, ...] = (
    OrderArrived(0, 0),
    OrderAssigned(0, 0, station=0, skus=(0, 1), items=2, period=1, complete=True),
    OrderArrived(5_000, 1),
    QueueJoined(10_000, robot=0, pod=0, station=0),
    VisitStarted(20_000, visit=1, robot=0, pod=0, station=0),
    ItemPicked(27_000, 20_000, 33_000, visit=1, station=0, pod=0, order=0, sku=0),
    ItemPicked(40_000, 33_000, 46_000, visit=1, station=0, pod=0, order=0, sku=1),
    OrderAssigned(50_000, 1, station=1, skus=(0,), items=2, period=2, complete=True),
)


DAY = StationsSection(open=(("00:00", "01:00"),))
FAILS = StationsSection(outages=FailuresSection(mtbf_h=1, mttr_s=10))
DOWN, UP = (StationDown, StationClosed), (StationUp, StationOpened)
DOWN_TWICE = [(kind, t) for kinds, t in ((DOWN, 5_000), (UP, 15_000), (DOWN, 30_000), (UP, 33_000)) for kind in kinds]


@cases(
    "section events column seconds other",
    # open until 10 s, at work until 46 s, open again from 55 s on
    (DAY, [(StationClosed, 10_000), (StationOpened, 55_000)], "open_s", [26, 20, 5, 0, 51], 60),
    # out of service while items are to be picked, and later with an item in hand
    (FAILS, DOWN_TWICE, "down_s", [26, 10, 14, 4, 10], 0),
    (FAILS, [(kind, 50_000) for kind in DOWN], "down_s", [26, 20, 4, 4, 10], 0),  # nothing is to be picked
)
def test_a_station_that_is_closed_or_out_of_service(tiny: RunInfo, section, events, column, seconds, other) -> None:
    assert Stations(tiny).values(0, 60_000) == {}
    stations = Stations(evolve(tiny, scenario=evolve(tiny.scenario, stations=section)))
    fed(stations, (*AT_STATIONS, *(kind(tick, 0) for kind, tick in events)))
    first, second = stations.rows(0, 60_000)
    assert [first[name] for name in ("busy_s", "waiting_s", "idle_s", "starved_s", column)] == seconds
    assert second[column] == other
    hours = {"station_open_h": 111 / 3600, "open_utilisation_percent": 100 * 26 / 111}
    assert stations.values(0, 60_000) == (hours if section is DAY else {})
    assert stations.paid_ticks(0, 60_000) == (111_000 if section is DAY else 120_000)


def test_runs_have_no_figures_of_what_they_lack(tmp_path: Path) -> None:
    over = ["rules.wait_for_stock=false", "instance.orders=5", "rules.pp=free-flow"]
    result = rmfs_core.run("examples/replenished", overrides=over, out=tmp_path)
    assert "turnover_stock_s" not in result.metrics
    assert (tmp_path / "delays.csv").read_text(encoding="utf-8").startswith("order,turnover_s,backlog_s,")
    result = rmfs_core.run("examples/small", overrides=["instance.orders=3"], out=tmp_path)
    assert not {"bundles_stored", "stock_outs"} & result.metrics.keys()
    assert not (tmp_path / "bundles.csv").exists()


def order(route: str | None = None) -> OrderData:
    return OrderData("a", arrival_tick=0, lines=((0, 1),), route=route)


DUE_ORDERS = [  # route, due, done
    (order("n"), 10_000, 10_000),  # just in time
    (order("n"), 10_000, 10_001),  # 1 ms late
    (order("n"), 10_000, None),  # not done when the run ends at 50 s: 40 s late
    (order("s"), 10_000, 4_000),
    (order("s"), 60_000, 20_000),  # before a truck that leaves after the end
    (order("s"), 60_000, None),  # which may still come
]


def test_trucks_and_who_missed_them() -> None:
    north, south, later = departures.rows(DUE_ORDERS, 50_000)
    assert tuple(north.values()) == (1, "n", 10.0, 3, 1, 2, 0, 1 / 3, 20.0)  # (1 ms + 40 s) / 2, in whole ms
    assert tuple(south.values()) == (2, "s", 10.0, 1, 1, 0, 0, 1.0, None)
    assert tuple(later.values()) == (3, "s", 60.0, 2, 0, 0, 2, None, None)  # an early order would flatter the share
    assert departures.values(DUE_ORDERS, 50_000) == {"departed_share": 2 / 4, "missed_percent": 50.0}
    assert departures.values([], 50_000) == {"departed_share": None, "missed_percent": None}
    assert costs.lateness(DUE_ORDERS, 50_000) == (2, 40_001)


@cases(
    "orders end until share",
    (DUE_ORDERS, 60_000, 60_000, 3 / 6),  # the truck has left
    (DUE_ORDERS[4:5], 20_000, None, 1.0),  # all orders are done: the run is over
    (DUE_ORDERS[4:5], 20_000, 50_000, None),  # the same trucks count for all rules, also for those that are done early
    (DUE_ORDERS[4:5], 20_000, 60_000, 1.0),
)
def test_which_trucks_count(orders, end, until, share) -> None:
    assert departures.values(orders, end, until)["departed_share"] == share


SMALL = ("instance.orders=10", "rules.pp=free-flow", "robots.count=3", "stations.item_capacity=4")
TRUCKS = ("instance.departures.times=[20, 60, 5000]", "instance.departures.cutoff_s=1")
PRICES = "costs={picker_per_h=36, packer_per_h=18, robot_per_h=3.6, late_order=2, late_h=36}"
PACKED = ("packing={packers=1, sorters=1, conveyor_s=5}",)
SHIFT = ('stations.open=[["00:01", "00:02"]]', 'robots.available=[["00:00", "00:01"], ["00:01", "24:00", 2]]')
FAILING = ("stations.outages={mtbf_h=0.01, mttr_s=20}", SHIFT[0])
RUNS = (0, 0, ()), (0, 0, PACKED), (0, 0, SHIFT), (0, 70, ()), (30, 0, PACKED), (0, 40, PACKED), (0, 0, FAILING)
BUNDLES = ("layout.replenishment_west=", "stations.also_replenish=true", "instance.replenishment.lead_s=300")
BY_NIGHT = (*BUNDLES, 'stations.open=[["00:00", "00:08"]]', "run.until_s=2000", "instance.orders=60", PRICES)


@cases("warmup_s end_s more", *RUNS)
def test_a_run_costs_what_its_trace_says(tmp_path: Path, warmup_s: float, end_s: float, more: tuple[str, ...]) -> None:
    ends = ([f"run.warmup_s={warmup_s}"] if warmup_s else []) + ([f"run.until_s={end_s}"] if end_s else [])
    every = [*SMALL, *TRUCKS, PRICES, "instance.arrivals={process='poisson', orders_per_hour=900}", *more, *ends]
    result = rmfs_core.run("examples/small", overrides=every, out=tmp_path, record=["trace"])
    assert validate_trace(tmp_path) == []
    parts = {name: value for name, value in result.metrics.items() if name.startswith("cost_") and name != "cost_total"}
    per_order = parts.pop("cost_per_order")
    assert per_order == (None if None in parts.values() else pytest.approx(sum(parts.values())))
    assert ("cost_packers_per_order" in parts, parts["cost_pickers_per_order"] != 0) == (more == PACKED, True)


def test_energy_is_what_batteries_give_or_else_what_driving_takes(tmp_path: Path) -> None:
    plain = rmfs_core.run("examples/small", overrides=[*SMALL, "costs.kwh=1000"], out=tmp_path).metrics
    assert "departed_share" not in plain
    assert not (tmp_path / "departures.csv").exists()
    assert plain["cost_total"] == pytest.approx(plain["energy_wh"] or 0)
    draws = "robots.battery={empty_w=90, loaded_w=90, lifting_w=90, idle_w=90, charging_w=9}"
    more = ("layout.chargers=1", "rules.idle=charge-when-low", draws)
    battery = rmfs_core.run("examples/small", overrides=[*SMALL, "costs.kwh=1000", *more]).metrics
    hours = 3 * (battery["simulated_s"] or 0) / 3600 * (1 - (battery["charging_percent"] or 0) / 100)
    assert battery["cost_total"] == pytest.approx(90 * hours)


def test_explain_and_report_tell_of_trucks_and_costs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    every = [*SMALL, "instance.departures.times=[60]", PRICES]
    result = rmfs_core.run("examples/small", overrides=every, out=tmp_path, record=["decisions"])
    late = next(row for row in result.orders if row["completed_s"] > row["due_s"])
    soon = next(row for row in result.orders if row["completed_s"] <= row["due_s"])
    for row, begins in (
        (late, "It missed the truck that left at 60 s: it was picked at "),
        (soon, "It was in time for "),
    ):
        assert exit_code("explain", str(tmp_path), "--order", row["order"]) == 0
        assert begins in capsys.readouterr().out
        exit_code("explain", str(tmp_path), "--order", row["order"], "--json")
        truck = json.loads(capsys.readouterr().out)["truck"]
        assert (truck["route"], truck["leaves_s"], truck["done_s"]) == (None, row["due_s"], row["completed_s"])
    assert exit_code("report", str(tmp_path)) == 0
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert all(f"<h2>{heading}</h2>" in page for heading in ("Departures", "What an order costs"))


FEW_AN_HOUR = "instance.arrivals={process='poisson', orders_per_hour=14}"
BUSY = "instance.arrivals={process='poisson', orders_per_hour=400}"
LATE = "instance.due={allowance_s=60, spread_s=60, priority_share=0.4, priority_allowance_s=20}"
BATTERY = "robots.battery={capacity_wh=90, loaded_w=900, charging_w=20000}"


@cases(
    "name changes",
    ("examples/small", (FEW_AN_HOUR, LATE, "run.warmup_s=3700", 'stations.open={1=[["00:00", "01:30"]]}')),
    ("examples/small", (BUSY, LATE, "run.warmup_s=30", "run.until_s=200", "rules.pp=whca-n")),
    ("examples/small", (BUSY, "layout.chargers=1", "rules.idle=charge-when-low", "rules.move=utility", BATTERY)),
    ("examples/small", (BUSY, "stations.outages={mtbf_h=0.05, mttr_s=60}", "robots.available=[['00:00', '00:04', 3]]")),
    ("examples/small", ("rules.poa=", "rules.pps=", "rules.poa_pps=split-over-time", "stations.release=handled")),
    ("examples/replenished", ("run.warmup_s=100",)),
    ("examples/replenished", ("instance.replenishment.lead_s=60", "stations.outages={mtbf_h=0.1, mttr_s=30}")),
)
def test_metrics_and_tables_are_what_the_trace_amounts_to(tmp_path: Path, name: str, changes: tuple[str, ...]) -> None:
    rmfs_core.run(name, overrides=["instance.orders=30", *changes], out=tmp_path, record=["trace"])
    assert validate_trace(tmp_path) == []


@cases("more", (), ("stations.outages={mtbf_h=0.01, mttr_s=30}",))
def test_a_picker_who_stores_a_bundle_after_closing_is_paid(tmp_path: Path, more: tuple[str, ...]) -> None:
    rmfs_core.run("examples/replenished", overrides=[*BY_NIGHT, *more], out=tmp_path, record=["trace"])
    bundles = (tmp_path / "bundles.csv").read_text(encoding="utf-8").splitlines()[1:]
    assert any(float(row.split(",")[5] or 0) > 900 for row in bundles)
    assert validate_trace(tmp_path) == []


def test_times_of_packing_leave_out_orders_that_arrive_before_the_warm_up_ends(tmp_path: Path) -> None:
    result = rmfs_core.run("examples/packing", overrides=[BUSY, "run.warmup_s=300"], out=tmp_path, record=["trace"])
    with (tmp_path / "packing.csv").open(encoding="utf-8") as file:
        packed = {row["order"]: row for row in csv.DictReader(file)}
    rows = [packed[order["order"]] for order in result.orders if order["arrival_s"] >= 300]
    together = [float(row["last_part_s"]) - float(row["first_part_s"]) for row in rows if row["box"]]
    assert result.metrics["consolidation_s"] == pytest.approx(sum(together) / len(together))
    waits = [float(row["packing_s"]) - float(row["last_part_s"]) for row in rows if not row["box"]]
    assert 0 < len(waits) < len(rows) < sum(float(row["packed_s"]) >= 300 for row in packed.values())
    assert validate_trace(tmp_path) == []
