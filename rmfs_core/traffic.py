"""The old name of `rmfs_traffic`, until 0.3.0."""

import importlib
import sys
import warnings

__path__: list[str] = []
sys.modules[f"{__name__}.paths"] = sys.modules[__name__]


def __getattr__(name: str) -> object:
    found = getattr(importlib.import_module("rmfs_traffic"), name)
    warnings.warn("rmfs_core.traffic is rmfs_traffic now", FutureWarning, stacklevel=2)
    return found
