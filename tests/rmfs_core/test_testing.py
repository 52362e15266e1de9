"""The name under which tests of rules import their tools."""

from __future__ import annotations

import importlib

import pytest

import rmfs_commands.testing
import rmfs_core.rule_helpers
import rmfs_core.testing


def test_the_tools_are_there_once() -> None:
    """They are those of `rmfs_commands.testing`; its modules cannot be imported a second time under another name."""
    assert rmfs_core.testing.check_rule is rmfs_commands.testing.check_rule
    for name in ("rmfs_core.testing.worlds", "rmfs_core.rule_helpers.trips"):
        with pytest.raises(ModuleNotFoundError, match=f"No module named '{name}'"):
            importlib.import_module(name)
