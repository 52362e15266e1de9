"""What every planner over a reservation table offers."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from rmfs_core.traffic.paths import Query, TimedPath
from rmfs_core.traffic.reservations import Reservations
from rmfs_core.traffic.roads import Roads


@runtime_checkable
class Planner(Protocol):
    """Plans one robot's path among the reservations of the others. Changes nothing."""

    def search(self, roads: Roads, table: Reservations, query: Query) -> TimedPath | None:
        """Return a path whose `occupancy` the table has room for, its end held for ever; None when there is none."""
