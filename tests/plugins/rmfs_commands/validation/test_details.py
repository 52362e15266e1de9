"""Metrics and delays that every run leaves, held against its trace."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

import rmfs_core
from rmfs_commands.trace import read_trace
from rmfs_commands.validation import validate_trace
from rmfs_commands.validation.details import HANDLED, PARTS, delays_of, recompute_details

LATE = (
    "instance.orders=12",
    'instance.arrivals={process = "poisson", orders_per_hour = 400}',
    "instance.due={allowance_s = 10}",
    "run.warmup_s=30",
    "stations.release=picked",
)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a small run with due times, warm-up and trace."""
    folder = tmp_path_factory.mktemp("details") / "out"
    rmfs_core.run("examples/small", overrides=LATE, out=folder, record=["trace"])
    return folder


def test_a_run_says_what_its_trace_amounts_to(recorded: Path) -> None:
    """Nothing is found; what is worked out anew is what the run measured."""
    assert not validate_trace(recorded)
    found = recompute_details(read_trace(recorded / "trace.jsonl.gz"))
    assert found["late_orders"]
    measured = rmfs_core.run("examples/small", overrides=LATE).metrics
    assert {name: measured[name] for name in found} == pytest.approx(found)


def test_handling_has_its_part_of_an_orders_time(tmp_path: Path) -> None:
    """Six seconds, where orders are complete only then; the times add up, whenever orders came into the backlog."""
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


def test_an_orders_times_add_up(recorded: Path) -> None:
    """To its turn-over time, to the millisecond."""
    delays = delays_of(read_trace(recorded / "trace.jsonl.gz"))
    assert len(delays) == 12
    for times in delays:
        assert sum(float(times[part] or 0) for part in PARTS) == pytest.approx(times["turnover_s"], abs=1e-9)
