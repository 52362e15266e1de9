"""Parts of rules besides their own code: files that parameters name, and rules that they ask in turn.

A parameter of the type `pathlib.Path` is the name of a file that the rule reads. It is looked up in the scenario's
folder, or where its text was given (`GivenText`). A rule that makes other rules (`rmfs_core.rules.parameters.build`)
while it is made has their files and classes among its parts.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any

from attrs import Factory, evolve, frozen

from rmfs_core.errors import InputError
from rmfs_core.scenario.model import RuleChoice
from rmfs_core.scenario.rulenames import GivenText, file_name_from


@frozen(eq=False)
class NamedFile:
    """A file that a parameter names.

    Parameters
    ----------
    text
        The parameter's value.
    file
        Where the file is.
    name
        Its name in the scenario: as seen from its folder, by the absolute path if it is elsewhere.
    """

    text: object
    file: Path
    name: str

    def digest(self) -> str:
        """Return the digest of its contents."""
        try:
            return f"sha256:{hashlib.sha256(self.file.read_bytes()).hexdigest()}"
        except OSError as error:
            raise InputError(str(self.file), f"cannot be read: {error.strerror}") from None


@frozen(eq=False)
class Parts:
    """Files and rules found while rules were made.

    Parameters
    ----------
    folder
        Where files are looked up.
    allow_code
        Whether code that is not installed may take part: files with rules, other programs.
    files, classes
        Files that parameters name, and the classes of all rules made.
    """

    folder: str = "."
    allow_code: bool = True
    files: list[NamedFile] = Factory(list)
    classes: list[type] = Factory(list)


class FileProblem(Exception):  # noqa: N818 - who makes the rule turns it into an InputError with the place
    """A parameter names no file that can be read."""


_parts: ContextVar[Parts | None] = ContextVar("parts", default=None)


@contextmanager
def made_in(folder: str, allow_code: bool = True) -> Iterator[Parts]:
    """Look up the files of rules that are made within in a folder; yields what these rules are made of."""
    parts = Parts(folder, allow_code)
    token = _parts.set(parts)
    try:
        yield parts
    finally:
        _parts.reset(token)


def parts_now() -> Parts:
    """Return the parts of the rule that is being made; outside of `made_in` new ones, of the working directory."""
    return _parts.get() or Parts()


def find_file(text: str | Path) -> Path:
    """Return the file that a parameter names; raise `FileProblem` when it cannot be read."""
    parts = parts_now()
    there = text.there if isinstance(text, GivenText) else parts.folder
    file = Path(there) / text
    if not os.path.isfile(file):  # noqa: PTH113 (False for a name that is too long, too)
        found = "a folder" if os.path.isdir(file) else "a device" if os.path.exists(file) else ""  # noqa: PTH110, PTH112
        raise FileProblem(f"expected a file, found {found}, {file}" if found else f"there is no file {file}")
    if not os.access(file, os.R_OK):
        raise FileProblem(f"{file} cannot be read: permission denied")
    if isinstance(text, GivenText):
        name = file_name_from(text, there, parts.folder)
    else:
        path, home = file.absolute(), Path(parts.folder).absolute()
        name = (path.relative_to(home) if path.is_relative_to(home) else path).as_posix()
    parts.files.append(NamedFile(text, file, name))
    return file


def add_paths(value: Any) -> None:
    """Add to the parts the files that a parameter of a rule's object names, as seen from the working directory."""
    if isinstance(value, Path) and value.is_file():
        find_file(value.absolute())
    elif isinstance(value, list | tuple | Mapping):
        for entry in value.values() if isinstance(value, Mapping) else value:
            add_paths(entry)


def with_given(value: Any, change: Callable[[GivenText], str]) -> Any:
    """Return a value, or a rule's choice, with each text that was given elsewhere changed."""
    if isinstance(value, GivenText):
        return change(value)
    if isinstance(value, RuleChoice):
        return evolve(value, parameters=with_given(value.parameters, change))
    if isinstance(value, Mapping):
        return {key: with_given(entry, change) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return type(value)(with_given(entry, change) for entry in value)
    return value
