"""Joint POA+PPS rule ``alternating``."""

from rmfs_joint.alternating import Alternating

__all__ = ["Alternating"]
