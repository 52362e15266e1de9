"""What `rmfs new-rule` writes, and what it refuses."""

from __future__ import annotations

import ast
import subprocess
import sys
import tomllib
from importlib.metadata import version
from pathlib import Path

import pytest

from rmfs_commands.kit import NewRule, project_files, selecting, write_project
from rmfs_commands.kit.names import COMMAND
from rmfs_core import InputError
from rmfs_core.roles import Role

WORDS = (
    *("the-rule", "the_rule", "TheRule", "TARGET", "DECIDES", "SUMMARY", "GROUP", "LIBRARY", "FOUND", "TRYING"),
    "SCENARIO_LINE",
)


@pytest.mark.parametrize("role", Role)
def test_every_role_has_its_templates(role: Role, tmp_path: Path) -> None:
    """The class is named after the rule, implements the role's hook, and the entry point leads to it."""
    folder = write_project(NewRule("fine-rule", role), tmp_path)
    written = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    assert written == {"pyproject.toml", "README.md", "src/fine_rule/__init__.py", "tests/test_fine_rule.py"}
    assert [path.name for path in tmp_path.iterdir()] == ["fine-rule"]
    project = tomllib.loads((folder / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["name"] == "fine-rule"
    assert project["dependencies"][0] == f"rmfs>={version('rmfs')}"
    assert project["entry-points"] == {"rmfs.rules": {"fine-rule": "fine_rule:FineRule"}}
    code = ast.parse((folder / "src/fine_rule/__init__.py").read_text(encoding="utf-8"))
    (rule,) = (node for node in code.body if isinstance(node, ast.ClassDef))
    assert rule.name == "FineRule"
    assert role.hook in {node.name for node in rule.body if isinstance(node, ast.FunctionDef)}


@pytest.mark.parametrize("role", Role)
def test_no_word_of_the_templates_is_left(role: Role) -> None:
    """Every stand-in was replaced, and the README has the commands for this kind of rule."""
    rule = NewRule("fine-rule", role)
    texts = project_files(rule)
    for text in texts.values():
        for word in WORDS:
            assert word not in text
    scenario = "examples/replenished" if "bundles" in role.hook or "replenishment" in role.hook else "examples/small"
    assert f"rmfs run {scenario} {selecting(rule)}" in texts["README.md"]


def test_a_command_has_its_templates(tmp_path: Path) -> None:
    """Its function is named after it, and the entry point of `rmfs.commands` leads to it."""
    rule = NewRule("fine-tool", COMMAND)
    folder = write_project(rule, tmp_path)
    project = tomllib.loads((folder / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["entry-points"] == {"rmfs.commands": {"fine-tool": "fine_tool:fine_tool"}}
    assert project["dependencies"][1].startswith("click")
    assert project["description"].startswith("Command for rmfs: Run SCENARIO")
    code = ast.parse((folder / "src/fine_tool/__init__.py").read_text(encoding="utf-8"))
    assert [node.name for node in code.body if isinstance(node, ast.FunctionDef)] == ["fine_tool"]
    texts = project_files(rule)
    assert "rmfs fine-tool examples/small\n" in texts["README.md"]
    assert not any(word in text for text in texts.values() for word in WORDS)


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("compare", r'command name "compare": a command of that name is installed \(rmfs '),
        ("seeds", "its function would hide the `seeds` it uses"),
        ("No", 'command name "No": expected small letters'),
    ],
)
def test_a_commands_bad_name_is_refused(name: str, problem: str, tmp_path: Path) -> None:
    """Names of commands are apart from those of rules."""
    with pytest.raises(InputError, match=problem):
        write_project(NewRule(name, COMMAND), tmp_path)
    assert (write_project(NewRule("demand", COMMAND), tmp_path) / "README.md").exists()


def test_rules_are_selected_by_their_role() -> None:
    """One rule for a decision, lists of filters and observers, and a joint rule in place of two."""
    assert selecting(NewRule("x", "pps")) == "--set rules.pps=x"
    assert selecting(NewRule("x", "filter")) == """--set 'rules.filters=["x"]'"""
    assert selecting(NewRule("x", "poa_pps")) == "--set rules.poa_pps=x"


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("demand", r"a rule of that name is installed \(rmfs "),
        ("order-assignment", "its class would hide the `OrderAssignment` it uses"),
    ],
)
def test_a_bad_name_is_refused(name: str, problem: str, tmp_path: Path) -> None:
    """One sentence, and nothing written."""
    with pytest.raises(InputError, match=problem):
        write_project(NewRule(name, "poa"), tmp_path / "new")
    assert list(tmp_path.iterdir()) == []


def test_what_is_there_stays(tmp_path: Path) -> None:
    """An existing folder or file of that name is left as it is."""
    write_project(NewRule("mine", "ta"), tmp_path)
    (tmp_path / "mine" / "README.md").write_text("changed", encoding="utf-8")
    with pytest.raises(InputError, match="is there already"):
        write_project(NewRule("mine", "poa"), tmp_path)
    assert (tmp_path / "mine" / "README.md").read_text(encoding="utf-8") == "changed"
    assert [path.name for path in tmp_path.iterdir()] == ["mine"]


def test_what_cannot_be_written_leaves_nothing(tmp_path: Path) -> None:
    """A name that is too long for a folder."""
    with pytest.raises(InputError, match="cannot be written: File name too long"):
        write_project(NewRule("a" * 300, "ta"), tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    """A file is in the way."""
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(InputError, match="expected a folder"):
        write_project(NewRule("mine", "ta"), tmp_path / "file")


def test_imports_are_sorted(tmp_path: Path) -> None:
    """As ruff sorts them, whatever the package is called."""
    pytest.importorskip("ruff")  # it is among the tools of `make lint`, which `make lowest` does not install
    for role in Role:
        write_project(NewRule(f"aaa-{role.value}".replace("_", "-").lower(), role), tmp_path)
        write_project(NewRule(f"zzz-{role.value}".replace("_", "-").lower(), role), tmp_path)
    write_project(NewRule("fine-tool", COMMAND), tmp_path)
    command = [sys.executable, "-m", "ruff", "check", "--isolated", "--select", "I", "--line-length", "120"]
    for folder in tmp_path.iterdir():
        done = subprocess.run([*command, "."], cwd=folder, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout
