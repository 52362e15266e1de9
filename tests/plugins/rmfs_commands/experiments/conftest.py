from collections.abc import Callable
from pathlib import Path

import pytest

from rmfs_commands.experiments import Experiment, load_experiment
from tiny import TINY, TWO_RULES

DEADLY = '''
import os
import signal
from pathlib import Path

from attrs import define
from rmfs_core import hookimpl


@define
class Deadly:
    """PR: dies the first times it is asked, as often as a file does not count yet; a fixed place afterwards."""

    counter: str
    deaths: int = 1

    @hookimpl
    def choose_storage_location(self, warehouse):
        file = Path(self.counter)
        died = len(file.read_text()) if file.exists() else 0
        if died < self.deaths:
            file.write_text("x" * (died + 1))
            os.kill(os.getpid(), signal.SIGKILL)
        return min(warehouse.free_storage_locations)


@define
class Reading:
    """PR: a place by the number in a file."""

    weights: Path

    @hookimpl
    def choose_storage_location(self, warehouse):
        free = sorted(warehouse.free_storage_locations)
        return free[int(self.weights.read_text()) % len(free)]


@define
class Raising:
    """PR: has no idea."""

    @hookimpl
    def choose_storage_location(self, warehouse):
        raise ValueError("no idea")
'''

Write = Callable[..., Experiment]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "tiny.toml").write_text(TINY, encoding="utf-8")
    (tmp_path / "bad.py").write_text(DEADLY, encoding="utf-8")
    return tmp_path


@pytest.fixture
def experiment(folder: Path) -> Write:

    def write(text: str = TWO_RULES, name: str = "experiment.toml") -> Experiment:
        (folder / name).write_text(text, encoding="utf-8")
        return load_experiment(folder / name)

    return write
