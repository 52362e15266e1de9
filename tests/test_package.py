"""The distribution as it is released: what wheel and sdist hold, and whether an index would take them."""

import re
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from collections.abc import Callable
from importlib.metadata import entry_points
from pathlib import Path

import pytest
from packaging.specifiers import SpecifierSet
from packaging.version import Version

ROOT = Path(__file__).resolve().parent.parent
Built = Callable[..., tuple[Path, Path]]
PACKAGES = ("rmfs", "rmfs_commands", "rmfs_core", "rmfs_rules", "rmfs_traffic")


@pytest.mark.slow
def test_the_wheel_holds_kernel_plugins_and_scenarios(built: Built) -> None:
    names = set(zipfile.ZipFile(built()[1]).namelist())
    tops = {name.split("/")[0] for name in names}
    assert {top for top in tops if not top.endswith(".dist-info")} == {*PACKAGES, "rmfs_scenarios"}
    for package in PACKAGES:
        assert f"{package}/py.typed" in names
        files = (ROOT if package == "rmfs_core" else ROOT / "plugins").joinpath(package).rglob("*.py*")
        found = {file for file in files if file.suffix in (".py", ".pyi")}
        assert {f"{package}/{'/'.join(file.parts[file.parts.index(package) + 1 :])}" for file in found} <= names
    view = ("page.html", "style.css", "main.mjs", "watch.mjs")
    assert {f"rmfs_commands/replay/view/{name}" for name in view} <= names
    for scenario in (ROOT / "scenarios").rglob("*.toml"):
        assert f"rmfs_scenarios/{scenario.relative_to(ROOT / 'scenarios').as_posix()}" in names
    assert {"rmfs_commands/kit/templates/pyproject.toml", "rmfs_commands/experiments/report/report.html.j2"} <= names
    (text,) = (name for name in names if name.endswith(".dist-info/entry_points.txt"))
    described = zipfile.ZipFile(built()[1]).read(text).decode()
    for group in ("rmfs.rules", "rmfs.commands", "rmfs.observers", "rmfs.recorders"):
        ours = [entry for entry in entry_points(group=group) if entry.dist is not None and entry.dist.name == "rmfs"]
        assert ours
        assert all(f"{entry.name} = {entry.value}\n" in described for entry in ours)


@pytest.mark.slow
def test_the_sdist_holds_what_it_takes_to_build_and_test(built: Built) -> None:
    with tarfile.open(built()[0]) as sdist:
        names = {name.partition("/")[2] for name in sdist.getnames()}
    found = {"pyproject.toml", "Makefile", "README.md", "CHANGELOG.md", "LICENSE", ".ci/run", "docs/index.md"}
    for folder in ("rmfs_core", "plugins", "scenarios", "tests", "tools"):
        files = (file for file in (ROOT / folder).rglob("*") if file.is_file() and "__pycache__" not in file.parts)
        found |= {file.relative_to(ROOT).as_posix() for file in files}
    assert found <= names


def test_the_version_is_in_pyproject_alone() -> None:
    version = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    named = re.compile(rf"(rmfs |\{{){re.escape(version)}\b")
    files = [file for folder in ("tests", "docs/how-to", "docs/tutorial") for file in (ROOT / folder).rglob("*.*")]
    files = [file for file in files if file.suffix in (".py", ".md", ".ipynb")]
    assert [str(file) for file in files if named.search(file.read_text(encoding="utf-8"))] == []


def test_the_citation_is_that_of_the_last_release() -> None:
    changes, citation, project = (
        (ROOT / name).read_text(encoding="utf-8") for name in ("CHANGELOG.md", "CITATION.cff", "pyproject.toml")
    )
    released = re.findall(r"^## \[(\d\S*)\] - (\S+)$", changes, re.MULTILINE)[0]
    (cited,) = re.findall(r"^version: (\S+)\ndate-released: (\S+)$", citation, re.MULTILINE)
    assert cited == released
    version = Version(tomllib.loads(project)["project"]["version"])
    assert version == Version(released[0]) or (version > Version(released[0]) and version.is_devrelease)


PYTHONS = ("3.11", "3.12", "3.13", "3.14")


def test_the_pythons_it_installs_on_are_the_same_everywhere() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    allowed = SpecifierSet(project["requires-python"])
    assert tuple(f"3.{minor}" for minor in range(30) if allowed.contains(f"3.{minor}.1")) == PYTHONS
    prefix = "Programming Language :: Python :: 3."
    assert [one for one in project["classifiers"] if one.startswith(prefix)] == [
        f"Programming Language :: Python :: {version}" for version in PYTHONS
    ]
    for page in ("README.md", "CONTRIBUTING.md", "docs/tutorial/first-run.md"):
        assert f"Python {PYTHONS[0]} to {PYTHONS[-1]}" in (ROOT / page).read_text(encoding="utf-8")


@pytest.mark.slow
def test_an_index_would_take_it(built: Built) -> None:
    command = [sys.executable, "-m", "twine", "check", "--strict", *map(str, built())]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.count("PASSED") == 2
