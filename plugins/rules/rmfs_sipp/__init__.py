"""PP rule ``sipp``."""

from rmfs_sipp.rule import Sipp

__all__ = ["Sipp"]
