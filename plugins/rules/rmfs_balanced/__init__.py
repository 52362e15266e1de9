"""TA rule ``balanced``."""

from rmfs_balanced.rule import Balanced

__all__ = ["Balanced"]
