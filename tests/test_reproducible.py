"""Same scenario, same seed, same versions: the same bytes, also in several threads of one process."""

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

import rmfs_core
from rmfs_core.world.travel import Travel

RUN = """
import sys, rmfs_core
rmfs_core.run("examples/small", overrides=["instance.orders=30"], out=sys.argv[1], record=["trace"])
"""


def without_wall_clock(file: Path) -> bytes:
    """Bytes of an output file but for the wall-clock figures: `timing` in result.json, `seconds` in periods.csv."""
    data = file.read_bytes()
    if file.name == "result.json":
        content = json.loads(data)
        assert content.pop("timing")
        return json.dumps(content).encode()
    if file.name == "periods.csv":
        rows = data.decode().splitlines()
        assert rows[0].endswith(",seconds")
        return "\n".join(row.rpartition(",")[0] for row in rows).encode()
    return data


def test_two_fresh_processes_write_the_same_bytes(tmp_path: Path) -> None:
    folders = [tmp_path / "one", tmp_path / "two"]
    for hash_seed, folder in zip(("1", "4242"), folders, strict=True):
        environment = os.environ | {"PYTHONHASHSEED": hash_seed}
        subprocess.run([sys.executable, "-c", RUN, str(folder)], check=True, env=environment)
    names = sorted(file.name for file in folders[0].iterdir())
    tables = ("orders", "visits", "periods", "hours", "stations", "robots", "delays")
    assert names == sorted(("result.json", "trace.jsonl.gz", *(f"{table}.csv" for table in tables)))
    assert names == sorted(file.name for file in folders[1].iterdir())
    for name in names:
        assert without_wall_clock(folders[0] / name) == without_wall_clock(folders[1] / name), name


@pytest.mark.parametrize("poa", ["first-come", "common-lines"])
def test_rule_sets_see_the_same_orders_and_pods(poa: str) -> None:
    base = rmfs_core.run("examples/small")
    other = rmfs_core.run("examples/small", overrides=[f"rules.poa={poa}"])
    assert [(row["order"], row["items"]) for row in base.orders] == [
        (row["order"], row["items"]) for row in other.orders
    ]
    assert base.metrics != other.metrics


FILES = ("orders.csv", "visits.csv", "trace.jsonl.gz")
SMALL = ("examples/small", "instance.orders=100", "robots.count=8")
RUNS = {
    "sipp": SMALL,
    "sipp, another seed": (*SMALL, "seed=2"),
    "whca-n": (*SMALL, 'rules.pp="whca-n"'),
    "split-over-time on two threads": (*SMALL, 'rules.poa_pps={rule="split-over-time", threads=2}'),
    "bundles": ("examples/replenished", "run.until_s=1800"),
}
"""Scenario and overrides of each run; `examples/small` has `sipp` for PP."""


@pytest.fixture
def hasty(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Let Python change from thread to thread as often as it can, and whenever a run has looked up driving times."""

    def then_pausing(look_up: Callable[..., Any]) -> Callable[..., Any]:
        def paused(*arguments: Any, **more: Any) -> Any:
            found = look_up(*arguments, **more)
            time.sleep(1e-5)
            return found

        return paused

    for name in ("times_near", "nearest", "ways_to", "fastest_path"):
        monkeypatch.setattr(Travel, name, then_pausing(getattr(Travel, name)))
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    yield
    sys.setswitchinterval(before)


def written(name: str, out: Path) -> dict[str, bytes]:
    scenario, *overrides = RUNS[name]
    rmfs_core.run(scenario, overrides=overrides, out=out, record=["trace"])
    return {file: (out / file).read_bytes() for file in FILES}


@pytest.mark.usefixtures("hasty")
def test_runs_in_two_threads_write_what_they_write_alone(tmp_path: Path) -> None:
    names = (*RUNS, "sipp")
    alone = {name: written(name, tmp_path / name) for name in names}
    with ThreadPoolExecutor(2) as threads:
        together = list(threads.map(written, names, [tmp_path / f"run {number}" for number in range(len(names))]))
    assert together == [alone[name] for name in names]
