"""A distribution with a rule or command, made from the templates next to this file and written whole or not at all.

The templates are working files of something called ``the-rule``; only that name, the words in capitals and the version
of rmfs are replaced.
"""

from __future__ import annotations

import ast
import os
import re
from collections.abc import Mapping
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from tempfile import TemporaryDirectory

from rmfs_commands.kit.kinds import COMMAND, KINDS, Kind
from rmfs_commands.kit.names import NewRule
from rmfs_commands.results.files import output_folder
from rmfs_core.errors import InputError
from rmfs_core.roles import Role


def selecting(rule: NewRule) -> str:
    """Return the arguments of `rmfs run` that select the rule instead of the scenario's."""
    if kind := KINDS.get(rule.role):
        return f"--set {kind.section}.generator={rule.name}"
    if _is_listed(rule):
        return f"""--set 'rules.{Role(rule.role).key}=["{rule.name}"]'"""
    return f"--set rules.{rule.role}={rule.name}"


def example(rule: NewRule) -> str:
    """Return the shipped scenario in which there is something for it to decide."""
    if rule.role in (Role.PACKING, Role.PACKING_TASK):
        return "examples/packing"
    return "examples/replenished" if rule.role in (Role.ROA, Role.RPS, Role.ROA_RPS) else "examples/small"


def trying(rule: NewRule) -> str:
    """Return the command that tries it."""
    command = f"rmfs {rule.name}" if rule.role == COMMAND else "rmfs run"
    return f"{command} {example(rule)}" + ("" if rule.role == COMMAND else f" {selecting(rule)}")


def _is_listed(rule: NewRule) -> bool:
    """Whether scenarios name it in a list."""
    return isinstance(rule.role, Role) and rule.role.many


def _scenario_line(rule: NewRule) -> str:
    if rule.role in KINDS:
        return f'generator = "{rule.name}"'
    if _is_listed(rule):
        return f'{Role(rule.role).key} = ["{rule.name}"]'
    return f'{rule.role} = "{rule.name}"'


def project_files(rule: NewRule) -> Mapping[str, str]:
    """Return the text of each file of the distribution by its path.

    Raises
    ------
    InputError
        When the name of the class or function is one that its code needs for something else.
    """
    code, tests = _template(f"{rule.role}/rule.py"), _template(f"{rule.role}/test_rule.py")
    kind = KINDS.get(rule.role)
    if re.search(rf"\b{rule.target}\b", code + tests):
        what = "function" if kind else "class"
        raise InputError(rule.place, f"its {what} would hide the `{rule.target}` it uses; choose another name")
    label = rule.kind if kind else Role(rule.role).label
    of = kind or Kind("rmfs.rules", "attrs>=24.2", "the name that scenarios use, and the class.", "rules")
    words = {
        "the-rule": rule.name,
        "the_rule": rule.module,
        "TheRule": rule.target,
        "TARGET": rule.target,
        "DECIDES": label.capitalize() if kind or _is_listed(rule) else f"{label} rule",
        "SUMMARY": _summary(code),
        "GROUP": of.group,
        "LIBRARY": of.requires,
        "FOUND": of.found,
        "rmfs>=0.1": f"rmfs>={version('rmfs')}",
        "TRYING": trying(rule),
        "SECTION": of.section,
        "SCENARIO_LINE": _scenario_line(rule),
    }
    templates = {
        "pyproject.toml": _template("pyproject.toml"),
        "README.md": _template(f"{rule.role}/README.md" if kind else "README.md"),
        f"src/{rule.module}/__init__.py": code,
        f"tests/test_{rule.module}.py": tests,
    }
    word = re.compile("|".join(words))
    return {path: word.sub(lambda match: words[match[0]], text) for path, text in templates.items()}


def write_project(rule: NewRule, into: str | Path) -> Path:
    """Write the distribution to a new folder with the rule's name; return the folder.

    Parameters
    ----------
    rule
        The rule.
    into
        The folder to make it in; it is made if it is not there.

    Raises
    ------
    InputError
        When the name is taken, there is something of that name in the folder, or it cannot be written to. Then nothing
        is left there.
    """
    folder = Path(into) / rule.name
    rule.check_free()
    texts = project_files(rule)
    if os.path.lexists(folder):
        raise InputError(str(folder), "exists already; expected another name")
    try:
        with TemporaryDirectory(prefix=".new-rule.", dir=output_folder(into)) as beside:
            project = Path(beside) / rule.name
            for path, text in texts.items():
                (project / path).parent.mkdir(parents=True, exist_ok=True)
                (project / path).write_text(text, encoding="utf-8", newline="\n")
            project.rename(folder)
    except OSError as error:
        raise InputError(str(folder), f"cannot be written: {error.strerror or error}") from error
    return folder


def _template(path: str) -> str:
    return files("rmfs_commands.kit").joinpath("templates", path).read_text(encoding="utf-8")


def _summary(code: str) -> str:
    """Return the first line of the docstring of the class, or of a command's function."""
    (rule,) = (node for node in ast.parse(code).body if isinstance(node, ast.ClassDef | ast.FunctionDef))
    return (ast.get_docstring(rule) or "").partition("\n")[0]
