"""PR rules ``station-based``, ``turnover-classes``, ``cache`` and ``utility``."""

from rmfs_classes.rules import Cache, StationBased, TurnoverClasses, Utility

__all__ = ["Cache", "StationBased", "TurnoverClasses", "Utility"]
