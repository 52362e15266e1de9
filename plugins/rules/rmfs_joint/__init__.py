"""Joint POA+PPS rules ``alternating``, ``two-stage`` and ``lns``."""

from rmfs_joint.alternating import Alternating
from rmfs_joint.lns import LargeNeighborhoodSearch
from rmfs_joint.two_stage import TwoStage

__all__ = ["Alternating", "LargeNeighborhoodSearch", "TwoStage"]
