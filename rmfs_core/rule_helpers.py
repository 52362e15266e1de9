"""Loops and look-ups for authors of rules, under the name that rules import: what `rmfs_rule_helpers` offers."""

from __future__ import annotations

import importlib


def __getattr__(name: str) -> object:
    if name == "__path__":  # this is no package: else its modules could be imported twice
        raise AttributeError(name)
    return getattr(importlib.import_module("rmfs_rule_helpers"), name)


def __dir__() -> list[str]:
    return dir(importlib.import_module("rmfs_rule_helpers"))
