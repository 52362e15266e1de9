"""Joint POA+PPS rules ``alternating`` and ``two-stage``."""

from rmfs_joint.alternating import Alternating
from rmfs_joint.two_stage import TwoStage

__all__ = ["Alternating", "TwoStage"]
