from pathlib import Path

import pytest

import rmfs_core
from rmfs_commands.replay.reading import Replay, read_replay
from rmfs_core.scenario import load_scenario

SETTINGS = ("instance.orders=20",)
BATTERIES = (
    "instance.orders=40",
    "layout.chargers=1",
    "robots.battery={capacity_wh=70, idle_w=200, charging_w=8000}",
    "rules.idle=charge-when-low",
    "rules.pp=free-flow",
)


@pytest.fixture(scope="session")
def day(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("runs") / "day"
    rmfs_core.run("examples/small", overrides=SETTINGS, out=folder, record=["trace", "decisions"])
    return folder


@pytest.fixture(scope="session")
def short(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("runs") / "short"
    overrides = (*SETTINGS, "run.until_s=100.5", "rules.pps=random")
    rmfs_core.run("examples/small", overrides=overrides, out=folder, record=["trace"])
    return folder


@pytest.fixture(scope="session")
def replay(day: Path) -> Replay:
    return read_replay(day)


@pytest.fixture(scope="session")
def restocked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("runs") / "restocked"
    overrides = ("instance.orders=40", "stations.open={2=[['00:10', '23:00']]}", "rules.move=utility")
    scenario = load_scenario("examples/replenished", (*overrides, "rules.idle=rest-nearest", "rules.pp=free-flow"))
    rmfs_core.run(scenario, out=folder, record=["trace", "decisions"])
    return folder


@pytest.fixture(scope="session")
def charged(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("runs") / "charged"
    rmfs_core.run(load_scenario("examples/small", BATTERIES), out=folder, record=["trace"])
    return folder


@pytest.fixture(scope="session")
def batteries() -> tuple[str, ...]:
    return BATTERIES
