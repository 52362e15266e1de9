"""The name of a new rule, and what is called after it."""

from __future__ import annotations

import keyword
import re
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec

from attrs import field, frozen

from rmfs_core import entrypoints
from rmfs_core.errors import InputError
from rmfs_core.roles import Role

_NAME = re.compile(r"[a-z][a-z0-9]*(-[a-z0-9]+)*")


@frozen
class NewRule:
    """A rule that is yet to be written.

    Parameters
    ----------
    name
        The rule's name in scenarios, its distribution's and its folder's: small letters, digits and hyphens.
    role
        What it decides.
    """

    name: str = field()
    role: Role = field(converter=Role)

    @name.validator
    def _spelling(self, _attribute: object, name: str) -> None:
        if not _NAME.fullmatch(name):
            likely = re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")
            such_as = likely if _NAME.fullmatch(likely) else "my-rule"
            raise InputError(
                f'rule name "{name}"',
                f'expected small letters, digits and single hyphens, beginning with a letter, such as "{such_as}"',
            )

    @property
    def module(self) -> str:
        """Name of its import package."""
        return self.name.replace("-", "_")

    @property
    def class_name(self) -> str:
        """Name of its class."""
        return "".join(part.capitalize() for part in self.name.split("-"))

    def check_free(self) -> None:
        """Raise `InputError` when a rule, a distribution or a module has the name already."""
        place = f'rule name "{self.name}"'
        if self.name in entrypoints.offers(entrypoints.RULES):
            distribution, found = entrypoints.origin(entrypoints.offers(entrypoints.RULES)[self.name][0])
            raise InputError(place, f"a rule of that name is installed ({distribution} {found}); choose another name")
        try:
            installed = version(self.name)
        except PackageNotFoundError:
            pass
        else:
            raise InputError(
                place, f"a distribution of that name is installed ({self.name} {installed}); choose another name"
            )
        for name in (self.module, self.class_name):
            if keyword.iskeyword(name):
                raise InputError(place, f"`{name}` is a word of the Python language; choose another name")
        if find_spec(self.module) is not None:
            raise InputError(
                place, f"there is a module `{self.module}`, which its package would hide; choose another name"
            )
