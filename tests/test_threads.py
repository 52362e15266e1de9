"""Runs in several threads of one process: each writes the bytes that it writes alone."""

import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

import rmfs_core
from rmfs_core.world.travel import Travel

FILES = ("orders.csv", "visits.csv", "trace.jsonl.gz")
SMALL = ("examples/small", "instance.orders=100", "robots.count=8")
RUNS = {
    "sipp": SMALL,
    "sipp, another seed": (*SMALL, "seed=2"),
    "whca-n": (*SMALL, 'rules.pp="whca-n"'),
    "pbs": (*SMALL, 'rules.pp="pbs"'),
    "pod-index": (*SMALL, 'rules.poa_pps="pod-index"', 'rules.ta="nearest-robot"'),
    "lns": (*SMALL, 'rules.poa_pps="lns"'),
    "integrated": (*SMALL, 'rules.poa_pps="integrated"'),
    "split-over-time on two threads": (*SMALL, 'rules.poa_pps={rule="split-over-time", threads=2}'),
    "bundles": ("examples/replenished", "run.until_s=1800"),
    "batteries": ("examples/charging", "run.until_s=900"),
    "a map": ("examples/text-map", "instance.orders=20"),
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


@pytest.mark.slow
@pytest.mark.usefixtures("hasty")
def test_runs_in_threads_write_what_they_write_alone(tmp_path: Path) -> None:
    alone = {name: written(name, tmp_path / "alone" / name) for name in RUNS}
    twice = [(name, tmp_path / f"{copy}" / name) for name in RUNS for copy in range(2)]
    with ThreadPoolExecutor(4) as threads:
        together = list(threads.map(lambda one: written(*one), twice))
    for (name, _), files in zip(twice, together, strict=True):
        for file in FILES:
            assert files[file] == alone[name][file], f"{name}, {file}"


@pytest.mark.usefixtures("hasty")
def test_runs_in_two_threads_write_what_they_write_alone(tmp_path: Path) -> None:
    names = ("sipp", "sipp, another seed", "whca-n", "sipp")
    alone = {name: written(name, tmp_path / name) for name in names}
    with ThreadPoolExecutor(2) as threads:
        together = list(threads.map(written, names, [tmp_path / f"run {number}" for number in range(len(names))]))
    assert together == [alone[name] for name in names]
