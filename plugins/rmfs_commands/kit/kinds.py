"""Packages besides rules: functions under entry points of other groups."""

from __future__ import annotations

from typing import NamedTuple

from rmfs_core import entrypoints


class Kind(NamedTuple):
    """A kind of package that is no rule.

    Parameters
    ----------
    group
        Of its entry points.
    requires
        Packages that its code needs besides rmfs.
    found
        How rmfs comes to it.
    section
        The section of a scenario whose key ``generator`` names it; none for a command.
    """

    group: str
    requires: str
    found: str
    section: str = ""


COMMAND, GENERATOR, LAYOUT = "command", "generator", "layout"
KINDS = {
    COMMAND: Kind(entrypoints.COMMANDS, "click>=8.2", "the name after `rmfs`, and the command."),
    GENERATOR: Kind(
        entrypoints.INSTANCES, "numpy>=1.26", "the name in `instance.generator`, and the function.", "instance"
    ),
    LAYOUT: Kind(entrypoints.LAYOUTS, "numpy>=1.26", "the name in `layout.generator`, and the function.", "layout"),
}
"""A command of `rmfs`; a function that makes orders, SKUs and pods; one that makes the grid."""
