"""Tables that every run leaves, and figures worked out by hand: which orders trucks take, what an order costs."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from attrs import evolve

import rmfs_core
from calling import exit_code
from cases import cases
from rmfs_commands.details import costs, departures
from rmfs_commands.details.energy import run_j, turn_j
from rmfs_commands.details.hours import Hours
from rmfs_commands.details.robots import Robots
from rmfs_commands.details.spans import Count, length, merged, overlap, percentile, within
from rmfs_commands.details.stations import Stations
from rmfs_commands.validation.checking import validate_trace
from rmfs_core.events import (
    Event,
    ItemPicked,
    OrderArrived,
    OrderAssigned,
    OrderCompleted,
    PodLifted,
    PodStored,
    QueueJoined,
    RobotMoved,
    RobotsOnDuty,
    StationClosed,
    StationOpened,
    TaskAssigned,
    VisitEnded,
    VisitStarted,
)
from rmfs_core.info import RunInfo
from rmfs_core.scenario.model import Costs, RobotsSection, StationsSection
from rmfs_core.world import OrderData


def test_spans_and_counts_over_time() -> None:
    assert merged([(5, 9), (0, 2), (2, 4), (8, 12), (3, 3)]) == [(0, 4), (5, 12)]
    assert within([(0, 4), (5, 12)], 3, 7) == [(3, 4), (5, 7)]
    assert length([(0, 4), (5, 12)]) == 11
    assert overlap([(0, 4), (5, 12)], [(3, 6), (10, 20)]) == 1 + 1 + 2
    count = Count()
    for tick, change in ((10, 1), (10, 1), (20, -1), (25, -1)):
        count.add(tick, change)
    assert count.above_zero(0, 40) == [(10, 25)]
    assert count.mean(0, 40) == 25 / 40
    assert (count.largest(0, 40), count.largest(22, 40), count.largest(30, 40)) == (2, 1, 0)


@pytest.mark.parametrize("share", [0.5, 0.95])
def test_percentiles_are_those_of_numpy(share: float) -> None:
    values = [7000, 1000, 4500, 12000, 3000]
    assert percentile(values, share) == pytest.approx(np.percentile(values, 100 * share) / 1000)
    assert percentile([], share) is None


H = 3_600_000
EVENTS: tuple[Event, ...] = (
    OrderArrived(0, 0),
    OrderArrived(H - 1, 1),
    OrderAssigned(H, 0, station=0, skus=(0,), items=1, period=1, complete=True),
    VisitStarted(H + 5, visit=1, robot=0, pod=0, station=0),
    RobotMoved(3 * H, 2 * H, robot=0, origin=0, to=1, heading=0, wait_ticks=0, turn_ticks=0, distance_m=12, pod=None),
    ItemPicked(3 * H + 7, 3 * H, 3 * H + 9, visit=1, station=0, pod=0, order=0, sku=0),
    OrderCompleted(3 * H + 7, 0),
)


def test_hours(tiny: RunInfo) -> None:
    hours = Hours(tiny)
    for event in EVENTS:
        hours.handlers[type(event)](event)
    rows = hours.rows(3 * H + 7)
    assert [(row["hour"], row["start_s"]) for row in rows] == [(0, 0), (1, 3600), (2, 7200), (3, 10_800)]
    counted = ("orders_in", "orders_out", "picks", "visits", "distance_m", "backlog")
    assert [[row[name] for name in counted] for row in rows] == [
        [2, 0, 0, 0, 0, 2],
        [0, 0, 0, 1, 0, 1],
        [0, 0, 0, 0, 0, 1],
        [0, 1, 1, 0, 12, 1],
    ]


def test_a_run_that_ends_with_an_hour(tiny: RunInfo) -> None:
    assert len(Hours(tiny).rows(2 * H)) == 2


def test_who_is_there(tiny: RunInfo) -> None:
    spans = (("00:00", "01:00"),)
    scenario = evolve(
        tiny.scenario, stations=StationsSection(open=spans), robots=RobotsSection(count=2, available=spans)
    )
    hours = Hours(evolve(tiny, scenario=scenario))
    for event in (StationClosed(H // 4, 0), RobotsOnDuty(H + H // 2, number=1), StationOpened(2 * H + H // 4, 0)):
        hours.handlers[type(event)](event)
    rows = hours.rows(2 * H + H // 2)
    assert [(row["stations_open"], row["robots_on_duty"]) for row in rows] == [(1.25, 2), (1, 1.5), (1.5, 1)]
    assert "stations_open" not in Hours(tiny).rows(H)[0]


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


@cases(
    "begin_s first second",
    # 26 s of work; items wanted from 0 to 40 s; an order in the backlog from 5 to 50 s
    (0, [2, 1, 26, 20, 14, 4, 0.166667, 1], [0, 0, 0, 10, 50, 45, 0, 0]),
    (30, [1, 0, 16, 0, 14, 4, 0, 0], [0, 0, 0, 10, 20, 20, 0, 0]),
)
def test_two_stations(tiny: RunInfo, begin_s: int, first: list[float], second: list[float]) -> None:
    stations = Stations(tiny)
    for event in AT_STATIONS:
        if type(event) in stations.handlers:
            stations.handlers[type(event)](event)
    rows = stations.rows(begin_s * 1000, 60_000)
    assert [list(row.values())[1:] for row in rows] == [first, second]
    assert all(row["busy_s"] + row["waiting_s"] + row["idle_s"] == 60 - begin_s for row in rows)


def test_a_station_that_is_closed_is_not_idle(tiny: RunInfo) -> None:
    """It is open until 10 s, and works until 46 s; from 55 s on it is open again. The other one is always open."""
    assert Stations(tiny).values(0, 60_000) == {}
    stations = Stations(
        evolve(tiny, scenario=evolve(tiny.scenario, stations=StationsSection(open=(("00:00", "01:00"),))))
    )
    for event in (*AT_STATIONS, StationClosed(10_000, 0), StationOpened(55_000, 0)):
        if type(event) in stations.handlers:
            stations.handlers[type(event)](event)
    first, second = stations.rows(0, 60_000)
    columns = ("busy_s", "waiting_s", "idle_s", "starved_s", "open_s")
    assert [first[column] for column in columns] == [26, 20, 5, 0, 51]
    assert second["open_s"] == 60
    assert stations.values(0, 60_000) == {"station_open_h": 111 / 3600, "open_utilisation_percent": 100 * 26 / 111}


def moved(start_s: int, wait_s: int, end_s: int, distance_m: int, pod: int | None) -> RobotMoved:
    return RobotMoved(
        end_s * 1000,
        start_s * 1000,
        robot=0,
        origin=0,
        to=1,
        heading=0,
        wait_ticks=wait_s * 1000,
        turn_ticks=0,
        distance_m=distance_m,
        pod=pod,
    )


TRIP: tuple[Event, ...] = (
    TaskAssigned(10_000, robot=0, pod=0),
    moved(10, 3, 20, 7, None),  # waits 3 s
    PodLifted(22_000, 20_000, robot=0, pod=0, cell=1),
    moved(25, 1, 35, 9, 0),  # waits 3 s for its path, and 1 s on it
    QueueJoined(35_000, robot=0, pod=0, station=0),
    VisitStarted(40_000, visit=1, robot=0, pod=0, station=0),
    VisitEnded(47_000, visit=1, pod=0, station=0, picks=1, next_station=None),
    moved(47, 0, 57, 10, 0),
    PodStored(59_000, 57_000, robot=0, pod=0, cell=1),
)


def test_waits_and_time_off_duty(tiny: RunInfo) -> None:
    robots = Robots(tiny, 0)
    robots.handlers[TaskAssigned](TaskAssigned(12_000, robot=0, pod=0))
    robots.handlers[RobotMoved](moved(10, 0, 15, 3, None))
    row = robots.rows(20_000)[0]
    assert (row["idle_s"], row["to_pod_s"], row["waiting_s"]) == (12, 8, 0)
    robots = Robots(tiny, 0)
    late = PodLifted(62_000, 60_000, robot=0, pod=0, cell=1)
    for event in (*TRIP[:2], late, moved(65, 0, 70, 9, 0)):
        robots.handlers[type(event)](event)
    assert (robots.for_room_ticks, robots.waiting_ticks) == (40_000, 46_000)
    assert "off_s" not in Robots(tiny, 0).rows(1000)[0]
    robots = Robots(
        evolve(tiny, scenario=evolve(tiny.scenario, robots=RobotsSection(available=(("00:00", "01:00"),)))), 0
    )
    for event in (*TRIP[:2], RobotsOnDuty(21_000, number=0), *TRIP[2:], RobotsOnDuty(100_000, number=1)):
        robots.handlers[type(event)](event)
    row = robots.rows(130_000)[0]
    assert (row["idle_s"], row["off_s"], row["storing_s"]) == (10 + 30, 41, 12)


@pytest.mark.parametrize(
    ("begin_s", "expected"),
    [(0, [26, 19, 21.0, 9.0, 9.0, 5.0, 7.0, 12.0, 7.0]), (34, [19, 19, 11.0, 0.0, 1.0, 5.0, 7.0, 12.0, 0.0])],
)
def test_a_trip(tiny: RunInfo, begin_s: int, expected: list[float]) -> None:
    robots = Robots(tiny, begin_s * 1000)
    for event in TRIP:
        if type(event) in robots.handlers:
            robots.handlers[type(event)](event)
    row, other = robots.rows(70_000)
    assert (list(row.values())[1:], sum(list(row.values())[3:])) == (expected, 70 - begin_s)
    assert (other["idle_s"], robots.waiting_ticks) == (70 - begin_s, expected[-1] * 1000)


def test_energy_of_runs() -> None:
    accelerating, rolling = run_j(10, False, 1.0, 1.5)
    assert accelerating == pytest.approx(150 * 1.5**2 / 2 / 0.8)
    assert rolling == pytest.approx(0.015 * 150 * 9.81 * (10 - 1.125) / 0.8)
    accelerating, rolling = run_j(1, False, 1.0, 1.5)
    assert accelerating == pytest.approx(150 * 1.0 * 0.5 / 0.8)
    assert rolling == pytest.approx(0.015 * 150 * 9.81 * 0.5 / 0.8)
    assert run_j(7, True, 1.0, 1.5) == pytest.approx([4 * joules for joules in run_j(7, False, 1.0, 1.5)])
    assert turn_j(1, True, 2.5) == pytest.approx(4 * turn_j(1, False, 2.5))
    assert turn_j(0, True, 2.5) == 0


def test_every_run_says_what_an_order_takes() -> None:
    metrics = rmfs_core.run("examples/small", overrides=["instance.orders=5", "rules.pp=free-flow"]).metrics
    parts = sum(metrics[f"energy_{part}_wh"] for part in ("acceleration", "rolling", "turns", "lifts"))
    assert parts == pytest.approx(metrics["energy_wh"])
    assert metrics["energy_per_order_wh"] == pytest.approx(parts / 5)


def test_runs_have_no_figures_of_what_they_lack(tmp_path: Path) -> None:
    over = ["rules.wait_for_stock=false", "instance.orders=5", "rules.pp=free-flow"]
    result = rmfs_core.run("examples/replenished", overrides=over, out=tmp_path)
    assert "turnover_stock_s" not in result.metrics
    assert (tmp_path / "delays.csv").read_text(encoding="utf-8").startswith("order,turnover_s,backlog_s,")
    result = rmfs_core.run("examples/small", overrides=["instance.orders=3"], out=tmp_path)
    assert not {"bundles_stored", "stock_outs"} & result.metrics.keys()
    assert not (tmp_path / "bundles.csv").exists()


HOUR = 3_600_000


def order(route: str | None = None) -> OrderData:
    return OrderData("a", arrival_tick=0, lines=((0, 1),), route=route)


DUE = [  # route, due, done
    (order("n"), 10_000, 10_000),  # just in time
    (order("n"), 10_000, 10_001),  # 1 ms late
    (order("n"), 10_000, None),  # not done when the run ends at 50 s: 40 s late
    (order("s"), 10_000, 4_000),
    (order("s"), 60_000, 20_000),  # before a truck that leaves after the end
    (order("s"), 60_000, None),  # which may still come
]


def test_trucks_and_who_missed_them() -> None:
    north, south, later = departures.rows(DUE, 50_000)
    assert tuple(north.values()) == (1, "n", 10.0, 3, 1, 2, 0, 1 / 3, 20.0)  # (1 ms + 40 s) / 2, in whole ms
    assert tuple(south.values()) == (2, "s", 10.0, 1, 1, 0, 0, 1.0, None)
    assert tuple(later.values()) == (3, "s", 60.0, 2, 0, 0, 2, None, None)  # an early order would flatter the share
    assert departures.values(DUE, 50_000) == {"departed_share": 2 / 4, "missed_percent": 50.0}
    assert departures.values([], 50_000) == {"departed_share": None, "missed_percent": None}
    assert costs.lateness(DUE, 50_000) == (2, 40_001)


@cases(
    "orders end until share",
    (DUE, 60_000, 60_000, 3 / 6),  # the truck has left
    (DUE[4:5], 20_000, None, 1.0),  # all orders are done: the run is over
    (DUE[4:5], 20_000, 50_000, None),  # the same trucks count for all rules, also for those that are done early
    (DUE[4:5], 20_000, 60_000, 1.0),
)
def test_which_trucks_count(orders, end, until, share) -> None:
    assert departures.values(orders, end, until)["departed_share"] == share


def test_what_an_order_costs_by_hand() -> None:
    prices = Costs(
        picker_per_h=30, packer_per_h=25, replenisher_per_h=20, robot_per_h=0.5, robot_per_year=6000,
        hours_per_year=4000, kwh=0.4, late_order=3, late_h=12,
    )  # fmt: skip
    # 2 pickers and 3 packers for 4 h, 1 replenisher for 2 h, 10 robots for 4 h; 5 kWh; 6 orders late, by 1.5 h in all
    paid = {"pickers": 8 * HOUR, "packers": 12 * HOUR, "replenishers": 2 * HOUR, "robots": 40 * HOUR}
    found = costs.values(prices, paid, 5000.0, (6, HOUR * 3 // 2), 100)
    assert found == {
        "cost_total": pytest.approx(240 + 300 + 40 + 40 * (0.5 + 1.5) + 2 + 18 + 18),
        "cost_per_order": pytest.approx(6.98),
        "cost_pickers_per_order": pytest.approx(2.4),
        "cost_packers_per_order": pytest.approx(3.0),
        "cost_replenishers_per_order": pytest.approx(0.4),
        "cost_robots_per_order": pytest.approx(0.8),
        "cost_energy_per_order": pytest.approx(0.02),
        "cost_lateness_per_order": pytest.approx(0.36),
    }


SMALL = ("instance.orders=10", "rules.pp=free-flow", "robots.count=3", "stations.item_capacity=4")
TRUCKS = ("instance.departures.times=[20, 60, 5000]", "instance.departures.cutoff_s=1")
PRICES = "costs={picker_per_h=36, packer_per_h=18, robot_per_h=3.6, late_order=2, late_h=36}"
PACKED = ("packing={packers=1, sorters=1, conveyor_s=5}",)
SHIFT = ('stations.open=[["00:01", "00:02"]]',)


def rows(file: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(file.read_text(encoding="utf-8").splitlines()))


RUNS = (0, 0, ()), (0, 0, PACKED), (0, 0, SHIFT), (0, 70, ()), (30, 0, PACKED), (0, 40, PACKED)


@cases("warmup_s end_s more", *RUNS)
def test_a_run_costs_what_its_tables_say(tmp_path: Path, warmup_s: float, end_s: float, more: tuple[str, ...]) -> None:
    ends = ([f"run.warmup_s={warmup_s}"] if warmup_s else []) + ([f"run.until_s={end_s}"] if end_s else [])
    every = [*SMALL, *TRUCKS, PRICES, "instance.arrivals={process='poisson', orders_per_hour=900}", *more, *ends]
    result = rmfs_core.run("examples/small", overrides=every, out=tmp_path, record=["trace"])
    assert validate_trace(tmp_path) == []
    table = rows(tmp_path / "packing.csv") if more == PACKED else result.orders
    done = {row["order"]: float(at) for row in table if (at := row.get("packed_s") or row.get("completed_s"))}
    horizon_s, end_s = end_s or 5000, end_s or max(done.values())
    number, hours = sum(end >= warmup_s for end in done.values()), (end_s - warmup_s) / 3600
    stations = rows(tmp_path / "stations.csv")
    picker_h = sum(float(row["open_s"]) for row in stations) / 3600 if more == SHIFT else len(stations) * hours
    due = [row for row in result.orders if warmup_s <= row["arrival_s"] <= end_s]
    late_s = [late for row in due if (late := done.get(row["order"], end_s) - row["due_s"]) > 0]
    left = [done.get(row["order"], 9999) <= row["due_s"] for row in due if row["due_s"] <= horizon_s]
    assert result.metrics["departed_share"] == (sum(left) / len(left) if left else None)
    parts = {"pickers": 36 * picker_h, "robots": 3 * 3.6 * hours, "energy": 0.0}
    parts |= {"lateness": 2 * len(late_s) + 36 * sum(late_s) / 3600}
    parts |= {"packers": 18 * 2 * hours} if more == PACKED else {}
    for part, cost in parts.items():
        expected = pytest.approx(cost / number) if number else None
        assert result.metrics[f"cost_{part}_per_order"] == expected, part
    assert result.metrics["cost_total"] == pytest.approx(sum(parts.values()))


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
