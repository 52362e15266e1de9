"""PR rules ``station-based``, ``turnover-classes``, ``cache`` and ``utility``; these two decide repositioning, too."""

from rmfs_rules.classes.rules import Cache, StationBased, TurnoverClasses, Utility

__all__ = ["Cache", "StationBased", "TurnoverClasses", "Utility"]
