"""A stranger's steps outside the checkout: install rmfs from its wheel, write a rule, install, test and run it."""

import json
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rmfs_commands.kit import NewRule, selecting, trying
from rmfs_commands.kit.kinds import COMMAND, GENERATOR, KINDS, LAYOUT
from rmfs_core.roles import Role

RULES = [role.label for role in Role]


def rule_of(label: str) -> NewRule:
    return NewRule(f"try-{label.lower().replace('+', '-')}", label if label in KINDS else Role.labelled(label))


@pytest.fixture(scope="session")
def place(environment: Callable[..., Any], built: Callable[..., tuple[Path, Path]]) -> Any:
    """Return an environment with the built wheel of rmfs and one new rule of each kind installed beside it."""
    place = environment(borrowed=False)
    place.call("pip", "install", "--quiet", str(built()[1]), "pytest", "hatchling")
    for label in (*RULES, *KINDS):
        place.call("rmfs", "new-rule", rule_of(label).name, "--decides", label)
    # The new rules need nothing that is not there; their build tool is installed already: no downloads.
    folders = [f"./{rule_of(label).name}" for label in (*RULES, *KINDS)]
    place.call("pip", "install", "--quiet", "--no-deps", "--no-build-isolation", *folders)
    return place


@pytest.mark.slow
def test_it_is_the_wheel_that_is_tried(place: Any) -> None:
    found = place.call("python", "-c", "import rmfs_core; print(rmfs_core.__file__)")
    assert Path(found.strip()).is_relative_to(place.folder / "venv")
    place.call("pip", "check")


@pytest.mark.slow
def test_the_wheel_alone_runs_the_tour(place: Any) -> None:
    place.call("rmfs", "run", "examples/small", "--trace", "--record-decisions", "--out", "day")
    assert "no fault" in place.call("rmfs", "validate", "day")
    place.call("rmfs", "explain", "day", "--decision", "1", "--against", "first-come", "--state", "state.json")
    assert json.loads(place.call("rmfs", "decide", "state.json", "--rule", "first-come"))["outcome"]
    assert "pod-match" in place.call("rmfs", "rules")
    assert "paper-250" in place.call("rmfs", "scenario", "list")
    place.call("rmfs", "scenario", "check", "paper-250")
    place.call("rmfs", "generate", "examples/small", "--out", "data")
    place.call("rmfs", "run", "data/scenario.toml", "--quiet", "--out", "same")
    assert (place.folder / "same" / "orders.csv").read_bytes() == (place.folder / "day" / "orders.csv").read_bytes()
    (place.folder / "lines.csv").write_text(
        "order,sku,quantity,time\nA-7,tea,1,2024-03-01T06:10\nA-8,mug,2,2024-03-01T06:05\n", encoding="utf-8"
    )
    columns = ("--order", "order", "--sku", "sku", "--quantity", "quantity", "--time", "time")
    pods = ("--pods", "4", "--skus-per-pod", "1", "--out", "converted")
    place.call("rmfs", "convert", "orders", "lines.csv", *columns, *pods)
    place.call("rmfs", "run", "converted/scenario.toml", "--quiet", "--out", "own")
    result = json.loads((place.folder / "own" / "result.json").read_text(encoding="utf-8"))
    assert (result["status"], result["metrics"]["picks"]) == ("complete", 3)
    (place.folder / "trial.toml").write_text(
        'base = "examples/small"\nseeds = [1, 2]\nbaseline = "as it is"\n[[rule_sets]]\nname = "as it is"\n'
        '[[rule_sets]]\nname = "first-come"\nrules.poa = "first-come"\n',
        encoding="utf-8",
    )
    place.call("rmfs", "compare", "trial.toml", "--out", "compared", "--jobs", "1")
    assert (place.folder / "compared" / "report.html").exists()
    assert "small-rules" in place.call("rmfs", "compare", "--list")
    (place.folder / "empty.map").write_text("type octile\nheight 4\nwidth 4\nmap\n" + "....\n" * 4, encoding="utf-8")
    place.call("rmfs", "plan", "empty.map", "--agents", "2")
    for command in ("bench", "reproduce", "new-rule", "compare"):
        assert "Usage: " in place.call("rmfs", command, "--help")


@pytest.mark.slow
@pytest.mark.parametrize("label", RULES)
def test_a_new_rule_passes_its_tests_and_runs(place: Any, label: str) -> None:
    rule = rule_of(label)
    assert " passed" in place.call("python", "-m", "pytest", "-q", within=rule.name)
    (described,) = json.loads(place.call("rmfs", "rules", rule.name, "--json"))
    assert label in described["decides"]
    assert described["distribution"] == rule.name
    assert described["summary"].endswith(".")
    assert all(parameter["doc"] for parameter in described["parameters"])
    out = f"results-{rule.name}"
    place.call(*shlex.split(trying(rule)), "--quiet", "--out", out)
    result = json.loads((place.folder / out / "result.json").read_text(encoding="utf-8"))
    assert (result["status"], result["versions"][rule.name]) == ("complete", "0.1.0")


@pytest.mark.slow
def test_a_new_observers_metric_is_a_metric(place: Any) -> None:
    rule = rule_of("observer")
    printed = place.call("rmfs", "run", "examples/small", "--out", "observed", *shlex.split(selecting(rule)))
    assert "Picks at the busiest station" in printed
    metrics = json.loads((place.folder / "observed" / "result.json").read_text(encoding="utf-8"))["metrics"]
    assert 50 <= metrics["busiest_station_percent"] <= 100
    assert (place.folder / "observed" / f"{rule.module}.csv").exists()


@pytest.mark.slow
@pytest.mark.parametrize("kind", [GENERATOR, LAYOUT])
def test_a_new_generator_passes_its_tests_and_runs(place: Any, kind: str) -> None:
    rule = rule_of(kind)
    assert " passed" in place.call("python", "-m", "pytest", "-q", within=rule.name)
    place.call(*shlex.split(trying(rule)), "--quiet", "--out", kind)
    result = json.loads((place.folder / kind / "result.json").read_text(encoding="utf-8"))
    assert (result["status"], result["versions"][rule.name]) == ("complete", "0.1.0")


@pytest.mark.slow
def test_a_new_command_passes_its_tests_and_runs(place: Any) -> None:
    rule = rule_of(COMMAND)
    assert " passed" in place.call("python", "-m", "pytest", "-q", within=rule.name)
    assert f"  {rule.name} " in place.call("rmfs", "--help")
    assert place.call(*shlex.split(trying(rule))).startswith("seed 1: makespan_s ")
