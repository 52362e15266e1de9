"""What every run leaves beside its results."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

import rmfs_core
from rmfs_commands.details.catalogue import DETAILS, LATENESS
from rmfs_commands.details.loading import load_result
from rmfs_commands.validation.checking import validate_trace
from rmfs_core.errors import InputError

SETTINGS = ("instance.orders=12", "rules.pp=free-flow", "instance.arrivals.process=poisson")
DUE = (
    "instance.arrivals.orders_per_hour=200",
    "instance.due.allowance_s=300",
    "instance.due.priority_share=0.4",
    "instance.due.priority_allowance_s=60",
    "run.warmup_s=100",
)


def rows(folder: Path, name: str) -> list[dict[str, str]]:
    """Return the rows of a table."""
    return list(csv.DictReader((folder / name).read_text(encoding="utf-8").splitlines()))


def test_files_metrics_and_their_validation(tmp_path: Path) -> None:
    """Each table has its rows, times add up, and the validator works out the same metrics and delays."""
    result = rmfs_core.run("examples/small", overrides=[*SETTINGS, *DUE], out=tmp_path, record=["trace"])
    metrics = json.loads((tmp_path / "result.json").read_text(encoding="utf-8"))["metrics"]
    assert {metric.name for metric in (*DETAILS, *LATENESS)} <= metrics.keys()
    assert {metric.name for metric in (*DETAILS, *LATENESS)} <= result.described.keys()
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


def test_a_wrong_delay_is_a_fault(tmp_path: Path) -> None:
    """A time in delays.csv that is not what the events amount to is named."""
    rmfs_core.run(
        "examples/small", overrides=["instance.orders=3", "rules.pp=free-flow"], out=tmp_path, record=["trace"]
    )
    file = tmp_path / "delays.csv"
    lines = file.read_text(encoding="utf-8").splitlines()
    order, turnover, _, *rest = lines[1].split(",")
    file.write_text("\n".join([lines[0], ",".join([order, turnover, "1.5", *rest]), *lines[2:], ""]), encoding="utf-8")
    assert [(fault.kind, fault.sentence) for fault in validate_trace(tmp_path)] == [
        ("table", "delays.csv has 1.5 as backlog_s of order 1; the trace amounts to 0.0")
    ]


def test_due_columns_come_back(tmp_path: Path) -> None:
    """orders.csv has due times where orders are due, and is read back with them; else it has none."""
    due = rmfs_core.run("examples/small", overrides=[*SETTINGS, *DUE], out=tmp_path / "due")
    plain = rmfs_core.run(
        "examples/small", overrides=["instance.orders=3", "rules.pp=free-flow"], out=tmp_path / "plain"
    )
    assert load_result(tmp_path / "due").orders == due.orders
    assert list(due.orders[0])[-3:] == ["due_s", "priority", "lateness_s"]
    assert "due_s" not in plain.orders[0]
    assert load_result(tmp_path / "plain").orders == plain.orders
    assert not {metric.name for metric in LATENESS} & plain.metrics.keys()


def test_foreign_files_are_not_replaced(tmp_path: Path) -> None:
    """A file of one's own by the name of a table stays: the run is refused."""
    (tmp_path / "stations.csv").write_text("mine", encoding="utf-8")
    with pytest.raises(InputError, match=r"found a file stations\.csv that no run of rmfs has written"):
        rmfs_core.run("examples/small", overrides=["instance.orders=1"], out=tmp_path)
