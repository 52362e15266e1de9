"""The tools for testing rules under the name that tests of rules import: what `rmfs_commands.testing` offers."""

from __future__ import annotations

import importlib

__path__: list[str] = []  # not that of the other: its modules could be imported twice


def __getattr__(name: str) -> object:
    return getattr(importlib.import_module("rmfs_commands.testing"), name)


def __dir__() -> list[str]:
    return dir(importlib.import_module("rmfs_commands.testing"))
