"""Scenario files."""

from rmfs_core.scenario.model import Scenario

__all__ = ["Scenario"]
