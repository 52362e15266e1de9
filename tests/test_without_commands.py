"""The kernel needs no tools: where every command but `rmfs run` and its neighbours is gone, a run is the same."""

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import rmfs_core

ROOT = Path(__file__).resolve().parent.parent
KEPT = ("cli", "instances", "layouts", "outages", "processes", "results", "run")
RMFS = ("python", "-c", "from rmfs_commands.cli.main import main; main()")
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def place(
    environment: Callable[..., Any],
    built: Callable[[Path], tuple[Path, Path]],
    tmp_path_factory: pytest.TempPathFactory,
) -> Any:
    """Return an environment that has rmfs from a copy of the checkout without the other commands' folders."""
    copy = tmp_path_factory.mktemp("checkout")
    for name in ("rmfs_core", "plugins", "scenarios"):
        shutil.copytree(ROOT / name, copy / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "README.md", "LICENSE", "CITATION.cff"):
        shutil.copy(ROOT / name, copy)
    for folder in (copy / "plugins" / "rmfs_commands").iterdir():
        if folder.is_dir() and folder.name not in KEPT:
            shutil.rmtree(folder)
    place = environment(borrowed=True, without=[ROOT, ROOT / "plugins"])
    place.install(built(copy)[1])
    return place


def test_the_other_commands_are_gone(place: Any) -> None:
    places = place.call(
        "python", "-c", "import rmfs_core, rmfs_commands.cli; print(rmfs_core.__file__, rmfs_commands.cli.__file__)"
    )
    assert all(Path(found).is_relative_to(place.folder) for found in places.split())
    listed = place.call(*RMFS, "--help")
    for name in ("compare", "explain", "validate", "new-rule", "bench", "bound", "plan", "reproduce", "size"):
        assert f"  {name:9}  (not usable: " in listed


def test_a_run_is_the_same(place: Any, tmp_path: Path) -> None:
    """With rules of which little is compiled: nothing of it is kept in a new environment."""
    plain = ["rules.poa=random", "rules.pps=random", "rules.pp=free-flow"]
    place.call(*RMFS, "run", "examples/small", "--out", "day", *(word for rule in plain for word in ("--set", rule)))
    rmfs_core.run("examples/small", overrides=plain, out=tmp_path)
    for file in ("orders.csv", "visits.csv"):
        assert (place.folder / "day" / file).read_bytes() == (tmp_path / file).read_bytes()


def test_a_recorder_that_is_not_there_is_named(place: Any) -> None:
    done = place.run(*RMFS, "run", "examples/small", "--out", "traced", "--trace")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.splitlines()[-1].startswith('Error: record trace: recorder "trace" (rmfs ')
    assert "No module named 'rmfs_commands.trace'" in done.stderr
    assert not (place.folder / "traced").exists()
