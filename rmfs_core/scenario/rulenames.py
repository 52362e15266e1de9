"""Names of rules in a scenario: which there are, which are files', where those lie. Nothing is imported."""

from __future__ import annotations

import os.path
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Self

from rmfs_core.scenario.model import RuleChoice, RulesSection
from rmfs_core.scenario.source import KeyPath
from rmfs_core.scenario.structuring import KeyProblem, fields_of
from rmfs_core.wording import nearest


class GivenText(str):
    """A parameter's text that is not from the scenario's file: should it name a file, that is looked up in ``there``.

    Whether it names one, only the rule knows.
    """

    __slots__ = ("there",)
    there: str

    def __new__(cls, text: str, there: str) -> Self:
        """Return the text; what it is compared with sees nothing else."""
        given = super().__new__(cls, text)
        given.there = there
        return given

    def __getnewargs__(self) -> tuple[str, str]:  # type: ignore[override] # pickle hands them to __new__
        return str(self), self.there

    def __repr__(self) -> str:
        return f"{super().__repr__()} in {self.there}"


def rule_choices(rules: RulesSection) -> Iterator[tuple[KeyPath, RuleChoice]]:
    """Yield the path under ``rules`` and the choice of every rule a scenario names."""
    for key in fields_of(RulesSection):
        chosen = getattr(rules, key)
        if isinstance(chosen, RuleChoice):
            yield (key,), chosen
        elif isinstance(chosen, tuple):
            yield from (((key, i), choice) for i, choice in enumerate(chosen))


def is_inline(name: str) -> bool:
    """Whether a rule's name is a file's: ``./my_rule.py:MyRule``."""
    return name.startswith((".", "/")) or ".py:" in name or name.endswith(".py")


def file_name_from(name: str, there: str | Path, folder: str | Path) -> str:
    """Return what a scenario in ``folder`` calls the file that has this name in the folder ``there``.

    In the scenario's folder it is named as a scenario file would, any other by its absolute path, so that what is
    stored of the scenario leads to it from everywhere.
    """
    if "\0" in name:  # no file can have it, which is said where it is read
        return Path(name).as_posix()
    path, home = (Path(os.path.realpath(where)) for where in (Path(there) / name, folder))
    return path.relative_to(home).as_posix() if path.is_relative_to(home) else str(path)


def inline_parts(name: str) -> tuple[str, str]:
    """Return the file and the class that an inline rule's name has; raise KeyProblem where it has not both."""
    file, _, class_name = name.rpartition(":")
    if not (file.endswith(".py") and class_name.isidentifier()):
        raise KeyProblem(f'expected "./file.py:Class" for a rule next to the scenario, found "{name}"')
    return file, class_name


def check_rule_name(name: str, folder: Path, names: Collection[str]) -> None:
    """Raise KeyProblem unless a rule is among those installed, or ``./file.py:Class`` of a file in ``folder``."""
    if not is_inline(name):
        if name not in names:
            raise KeyProblem(f'there is no rule "{name}"{nearest(name, names)}')
        return
    file, _ = inline_parts(name)
    if not os.path.isfile(folder / file):  # noqa: PTH113 (False for a name that is too long, too)
        where = "" if Path(file).is_absolute() else f" in the scenario's folder ({folder})"
        raise KeyProblem(f"there is no file `{file}`{where}")
