"""A run that begins in a state: what it was stopped in, and what others write."""

import copy
import csv
import gzip
import json
import math
import operator
from collections.abc import Iterator, Sequence
from functools import reduce
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from attrs import define
from hypothesis import example, given, settings
from hypothesis import strategies as st

import rmfs_core
from calling import exit_code, refusal, refused
from cases import cases
from rmfs_commands.advice.cutting import cut
from rmfs_commands.cli.main import main
from rmfs_commands.plan import find_planner
from rmfs_commands.states import decide, state_from_dict
from rmfs_commands.validation import validate_trace
from rmfs_core import Result
from rmfs_core.errors import InputError, RunError
from rmfs_core.events import PodStored
from rmfs_core.scenario import RuleChoice, load_scenario
from rmfs_core.world import make_instance
from rmfs_rules.nearest_robot import NearestRobot
from saying import said
from told import ToldRun

PACKED = "rules.poa= rules.pps= rules.poa_pps=pod-index packing.stations=2 packing.packers=1"
COME = "instance.arrivals.process=poisson instance.arrivals.orders_per_hour={}"
WORLDS = {
    name: tuple(settings.split())
    for name, settings in {
        "plain": "",
        "scarce": "instance.items_per_sku=8 rules.poa=first-come rules.pr=random stations.release=picked",
        "orders come": "instance.due.allowance_s=60 costs.late_order=1 costs.late_h=1 " + COME.format(300),
        "trucks": "instance.departures.times=[200,400,9000] costs.late_h=1 " + COME.format(300),
        "refilled": "instance.arrivals.process=refill instance.arrivals.backlog=6 rules.ta=nearest-robot",
        "times vary": 'robots.lift_s={mean=3,cv=0.5,distribution="lognormal"} '
        'stations.pick_s={mean=7,cv=0.5,distribution="lognormal"} stations.line_s=2 rules.poa=station-queue',
        "shifts": "instance.arrivals.process=poisson instance.arrivals.orders_per_hour=400 "
        'rules.activate=backlog-threshold stations.open={1=[["00:00","00:05"]]} '
        'robots.available=[["00:00","00:03"],["00:03","23:00",2]]',
        "pods move": "rules.move=utility rules.idle=charge-when-low layout.chargers=1 robots.battery.capacity_wh=900",
        "split": "rules.poa= rules.pps= rules.poa_pps=split-over-time",
        "low": "layout.chargers=2 rules.idle=charge-when-low robots.battery.capacity_wh=33 " + COME.format(400),
        "crowded": "layout.block_rows=9 layout.stations_east=4 layout.stations_west=3 robots.count=30 "
        'instance.orders=120 rules.poa={rule="pod-match",spread=0.5}',
        "restocked": "instance.items_per_sku=3 instance.pod_capacity=24 layout.replenishment_west=1 "
        "rules.roa=first-bundle rules.rps=emptiest-pod instance.replenishment.process=reorder-point "
        "instance.replenishment.lead_s=120 instance.replenishment.reorder_point=4 "
        "instance.replenishment.order_up_to=12 instance.replenishment.bundle_items=6 " + COME.format(400),
        "packed": f"{PACKED} packing.boxes=4 packing.tote=visit",
        "sorted": f"{PACKED} packing.sorters=1 packing.packing_from=picked rules.packing_task=pack-first "
        "stations.release=picked "
        + " ".join(f'packing.{key}_s={{mean=9,cv=0.5,distribution="lognormal"}}' for key in ("tote", "put", "pack")),
        "packers come": f'{PACKED} packing.open=[["00:05","00:15"],["00:20","23:00"]] instance.due.allowance_s=300 '
        + COME.format(200),
        "failing": "robots.failures={mtbf_h=0.1,mttr_s=40} stations.outages={mtbf_h=0.15,mttr_s=60} "
        'robots.maintenance={"1"=[["00:02","00:04"]],"3"=[["00:01","00:05"]]}',
        "chargers fail": "layout.chargers=2 rules.idle=charge-when-low robots.battery.capacity_wh=40 "
        "robots.battery.charger_outages={mtbf_h=0.05,mttr_s=60} robots.failures={mtbf_h=0.5,mttr_s=60} "
        + COME.format(400),
        "off duty at chargers": "layout.chargers=2 rules.idle=charge-when-low robots.battery.capacity_wh=33 "
        'robots.failures={mtbf_h=0.05,mttr_s=20} robots.available=[["00:00","00:03"],["00:03","23:00",2]] '
        + COME.format(150),
        "maintained": "robots.failures={mtbf_h=0.03,mttr_s=10} "
        'robots.maintenance={"1"=[["00:05","00:07"]],"2"=[["00:06","00:07"]],"3"=[["00:05","00:06"]]} '
        + COME.format(150),
        "repaired": "layout.maintenance_cells=2 robots.failures={mtbf_h=0.1,mttr_s=40}",
    }.items()
}
SAME = ("charge_lowest_percent", "replenishment_robot_percent")
"""Metrics that know what was before, or what it led to: the lowest charge, and what a trip was for."""
WITHOUT = (
    "turnover",
    "late",
    "tardiness",
    "on_time",
    "cost",
    "departed",
    "missed",
    "packed_s",
    "packed_median_s",
    "packed_p95_s",
)
"""Beginnings of metrics of orders that arrived in the time that counts: here, of all that were completed in it."""


def simulate(*overrides: str, scenario: str = "examples/small", **options: Any) -> Result:
    return rmfs_core.run(scenario, overrides=["instance.orders=25", *overrides], **options)


def stopped(folder: Path, at_s: float, *world: str) -> tuple[Result, Path]:
    """Return a run that ends at a time, and its state."""
    state = folder / "state.json"
    return simulate(*world, f"run.until_s={at_s}", save_state=state), state


def rows(table: Sequence[dict[str, Any]], after_s: float, key: str) -> list[dict[str, Any]]:
    """Return the rows of a table of what ends after a time, but for wall-clock time."""
    left = (row for row in table if row[key] is None or row[key] > after_s)
    return [{name: value for name, value in row.items() if name != "seconds"} for row in left]


def test_a_state_of_a_run_that_begins_with_an_item_in_hand(tmp_path: Path) -> None:
    """Its pod had left before, so that nobody tells when that visit began."""
    whole, state = rmfs_core.run("examples/small"), tmp_path / "state.json"
    for at_s in (105, 105.5):
        over = [f"run.until_s={at_s}", *([f"instance.state_file={state}"] if state.exists() else [])]
        rmfs_core.run("examples/small", overrides=over, save_state=state)
    assert rmfs_core.run("examples/small", overrides=[f"instance.state_file={state}"]).orders == whole.orders


@settings(max_examples=20)
@example("orders come", "sipp", 200_000, 1)
@example("trucks", "sipp", 150_000, 1)
@example("maintained", "sipp", 200_000, 2)
@example("off duty at chargers", "sipp", 500_000, 4)
@example("restocked", "free-flow", 450_000, 8)
@given(
    st.sampled_from(sorted(WORLDS)), st.sampled_from(["free-flow", "sipp"]), st.integers(1, 900_000), st.integers(1, 9)
)
def test_a_run_goes_on_as_if_it_had_not_been_stopped(
    tmp_path_factory: pytest.TempPathFactory, world: str, pp: str, at: int, seed: int
) -> None:
    """Orders, visits and decisions are those of the run that was not stopped; so is what is counted from then on."""
    at_s, given = at / 1000, (*WORLDS[world], f"rules.pp={pp}", f"seed={seed}")
    first, state = stopped(tmp_path_factory.mktemp("run"), at_s, *given)
    if first.status == "complete":
        return
    folder = state.parent
    whole = simulate(*given, f"run.warmup_s={(at + 1) / 1000}", out=folder / "whole")
    rest = simulate(*given, f"instance.state_file={state}", out=folder / "rest", record=["trace"])
    assert validate_trace(folder / "rest") == []
    again = (*given, f"instance.state_file={state}", f"run.until_s={at_s + 60}")
    if simulate(*again, save_state=folder / "again.json").status == "horizon":  # a state of a run from a state
        assert simulate(*given, f"instance.state_file={folder / 'again.json'}").orders == whole.orders
    assert rest.status == whole.status == "complete"
    assert rest.orders == whole.orders
    if (folder / "whole/packing.csv").exists():
        assert (folder / "rest/packing.csv").read_bytes() == (folder / "whole/packing.csv").read_bytes()
    if (folder / "whole/bundles.csv").exists():
        texts = ((folder / name / "bundles.csv").read_text() for name in ("rest", "whole"))
        found, kept = (list(csv.DictReader(text.splitlines())) for text in texts)
        assert found == [row for row in kept if not row["stored_s"] or float(row["stored_s"]) > at_s]
    for table, key in (("visits", "end_s"), ("periods", "time_s")):
        assert rows(getattr(rest, table), 0, key) == rows(getattr(whole, table), at_s, key)
    for name, value in whole.metrics.items():
        if name not in SAME and not name.startswith(WITHOUT):
            assert (name, rest.metrics[name]) == (name, value)
    turnover = [row["turnover_s"] for row in rest.orders if row["completed_s"] > at_s]
    assert rest.metrics["orders_completed"] == len(turnover)
    if not turnover:  # all orders are picked already, and not all packed
        return
    assert rest.metrics["turnover_s"] == pytest.approx(sum(turnover) / len(turnover))
    told = rest.summary["bottleneck"]
    before = sum(max(at_s - row["arrival_s"], 0) for row in rest.orders if row["completed_s"] > at_s)
    assert sum(told["turnover_parts_s"].values()) == pytest.approx(rest.metrics["turnover_s"])
    assert told["turnover_parts_s"]["before"] == pytest.approx(before / len(turnover))
    assert told["completed"] == len(turnover)
    assert told["orders_time_s"] == pytest.approx((sum(turnover) - before) / len(turnover))
    assert min(*told["turnover_parts_s"].values(), *told["causes_percent"].values()) >= 0


def test_an_order_that_has_left_has_left_when_it_did(tmp_path: Path) -> None:
    """A state that does not tell when: at its time."""
    rows = "a,0,x,1,\nb,0,y,1,\nc,12.5,x,1,20\nd,40,x,1,\n"
    (tmp_path / "orders.csv").write_text(f"order,arrival_s,sku,quantity,cancelled_s\n{rows}")
    (tmp_path / "pods.csv").write_text("pod,sku,quantity\np,x,9\nq,y,9\n")
    files = (f"instance.{name}_file={tmp_path / name}.csv" for name in ("orders", "pods"))
    given = (*files, "instance.orders=", "layout.stations_east=1", "layout.stations_west=0", "stations.item_capacity=1")
    whole, (_, state) = simulate(*given), stopped(tmp_path, 30, *given)
    left = [row["cancelled_s"] for row in whole.orders]
    assert left == [None, None, 20, None]
    assert [row["cancelled_s"] for row in simulate(*given, f"instance.state_file={state}").orders] == left
    del (told := json.loads(state.read_text()))["run"]["cancelled_s"]
    state.write_text(json.dumps(told))
    assert simulate(*given, f"instance.state_file={state}").orders[2]["cancelled_s"] == 30


def test_a_trace_has_the_state_and_is_checked_against_it(tmp_path: Path) -> None:
    """It needs no state next to it. Another stock or time in the state, another past, or a pick too many: faults."""
    _, state = stopped(tmp_path, 160.0, *WORLDS["restocked"])
    simulate(*WORLDS["restocked"], f"instance.state_file={state}", out=tmp_path / "out", record=["trace"])
    state.unlink()
    lines = [json.loads(line) for line in gzip.decompress((tmp_path / "out/trace.jsonl.gz").read_bytes()).splitlines()]
    (tmp_path / "out/trace.jsonl.gz").rename(tmp_path / "trace.jsonl.gz")
    assert validate_trace(tmp_path / "trace.jsonl.gz") == []
    pod = next(name for name, one in lines[0]["state"]["content"]["pods"].items() if one["contents"])
    picked = next(i for i, line in enumerate(lines) if line["e" if i else "format"] == "item_picked" and i > 60)
    for change, kind in (
        (lambda one: one[0]["state"]["content"]["pods"][pod].update(contents={}), "header"),
        (lambda one: one[1].update(tick=1), "header"),
        (lambda one: one[0]["state"].update(tick=160_001), "header"),
        (lambda one: one.insert(picked, one[picked]), "picker-busy"),
    ):
        change(changed := copy.deepcopy(lines))
        text = "".join(f"{json.dumps(line)}\n" for line in changed)
        (tmp_path / "trace.jsonl.gz").write_bytes(gzip.compress(text.encode()))
        assert kind in {fault.kind for fault in validate_trace(tmp_path / "trace.jsonl.gz")}


def test_what_is_said_of_a_run_is_of_its_own_time(tmp_path: Path) -> None:
    """Hours begin with that of the state; a station that only finishes what it has is no busy or idle one."""
    coming = ("instance.orders=200", "instance.arrivals.process=poisson", "instance.arrivals.orders_per_hour=150")
    given = (*coming, "rules.pp=free-flow", 'stations.open={1=[["00:00","05:00"]],2=[["00:00","00:58"]]}')
    _, state = stopped(tmp_path, 3480.5, *given)
    rest = simulate(*given, f"instance.state_file={state}", out=tmp_path / "out")
    with (tmp_path / "out" / "hours.csv").open() as file:
        hours = list(csv.DictReader(file))
    assert [row["hour"] for row in hours] == ["0", "1"]
    assert [float(row["stations_open"]) for row in hours] == [1, 1]
    assert sum(int(row["picks"]) for row in hours) == rest.metrics["picks"]
    assert sum(int(row["orders_out"]) for row in hours) == rest.metrics["orders_completed"]
    told = rest.summary["bottleneck"]
    assert told["busiest_station"]["station"] == told["idlest_station"]["station"] == "1"
    later = simulate(written(tmp_path), "instance.orders=0", "rules.pp=free-flow", out=tmp_path / "later")
    with (tmp_path / "later" / "hours.csv").open() as file:
        assert [(row["hour"], int(row["picks"])) for row in csv.DictReader(file)] == [("10", later.metrics["picks"])]


@cases("change", "whca-n", "whca-n stations.open.2=[]", "free-flow", "sipp rules.poa=first-come rules.pps=nearest-pod")
@pytest.mark.parametrize("at_s", [40.25, 160.0, 301.5])
def test_another_scenario_goes_on(tmp_path: Path, change: str, at_s: float) -> None:
    first, state = stopped(tmp_path, at_s, "rules.pp=whca-n")
    rest = simulate(f"instance.state_file={state}", *f"rules.pp={change}".split())
    assert rest.status == "complete"
    done = [row for row in first.orders if row["completed_s"] is not None]
    assert [row for row in rest.orders if row["completed_s"] is not None and row["completed_s"] <= at_s] == done
    assert rest.metrics["orders_completed"] == 25 - len(done)
    if "stations.open.2=[]" in change:
        assert all(row["stations"] == "1" for row in rest.orders if (row["assigned_s"] or 0) > at_s)


BY_HAND: dict[str, Any] = {
    "format": "rmfs-state",
    "version": 2,
    "time_s": 36000,
    "pods": {
        "P1": {"contents": {"milk": None, "tea": 5}},
        "P2": {"contents": {"jam": 6}},
        "P3": {"contents": {"tea": 2}},
    },
    "stations": {
        "1": {"item_capacity": 15, "requests": [{"order": "A", "sku": "tea"}], "inbound": ["P1"], "line": ["P1"]},
        "2": {"item_capacity": 15, "requests": [{"order": "B", "sku": "jam"}], "inbound": ["P2"]},
    },
    "orders": {
        "A": {"lines": {"milk": 1, "tea": 1}, "arrival_s": 35000},
        "B": {"lines": {"jam": 2}, "arrival_s": 35500, "due_s": 36600},
    },
}


def written(folder: Path, **changes: Any) -> str:
    """Return the override that names the state, changed."""
    file = folder / "by-hand.json"
    file.write_text(json.dumps(BY_HAND | changes))
    return f"instance.state_file={file}"


@pytest.mark.parametrize("pp", ["free-flow", "sipp", "whca-n"])
def test_a_state_by_hand_is_begun_in(tmp_path: Path, pp: str) -> None:
    """The scenario has what it leaves out: robots stand under pods; rules are asked at once."""
    result = simulate(written(tmp_path), f"rules.pp={pp}", "instance.orders=0")
    assert result.status == "complete"
    assert [(row["order"], row["arrival_s"]) for row in result.orders] == [("A", 35000), ("B", 35500)]
    assert all(36000 < row["completed_s"] < 36200 for row in result.orders)
    assert result.metrics["orders_completed"] == 2
    assert result.metrics["turnover_s"] == pytest.approx(sum(row["turnover_s"] for row in result.orders) / 2)
    assert result.metrics["late_orders"] == 0


CARRIED = {
    "robots": {"1": {"cell": 4, "task": "P1"}, "2": {"cell": 9, "task": "P2"}, "3": {"cell": 45}, "4": {"cell": 46}},
    "stations": {name: {"item_capacity": 15} for name in "12"},
    "orders": {"A": {"lines": {"tea": 2}, "arrival_s": 36000}},
}


def going(kind: str, **entry: Any) -> dict[str, Any]:
    return {"run": {"going": [{"kind": kind, **entry}], "visits": 1}}


PICK = {"robot": "1", "story": "transport", "visit": 1, "sku": "tea"}
TEA = {"contents": {"tea": 1}}
BUSY = {"stations": BY_HAND["stations"] | {"1": BY_HAND["stations"]["1"] | {"picker_free_s": 36009}}}


@pytest.mark.parametrize("pp", ["free-flow", "sipp"])
def test_pods_that_are_carried_get_a_location_each(tmp_path: Path, pp: str) -> None:
    given = written(tmp_path, **CARRIED, reserved=[41])
    result = simulate(given, f"rules.pp={pp}", "instance.orders=0", observers=[told := ToldRun()])
    assert result.status == "complete"
    assert {41, 33} <= {event.cell for event in told.of(PodStored)}  # the reserved one, and the first that is free


def test_cell_0_is_a_storage_location_as_any_other(tmp_path: Path) -> None:
    """As many pods as locations, without their cells: all of them get one."""
    (tmp_path / "hall.txt").write_text("#.......\n.##.##..\n........\n.##.##.qqqO\n.......@@@.\n...........")
    stations = {"1": {"item_capacity": 15}}
    given = written(
        tmp_path, **CARRIED | {"stations": stations, "robots": None, "pods": dict.fromkeys("abcdefghi", TEA)}
    )
    result = simulate(given, f"layout.map_file={tmp_path / 'hall.txt'}", "instance.orders=0", "instance.pods=5")
    assert result.status == "complete"


EMPTY = {f"X{i}": {"contents": {}} for i in range(200)}


SLOW = "instance.orders=9 instance.arrivals.process=poisson instance.arrivals.orders_per_hour=0.5"


@cases(
    "changes overrides sentence",
    (
        CARRIED | {"pods": BY_HAND["pods"] | dict([*EMPTY.items()][:118])},
        "",
        'robots.2.task: found pod "P2", for which none is left; expected a free or reserved storage location',
    ),
    ({"stations": {"1": BY_HAND["stations"]["1"]}}, "", "stations: found 1; expected the scenario's 2"),
    ({"stations": BY_HAND["stations"] | {"3": {"item_capacity": 15}}}, "", "stations: found 3; expected the scenario'"),
    ({"orders": BY_HAND["orders"] | {"C": {"lines": {"tea": 1, "ink": 1}}}}, "", 'orders.C.lines: SKU "ink" is on no'),
    ({}, SLOW, 'pods: found none of SKU "'),
    ({}, "stations.item_capacity=12", "stations.1.item_capacity: found 15; expected the scenario's"),
    ({}, "stations.item_capacity=[15,7]", "stations.2.item_capacity: found 15; expected the scenario's"),
    ({}, "stations.order_capacity=5", "stations.1.item_capacity: found 15; expected the scenario's stations.ord"),
    ({"layout": {"blocks": {"block_rows": 5, "stations_east": 2}}}, "", "layout: found another grid"),
    ({"robots": {"r": {"cell": 9, "task": "P1"}}}, "", "robots: found 1; expected the scenario's"),
    (CARRIED | {"robots": CARRIED["robots"] | {"4": {"cell": 45}}}, "", "by-hand.json, robots: robots 4 and 3 have ro"),
    ({}, "run.until_s=60", "run.until_s=60: found 60, but the state is of 36000 s"),
    ({"robots": {name: {"cell": 30 + int(name), "in_service": name != "2"} for name in "1234"}}, "", "robots.2.in_s"),
    ({"robots": {name: {"cell": 30} for name in "1234"}}, "", 'stations.1.line[0]: names pod "P1", which is no rob'),
    ({"pods": BY_HAND["pods"] | EMPTY}, "", "pods: found 203; the layout ha"),
    ({"time_s": -5.5, "orders": {}}, "", "time_s: found -5.5; expected seconds since a run's time 0"),
    ({"time_s": 1.7e9}, "", "time_s: found 1,700,000,000; expected seconds since a run's time 0, not more than 100"),
    ({"run": {"pickers_s": {"1": -5}}}, "", "run.pickers_s.1: found -5, which is not later than the state's time"),
    ({"run": {"completed_s": {"C": 35600}}}, "", 'run.completed_s.C: names order "C", which the state does not list'),
    ({"run": {"cancelled_s": {"A": 36001}}}, "", "run.cancelled_s.A: found 36001; expected a time from the order's a"),
    ({"run": {"bundles_s": {"C": 35600}}}, "", 'run.bundles_s.C: names bundle "C", which the state does not list'),
    ({"run": {"begun": {"9": [1, 2, 3]}}}, "", 'run.begun.9: names station "9", which the state does not list'),
    ({"run": {"begun": {"1": [0, 2, 0]}}}, "", "run.begun.1: found [0, 2, 0]; expected the ids of a visit, an order"),
    ({"run": {"drawn": {"": 5}}}, "", 'found ""; expected ids: pod, or order and SKU'),
    (going("dance"), "", "run.going[0].kind: expected"),
    (going("lift", robot="9"), "", 'run.going[0].robot: names robot "9", which the state'),
    (going("alarm", until_s=5), "", "run.going[0].until_s: found 5, which is not later th"),
    (going("release", station="1", until_s=36001), "", 'run.going[0].station: found "r'),
    (
        going("handled", station="1", order="Z", sku="tea", until_s=36001),
        "",
        'run.going[0].order: names order "Z", which the state does not list',
    ),
    (
        going("picker", robot="1", story="transport"),
        "",
        'run.going[0].visit: is missing; expected in an entry of kind "picker"',
    ),
    (
        going("pick", robot="2", visit=1, sku="tea", until_s=36001),
        "",
        'run.going[0].kind: found "pick", but robot "2" is first in no line',
    ),
    (going("pick", **PICK, until_s=36010) | BUSY, "", "run.going[0].until_s: found 36010; ex"),
    (
        going("pick", **PICK, until_s=36009) | BUSY | {"robots": CARRIED["robots"] | {"2": {"cell": 9}}},
        "",
        'run.going[0].kind: found "pick" for robot "1"; expected one that stands at the station where it is first',
    ),
    (
        CARRIED | going("wait", robot="3", until_s=36010, legs=[[46, 2]]),
        "",
        "run.going[0].until_s: found 36010; expected 2 s after a time from `since_s` to the state's",
    ),
)
def test_what_cannot_be_is_refused(tmp_path: Path, changes: dict[str, Any], overrides: str, sentence: str) -> None:
    assert sentence in refusal(lambda: simulate(written(tmp_path, **changes), "instance.orders=0", *overrides.split()))


def task(kind: str, order: str, **more: Any) -> dict[str, Any]:
    return {"kind": kind, "order": order, "since_s": 35950} | more


TEA_AND_MILK, JAM = {"station": "1", "skus": ["milk", "tea"]}, {"station": "2", "skus": ["jam"]}
BOXED = {
    "lines": {"milk": 2, "tea": 1, "jam": 2},
    "arrival_s": 35000,
    "parts": [TEA_AND_MILK, JAM],
    "packing": {"station": "1", "box": 0, "first_part_s": 35900, "items_in_box": 1},
}
WHOLE = {"lines": {"jam": 2}, "arrival_s": 35500, "parts": [JAM], "packing": {"station": "1", "first_part_s": 35950}}
AT_WORK = task("pack", "B", items=2, duration_s=40, until_s=36010)
HALL: dict[str, Any] = {
    "pods": {"P1": {"contents": {"milk": 9, "tea": 5}}, "P2": {"contents": {"jam": 6}}},
    "stations": BY_HAND["stations"] | {"2": {"item_capacity": 15}},
    "orders": {"A": BOXED, "B": WHOLE, "C": WHOLE | {"packing": {"station": "2"}}},
    "packing": {"stations": [{"tasks": [task("put", "A", duration_s=9)], "working": [AT_WORK]}, {}]},
}


def packs(folder: Path, *overrides: str, tasks: Any = (), working: Any = (), **orders: Any) -> Result:
    """Return the run of a packing hall by hand, with other orders, and more tasks and work at its first station."""
    first = HALL["packing"]["stations"][0]
    stations = [{"tasks": [*first["tasks"], *tasks], "working": [*first["working"], *working]}, {}]
    state = written(folder, **HALL | {"orders": HALL["orders"] | orders, "packing": {"stations": stations}})
    return simulate(state, "instance.orders=0", "rules.pp=free-flow", *overrides, scenario="examples/packing")


def test_a_packing_hall_by_hand_goes_on(tmp_path: Path) -> None:
    result = packs(tmp_path)
    assert (result.status, result.metrics["orders_packed"], result.metrics["totes"]) == ("complete", 3, 2)
    assert result.metrics["packed_makespan_s"] == pytest.approx(36143, abs=1)


@cases(
    "changes overrides sentence",
    ({"E": BOXED | {"parts": [JAM, JAM | {"skus": ["milk", "tea"]}]}}, (), "orders: found a box that two orders have"),
    ({"A": BOXED | {"packing": {"station": "1"}}}, (), "orders.A.packing.box: expected a box for an order that is s"),
    ({"B": WHOLE | {"packing": {"station": "1", "box": 0}}}, (), "orders.B.packing.box: expected a box for an order"),
    ({"C": WHOLE | {"packing": None}}, (), "orders.C.packing: is missing; expected the packing station of an order"),
    ({"A": BOXED | {"packing": BOXED["packing"] | {"items_in_box": 4}}}, (), "found 5 items in the box and in tasks"),
    ({"C": WHOLE | {"packing": {"station": "3"}}}, (), 'names packing station "3"; the state has 2'),
    ({"tasks": [task("put", "Z")]}, (), 'tasks[1].order: names order "Z", which the state does not list'),
    ({"tasks": [task("put", "B")]}, (), 'orders.B.packing: found 1 task of kind "put" for it; expected 0'),
    ({"tasks": [AT_WORK]}, (), "orders.B.packing: found 4 items in the box and in tasks; expected at most 2"),
    ({"working": [task("put", "A")]}, (), "working: found 2 tasks of packers; expected at most 1"),
    ({"A": BOXED | {"packing": BOXED["packing"] | {"packed": True}}}, (), 'names order "A", which is not bound'),
    ({}, ("packing.stations=3",), "packing.stations: found 2; expected the scenario's packing stations: 3"),
    ({}, ("packing=", "rules.packing=", "rules.packing_task="), "found 2; expected the scenario's packing stations: 0"),
)
def test_a_packing_hall_that_cannot_be_is_refused(tmp_path, changes, overrides, sentence) -> None:
    assert sentence in refusal(lambda: packs(tmp_path, *overrides, **changes))


STOPPED = (
    *(("restocked", "sipp", 362.89), ("low", "whca-n", 382.454), ("times vary", "free-flow", 332.85)),
    *(("packed", "free-flow", 282.5), ("sorted", "free-flow", 282.5)),
)
"""World, PP rule and time of states with much going on."""
REMOVED = object()
WRONG = (REMOVED, None, "nobody", "wait", 1e6, -1, -1.5, 0, 3.5, 10**12, 1e300, float("nan"), True, [], {}, [[]])


def paths(node: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    entries = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, value in entries:
        yield (*path, key)
        yield from paths(value, (*path, key))


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    folder = tmp_path_factory.mktemp("saved")
    made = {
        world: stopped(folder, at_s, *WORLDS[world], f"rules.pp={pp}")[1].read_text() for world, pp, at_s in STOPPED
    }
    return {world: json.loads(text) for world, text in made.items()}


@settings(max_examples=60)
@given(st.integers(0, 9_999), st.sampled_from(STOPPED), st.sampled_from(WRONG))
def test_whatever_is_wrong_with_what_goes_on_is_a_sentence(
    tmp_path_factory: pytest.TempPathFactory,
    saved: dict[str, Any],
    number: int,
    stop: tuple[str, str, float],
    wrong: object,
) -> None:
    """The run goes on, or is refused with the state's file and the key: no other error, whatever was changed."""
    world, pp, at_s = stop
    state = copy.deepcopy(saved[world])
    places = [*paths(state["run"])]
    *within, last = places[number % len(places)]
    table = reduce(operator.getitem, within, state["run"])
    if wrong is REMOVED:
        del table[last]
    elif wrong == "nobody" and isinstance(last, str) and isinstance(table[last], dict | list | float):
        table["nobody"] = table.pop(last)
    else:
        table[last] = wrong
    file = tmp_path_factory.mktemp("wrong") / "state.json"
    file.write_text(json.dumps(state))
    begun = f"instance.state_file={file}", f"run.until_s={at_s + 5}"
    try:
        simulate(*WORLDS[world], f"rules.pp={pp}", *begun, out=file.with_name("out"))
    except InputError as error:
        assert str(error).startswith((f"{file}, run", f"{file}, packing", f"{file}, orders", "instance.state_file: r"))
        assert not file.with_name("out").exists()
    except RunError as error:  # with next to nothing in its battery
        assert "has no charge left" in str(error)


@cases(
    "overrides sentence",
    ((), "run.until_s: found none"),
    (('rules.ta={rule="switch",cases=[{rule="nearest-robot"}]}', "run.until_s=60"), "keeps data that no state holds"),
)
def test_a_state_that_would_not_be_whole_is_not_written(tmp_path, overrides, sentence) -> None:
    with pytest.raises(InputError, match=sentence):
        simulate(*overrides, save_state=tmp_path / "state.json")
    assert not (tmp_path / "state.json").exists()


@define
class Remembering(NearestRobot):
    """Remembers whatever it is given, by a method or a parameter of that name."""

    memory: Any = None


@cases(
    "memory sentence",
    (lambda: {3: 1}, "memory: returned {3: 1}; expected texts, finite numbers"),
    (lambda: {"prices": np.zeros(2)}, "memory: returned {'prices': array"),
    (lambda: [math.inf], "memory: returned [inf]; expected"),
    (lambda: 1 / 0, "memory: raised ZeroDivisionError: division by zero ("),
    (lambda: {"at": [np.int64(3), 0.5, None]}, None),
    (20, None),
)
def test_what_a_state_would_not_give_back_is_not_written(tmp_path: Path, memory: Any, sentence: str | None) -> None:
    file, rules = tmp_path / "state.json", {"ta": Remembering(memory)}
    if sentence is None:
        simulate("run.until_s=60", rules=rules, save_state=file)
    else:
        assert sentence in said(InputError, simulate, "run.until_s=60", rules=rules, save_state=file)
    assert file.exists() == (sentence is None)


def test_commands_begin_in_a_state(tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    small = ("run", "examples/small", "--set", "instance.orders=25", "--set", "rules.pp=free-flow", "-q")
    main([*small, "--set", "run.until_s=100", "--save-state", "s.json", "--out", "a"])
    main([*small, "--from", "s.json", "--out", "b"])
    assert json.loads((tmp_path / "b/result.json").read_text())["status"] == "complete"
    capsys.readouterr()
    main([*small, "--from", "s.json", "--trace", "--record-decisions", "--out", "t"])
    assert exit_code("validate", "t") == exit_code("replay", "t", "--frames", "1", "-q") == 0
    assert "the run has periods 4 to" in refused(capsys, main, ["explain", "t", "--period", "2"])
    state, late = (tmp_path / "s.json").read_text(), (*small, "--set", "run.until_s=9000")
    sentence = "so s.json was not written; the file there is an earlier one; expected an earlier time"
    assert sentence in refused(capsys, main, [*late, "--save-state", "s.json", "--out", "c"])
    assert (tmp_path / "s.json").read_text() == state
    assert refused(capsys, main, [*late, "--save-state", "."]).startswith("Error: .: cannot be written: a folder")
    assert "gone/s.json: cannot be written" in refused(capsys, main, [*late, "--save-state", "gone/s.json"])
    main(["report", "b", "--out", "b.html"])
    assert "before the run" in (tmp_path / "b.html").read_text()
    checked = ("scenario", "check", "examples/small", "--set", "instance.state_file")
    assert exit_code(*checked[:-1], f"{checked[-1]}=s.json") == 0
    capsys.readouterr()
    assert exit_code(*checked[:-1], f"{checked[-1]}=none.json") == 2
    assert "none.json: cannot be read: No such file" in "".join(capsys.readouterr())
    sized = ("size", "examples/small", "--set", "instance.state_file=s.json", "--p95", "100", "-q")
    assert "the state tells of 4 robots" in refused(capsys, main, sized)
    many = (*small[:4], *("--set", "robots.count=12", "--seed", "4", "-q"))
    main([*many, "--set", "rules.pp=whca-n", "--set", "run.until_s=255.662", "--save-state", "w.json"])
    assert exit_code(*many, "--set", "rules.pp=sipp", "--from", "w.json") == 1
    assert "expected rules.pp=whca-n or free-flow, which go on from there" in capsys.readouterr().err
    clock = refused(capsys, main, [*small, "--set", "run.until_s=12:00"])
    assert clock.endswith('expected a number, found "12:00", which is 43200 s after midnight\n')


def test_advice_is_about_the_orders_of_a_state_and_those_that_come(tmp_path: Path) -> None:
    orders = {name: order | {"arrival_s": 0} for name, order in BY_HAND["orders"].items()}
    state = written(tmp_path, time_s=3600, orders=orders)
    given = (state, "instance.arrivals.process=poisson", "instance.arrivals.orders_per_hour=300")
    later, none = (load_scenario("examples/small", [*given, f"instance.orders={number}"]) for number in (600, 25))
    assert cut(none, None).told == ("Simulated: 2 orders, those of the state.",)
    number = sum(3_600_000 < order.arrival_tick < 5_400_000 for order in make_instance(later).orders)
    assert cut(later, 0.5).told[0] == f"Simulated: 0.5 hours, in which {number} of 600 orders arrive."


WAY = """
from rmfs_core.simulation.driving.base import Driving

class Way(Driving):
    def to_location(self, robot, cell):
        now = self.run.warehouse.now
        yield self.set_off(robot, cell, 0, robot.heading, now, 0, now + 900_000)

@define
class Mine:
    "PP: plans for a way that is not ours."
    reserves = "way"

    @hookimpl
    def plan_path(self):
        return None
"""


def test_a_way_that_is_not_ours_is_driven_in_whole_runs_only(at_work, install, tmp_path: Path) -> None:
    install("bolt", {"way": "acme_rules:Way"}, "rmfs.driving")
    install("acme", {"mine": "acme_rules:Mine"}, acme_rules=WAY)
    told = r'rule "mine" \(acme 1.0\) plans for the way of driving \'way\', '
    _, state = stopped(tmp_path, 5)
    for beginning in ((), (f"instance.state_file={state}",)):
        with pytest.raises(InputError, match=f"rules.pp.*: {told}of whose robots on their legs a state tells nothing;"):
            simulate("rules.pp=mine", "run.until_s=90", *beginning, save_state=tmp_path / "saved.json")
    at_work |= {"ask": {"decides": "PP", "robot": "r2", "goal": 7}}
    with pytest.raises(InputError, match=f"^state: {told}which asks for paths in a run only; expected a rule for a wa"):
        decide(state_from_dict(at_work), RuleChoice("mine"))
    with pytest.raises(InputError, match=f"^--pp: {told}which asks"):
        find_planner("mine", {}, np.random.default_rng(1))
