"""The name of a new rule, observer or command, and what is called after it."""

from __future__ import annotations

import keyword
import re
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec

from attrs import field, frozen

from rmfs_commands.kit.kinds import KINDS
from rmfs_core import entrypoints
from rmfs_core.errors import InputError
from rmfs_core.roles import Role


def _role(role: str) -> Role | str:
    return role if role in KINDS else Role(role)


_NAME = re.compile(r"[a-z][a-z0-9]*(-[a-z0-9]+)*")


@frozen
class NewRule:
    """A rule, observer or command that is yet to be written.

    Parameters
    ----------
    name
        Its name in scenarios or on the command line, its distribution's and its folder's: small letters, digits and
        hyphens.
    role
        Kind of its decision; or one of `KINDS`.
    """

    name: str = field()
    role: Role | str = field(converter=_role)

    @name.validator
    def _spelling(self, _attribute: object, name: str) -> None:
        if not _NAME.fullmatch(name):
            likely = re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")
            such_as = likely if _NAME.fullmatch(likely) else "my-rule"
            raise InputError(
                self.place,
                f'expected small letters, digits and single hyphens, beginning with a letter, such as "{such_as}"',
            )

    @property
    def kind(self) -> str:
        """Its kind, for people."""
        return "rule" if isinstance(self.role, Role) else self.role

    @property
    def place(self) -> str:
        """Its name in messages."""
        return f'{self.kind} name "{self.name}"'

    @property
    def module(self) -> str:
        """Name of its import package."""
        return self.name.replace("-", "_")

    @property
    def target(self) -> str:
        """Name of its class; of its function where it is no rule."""
        if not isinstance(self.role, Role):
            return self.module
        return "".join(part.capitalize() for part in self.name.split("-"))

    def check_free(self) -> None:
        """Raise `InputError` when another of its kind, a distribution or a module has the name already."""
        place = self.place
        offers = entrypoints.offers(entrypoints.RULES if isinstance(self.role, Role) else KINDS[self.role].group)
        if self.name in offers:
            by = " ".join(entrypoints.origin(offers[self.name][0]))
            raise InputError(place, f"a {self.kind} of that name is installed ({by}); choose another name")
        try:
            installed = version(self.name)
        except PackageNotFoundError:
            pass
        else:
            raise InputError(
                place, f"a distribution of that name is installed ({self.name} {installed}); choose another name"
            )
        for name in (self.module, self.target):
            if keyword.iskeyword(name):
                raise InputError(place, f"`{name}` is a word of the Python language; choose another name")
        if find_spec(self.module) is not None:
            raise InputError(
                place, f"there is a module `{self.module}`, which its package would hide; choose another name"
            )
