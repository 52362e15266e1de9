"""Tables and metrics of replenishment, worked out anew from the trace of a run."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

import rmfs_core
from replenished import scenario_of
from rmfs_commands.details.catalogue import REPLENISHMENT
from rmfs_commands.trace import read_trace
from rmfs_commands.validation import check_trace
from rmfs_commands.validation.restocking import bundles_of, recompute_replenishment, stock_of
from rmfs_core import StandstillError
from rmfs_core.events import BundleStored, PodMoveDecided

SUPPLY = {"process": "reorder-point", "reorder_point": 1, "order_up_to": 6, "lead_s": 200.0}
INSTANCE = {"orders": 40, "skus": 4, "pods": 4, "skus_per_pod": 1, "items_per_sku": 4, "replenishment": SUPPLY}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return the folder of a run with a warm-up, in which SKUs run out."""
    scenario = scenario_of(SUPPLY, robots=1, instance=INSTANCE, run={"warmup_s": 600.0})
    rmfs_core.run(scenario, out=tmp_path, record=["trace"])
    return tmp_path


def test_what_a_run_measures_is_what_its_events_amount_to(folder: Path) -> None:
    """All metrics, in agreement with the observer that counts while the run goes on."""
    assert check_trace(folder).faults == []
    trace = read_trace(folder / "trace.jsonl.gz")
    metrics = recompute_replenishment(trace)
    assert metrics.keys() == {metric.name for metric in REPLENISHMENT}
    assert 0 < metrics["bundles_stored"] < sum(isinstance(event, BundleStored) for event in trace.events)  # type: ignore[operator]
    assert sum(row["items_stored"] for row in stock_of(trace)) > metrics["items_stored"]  # type: ignore[misc, operator]
    assert len(list(bundles_of(trace))) > metrics["bundles_stored"]  # type: ignore[operator]


def test_pods_that_are_moved_without_a_visit_are_no_replenishment(tmp_path: Path) -> None:
    """Nobody was given a task for them."""
    instance = {**INSTANCE, "orders": 5, "arrivals": {"process": "poisson", "orders_per_hour": 30.0}}
    rmfs_core.run(scenario_of(SUPPLY, instance=instance, rules={"move": "utility"}), out=tmp_path, record=["trace"])
    assert any(isinstance(event, PodMoveDecided) for event in read_trace(tmp_path / "trace.jsonl.gz").events)
    assert check_trace(tmp_path).faults == []


def test_a_run_that_ends_at_time_0_has_one_hour(tmp_path: Path) -> None:
    """It stands still: the only pod has no room for the bundle that the only order waits for."""
    (tmp_path / "orders.csv").write_text("order,arrival_s,sku,quantity\n1,0,mug,1\n", encoding="utf-8")
    (tmp_path / "pods.csv").write_text("pod,sku,quantity\np,tea,4\n", encoding="utf-8")
    files = {f"{name}_file": str(tmp_path / f"{name}.csv") for name in ("orders", "pods")}
    supply = {"process": "reorder-point", "reorder_point": 0, "order_up_to": 2}
    scenario = scenario_of(supply, instance={**files, "pod_capacity": 4, "replenishment": supply})
    with pytest.raises(StandstillError, match="no pod has room for bundles: 1"):
        rmfs_core.run(scenario, out=tmp_path / "run", record=["trace"])
    assert len(list(stock_of(read_trace(tmp_path / "run" / "trace.jsonl.gz")))) == 1
    assert check_trace(tmp_path / "run").faults == []


@pytest.mark.parametrize("metric", [metric.name for metric in REPLENISHMENT])
def test_a_wrong_metric_is_found(folder: Path, metric: str) -> None:
    """Each one."""
    result = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    result["metrics"][metric] = (result["metrics"][metric] or 0) + 1  # None where no order arrives after the warm-up
    (folder / "result.json").write_text(json.dumps(result), encoding="utf-8")
    (fault,) = check_trace(folder).faults
    assert fault.sentence.startswith(f"{metric} is reported as ")


@pytest.mark.parametrize("name", ["bundles.csv", "stock.csv"])
def test_a_wrong_figure_in_a_table_is_found(folder: Path, name: str) -> None:
    """The last one of the file."""
    text = (folder / name).read_text(encoding="utf-8")
    (folder / name).write_text(re.sub(r"(\d+)(\D*)$", r"9\1\2", text), encoding="utf-8")
    (fault,) = check_trace(folder).faults
    assert fault.kind == "table"
