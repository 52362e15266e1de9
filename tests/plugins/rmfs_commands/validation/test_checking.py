"""Folders of runs: those of every shipped rule have no faults, and what is missing or damaged is said."""

from __future__ import annotations

import gzip
import json
from collections.abc import Iterator, Sequence
from itertools import product
from pathlib import Path
from shutil import copytree

import pytest

import rmfs_core
from rmfs_commands.cli.description import installed_rules
from rmfs_commands.validation import check_trace, validate_trace
from rmfs_core.errors import InputError

COMMON = ("instance.orders=15", "instance.skus=12", "instance.pods=12", "layout.block_columns=2")


def shipped(decides: str) -> list[str]:
    """Return the names of the rules of this distribution that decide something."""
    found = installed_rules()
    return [rule.name for rule in found if rule.distribution == "rmfs" and decides in rule.decides and not rule.error]


def rows(roles: Sequence[str]) -> Iterator[tuple[str, ...]]:
    """Yield rules for roles, so that every rule is there twice, the second time beside others."""
    names = [shipped(role) for role in roles]
    for turn, number in product(range(2), range(max(map(len, names)))):
        yield tuple(found[(number + turn * place) % len(found)] for place, found in enumerate(names))


SEQUENTIAL = [(*row, pp) for row in rows(("POA", "PPS", "PR", "TA")) for pp in shipped("PP")]
JOINT = list(product(shipped("POA+PPS"), shipped("PP")))
CHOSEN = {"switch": '{rule="switch", cases=[{rule="random", before_s=300}, {rule="random"}]}'}
"""What a scenario says of a rule that cannot do without parameters."""


def test_there_are_rules_to_combine() -> None:
    """The combinations below are not empty."""
    assert len(SEQUENTIAL) >= 36
    assert {name for row in SEQUENTIAL for name in row} >= {*shipped("POA"), *shipped("PPS"), *shipped("PR")}


@pytest.mark.parametrize(("poa", "pps", "pr", "ta", "pp"), SEQUENTIAL)
def test_sequential_rules(poa: str, pps: str, pr: str, ta: str, pp: str, tmp_path: Path) -> None:
    """Shipped sequential rules leave a trace and metrics without faults, whatever the others are."""
    named = {"poa": poa, "pps": pps, "pr": pr, "ta": ta, "pp": pp}
    rules = (f"rules.{role}={CHOSEN.get(name, name)}" for role, name in named.items())
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
        ("stations.item_capacity=3",),
        ("stations.order_capacity=2", "rules.poa=", "rules.pps=", "rules.poa_pps=split-over-time"),
        ("stations.item_capacity=[15, 20]", "stations.queue_length=1", "robots.count=8"),
        ("instance.items_per_sku=40", "instance.arrivals.process=poisson", "instance.arrivals.orders_per_hour=400"),
        ("run.until_s=200",),
        ("instance.pods_at_stations={1 = ['1', '2'], 2 = ['3']}",),
        ("robots.acceleration_m_per_s2=0.7", "robots.top_speed_m_per_s=2.3", "robots.full_turn_s=3.1"),
        ("stations.pick_s=5", "stations.handle_s=5", "robots.lift_s=0"),
        ("layout.pod_fill=1", "layout.stations_west=1"),
        ("stations.release=handled", "stations.order_capacity=2"),
        ("stations.release=handled", "instance.arrivals={process='refill', backlog=6}", "run.until_s=333"),
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
    assert report.events > 80
    assert report.metrics_checked
    assert not report.collisions_checked


@pytest.fixture
def copied(recorded_folder: Path, tmp_path: Path) -> Path:
    """Return a copy of a recorded run's folder, to be damaged."""
    return copytree(recorded_folder, tmp_path / "run")


def test_a_result_is_read_where_there_is_one(copied: Path) -> None:
    """The folder or the trace in it, with its result beside it; without one, no metric is compared."""
    for path in (copied, copied / "trace.jsonl.gz", str(copied)):
        report = check_trace(path)
        assert (report.faults, report.metrics_checked, report.collisions_checked) == ([], True, False)
    result = copied / "result.json"
    content = json.loads(result.read_text(encoding="utf-8"))
    content["metrics"]["picks"] += 1
    result.write_text(json.dumps(content), encoding="utf-8")
    assert [fault.kind for fault in validate_trace(copied)] == ["metric"]
    result.unlink()
    assert not check_trace(copied).metrics_checked
    assert validate_trace(copied) == []


def test_collisions_are_looked_for_when_asked_to(copied: Path) -> None:
    """A run of free-flow is full of them; the report says whether they were looked for."""
    report = check_trace(copied, collisions=True)
    assert report.collisions_checked
    assert {fault.kind for fault in report.faults} & {"collision", "swap"}


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        ("{", "result.json: cannot be read as JSON: Expecting property name"),
        ("[" * 100_000, "result.json: cannot be read as JSON: maximum recursion depth"),
        ("[1]", "result.json: expected a result that rmfs has written, with the key `metrics`"),
        ('{"metrics": 3}', "result.json: expected a result that rmfs has written, with the key `metrics`"),
    ],
)
def test_a_damaged_result_is_refused(copied: Path, content: str, problem: str) -> None:
    """A file that is there must be a result: leaving it out of the comparison would hide the damage."""
    (copied / "result.json").write_text(content, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        validate_trace(copied)
    assert str(caught.value).startswith(f"{copied}/{problem}")


def test_a_folder_without_a_trace_is_refused(copied: Path) -> None:
    """The sentence says how to record one."""
    (copied / "trace.jsonl.gz").unlink()
    with pytest.raises(InputError, match=r"run: has no trace.jsonl.gz; `rmfs run --trace` records one$"):
        check_trace(copied)


@pytest.mark.parametrize("scenario", [[], {"rules": "[/x]"}])
def test_a_header_that_does_not_fit_together_is_refused(copied: Path, scenario: object) -> None:
    """Also where it is asked first, whether the path planner avoids collisions."""
    trace = copied / "trace.jsonl.gz"
    header, *lines = gzip.decompress(trace.read_bytes()).decode().splitlines(keepends=True)
    changed = json.dumps({**json.loads(header), "scenario": scenario}) + "\n"
    trace.write_bytes(gzip.compress("".join([changed, *lines]).encode()))
    with pytest.raises(InputError, match="what it says does not fit together"):
        check_trace(copied)
