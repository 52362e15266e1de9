import os
import shlex
import subprocess
import sys
import venv
from collections.abc import Callable, Collection, Iterator
from pathlib import Path
from typing import Any

import pytest
from attrs import frozen
from hypothesis import settings

from rmfs_commands.testing import small_instance, small_layout, small_world
from rmfs_core.info import RunInfo
from rmfs_core.motion import Motion
from rmfs_core.rules import RuleSet
from rmfs_core.scenario import RuleChoice, Scenario, model
from rmfs_core.simulation.engine import Simulation
from rmfs_core.warehouse import WarehouseView
from rmfs_core.world import Instance, Layout
from told import ToldRun

ROOT = Path(__file__).resolve().parent.parent
# How long an example takes says more of the machine than of the code. Every run of the tests tries the same examples;
# `make long` draws others: pytest -m hypothesis --hypothesis-profile=explore.
settings.register_profile("rmfs", deadline=None, derandomize=True)
settings.register_profile("explore", deadline=None)
settings.load_profile("rmfs")

Install = Callable[..., None]
SEQUENTIAL = {"poa": "pod-match", "pps": "demand", "pr": "nearest", "ta": "nearest-robot", "pp": "free-flow"}
HEADER = "from attrs import define, field, validators\nfrom rmfs_core import hookimpl\n"


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    for report in terminalreporter.getreports("passed"):
        for name, sentence in report.user_properties:
            if name == "slower":
                terminalreporter.write_line(str(sentence), yellow=True)


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Install]:
    """Install a distribution for one test: its entry points, and the source of its modules."""
    before = set(sys.modules)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)

    def install(distribution: str, entry_points: dict[str, str], group: str = "rmfs.rules", **modules: str) -> None:
        folder = tmp_path / distribution
        metadata = folder / f"{distribution}-1.0.dist-info"
        metadata.mkdir(parents=True)
        (metadata / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {distribution}\nVersion: 1.0\n")
        lines = [f"{name} = {target}\n" for name, target in entry_points.items()]
        (metadata / "entry_points.txt").write_text(f"[{group}]\n" + "".join(lines))
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
        scenario=Scenario(rules=model.RulesSection(poa=RuleChoice("first-come"), pps=RuleChoice("demand")), seed=7),
        instance=small_instance(orders, pods, arrivals_s={"second": 5.0}),
        layout=small_layout(2),
        motion=Motion(),
        warehouse=WarehouseView(small_world(orders, pods, capacities=(4, 4))),
    )


@frozen
class Environment:
    """A folder, and beside it an environment whose programs are called there."""

    folder: Path  # where they are called
    programs: Path  # the environment's programs

    def run(self, *command: str, within: str = ".") -> subprocess.CompletedProcess[str]:
        """Call a program of the environment; return how it ended and what it printed."""
        program = str(self.programs / command[0])
        variables = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
        folder = self.folder / within
        return subprocess.run(
            [program, *command[1:]], cwd=folder, env=variables, capture_output=True, text=True, check=False
        )

    def call(self, *command: str, within: str = ".") -> str:
        """Call a program that must succeed; return what it printed."""
        done = self.run(*command, within=within)
        assert done.returncode == 0, f"{shlex.join(command)}\n{done.stdout}\n{done.stderr}"
        return done.stdout

    def install(self, *wheels: Path) -> None:
        """Install wheels, whatever the environment has already, and nothing else."""
        python = str(self.programs / "python")
        arguments = ("--no-deps", "--no-index", "--ignore-installed", "--quiet", *map(str, wheels))
        subprocess.run([sys.executable, "-m", "pip", "--python", python, "install", *arguments], check=True)


@pytest.fixture(scope="session")
def environment(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Environment]:
    """Return the function that makes an environment, with pip, or with what the running one has ``borrowed``.

    What is borrowed is there in no time: nothing is installed. ``without`` are entries of the module search path.
    """

    def make(*, borrowed: bool, without: Collection[Path] = ()) -> Environment:
        folder = tmp_path_factory.mktemp("stranger")
        venv.create(folder / "venv", with_pip=not borrowed)
        programs = folder / "venv" / ("Scripts" if os.name == "nt" else "bin")
        if borrowed:
            packages = next((folder / "venv").rglob("site-packages"))
            paths = [path for path in map(Path, sys.path) if path.is_dir() and path.resolve() not in without]
            (packages / "borrowed.pth").write_text("".join(f"{path.resolve()}\n" for path in paths), encoding="utf-8")
        return Environment(folder, programs)

    return make


@pytest.fixture(scope="session")
def built(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Path], tuple[Path, Path]]:
    """Return the function that builds a project's sdist, and from that its wheel, each project once."""
    found: dict[Path, tuple[Path, Path]] = {}

    def build(project: Path = ROOT) -> tuple[Path, Path]:
        if project not in found:
            folder = tmp_path_factory.mktemp("dist")
            subprocess.run([sys.executable, "-m", "build", "--outdir", str(folder), str(project)], check=True)
            (sdist,), (wheel,) = folder.glob("*.tar.gz"), folder.glob("*.whl")
            found[project] = sdist, wheel
        return found[project]

    return build


@pytest.fixture
def tiny_run(tmp_path: Path) -> Callable[..., ToldRun]:

    def prepare(
        instance: Instance,
        *,
        layout: Layout | None = None,
        robots: int = 1,
        capacity: int | tuple[int, ...] = 15,
        order_capacity: int | None = None,
        queue_length: int = 3,
        run: model.RunSection | None = None,
        at_stations: dict[str, tuple[str, ...]] | None = None,
        seed: int = 1,
        change: Callable[[Scenario], Scenario] = lambda scenario: scenario,
        **rules: Any,
    ) -> ToldRun:
        chosen = SEQUENTIAL | rules
        if "poa_pps" in chosen:
            del chosen["poa"], chosen["pps"]
        filters, observers = (
            tuple(RuleChoice(name) for name in chosen.pop(key, ())) for key in ("filters", "observers")
        )
        choices = {r: c if isinstance(c, RuleChoice) else RuleChoice(c) for r, c in chosen.items()}
        scenario = Scenario(
            rules=model.RulesSection(filters=filters, observers=observers, **choices),
            seed=seed,
            instance=model.InstanceSection(pods_at_stations=at_stations or {}),
            layout=model.LayoutSection(pod_fill=0.05),
            robots=model.RobotsSection(count=robots),
            stations=model.StationsSection(
                item_capacity=capacity, order_capacity=order_capacity, queue_length=queue_length
            ),
            run=run or model.RunSection(),
            folder=str(tmp_path),
        )
        scenario = change(scenario)
        loaded = RuleSet.load(scenario.rules, scenario.folder)
        stations = len(capacity) if isinstance(capacity, tuple) else 1
        layout = layout or small_layout(stations, queue_length=queue_length)
        run = ToldRun(Simulation(scenario, instance, layout, loaded))
        loaded.register_observer(run)
        return run

    return prepare
