"""Which orders trucks take, and what an order costs: figures worked out by hand."""

import csv
import json
from pathlib import Path

import pytest

import rmfs_core
from calling import exit_code
from cases import cases
from rmfs_commands.details import costs, departures
from rmfs_commands.details.catalogue import COSTS, DEPARTURES
from rmfs_commands.validation.checking import validate_trace
from rmfs_core.scenario.model import Costs
from rmfs_core.world import OrderData

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
    assert tuple(later.values()) == (3, "s", 60.0, 2, 1, 0, 1, 1.0, None)
    assert departures.values(DUE, 50_000) == {"departed_share": 3 / 5, "missed_percent": 40.0}
    assert departures.values([], 50_000) == {"departed_share": None, "missed_percent": None}
    assert costs.lateness(DUE, 50_000) == (2, 40_001)


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
    assert costs.values(prices, {"pickers": HOUR}, 0.0, None, 0) == {
        "cost_total": 30.0,
        **dict.fromkeys(("cost_per_order", "cost_pickers_per_order", "cost_energy_per_order")),
    }


SMALL = ("instance.orders=10", "rules.pp=free-flow", "robots.count=3", "stations.item_capacity=4")
TRUCKS = ("instance.departures.times=[20, 60, 5000]", "instance.departures.cutoff_s=1")
PRICES = "costs={picker_per_h=36, packer_per_h=18, robot_per_h=3.6, late_order=2, late_h=36}"
PACKED = ("packing={packers=1, sorters=1, conveyor_s=5}",)
SHIFT = ('stations.open=[["00:01", "00:02"]]',)


def rows(file: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(file.read_text(encoding="utf-8").splitlines()))


@cases("more", (), PACKED, SHIFT, ("run.until_s=70",), ("run.warmup_s=30", *PACKED), ("run.until_s=40", *PACKED))
def test_a_run_costs_what_its_tables_say(tmp_path: Path, more: tuple[str, ...]) -> None:
    every = [*SMALL, *TRUCKS, PRICES, "instance.arrivals={process='poisson', orders_per_hour=900}", *more]
    result = rmfs_core.run("examples/small", overrides=every, out=tmp_path, record=["trace"])
    assert validate_trace(tmp_path) == []
    found, warmup_s = result.metrics, 30 * ("run.warmup_s=30" in more)
    table = rows(tmp_path / "departures.csv")
    sums = {name: sum(int(row[name]) for row in table) for name in ("departed", "missed", "open")}
    assert found["missed_percent"] == pytest.approx(100 * sums["missed"] / (sums["departed"] + sums["missed"]))
    packed = more[-1:] == PACKED
    done = {row["order"]: row["packed_s"] for row in rows(tmp_path / "packing.csv")} if packed else {}
    for row in result.orders if not packed else ():
        done[row["order"]] = "" if row["completed_s"] is None else str(row["completed_s"])
    ends = [float(text) for text in done.values() if text]
    end_s = max(ends) if result.status == "complete" else next(float(one[12:]) for one in more if "until" in one)
    stations, number = len(rows(tmp_path / "stations.csv")), sum(end >= warmup_s for end in ends)
    hours = (end_s - warmup_s) / 3600
    paid = 36 * stations * hours
    if more == SHIFT:
        paid = 36 * sum(float(row["open_s"]) for row in rows(tmp_path / "stations.csv")) / 3600
        assert 0 < paid < 36 * stations * hours
    late = [
        (float(done.get(row["order"]) or end_s) - row["due_s"])
        for row in result.orders
        if warmup_s <= row["arrival_s"] <= end_s
    ]
    late_s = [one for one in late if one > 0]
    parts = {"pickers": paid, "robots": 3 * 3.6 * hours, "lateness": 2 * len(late_s) + 36 * sum(late_s) / 3600}
    parts |= {"packers": 18 * 2 * hours} if packed else {}
    for part, cost in parts.items():
        expected = cost / number if number else None
        assert found[f"cost_{part}_per_order"] == (None if expected is None else pytest.approx(expected)), part
    assert found["cost_total"] == pytest.approx(sum(parts.values()))  # electricity is free here


def test_energy_is_what_batteries_give_or_else_what_driving_takes() -> None:
    plain = rmfs_core.run("examples/small", overrides=[*SMALL, "costs.kwh=1000"]).metrics
    assert plain["cost_total"] == pytest.approx(plain["energy_wh"] or 0)
    draws = "robots.battery={empty_w=90, loaded_w=90, lifting_w=90, idle_w=90, charging_w=9}"
    more = ("layout.chargers=1", "rules.idle=charge-when-low", draws)
    battery = rmfs_core.run("examples/small", overrides=[*SMALL, "costs.kwh=1000", *more]).metrics
    hours = 3 * (battery["simulated_s"] or 0) / 3600 * (1 - (battery["charging_percent"] or 0) / 100)
    assert battery["cost_total"] == pytest.approx(90 * hours)


def test_without_the_keys_there_is_nothing_of_them(tmp_path: Path) -> None:
    metrics = rmfs_core.run("examples/small", overrides=SMALL, out=tmp_path).metrics
    assert not metrics.keys() & {metric.name for metric in (*DEPARTURES, *COSTS)}
    assert not (tmp_path / "departures.csv").exists()


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
    assert "<h2>Departures</h2>" in page
    assert "<h2>What an order costs</h2>" in page
