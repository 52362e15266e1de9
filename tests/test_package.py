"""The distribution as it is released: what wheel and sdist hold, and whether an index would take them."""

from __future__ import annotations

import re
import subprocess
import sys
import tarfile
import zipfile
from collections.abc import Callable
from importlib.metadata import entry_points
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
Built = Callable[..., tuple[Path, Path]]


def packages(folder: str) -> list[str]:
    """Return the import packages below a folder of plugins."""
    return sorted(path.parent.name for path in (ROOT / "plugins" / folder).glob("*/__init__.py"))


@pytest.mark.slow
def test_the_wheel_holds_kernel_plugins_and_scenarios(built: Built) -> None:
    """The wheel that the sdist makes has every package, scenario and entry point, and nothing of the tests."""
    names = set(zipfile.ZipFile(built()[1]).namelist())
    for package in ("rmfs_core", *packages("rules"), *packages("commands")):
        assert f"{package}/__init__.py" in names
    assert {f"rmfs_replay/view/{name}" for name in ("page.html", "style.css", "main.mjs", "watch.mjs")} <= names
    for scenario in (ROOT / "scenarios").rglob("*.toml"):
        assert f"rmfs_scenarios/{scenario.relative_to(ROOT / 'scenarios').as_posix()}" in names
    public = re.findall(r"rmfs_\w+", (ROOT / "docs" / "reference" / "api.md").read_text(encoding="utf-8"))
    assert {f"{package}/py.typed" for package in public if f"{package}/__init__.py" in names} <= names
    assert {"rmfs_kit/templates/pyproject.toml", "rmfs_experiments/report/report.html.j2"} <= names
    assert not {name.split("/")[0] for name in names} & {"tests", "tools", "plugins", "scenarios"}
    (text,) = (name for name in names if name.endswith(".dist-info/entry_points.txt"))
    described = zipfile.ZipFile(built()[1]).read(text).decode()
    for group in ("rmfs", "rmfs.commands", "rmfs.observers", "rmfs.recorders"):
        ours = [entry for entry in entry_points(group=group) if entry.dist is not None and entry.dist.name == "rmfs"]
        assert ours
        assert all(f"{entry.name} = {entry.value}\n" in described for entry in ours)


@pytest.mark.slow
def test_the_sdist_holds_what_it_takes_to_build_and_test(built: Built) -> None:
    """Every file of code, tests, tools and scenarios, and what builds, describes and tests them."""
    with tarfile.open(built()[0]) as sdist:
        names = {name.partition("/")[2] for name in sdist.getnames()}
    found = {
        "pyproject.toml",
        "Makefile",
        "README.md",
        "CHANGELOG.md",
        "LICENSE",
        ".ci/run",
        "docs/conf.py",
        "docs/index.md",
    }
    for folder in ("rmfs_core", "plugins", "scenarios", "tests", "tools"):
        files = (file for file in (ROOT / folder).rglob("*") if file.is_file() and "__pycache__" not in file.parts)
        found |= {file.relative_to(ROOT).as_posix() for file in files}
    assert found <= names


@pytest.mark.slow
def test_an_index_would_take_it(built: Built) -> None:
    """`twine check` finds nothing wrong with the metadata of wheel and sdist, README included."""
    command = [sys.executable, "-m", "twine", "check", "--strict", *map(str, built())]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.count("PASSED") == 2
