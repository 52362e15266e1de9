"""TA rule ``balanced``."""

from rmfs_rules.balanced.rule import Balanced

__all__ = ["Balanced"]
