"""The start of a run: layout, orders, pods and SKUs."""

from rmfs_core.world import *
from rmfs_core.world import __all__ as __all__
