"""Rules as plugins: what is installed, what a scenario selects, and the plugin manager of a run."""

from rmfs_core.plugins.ruleset import BoundRule, RuleSet
from rmfs_core.plugins.sources import available_rules

__all__ = ["BoundRule", "RuleSet", "available_rules"]
