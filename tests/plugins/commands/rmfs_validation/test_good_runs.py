"""Recorded runs of every shipped rule have no faults."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import pytest

import rmfs_core
from rmfs_cli.description import installed_rules
from rmfs_validation import check_trace, validate_trace

COMMON = ("instance.orders=15", "instance.skus=12", "instance.pods=12", "layout.block_columns=2")


def shipped(decides: str) -> list[str]:
    """Return the names of the rules of this distribution that decide something."""
    found = installed_rules()
    return [rule.name for rule in found if rule.distribution == "rmfs" and decides in rule.decides and not rule.error]


SEQUENTIAL = list(product(shipped("POA"), shipped("PPS"), shipped("PR"), shipped("TA"), shipped("PP")))
JOINT = list(product(shipped("POA+PPS"), shipped("PP")))


def test_there_are_rules_to_combine() -> None:
    """The combinations below are not empty."""
    assert len(SEQUENTIAL) >= 36


@pytest.mark.parametrize(("poa", "pps", "pr", "ta", "pp"), SEQUENTIAL)
def test_sequential_rules(poa: str, pps: str, pr: str, ta: str, pp: str, tmp_path: Path) -> None:
    """Any combination of shipped sequential rules leaves a trace and metrics without faults."""
    rules = (f"rules.poa={poa}", f"rules.pps={pps}", f"rules.pr={pr}", f"rules.ta={ta}", f"rules.pp={pp}")
    rmfs_core.run("examples/small", overrides=(*COMMON, *rules), out=tmp_path, record=["trace"])
    assert validate_trace(tmp_path) == []


@pytest.mark.parametrize(("joint", "pp"), JOINT)
def test_joint_rules(joint: str, pp: str, tmp_path: Path) -> None:
    """So does any joint rule."""
    rules = ("rules.poa=", "rules.pps=", f"rules.poa_pps={joint}", f"rules.pp={pp}")
    rmfs_core.run("examples/small", overrides=(*COMMON, *rules), out=tmp_path, record=["trace"])
    assert validate_trace(tmp_path) == []


@pytest.mark.parametrize("pp", shipped("PP"))
@pytest.mark.parametrize(
    "settings",
    [
        ("stations.order_capacity=2",),
        ("stations.order_capacity=[1, 4]",),
        ("stations.item_capacity=[15, 20]", "stations.queue_length=1", "robots.count=8"),
        ("instance.items_per_sku=40", "instance.arrivals.process=poisson", "instance.arrivals.orders_per_hour=400"),
        ("run.until_s=200",),
        ("instance.pods_at_stations={1 = ['1', '2'], 2 = ['3']}",),
        ("robots.acceleration_m_per_s2=0.7", "robots.top_speed_m_per_s=2.3", "robots.full_turn_s=3.1"),
        ("stations.pick_s=5", "stations.handle_s=5", "robots.lift_s=0"),
        ("layout.pod_fill=1", "layout.stations_west=1"),
    ],
)
def test_settings(settings: tuple[str, ...], pp: str, tmp_path: Path) -> None:
    """Capacity in orders, finite stock, arrivals, early ends, other robots: no faults."""
    overrides = (*COMMON, f"rules.pp={pp}", *settings)
    rmfs_core.run("examples/small", overrides=overrides, out=tmp_path, record=["trace"])
    assert validate_trace(tmp_path) == []


@pytest.mark.parametrize("name", ["examples/from-csv", "examples/example-2-sequential", "examples/poisson"])
def test_shipped_scenarios(name: str, tmp_path: Path) -> None:
    """Shipped examples have no faults; the report says what was looked at."""
    rmfs_core.run(name, overrides=("rules.pp=free-flow",), out=tmp_path, record=["trace"])
    report = check_trace(tmp_path)
    assert report.faults == []
    assert report.events > 100
    assert report.metrics_checked
    assert not report.collisions_checked
