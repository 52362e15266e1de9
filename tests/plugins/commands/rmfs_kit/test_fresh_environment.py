"""What a stranger does, outside the checkout: install rmfs from its wheel, write a rule, install, test and run it."""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import sys
import venv
from pathlib import Path

import pytest
from attrs import frozen

from rmfs_core.roles import Role
from rmfs_kit import NewRule, selecting

LABELS = [role.label for role in Role]

ROOT = Path(__file__).resolve().parents[4]


def rule_of(label: str) -> NewRule:
    """Return the rule that is written for a kind of decision."""
    return NewRule(f"try-{label.lower().replace('+', '-')}", Role.labelled(label))


@frozen
class Place:
    """A folder and an environment that know nothing of the checkout."""

    folder: Path
    programs: Path

    def call(self, *command: str, within: str = ".") -> str:
        """Run a program of the environment in a folder; return what it printed."""
        program = str(self.programs / command[0])
        environment = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
        done = subprocess.run(
            [program, *command[1:]],
            cwd=self.folder / within,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, f"{shlex.join(command)}\n{done.stdout}\n{done.stderr}"
        return done.stdout


@pytest.fixture(scope="session")
def place(tmp_path_factory: pytest.TempPathFactory) -> Place:
    """Return an environment with the built wheel of rmfs and one new rule of each kind installed beside it."""
    folder = tmp_path_factory.mktemp("stranger")
    build = [sys.executable, "-m", "pip", "wheel", "--no-deps", "--quiet", "--wheel-dir", str(folder), str(ROOT)]
    subprocess.run(build, check=True)
    (wheel,) = folder.glob("*.whl")
    venv.create(folder / "venv", with_pip=True)
    place = Place(folder, folder / "venv" / ("Scripts" if os.name == "nt" else "bin"))
    place.call("pip", "install", "--quiet", str(wheel), "pytest", "hatchling")
    for label in LABELS:
        place.call("rmfs", "new-rule", rule_of(label).name, "--decides", label)
    # The new rules need nothing that is not there; their build tool is installed already: no downloads.
    folders = [f"./{rule_of(label).name}" for label in LABELS]
    place.call("pip", "install", "--quiet", "--no-deps", "--no-build-isolation", *folders)
    return place


@pytest.mark.slow
def test_it_is_the_wheel_that_is_tried(place: Place) -> None:
    """The package comes from the environment, not from the checkout, and the new rules' needs are met."""
    found = place.call("python", "-c", "import rmfs_core; print(rmfs_core.__file__)")
    assert Path(found.strip()).is_relative_to(place.folder / "venv")
    place.call("pip", "check")


@pytest.mark.slow
@pytest.mark.parametrize("label", LABELS)
def test_a_new_rule_passes_its_tests_and_runs(place: Place, label: str) -> None:
    """Its own tests pass, `rmfs rules` describes it, and a run that selects it completes every order with it."""
    rule = rule_of(label)
    assert " passed" in place.call("python", "-m", "pytest", "-q", within=rule.name)
    (described,) = json.loads(place.call("rmfs", "rules", rule.name, "--json"))
    assert label in described["decides"]
    assert described["distribution"] == rule.name
    assert described["summary"].endswith(".")
    assert all(parameter["doc"] for parameter in described["parameters"])
    out = f"results-{rule.name}"
    place.call("rmfs", "run", "examples/small", "--quiet", "--out", out, *shlex.split(selecting(rule)))
    result = json.loads((place.folder / out / "result.json").read_text(encoding="utf-8"))
    assert result["status"] == "complete"
    assert result["versions"][rule.name] == "0.1.0"
