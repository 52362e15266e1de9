import gzip
import json
from collections.abc import Callable
from pathlib import Path
from shutil import copytree
from typing import Any

import pytest

import rmfs_core
from rmfs_commands.states import Recording, read_recording

Record = Callable[..., Recording]
SMALL = ("instance.orders=14", "instance.max_lines=5", "stations.item_capacity=6", "rules.pp=free-flow")


@pytest.fixture(scope="session")
def record(tmp_path_factory: pytest.TempPathFactory) -> Record:
    """Return a function that runs the small example with its decisions recorded, once for the same settings."""
    done: dict[tuple[str, ...], Recording] = {}

    def run(*settings: str) -> Recording:
        if settings not in done:
            folder = tmp_path_factory.mktemp("recorded")
            overrides = [*SMALL, "rules.ta=nearest-robot", *settings]
            rmfs_core.run("examples/small", overrides=overrides, out=folder, record=["decisions"])
            done[settings] = read_recording(folder)
        return done[settings]

    return run


@pytest.fixture
def damaged(record: Record, tmp_path: Path) -> Callable[..., Path]:
    """Return a function that writes the lines of a recording, changed, to another folder."""

    def write(change: Callable[[list[Any]], list[Any]]) -> Path:
        file = record().file
        folder = copytree(file.parent, tmp_path / "run", dirs_exist_ok=True)
        lines = [json.loads(line) for line in gzip.decompress(file.read_bytes()).decode().splitlines()]
        text = "".join(f"{json.dumps(line)}\n" for line in change(lines))
        (folder / file.name).write_bytes(gzip.compress(text.encode()))
        return folder

    return write


@pytest.fixture
def by_hand() -> dict[str, Any]:
    """Return a state as another program would write it: nothing but what it must have."""
    return {
        "format": "rmfs-state",
        "version": 1,
        "pods": {"P1": {"contents": {"milk": None, "tea": None}}, "P2": {"contents": {"jam": None}}},
        "stations": {"north": {"item_capacity": 4}},
        "orders": {"A": {"lines": {"milk": 1, "tea": 1}}, "B": {"lines": {"jam": 2}}},
    }


@pytest.fixture
def at_work(by_hand: dict[str, Any]) -> dict[str, Any]:
    """Return a state with a layout in which half of order A is picked, and pod P1 stands at the station."""
    rows = ["........", ".##.##..", ".##.##..", "........", ".##.##.qqqO", ".##.##.@@@.", "..........."]
    return by_hand | {
        "time_s": 60.5,
        "layout": {"map": rows},
        "pods": {"P1": {"contents": {"milk": 3, "tea": 1}, "home": 12}, "P2": {"contents": {"jam": 5}, "cell": 13}},
        "stations": {
            "north": {
                "item_capacity": 4,
                "queue_length": 3,
                "requests": [{"order": "A", "sku": "tea"}],
                "inbound": ["P1", "P2"],
                "line": ["P1"],
            }
        },
        "orders": {
            "A": {"lines": {"milk": 1, "tea": 1}, "parts": [{"station": "north", "skus": ["milk", "tea"]}]},
            "B": {"lines": {"jam": 2}, "arrival_s": 30},
        },
        "robots": {"r1": {"cell": 54, "task": "P1"}, "r2": {"cell": 0}},
    }
