"""Which orders trucks take, and what an order costs: figures worked out by hand."""

import csv
import json
from pathlib import Path

import pytest

import rmfs_core
from calling import exit_code
from cases import cases
from rmfs_commands.details import costs, departures
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
