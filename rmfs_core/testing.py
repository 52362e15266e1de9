"""The tools for testing rules under the name that tests of rules import: what `rmfs_testing` offers."""

from __future__ import annotations

import importlib


def __getattr__(name: str) -> object:
    if name == "__path__":  # this is no package: else its modules could be imported twice
        raise AttributeError(name)
    return getattr(importlib.import_module("rmfs_testing"), name)


def __dir__() -> list[str]:
    return dir(importlib.import_module("rmfs_testing"))
