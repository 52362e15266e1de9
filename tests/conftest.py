"""Fixtures for tests of several packages."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

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
