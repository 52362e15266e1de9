"""Loops and look-ups for authors of rules, under the name that rules import: what `rmfs_rules.helpers` offers."""

from __future__ import annotations

import importlib

__path__: list[str] = []  # not that of the other: its modules could be imported twice


def __getattr__(name: str) -> object:
    return getattr(importlib.import_module("rmfs_rules.helpers"), name)


def __dir__() -> list[str]:
    return dir(importlib.import_module("rmfs_rules.helpers"))
