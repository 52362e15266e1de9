"""Joint POA+PPS rules ``alternating``, ``two-stage`` and ``lns``."""

from rmfs_rules.joint.alternating import Alternating
from rmfs_rules.joint.lns import LargeNeighborhoodSearch
from rmfs_rules.joint.two_stage import TwoStage

__all__ = ["Alternating", "LargeNeighborhoodSearch", "TwoStage"]
