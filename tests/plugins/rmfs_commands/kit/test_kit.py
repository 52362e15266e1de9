"""`rmfs new-rule`: names, files, and the project that they make, also in a new environment."""

import ast
import io
import json
import shlex
import subprocess
import sys
import tomllib
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest

from calling import refused
from cases import cases
from rmfs_commands.cli.main import main
from rmfs_commands.kit import NewRule, project_files, selecting, trying, write_project
from rmfs_commands.kit.kinds import COMMAND, GENERATOR, KINDS, LAYOUT
from rmfs_core import InputError
from rmfs_core.roles import Role


def test_it_writes_the_folder_and_says_what_comes_next(tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    main(["new-rule", "fine-rule", "--decides", "POA+PPS"])
    assert (tmp_path / "fine-rule" / "pyproject.toml").exists()
    out = capsys.readouterr().out
    assert out.startswith(
        "Wrote fine-rule: pyproject.toml, README.md, src/fine_rule/__init__.py, tests/test_fine_rule.py."
    )
    assert "  pip install -e ./fine-rule\n" in out
    assert "--set rules.poa_pps=fine-rule\n" in out
    main(["new-rule", "fine-tool", "--decides", "command"])
    assert "\n  rmfs fine-tool examples/small\n" in capsys.readouterr().out


@pytest.mark.parametrize("folder", ["my rules", "x\udcff"])  # one whose name is no text
def test_into_another_folder(folder: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with io.TextIOWrapper(io.BytesIO(), "utf-8") as output:
        monkeypatch.setattr(sys, "stdout", output)
        main(["new-rule", "fine-rule", "--decides", "PR", "--into", folder])
        output.flush()
        told = output.buffer.getvalue()
    assert told.startswith(b"Wrote " + folder.encode("utf-8", "backslashreplace") + b"/fine-rule: pyproject.toml")
    assert b"  pip install -e " in told
    assert (tmp_path / folder / "fine-rule" / "README.md").exists()


def test_a_folder_that_is_there_is_refused(tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "there").mkdir()
    assert "Error: there: exists already" in refused(capsys, main, ["new-rule", "there", "--decides", "PR"])
    assert [path.name for path in tmp_path.rglob("*")] == ["there"]


@cases(
    "name role kind module target",
    ("fine-rule", Role.POA, "rule", "fine_rule", "FineRule"),
    ("k2-opt", Role.PP, "rule", "k2_opt", "K2Opt"),
    ("x", Role.OBSERVER, "rule", "x", "X"),
    ("fine-tool", COMMAND, "command", "fine_tool", "fine_tool"),
)
def test_what_is_called_after_it(name: str, role: Role | str, kind: str, module: str, target: str) -> None:
    rule = NewRule(name, role)
    assert (rule.kind, rule.module, rule.target, rule.place) == (kind, module, target, f'{kind} name "{name}"')
    rule.check_free()


def test_names_of_rules_and_commands(install: Callable[..., None]) -> None:
    assert NewRule("x", "poa_pps").role is Role.POA_PPS
    assert NewRule("x", COMMAND).role == COMMAND
    NewRule("demand", COMMAND).check_free()
    NewRule("compare", Role.POA).check_free()
    install("acme", {"clever": "acme_rules:Clever"})
    with pytest.raises(InputError, match=r"a rule of that name is installed \(acme 1.0\)"):
        NewRule("clever", "poa").check_free()
    assert selecting(NewRule("x", "pps")) == "--set rules.pps=x"
    assert selecting(NewRule("x", "filter")) == """--set 'rules.filters=["x"]'"""
    assert selecting(NewRule("x", "poa_pps")) == "--set rules.poa_pps=x"


@cases(
    "name such_as",
    ("My_Rule", "my-rule"),
    ("two words", "two-words"),
    ("2opt", "my-rule"),  # a package cannot begin with a digit
    ("a--b", "a-b"),
    ("-a-", "a"),
    ("-", "my-rule"),
    ("", "my-rule"),
    ("../up", "up"),
    ("größte", "gr-te"),
    ("a\n", "a"),
)
def test_a_name_is_spelled_as_a_folder_is(name: str, such_as: str) -> None:
    expected = "expected small letters, digits and single hyphens, beginning with a letter, such as"
    with pytest.raises(InputError) as caught:
        NewRule(name, Role.POA)
    assert caught.value.problem == f'{expected} "{such_as}"'


@cases(
    "name role problem",
    ("demand", Role.POA, r"a rule of that name is installed \(rmfs "),
    ("compare", COMMAND, r"a command of that name is installed \(rmfs "),
    ("numpy", Role.POA, r"a distribution of that name is installed \(numpy "),
    ("rmfs", Role.POA, r"a distribution of that name is installed \(rmfs "),
    ("lambda", Role.POA, "`lambda` is a word of the Python language"),
    ("true", Role.POA, "`True` is a word of the Python language"),  # its class would be called so
    ("queue", Role.POA, "there is a module `queue`"),
    ("rmfs-core", Role.POA, "there is a module `rmfs_core`"),
)
def test_a_name_that_is_taken_is_refused(name: str, role: Role | str, problem: str) -> None:
    with pytest.raises(InputError, match=problem):
        NewRule(name, role).check_free()


WORDS = (
    *("the-rule", "the_rule", "TheRule", "TARGET", "DECIDES", "SUMMARY", "GROUP", "LIBRARY", "FOUND", "TRYING"),
    *("SCENARIO_LINE", "SECTION"),
)


@pytest.mark.parametrize("role", Role)
def test_every_role_has_its_templates(role: Role, tmp_path: Path) -> None:
    rule = NewRule("fine-rule", role)
    folder = write_project(rule, tmp_path)
    written = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    assert written == {"pyproject.toml", "README.md", "src/fine_rule/__init__.py", "tests/test_fine_rule.py"}
    assert [path.name for path in tmp_path.iterdir()] == ["fine-rule"]
    project = tomllib.loads((folder / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["name"] == "fine-rule"
    assert project["dependencies"][0] == f"rmfs>={version('rmfs')}"
    assert project["entry-points"] == {"rmfs.rules": {"fine-rule": "fine_rule:FineRule"}}
    code = ast.parse((folder / "src/fine_rule/__init__.py").read_text(encoding="utf-8"))
    (made,) = (node for node in code.body if isinstance(node, ast.ClassDef))
    assert made.name == "FineRule"
    assert role.hook in {node.name for node in made.body if isinstance(node, ast.FunctionDef)}
    texts = project_files(rule)
    for text in texts.values():
        for word in WORDS:
            assert word not in text
    needed = {"examples/replenished": ("bundles", "replenishment"), "examples/packing": ("packing",)}
    names = [name for name, words in needed.items() if any(word in role.hook for word in words)]
    scenario = names[0] if names else "examples/small"
    assert f"rmfs run {scenario} {selecting(rule)}" in texts["README.md"]


@cases(
    "kind group summary trying",
    (COMMAND, "rmfs.commands", "Run SCENARIO", "rmfs fine-tool examples/small\n"),
    (GENERATOR, "rmfs.instances", "Make orders", "rmfs run examples/small --set instance.generator=fine-tool\n"),
    (LAYOUT, "rmfs.layouts", "Make pairs of rows", "rmfs run examples/small --set layout.generator=fine-tool\n"),
)
def test_what_is_no_rule_has_its_templates(tmp_path: Path, kind: str, group: str, summary: str, trying: str) -> None:
    rule = NewRule("fine-tool", kind)
    folder = write_project(rule, tmp_path)
    project = tomllib.loads((folder / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["entry-points"] == {group: {"fine-tool": "fine_tool:fine_tool"}}
    assert project["description"].startswith(f"{kind.capitalize()} for rmfs: {summary}")
    code = ast.parse((folder / "src/fine_tool/__init__.py").read_text(encoding="utf-8"))
    assert [node.name for node in code.body if isinstance(node, ast.FunctionDef)] == ["fine_tool"]
    texts = project_files(rule)
    assert trying in texts["README.md"]
    assert not any(word in text for text in texts.values() for word in WORDS)


@cases(
    "rule problem",
    (NewRule("seeds", COMMAND), "its function would hide the `seeds` it uses"),
    (NewRule("order-assignment", Role.POA), "its class would hide the `OrderAssignment` it uses"),
)
def test_a_bad_name_is_refused(rule, problem, tmp_path) -> None:
    with pytest.raises(InputError, match=problem):
        write_project(rule, tmp_path / "new")
    assert list(tmp_path.iterdir()) == []


def test_what_is_there_stays(tmp_path: Path) -> None:
    write_project(NewRule("mine", "ta"), tmp_path)
    (tmp_path / "mine" / "README.md").write_text("changed", encoding="utf-8")
    with pytest.raises(InputError, match="exists already"):
        write_project(NewRule("mine", "poa"), tmp_path)
    assert (tmp_path / "mine" / "README.md").read_text(encoding="utf-8") == "changed"
    assert [path.name for path in tmp_path.iterdir()] == ["mine"]


def test_what_cannot_be_written_is_named_and_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be written: File name too long"):
        write_project(NewRule("a" * 300, "ta"), tmp_path)
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(InputError, match="expected a folder"):
        write_project(NewRule("mine", "ta"), tmp_path / "file")


def test_imports_are_sorted(tmp_path: Path) -> None:
    pytest.importorskip("ruff")  # it is among the tools of `make lint`, which `make lowest` does not install
    for role in Role:
        write_project(NewRule(f"aaa-{role.value}".replace("_", "-").lower(), role), tmp_path)
        write_project(NewRule(f"zzz-{role.value}".replace("_", "-").lower(), role), tmp_path)
    for kind in KINDS:
        write_project(NewRule(f"fine-{kind}", kind), tmp_path)
    command = [sys.executable, "-m", "ruff", "check", "--isolated", "--select", "I", "--line-length", "120"]
    for folder in tmp_path.iterdir():
        done = subprocess.run([*command, "."], cwd=folder, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout


RULES = [role.label for role in Role]


def rule_of(label: str) -> NewRule:
    return NewRule(f"try-{label.lower().replace('+', '-')}", label if label in KINDS else Role.labelled(label))


@pytest.fixture(scope="session")
def place(environment: Callable[..., Any], built: Callable[..., tuple[Path, Path]]) -> Any:
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
