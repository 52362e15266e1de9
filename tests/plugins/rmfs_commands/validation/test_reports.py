"""Metrics and tables of a run, worked out anew from its trace."""

import csv
import gzip
import json
import time
from pathlib import Path
from typing import Any

import pytest

import rmfs_core
from cases import cases
from replenished import scenario_of
from rmfs_commands.details.catalogue import REPLENISHMENT
from rmfs_commands.results.files import to_csv
from rmfs_commands.trace import Trace, read_trace
from rmfs_commands.validation import check_trace, faults_of, validate_trace
from rmfs_commands.validation.details import HANDLED, recompute_details
from rmfs_commands.validation.files import FILES
from rmfs_commands.validation.metrics import recompute
from rmfs_commands.validation.restocking import bundles_of, recompute_replenishment, stock_of
from rmfs_commands.validation.robots import recompute_robots
from rmfs_core import StandstillError
from rmfs_core.errors import InputError
from rmfs_core.events import BundleStored, PodMoveDecided


def test_every_metric_is_recomputed_and_an_altered_one_is_found(recorded, recorded_result) -> None:
    metrics = recorded_result["metrics"]
    assert metrics.keys() == (recompute(recorded) | recompute_details(recorded)).keys()
    for name, value in metrics.items():
        for altered in (
            metrics | {name: (value or 0) * 1.001 + 0.001},
            {k: v for k, v in metrics.items() if k != name},
        ):
            (fault,) = faults_of(recorded, recorded_result | {"metrics": altered})
            assert (fault.kind, fault.sentence.split()[0]) == ("metric", name)


def test_a_result_of_another_run_is_found(recorded: Trace, recorded_result: dict[str, Any]) -> None:
    for change_of in ({"status": "failed"}, {"scenario": {**recorded_result["scenario"], "seed": 99}}):
        (fault,) = faults_of(recorded, {**recorded_result, **change_of})
        assert fault.kind == "other-run"


@cases(
    "altered kind",
    ({"seed": True}, "other-run"),
    ({"timing": {"wall_s": True}}, "metric"),
    ({"timing": {"hook_s": {"plan_path": False}}}, "metric"),
    ({"metrics": {"mine": True}}, "metric"),
)
def test_true_is_no_number(recorded: Trace, recorded_result: dict[str, Any], altered: Any, kind: str) -> None:
    assert recorded_result["seed"] == 1
    (section,) = altered
    if section != "seed":
        altered = {section: recorded_result[section] | altered[section]}
    (fault,) = faults_of(recorded, recorded_result | altered)
    assert fault.kind == kind


def test_handling_has_its_part_of_an_orders_time(tmp_path: Path) -> None:
    settings = ("stations.release=handled", 'instance.arrivals={process="refill", backlog=5}', "run.until_s=400")
    rmfs_core.run("examples/small", overrides=settings, out=tmp_path, record=["trace"])
    assert not validate_trace(tmp_path)
    rows = list(csv.DictReader((tmp_path / "delays.csv").read_text(encoding="utf-8").splitlines()))
    done = [row for row in rows if row["turnover_s"]]
    assert 5 < len(done) < len(rows)
    for row in done:
        assert float(row["handling_s"]) == 6
        assert sum(float(row[part]) for part in HANDLED) == pytest.approx(float(row["turnover_s"]), abs=1e-9)
    orders = list(csv.DictReader((tmp_path / "orders.csv").read_text(encoding="utf-8").splitlines()))
    assert {row["arrival_s"] for row in orders} >= {"0.0", ""}
    assert len({row["arrival_s"] for row in orders}) > 5


SETTINGS = (
    "instance.orders=12",
    'instance.arrivals={process = "poisson", orders_per_hour = 400}',
    "instance.departures.times=[20, 60, 100, 5000]",
    "run.warmup_s=30",
    "layout.replenishment_west=1",
    "instance.items_per_sku=3",
    'instance.replenishment={process = "reorder-point", reorder_point = 12, order_up_to = 16}',
    "rules.roa=first-bundle",
    "rules.rps=emptiest-pod",
    "packing.packers=1",
    "costs={picker_per_h=30, packer_per_h=20, replenisher_per_h=9, robot_per_h=2, kwh=900, late_order=2, late_h=3}",
)


@pytest.fixture(scope="module")
def tables(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a small run with departures, warm-up, replenishment, packing and trace."""
    folder = tmp_path_factory.mktemp("tables") / "out"
    rmfs_core.run("examples/small", overrides=SETTINGS, out=folder, record=["trace"])
    return folder


@pytest.fixture
def copy(tables: Path, tmp_path: Path) -> Path:
    for name in ("trace.jsonl.gz", "result.json", *FILES):
        (tmp_path / name).write_bytes((tables / name).read_bytes())
    return tmp_path


def test_every_table_is_worked_out_anew(tables: Path, copy: Path) -> None:
    assert all((tables / name).exists() for name in FILES)
    assert not validate_trace(tables)
    for name in FILES:
        (copy / name).unlink()
    assert not validate_trace(copy)
    result = json.loads((copy / "result.json").read_text(encoding="utf-8"))
    costs = [name for name in result["metrics"] if name.startswith("cost_")]
    assert len(costs) == 8
    for name in (*costs, "departed_share", "missed_percent", "late_orders", "late_percent", "on_time_percent"):
        altered = result | {"metrics": result["metrics"] | {name: (result["metrics"][name] or 0) * 1.001 + 0.001}}
        (copy / "result.json").write_text(json.dumps(altered), encoding="utf-8")
        (fault,) = validate_trace(copy)
        assert fault.sentence.startswith(name)


@pytest.mark.parametrize("name", FILES)
def test_each_figure_that_was_changed_is_found(copy: Path, name: str) -> None:
    with (copy / name).open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    key, *columns = rows[0]
    for column in columns:
        if column == "seconds":  # of the wall clock, which a trace does not know
            continue
        changed = [*rows[:-1], {**rows[-1], column: "123.5"}]
        (copy / name).write_text(to_csv(list(rows[0]), changed), encoding="utf-8")
        (fault,) = validate_trace(copy)
        assert fault.kind == "table"
        assert fault.sentence.startswith(f"{name} has 123.5 as {column} of {key} {rows[-1][key]}; the trace amounts to")


@pytest.mark.parametrize("name", FILES)
def test_rows_that_are_missing_are_found(copy: Path, name: str) -> None:
    lines = (copy / name).read_text(encoding="utf-8").splitlines(keepends=True)
    (copy / name).write_text("".join(lines[:-1]), encoding="utf-8")
    (fault,) = validate_trace(copy)
    assert fault.sentence == f"{name} lists other {FILES[name][0]}s than the trace"


def test_tables_that_are_missing_or_no_text(copy: Path) -> None:
    text = (copy / "robots.csv").read_text(encoding="utf-8")
    (copy / "robots.csv").write_text(text.replace("idle_s", "lazy_s"), encoding="utf-8")
    assert "robots.csv has nothing as idle_s of robot 1; the trace amounts to" in validate_trace(copy)[0].sentence
    (copy / "delays.csv").write_bytes(b"\xff\xfe\xff")
    with pytest.raises(InputError, match=r"delays\.csv: cannot be read"):
        validate_trace(copy)


def test_a_trace_that_ends_in_thousands_of_years_takes_no_time(copy: Path) -> None:
    trace = copy / "trace.jsonl.gz"
    *lines, end = gzip.decompress(trace.read_bytes()).decode().splitlines()
    late = json.dumps({**json.loads(end), "tick": 10**15})
    trace.write_bytes(gzip.compress("\n".join([*lines, late, ""]).encode()))
    began = time.process_time()
    assert "hours.csv lists other hours than the trace" in [fault.sentence for fault in validate_trace(copy)]
    assert time.process_time() - began < 5


OVERRIDES = (
    "instance.orders=30",
    "robots.count=3",
    "layout.chargers=1",
    "rules.idle=charge-when-low",
    "rules.move=utility",
    "robots.battery={capacity_wh=55, loaded_w=900, charging_w=20000, detour=1.2}",
    "run.warmup_s=60",
)


def test_energy_charges_and_moves_are_worked_out_anew(tmp_path: Path) -> None:
    metrics = rmfs_core.run("examples/small", overrides=OVERRIDES, out=tmp_path, record=["trace"]).metrics
    assert validate_trace(tmp_path) == []
    found = recompute_robots(read_trace(tmp_path / "trace.jsonl.gz"), 60_000, metrics["orders_completed"])
    assert found == pytest.approx({name: metrics[name] for name in found})
    assert found.keys() >= {"energy_per_order_wh", "resting_distance_m", "pods_moved", "charges", "charging_percent"}
    assert found["pods_moved"] and found["charges"] and found["charging_percent"]
    header = (tmp_path / "robots.csv").read_text(encoding="utf-8").splitlines()[0]
    assert header.endswith("storing_s,to_rest_s,charging_s,low_s,moving_pods_s,waiting_s")
    metrics = rmfs_core.run("examples/small", overrides=["instance.orders=4"], out=tmp_path, record=["trace"]).metrics
    found = recompute_robots(read_trace(tmp_path / "trace.jsonl.gz"), 0, 4)
    assert {name for name in found if not name.startswith("energy_")} == {"picking_distance_per_order_m"}
    assert not {"charges", "pods_moved", "resting_distance_m"} & metrics.keys()


SUPPLY = {"process": "reorder-point", "reorder_point": 1, "order_up_to": 6, "lead_s": 200.0}
INSTANCE = {"orders": 40, "skus": 4, "pods": 4, "skus_per_pod": 1, "items_per_sku": 4, "replenishment": SUPPLY}


@pytest.fixture
def restocked(tmp_path: Path) -> Path:
    scenario = scenario_of(SUPPLY, robots=1, instance=INSTANCE, run={"warmup_s": 600.0})
    rmfs_core.run(scenario, out=tmp_path, record=["trace"])
    return tmp_path


def test_what_a_run_measures_is_what_its_events_amount_to(restocked: Path) -> None:
    assert check_trace(restocked).faults == []
    trace = read_trace(restocked / "trace.jsonl.gz")
    metrics = recompute_replenishment(trace)
    assert metrics.keys() == {metric.name for metric in REPLENISHMENT}
    assert 0 < metrics["bundles_stored"] < sum(isinstance(event, BundleStored) for event in trace.events)  # type: ignore[operator]
    assert sum(row["items_stored"] for row in stock_of(trace)) > metrics["items_stored"]  # type: ignore[misc, operator]
    assert len(list(bundles_of(trace))) > metrics["bundles_stored"]  # type: ignore[operator]


def test_pods_that_are_moved_without_a_visit_are_no_replenishment(tmp_path: Path) -> None:
    instance = {**INSTANCE, "orders": 5, "arrivals": {"process": "poisson", "orders_per_hour": 30.0}}
    rmfs_core.run(scenario_of(SUPPLY, instance=instance, rules={"move": "utility"}), out=tmp_path, record=["trace"])
    assert any(isinstance(event, PodMoveDecided) for event in read_trace(tmp_path / "trace.jsonl.gz").events)
    assert check_trace(tmp_path).faults == []


def test_a_run_that_ends_at_time_0_has_one_hour(tmp_path: Path) -> None:
    (tmp_path / "orders.csv").write_text("order,arrival_s,sku,quantity\n1,0,mug,1\n", encoding="utf-8")
    (tmp_path / "pods.csv").write_text("pod,sku,quantity\np,tea,4\n", encoding="utf-8")
    files = {f"{name}_file": str(tmp_path / f"{name}.csv") for name in ("orders", "pods")}
    supply = {"process": "reorder-point", "reorder_point": 0, "order_up_to": 2}
    scenario = scenario_of(supply, instance={**files, "pod_capacity": 4, "replenishment": supply})
    with pytest.raises(StandstillError, match="bundles that fit on no pod: 1"):
        rmfs_core.run(scenario, out=tmp_path / "run", record=["trace"])
    assert len(list(stock_of(read_trace(tmp_path / "run" / "trace.jsonl.gz")))) == 1
    assert check_trace(tmp_path / "run").faults == []


def test_a_wrong_metric_is_found(restocked: Path) -> None:
    trace, result = read_trace(restocked / "trace.jsonl.gz"), json.loads((restocked / "result.json").read_text("utf-8"))
    for name in (metric.name for metric in REPLENISHMENT):
        value = (result["metrics"][name] or 0) + 1  # None where no order arrives after the warm-up
        (fault,) = faults_of(trace, result | {"metrics": result["metrics"] | {name: value}})
        assert fault.sentence.startswith(f"{name} is reported as ")
