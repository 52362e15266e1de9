"""Loops and look-ups for authors of rules, under the name that rules import: what `rmfs_rules.helpers` offers."""

from rmfs_core.offered import offered

__path__: list[str] = []  # not that of the other: its modules could be imported twice
__getattr__, __dir__ = offered("rmfs_rules.helpers")
