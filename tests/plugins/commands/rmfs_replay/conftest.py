"""Recorded runs to replay."""

from __future__ import annotations

from pathlib import Path

import pytest

import rmfs_core
from rmfs_replay.reading import Replay, read_replay

SETTINGS = ("instance.orders=20",)


@pytest.fixture(scope="session")
def day(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a run with trace and decisions; robots keep out of each other's way in it."""
    folder = tmp_path_factory.mktemp("runs") / "day"
    rmfs_core.run("examples/small", overrides=SETTINGS, out=folder, record=["trace", "decisions"])
    return folder


@pytest.fixture(scope="session")
def short(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a run that ends while robots drive, without decisions."""
    folder = tmp_path_factory.mktemp("runs") / "short"
    overrides = (*SETTINGS, "run.until_s=100.5", "rules.pps=random")
    rmfs_core.run("examples/small", overrides=overrides, out=folder, record=["trace"])
    return folder


@pytest.fixture(scope="session")
def replay(day: Path) -> Replay:
    """Return the replay of the day."""
    return read_replay(day)
