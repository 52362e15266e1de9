"""Roads of a map that need not be a warehouse."""

from __future__ import annotations

from rmfs_core.layout import Layout
from rmfs_core.motion import Motion
from rmfs_core.traffic import Roads
from rmfs_core.travel import Travel


class _BareTravel(Travel):
    """Travel times of a map, which may have no station and no storage location."""

    def _load_searches(self) -> None:
        """Nothing is loaded ahead: there may be no trip that is sure to be possible."""


def bare_roads(layout: Layout, motion: Motion | None = None) -> Roads:
    """Return the roads of a map, for robots that move as in the paper unless ``motion`` says otherwise."""
    return Roads(_BareTravel(layout, motion or Motion()))
