"""The old name of `rmfs_traffic`, until 0.3.0."""

import sys

from rmfs_core.former import former

__path__: list[str] = []
__getattr__ = former(__name__, "rmfs_traffic")
sys.modules[f"{__name__}.paths"] = sys.modules[__name__]
