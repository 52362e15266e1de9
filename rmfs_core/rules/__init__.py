"""Rules as plugins: what is installed, what a scenario selects, and the plugin manager of a run."""

from rmfs_core.rules.ruleset import BoundRule, RuleSet, bind, with_objects

__all__ = ["BoundRule", "RuleSet", "bind", "with_objects"]
