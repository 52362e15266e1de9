"""Where rules come from: entry points of installed distributions, and files beside the scenario."""

from __future__ import annotations

import hashlib
import os.path
import sys
import types
from importlib.metadata import EntryPoint
from pathlib import Path

from attrs import frozen

from rmfs_core import entrypoints
from rmfs_core.errors import InputError
from rmfs_core.scenario.rulenames import is_inline
from rmfs_core.wording import did_you_mean, listed, one_line

INLINE = "inline"
"""What stands in place of a version for a rule loaded from a file."""


@frozen
class RuleSource:
    """What a scenario's rule name leads to.

    Parameters
    ----------
    name
        As in the scenario.
    target
        The imported object, not yet checked.
    distribution, version
        Where it comes from; for a file, the file's name and ``"inline"``.
    file
        The file the code was loaded from, for a rule beside the scenario.
    """

    name: str
    target: object
    distribution: str
    version: str
    file: str | None = None

    def describe(self) -> str:
        """Name the rule for a message: ``rule "demand" (rmfs 0.1.0)``."""
        return describe(self.name, self.distribution, self.version)


def describe(name: str, distribution: str, version: str) -> str:
    """Name a rule for a message."""
    return entrypoints.describe("rule", name, distribution, version)


def load_entry(entry: EntryPoint, place: str) -> RuleSource:
    """Import an entry point's rule; raise `InputError` with the cause if that fails."""
    return RuleSource(entry.name, entrypoints.load(entry, place, "rule"), *entrypoints.origin(entry))


class RuleSources:
    """Finds rules by the names that a scenario uses. Each file beside the scenario is loaded once.

    Parameters
    ----------
    folder
        The scenario's folder.
    allow_inline
        Whether files in it may be loaded as code.
    """

    def __init__(self, folder: str, allow_inline: bool = True) -> None:
        self.folder = folder
        self.allow_inline = allow_inline
        self._offers = entrypoints.offers(entrypoints.RULES)
        self._modules: dict[str, types.ModuleType] = {}

    def find(self, name: str, place: str) -> RuleSource:
        """Import what a rule's name leads to."""
        if is_inline(name):
            return self._from_file(name, place)
        entries = self._offers.get(name, ())
        if not entries:
            raise InputError(
                place,
                f'unknown rule "{name}"{did_you_mean(name, self._offers)}; `rmfs rules` lists the installed ones',
            )
        if len(entries) > 1:
            clash = listed(" ".join(entrypoints.origin(entry)) for entry in entries)
            raise InputError(
                place,
                f'rule "{name}" is offered by more than one installed distribution: {clash}; uninstall all but one',
            )
        return load_entry(entries[0], place)

    def _from_file(self, name: str, place: str) -> RuleSource:
        relative, colon, class_name = name.rpartition(":")
        if not (colon and relative.endswith(".py") and class_name.isidentifier()):
            raise InputError(place, f'expected "./file.py:Class" for a rule beside the scenario, found "{name}"')
        if not self.allow_inline:
            raise InputError(place, f'rule "{name}" would load code from a file, which --no-inline-rules refuses')
        relative = os.path.normpath(relative)
        if Path(relative).is_absolute() or relative.startswith(".."):
            raise InputError(place, f'rule "{name}" is outside the scenario\'s folder; move its file into the folder')
        path = str(Path(self.folder) / relative)
        if path not in self._modules:
            self._modules[path] = _load_file(path, name, place)
        module = self._modules[path]
        if not hasattr(module, class_name):
            classes = [
                key for key, value in vars(module).items() if getattr(value, "__module__", "") == module.__name__
            ]
            raise InputError(place, f"{path} has no class `{class_name}`{did_you_mean(class_name, classes)}")
        return RuleSource(name, getattr(module, class_name), Path(path).name, INLINE, path)


def _load_file(path: str, name: str, place: str) -> types.ModuleType:
    """Run a file as a module under a name of its own, without leaving compiled files in the scenario's folder."""
    try:
        source = Path(path).read_bytes()
    except OSError as error:
        raise InputError(place, f'rule "{name}": cannot read {path}: {error.strerror}') from error
    digest = hashlib.sha256(str(Path(path).resolve()).encode()).hexdigest()[:12]
    module = types.ModuleType(f"rmfs_inline_{Path(path).stem}_{digest}")
    module.__file__ = path
    sys.modules[module.__name__] = module  # attrs and typing look up the module of a class there
    try:
        exec(compile(source, path, "exec"), module.__dict__)
    except (Exception, SystemExit) as error:
        raise InputError(place, f'rule "{name}": {path} cannot be loaded: {one_line(error)}') from error
    return module
