"""Energy, rests, moves and charges, worked out anew."""

from __future__ import annotations

from pathlib import Path

import pytest

import rmfs_core
from rmfs_commands.trace import read_trace
from rmfs_commands.validation import validate_trace
from rmfs_commands.validation.robots import recompute_robots

OVERRIDES = (
    "instance.orders=30",
    "robots.count=6",
    "layout.chargers=2",
    "rules.idle=charge-when-low",
    "rules.move=utility",
    "robots.battery={capacity_wh=55, loaded_w=900, charging_w=20000, detour=1.2}",
    "run.warmup_s=60",
)


def test_a_run_says_what_its_trace_amounts_to(tmp_path: Path) -> None:
    """Nothing is found in the run's folder, robots.csv included; every metric but the lowest charge is worked out."""
    metrics = rmfs_core.run("examples/small", overrides=OVERRIDES, out=tmp_path, record=["trace"]).metrics
    assert validate_trace(tmp_path) == []
    found = recompute_robots(read_trace(tmp_path / "trace.jsonl.gz"), 60_000, metrics["orders_completed"])
    assert found == pytest.approx({name: metrics[name] for name in found})
    assert found.keys() >= {"energy_per_order_wh", "resting_distance_m", "pods_moved", "charges", "charging_percent"}
    assert found["pods_moved"] and found["charges"] and found["charging_percent"]
    header = (tmp_path / "robots.csv").read_text(encoding="utf-8").splitlines()[0]
    assert header.endswith("storing_s,to_rest_s,charging_s,moving_pods_s,waiting_s")


def test_a_run_without_such_rules_tells_of_energy_alone(tmp_path: Path) -> None:
    """Neither metrics nor columns of what cannot be."""
    metrics = rmfs_core.run("examples/small", overrides=["instance.orders=4"], out=tmp_path, record=["trace"]).metrics
    found = recompute_robots(read_trace(tmp_path / "trace.jsonl.gz"), 0, 4)
    assert {name for name in found if not name.startswith("energy_")} == {"picking_distance_per_order_m"}
    assert not {"charges", "pods_moved", "resting_distance_m"} & metrics.keys()
