"""A distribution with one rule, filled in from the templates beside this file and written whole or not at all.

The templates are working files of a rule called ``the-rule``; only that name and the words in capitals are replaced.
"""

from __future__ import annotations

import ast
import os
import re
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from tempfile import TemporaryDirectory

from rmfs_core.errors import InputError
from rmfs_core.results.files import output_folder
from rmfs_core.roles import Role
from rmfs_kit.names import NewRule

_LISTS = (Role.FILTER, Role.OBSERVER)
"""Roles that any number of rules can play."""


def selecting(rule: NewRule) -> str:
    """Return the arguments of `rmfs run` that select the rule in place of the scenario's."""
    if rule.role in _LISTS:
        return f"""--set 'rules.{rule.role.key}=["{rule.name}"]'"""
    chosen = f"--set rules.{rule.role}={rule.name}"
    return " ".join([*(f"--set rules.{other}=" for other in rule.role.excludes if rule.role is Role.POA_PPS), chosen])


def _scenario_line(rule: NewRule) -> str:
    if rule.role in _LISTS:
        return f'{rule.role.key} = ["{rule.name}"]'
    return f'{rule.role} = "{rule.name}"'


def project_files(rule: NewRule) -> Mapping[str, str]:
    """Return the text of each file of the distribution by its path.

    Raises
    ------
    InputError
        When the class's name is one that its code needs for something else.
    """
    code, tests = _template(f"{rule.role}/rule.py"), _template(f"{rule.role}/test_rule.py")
    if re.search(rf"\b{rule.class_name}\b", code + tests):
        raise InputError(
            f'rule name "{rule.name}"', f"its class would hide the `{rule.class_name}` it uses; choose another name"
        )
    label = rule.role.label
    words = {
        "the-rule": rule.name,
        "the_rule": rule.module,
        "TheRule": rule.class_name,
        "DECIDES": label.capitalize() if rule.role in _LISTS else f"{label} rule",
        "SUMMARY": _summary(code),
        "SELECTION": selecting(rule),
        "SCENARIO_LINE": _scenario_line(rule),
    }
    templates = {
        "pyproject.toml": _template("pyproject.toml"),
        "README.md": _template("README.md"),
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
        raise InputError(str(folder), "is there already; expected a name that is free in the folder")
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
    return files("rmfs_kit").joinpath("templates", path).read_text(encoding="utf-8")


def _summary(code: str) -> str:
    """Return the first line of the class's docstring."""
    (rule,) = (node for node in ast.parse(code).body if isinstance(node, ast.ClassDef))
    return (ast.get_docstring(rule) or "").partition("\n")[0]
