"""PP rules ``sipp`` and ``pbs``, which share a search."""

from rmfs_rules.sipp.pbs import Pbs
from rmfs_rules.sipp.rule import Sipp

__all__ = ["Pbs", "Sipp"]
