"""The limit of a run: hand-made runs in which each cause in turn does, and what holds of every run."""

import csv
import json
from collections.abc import Sequence
from io import StringIO
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import pytest
from rich.console import Console

import rmfs_core
from cases import cases
from random_worlds import random_world
from rmfs_commands.cli.summary import print_bottleneck
from rmfs_commands.details.bottleneck import LIMITS, PARTS, Packed, sentences
from rmfs_commands.details.metrics import Metrics
from rmfs_commands.details.observer import Details
from rmfs_core import OrderAssignment, hookimpl
from rmfs_core.results import Result
from rmfs_core.rules import RuleSet
from rmfs_core.simulation.engine import Simulation
from rmfs_core.warehouse import WarehouseView

SMALL = ("rules.pp=free-flow", "instance.orders=30")
MANY = (*SMALL, "robots.count=12")
QUIET = (*MANY, "instance.arrivals={process='poisson', orders_per_hour=60}")
QUICK = (*MANY, "layout.stations_east=1", "stations.handle_s=1", "stations.pick_s=1")
OUTAGES, FAILURES = (f"{key}={{mtbf_h=%g, mttr_s=%g}}" for key in ("stations.outages", "robots.failures"))
SUPPLY = "instance.replenishment={process='reorder-point', reorder_point=1, order_up_to=9, lead_s=%d}"


@attrs.define
class OneStation:
    @hookimpl
    def assign_orders(self, warehouse: WarehouseView, rng: np.random.Generator) -> Sequence[OrderAssignment]:
        station = warehouse.stations[0]
        return [
            OrderAssignment(order.id, station.id) for order in warehouse.backlog[:1] if warehouse.fits(order, station)
        ]


def bottleneck(*overrides: str, scenario: str = "examples/small", one_station: bool = False) -> dict[str, Any]:
    """Return what a run says of it, once it is seen that all adds up."""
    rules = {"poa": OneStation()} if one_station else {}
    return checked(rmfs_core.run(scenario, overrides=overrides, rules=rules))


def checked(result: Result) -> dict[str, Any]:
    """Return what a result says of it: parts add up to the turn-over time, and causes to all of the orders' time."""
    found: dict[str, Any] = result.summary["bottleneck"]
    turnover = result.metrics["turnover_s"]
    assert ["before", *found["turnover_parts_s"]] == list(PARTS)
    if turnover is None:
        assert set(found["turnover_parts_s"].values()) == {None}
    else:
        assert sum(found["turnover_parts_s"].values()) == pytest.approx(turnover, abs=1e-6)
    end, begin = result.metrics["simulated_s"], result.scenario.run.warmup_s or 0
    spent = [
        min(end if row["completed_s"] is None else row["completed_s"], end) - row["arrival_s"]
        for row in result.orders
        if row["arrival_s"] is not None and begin <= row["arrival_s"] <= end
    ]
    if spent:
        assert found["orders_time_s"] == pytest.approx(sum(spent) / len(spent), abs=1e-6)
    for shares in (found["causes_percent"], found["robots_percent"], found["pickers_percent"]):
        if None not in shares.values():
            assert sum(shares.values()) == pytest.approx(100, abs=0.01)
            assert min(shares.values()) >= 0
    if found["gain"] is not None and found["gain"]["time_s"] is not None:
        assert 0 <= found["gain"]["time_s"] <= found["orders_time_s"] + 0.001
    return found


@cases(
    "limit more overrides options",
    ("pickers", "layout.stations_west=1", (*MANY, "stations.handle_s=60"), {}),
    ("robots", "robots.count=2", (*SMALL, "robots.count=1"), {}),
    ("queues", "stations.queue_length=8", (*QUICK, "stations.queue_length=1"), {}),
    ("spread", "", (*MANY, "stations.item_capacity=900", "layout.stations_west=1"), {"one_station": True}),
    ("stock", SUPPLY % 60, (SUPPLY % 9000,), {"scenario": "examples/replenished"}),
    ("hours", 'stations.open=[["00:00","24:00"]]', (*MANY, 'stations.open=[["06:00","22:00"]]'), {}),
    ("hours", 'robots.available=[["00:00","24:00"]]', (*MANY, 'robots.available=[["06:00","22:00"]]'), {}),
    ("room", "stations.item_capacity=9", (*QUICK, "stations.item_capacity=1", "stations.oversize=alone"), {}),
    ("held", "rules.filters=[]", (*QUIET, "rules.filters=[{rule='waves', every_s=1800}]"), {}),
    ("chargers", "layout.chargers=2", ("layout.chargers=1",), {"scenario": "examples/charging"}),
    ("outages", OUTAGES % (90, 1), (*SMALL, OUTAGES % (0.1, 1800)), {}),
    ("outages", FAILURES % (90, 1), (*SMALL, FAILURES % (0.01, 3000)), {}),
    ("pods", "instance.pods=30", (*MANY, "instance.pods=1", "instance.skus_per_pod=20", "layout.pod_fill=0.1"), {}),
)
def test_each_cause_in_turn_is_the_limit(limit, more, overrides, options) -> None:
    """More of it helps, at most as much as is said; all other causes from 10 % on are named."""
    before = bottleneck(*overrides, **options)
    others = {cause for cause in LIMITS if (before["causes_percent"].get(cause) or 0) >= 10} - {limit}
    assert all(f" {cause} {before['causes_percent'][cause]:.0f} %" in before["says"][0] for cause in others)
    assert (before["robots_percent"]["low"] > before["robots_percent"]["idle"]) == (limit == "chargers")
    assert before["limit"] == limit
    assert before["says"][0].startswith(limit.capitalize())
    after = bottleneck(*overrides, *([more] if more else []), **options | {"one_station": False})
    saved = sum(before["turnover_parts_s"].values()) - sum(after["turnover_parts_s"].values())
    assert 0 < saved <= before["gain"]["time_s"] + 0.001


def test_outages_of_closed_stations_keep_no_order_waiting() -> None:
    """Nearly all of the wait is for six o'clock, whether stations are out of service until then or not."""
    found = bottleneck(*MANY, 'stations.open=[["06:00","22:00"]]', OUTAGES % (0.5, 1800))
    without = bottleneck(*MANY, 'stations.open=[["06:00","22:00"]]')
    assert found["causes_percent"]["hours"] == pytest.approx(without["causes_percent"]["hours"], abs=3)
    assert found["pickers_percent"]["down"] < 60
    night = 'robots.available=[["22:00","06:00",1],["06:00","22:00"]]'
    of_robots = bottleneck("instance.orders=60", "robots.count=8", night, FAILURES % (1, 3600))["causes_percent"]
    assert of_robots["outages"] < 2 < of_robots["robots"]  # seven fail off duty, too


def test_nothing_limits_a_quiet_warehouse() -> None:
    found = bottleneck(*MANY, "instance.arrivals={process='poisson', orders_per_hour=20}")
    assert (found["limit"], found["gain"]) == (None, None)
    assert found["says"][0].startswith("No single limit: ")
    assert found["turnover_parts_s"]["driving"] > 10 > found["turnover_parts_s"]["hands"] == 6


@cases(
    "overrides",
    ("run.until_s=1",),
    ("run.until_s=600", "robots.count=12"),
    ("run.until_s=300", "stations.release=picked", "rules.poa_pps=split-over-time"),
    ("run.until_s=60", "run.warmup_s=90"),
    ("instance.orders=0",),
    ('robots.available=[["06:00","07:00"]]', "run.until_s=600"),
    ('stations.open=[["06:00","07:00"]]', "run.until_s=600"),
    ("instance.arrivals={process='refill', backlog=5}", "run.until_s=900", "run.warmup_s=300"),
    ("stations.release=picked", "rules.poa_pps=split-over-time"),
)
def test_odd_runs_make_sense(overrides: tuple[str, ...]) -> None:
    found = bottleneck(*SMALL, *overrides)
    assert found["limit"] in (None, *LIMITS)
    json.dumps(found, allow_nan=False)


def test_one_station_has_no_spread() -> None:
    found = bottleneck(*QUIET, "layout.stations_east=1", "rules.filters=[{rule='waves', every_s=1800}]")
    assert (found["limit"], found["causes_percent"]["spread"]) == ("held", 0)


def orders_at(folder: Path, *times_s: int) -> list[str]:
    """Write orders of an item each that arrive at these times, and a pod; return what names the files."""
    rows = "".join(f"{number},{time_s},a,1\n" for number, time_s in enumerate(times_s))
    (folder / "orders.csv").write_text(f"order,arrival_s,sku,quantity\n{rows}", encoding="utf-8")
    (folder / "pods.csv").write_text("pod,sku,quantity\np,a,\n", encoding="utf-8")
    return [f"instance.{kind}_file={folder / kind}.csv" for kind in ("orders", "pods")]


def test_orders_before_the_warm_up_are_told(tmp_path: Path) -> None:
    files = orders_at(tmp_path, 0, 90)
    for given in ((*SMALL, "run.until_s=600"), (*files, "run.until_s=60")):
        found = bottleneck(*given, "run.warmup_s=90")
        assert found["limit"] is None
        assert found["says"] == [
            "Not known: all orders arrive before the warm-up ends (`run.warmup_s`), and none of them counts."
        ]


def test_packers_off_duty_are_told() -> None:
    """They begin after two hours, long after the last pick of most orders."""
    given = ["instance.orders=30", "packing.packers=4", 'packing.open=[["02:00", "20:00"]]']
    told = rmfs_core.run("examples/packing", overrides=given).summary["bottleneck"]["says"][2]
    assert told == "Packers are off duty for 99 % of the wait; longer hours may help."


@pytest.mark.parametrize(
    ("overrides", "limit"), [(("packing.boxes=1", "packing.pack_s=600"), "packers"), (("packing.pack_s=1",), None)]
)
def test_packers_may_be_the_limit(overrides: tuple[str, ...], limit: str | None) -> None:
    """Packing after the last pick does not count as idle time of pickers and robots."""
    result = rmfs_core.run("examples/packing", overrides=("instance.orders=30", *overrides))
    found = checked(result)
    after = result.metrics["packed_s"] - result.metrics["turnover_s"]
    assert found["packing"]["after_s"] == pytest.approx(after, abs=0.01)
    assert f"Last pick to packed: {after:,.0f} s; packers" in found["says"][-1]
    console = Console(width=80, file=StringIO())
    print_bottleneck(console, result)
    assert len(console.file.getvalue().strip().splitlines()) == 10
    assert (found["limit"] == "packers") == (limit == "packers")
    handling = found["pickers_percent"]["handling"]
    assert handling == pytest.approx(100 * result.metrics["picker_utilisation"], abs=0.5)
    assert found["robots_percent"]["idle"] < 30


def test_packing_takes_what_orders_wait_that_are_packed(tmp_path: Path) -> None:
    """Orders picked and packed in the run, not those of a state, nor those picked alone: their means differ."""
    rmfs_core.run("examples/packing", overrides=["run.until_s=600"], save_state=tmp_path / "state.json")
    for number, over in enumerate((["run.until_s=800"], [f"instance.state_file={tmp_path}/state.json"])):
        out = tmp_path / str(number)
        found = rmfs_core.run("examples/packing", overrides=over, out=out).summary["bottleneck"]
        orders, boxes = (
            (out / name).read_text(encoding="utf-8").splitlines() for name in ("orders.csv", "packing.csv")
        )
        picked = {row["order"]: float(row["completed_s"] or 0) for row in csv.DictReader(orders)}
        packed = {row["order"]: float(row["packed_s"] or 0) for row in csv.DictReader(boxes)}
        after = [at - picked[order] for order, at in packed.items() if at and picked[order] > 600 * number]
        assert found["packing"]["after_s"] == pytest.approx(sum(after) / len(after), abs=0.001)


def test_nothing_is_said_of_one_more_box() -> None:
    """How long boxes are reserved depends on the rules; how long packers work does not, if they always have work."""
    packed = Packed(after_s=500, wait_s=1, packers_percent=50, boxes_percent=95, packers=4)
    assert packed.limit(100) == "boxes"
    assert set(packed.one_more("boxes").values()) == {None}
    told = ["Boxes, 95 % reserved: from the last pick to packed 500 s on average."]
    assert [*packed.says("boxes", packed.one_more("boxes"))] == told
    assert set(packed.one_more("packers").values()) == {None}  # orders wait in peaks, for packers with time to spare
    assert len([*packed.says("packers", packed.one_more("packers"))]) == 1
    busy = attrs.evolve(packed, packers_percent=100)
    assert busy.one_more("packers")["throughput_percent"] == 25  # 5 for 4 who always work


def test_one_more_station_by_hand(tmp_path: Path) -> None:
    """Three orders of an item of 300 s, all there at once: two pickers need 300, 300 and 600 s, 400 s on average."""
    found = bottleneck(
        *orders_at(tmp_path, 0, 0, 0), "layout.stations_east=1", "stations.handle_s=300", "rules.pp=free-flow"
    )
    assert found["limit"] == "pickers"
    assert found["gain"]["time_s"] == pytest.approx(found["orders_time_s"] - 400, abs=0.001)
    at_most = f"at most {found['gain']['time_s']:.0f} s (38 %) less time"
    assert found["says"][1] == f"One more station and ideal rules: {at_most}."


def test_where_orders_are_refilled_the_bound_is_on_picks() -> None:
    found = bottleneck(
        *MANY, "instance.arrivals={process='refill', backlog=5}", "run.until_s=900", "stations.handle_s=60"
    )
    handling = found["pickers_percent"]["handling"]
    assert (found["limit"], found["gain"]["time_s"]) == ("pickers", None)
    assert found["gain"]["throughput_percent"] == pytest.approx(100 * (3 / 2 / (handling / 100) - 1), abs=0.01)
    assert found["says"][1].startswith("One more station: at most 5")


def test_days_of_waiting_take_no_more_lines() -> None:
    result = rmfs_core.run("examples/small", overrides=SMALL)
    parts = result.summary["bottleneck"]["turnover_parts_s"]
    parts |= {part: 999.9 * seconds for part, seconds in parts.items()}
    console = Console(width=80, file=StringIO())
    print_bottleneck(console, result)
    assert len(console.file.getvalue().strip().splitlines()) == 9


def test_stations_that_a_rule_closes_are_no_matter_of_hours() -> None:
    found = bottleneck(*MANY, "rules.activate=constant-ratio")
    assert found["causes_percent"]["hours"] == 0
    assert found["causes_percent"]["closed"] > 10


@pytest.mark.parametrize("seed", range(12))
def test_all_adds_up_in_random_worlds(seed: int) -> None:
    world = random_world(seed)
    for rule in () if world.short else ("first-come", "split-over-time", "pod-index"):
        scenario = world.with_rule(rule)
        run = attrs.evolve(scenario.run, until_s=(60.0, 600.0, 9e5)[seed % 3], warmup_s=30.0 if seed % 2 else None)
        scenario = attrs.evolve(scenario, run=run)
        rules, metrics, details = RuleSet.load(scenario.rules, "."), Metrics(), Details()
        for observer in (metrics, details):
            rules.register_observer(observer)
        simulation = Simulation(scenario, world.instance, world.layout, rules)
        simulation.run()
        details.run_ended(simulation.now)
        turnover, found = metrics.measured()["turnover_s"], simulation.info.summary["bottleneck"]
        parts, shares = (
            [share or 0.0 for share in found[key].values()] for key in ("turnover_parts_s", "causes_percent")
        )
        assert sum(shares) == pytest.approx(100 if found["orders_time_s"] else 0, abs=0.01)
        assert sum(parts) == pytest.approx(turnover or 0.0, abs=1e-6)
        assert min(*parts, *shares, ((found["gain"] or {}).get("time_s") or 0.0)) >= 0
        cancelled = any(order.cancelled for order in simulation.warehouse.orders)  # whose time counts as well
        if simulation.status == "complete" and not run.warmup_s and not cancelled:
            assert found["orders_time_s"] == pytest.approx(turnover, abs=1e-6)


def test_what_would_help_keeps_its_abbreviations() -> None:
    gain = {"time_s": 60.0, "time_percent": 20.0, "throughput_percent": None}
    _, helps = sentences("pods", dict.fromkeys([*LIMITS, "driving", "picking"], 20.0), gain)
    assert helps.startswith("The same SKUs on more pods: at most ")
