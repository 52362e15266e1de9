"""Roads of a map that need not be a warehouse."""

from __future__ import annotations

from rmfs_core.motion import Motion
from rmfs_core.traffic import Roads
from rmfs_core.world import Layout
from rmfs_core.world.travel import Travel


def roads_of_map(layout: Layout) -> Roads:
    """Return the roads of a map, for robots that move as in the paper."""
    return Roads(Travel(layout, Motion()))
