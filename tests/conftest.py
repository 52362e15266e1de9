"""Fixtures for tests of several packages."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from rmfs_core.info import RunInfo
from rmfs_core.motion import Motion
from rmfs_core.scenario.model import RuleChoice, RulesSection, Scenario
from rmfs_core.warehouse import WarehouseView
from rmfs_testing import small_instance, small_layout, small_world

Install = Callable[..., None]
HEADER = "from attrs import define, field, validators\nfrom rmfs_core import hookimpl\n"


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Install]:
    """Install a distribution for one test: its entry points, and the source of its modules."""
    before = set(sys.modules)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)

    def install(distribution: str, entry_points: dict[str, str], **modules: str) -> None:
        folder = tmp_path / distribution
        metadata = folder / f"{distribution}-1.0.dist-info"
        metadata.mkdir(parents=True)
        (metadata / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {distribution}\nVersion: 1.0\n")
        lines = [f"{name} = {target}\n" for name, target in entry_points.items()]
        (metadata / "entry_points.txt").write_text("[rmfs]\n" + "".join(lines))
        for name, source in modules.items():
            (folder / f"{name}.py").write_text(HEADER + source)
        monkeypatch.syspath_prepend(folder)

    yield install
    for name in set(sys.modules) - before:
        if name.startswith(("acme", "bolt")):
            del sys.modules[name]


@pytest.fixture
def tiny() -> RunInfo:
    """Two stations, two robots; orders ``first`` (a, b) at 0 s, ``second`` (two of a) at 5 s; pods ``p`` and ``q``."""
    orders = {"first": ["a", "b"], "second": {"a": 2}}
    pods = {"p": {"a": 10, "b": 10}, "q": ["b"]}
    return RunInfo(
        scenario=Scenario(rules=RulesSection(poa=RuleChoice("first-come"), pps=RuleChoice("demand")), seed=7),
        instance=small_instance(orders, pods, arrivals_s={"second": 5.0}),
        layout=small_layout(2),
        motion=Motion(),
        warehouse=WarehouseView(small_world(orders, pods, capacities=(4, 4))),
    )
