"""Where rules come from: entry points of installed distributions, and files next to the scenario."""

from __future__ import annotations

import hashlib
import os
import sys
import types
from contextlib import suppress
from functools import partial
from pathlib import Path
from weakref import finalize

from attrs import field, frozen

from rmfs_core import entrypoints
from rmfs_core.errors import InputError, refusing
from rmfs_core.scenario.rulenames import inline_parts, is_inline
from rmfs_core.scenario.structuring import KeyProblem
from rmfs_core.wording import did_you_mean, nearest, one_line

INLINE = "inline"
"""Version shown for a rule loaded from a file."""

OBJECT = "object"
"""Version shown for a rule given as an object, of a class that is no installed rule."""


@frozen
class RuleSource:
    """The class that a scenario's rule name leads to.

    Parameters
    ----------
    name
        As in the scenario.
    target
        The imported object, not yet checked.
    distribution, version
        Where it comes from; for a file, the file's name and ``"inline"``; for an object, its module and ``"object"``.
    file
        The file the code was loaded from, for a rule next to the scenario.
    sources
        Who keeps the file's module.
    """

    name: str
    target: object
    distribution: str
    version: str
    file: str | None = None
    sources: RuleSources | None = field(default=None, eq=False, repr=False)

    def describe(self) -> str:
        """Name the rule for a message: ``rule "demand" (rmfs 0.1.0)``."""
        return entrypoints.describe("rule", self.name, self.distribution, self.version)


def load_entry(entries: entrypoints.Entries, place: str) -> RuleSource:
    """Import the rule that a name's entry point leads to; raise `InputError` with the cause if that fails."""
    return RuleSource(entries[0].name, entrypoints.load(entries, place, "rule"), *entrypoints.origin(entries[0]))


def source_of(rule: object) -> RuleSource:
    """Return where an object's class comes from: by the name of the installed rule that it is, else by its own."""
    cls = type(rule)
    package = cls.__module__.partition(".")[0]
    for name, (entry, *others) in entrypoints.offers(entrypoints.RULES).items():
        if not others and entry.attr == cls.__qualname__ and entry.module.partition(".")[0] == package:
            with suppress(InputError):
                if entrypoints.load((entry,), "", "rule") is cls:
                    return RuleSource(name, cls, *entrypoints.origin(entry))
    return RuleSource(cls.__name__, cls, cls.__module__, OBJECT)


class RuleSources:
    """Finds rules by the names that a scenario uses. Each file next to the scenario is loaded once.

    Its module is in ``sys.modules``, where pickle, inspect and typing look for that of a class, until `close` is called
    or nobody has these sources or a rule of theirs any more.

    Parameters
    ----------
    folder
        The scenario's folder.
    allow_inline
        Whether files in it may be loaded as code; none may where the environment has RMFS_NO_INLINE_RULES.
    """

    def __init__(self, folder: str, allow_inline: bool = True) -> None:
        self.folder = folder
        self.allow_inline = allow_inline and not os.environ.get("RMFS_NO_INLINE_RULES")
        self._offers = entrypoints.offers(entrypoints.RULES)
        self._modules: dict[str, types.ModuleType] = {}
        self.close = finalize(self, _forget, self._modules)
        """Removes the modules from ``sys.modules``."""

    def find(self, name: str, place: str) -> RuleSource:
        """Import what a rule's name leads to."""
        if is_inline(name):
            return self._from_file(name, place)
        if name not in self._offers:
            raise InputError(place, f'there is no rule "{name}"{nearest(name, self._offers)}')
        return load_entry(self._offers[name], place)

    def _from_file(self, name: str, place: str) -> RuleSource:
        try:
            relative, class_name = inline_parts(name)
        except KeyProblem as error:
            raise InputError(place, error.problem) from None
        if not self.allow_inline:
            raise InputError(place, f'rule "{name}" would load code from a file, which --no-inline-rules refuses')
        if (relative := os.path.normpath(relative)).startswith(".."):
            raise InputError(place, f'rule "{name}" is outside {Path(self.folder).absolute()}; move its file there')
        path = str(Path(self.folder) / relative)
        if path not in self._modules:
            self._modules[path] = _load_file(path, name, place)
        module = self._modules[path]
        if class_name not in vars(module):
            classes = [key for key, value in vars(module).items() if isinstance(value, type)]
            raise InputError(place, f"{path} has no class `{class_name}`{did_you_mean(class_name, classes)}")
        return RuleSource(name, vars(module)[class_name], Path(path).name, INLINE, path, self)


def _load_file(path: str, name: str, place: str) -> types.ModuleType:
    """Run a file as a module under a name of its own, without leaving compiled files in the scenario's folder."""
    try:
        source = Path(path).read_bytes()
    except (OSError, ValueError) as error:  # ValueError: of a name that no file can have
        raise InputError(place, f'rule "{name}": cannot read {path}: {getattr(error, "strerror", error)}') from error
    digest = hashlib.sha256(str(Path(path).resolve()).encode()).hexdigest()[:12]
    base, number = f"rmfs_inline_{Path(path).stem}_{digest}", 1
    module = types.ModuleType(base)
    vars(module).update(__file__=path, __package__="")
    while sys.modules.setdefault(module.__name__, module) is not module:  # another run has one of the same file
        number += 1
        module.__name__ = f"{base}_{number}"
    try:
        what = f'rule "{name}": {path} cannot be loaded:'
        with entrypoints.IMPORTING, refusing(place, what, partial(_told, Path(path).parent)):
            exec(compile(source, path, "exec"), module.__dict__)
    except BaseException:
        _forget({path: module})
        raise
    return module


def _told(folder: Path, error: BaseException) -> str:
    wanted = (error.name or str(error)).partition(".")[0] if isinstance(error, ImportError) else None
    near = {"attempted relative import with no known parent package", *(one.stem for one in folder.glob("*.py"))}
    helps = "; it imports what is installed, and no file next to it: put them into a package (`rmfs new-rule`)"
    return one_line(error) + helps * (wanted in near)


def _forget(modules: dict[str, types.ModuleType]) -> None:
    for module in modules.values():
        sys.modules.pop(module.__name__, None)
