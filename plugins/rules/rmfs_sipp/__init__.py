"""PP rules ``sipp`` and ``pbs``, which share a search."""

from rmfs_sipp.pbs import Pbs
from rmfs_sipp.rule import Sipp

__all__ = ["Pbs", "Sipp"]
