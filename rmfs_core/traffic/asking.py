"""What a PP rule that reserves is asked with, and what every planner over a reservation table offers."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from attrs import frozen

from rmfs_core.traffic.paths import Query, TimedPath
from rmfs_core.traffic.reservations import Reservations
from rmfs_core.traffic.roads import Roads


@frozen(eq=False)
class Traffic:
    """The other robots' reservations, and the path that is wanted among them.

    Parameters
    ----------
    roads
        The layout as path planning sees it.
    table
        Who has reserved which cell when. For looking only: the kernel reserves what a path occupies.
    query
        From where, when and where to. A robot that is on its way is planned for from the end of the leg under way.
    """

    roads: Roads
    table: Reservations
    query: Query


@runtime_checkable
class Planner(Protocol):
    """Plans one robot's path among the reservations of the others. Changes nothing."""

    def search(self, roads: Roads, table: Reservations, query: Query) -> TimedPath | None:
        """Return a path whose `occupancy` the table has room for, its end held for ever; None when there is none."""
