"""PPS rules ``completes``, ``work-amount`` and ``lexicographic``."""

from rmfs_rules.scorers.rules import Completes, Lexicographic, WorkAmount

__all__ = ["Completes", "Lexicographic", "WorkAmount"]
