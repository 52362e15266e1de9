"""How good storage locations are: near a station."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Generic, TypeVar

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

if TYPE_CHECKING:
    from rmfs_core.warehouse import Robot, WarehouseView

NO_STATION = -1

Ids = NDArray[np.int64]
T = TypeVar("T")


def nearest_to(warehouse: WarehouseView, cell: int, cells: Ids) -> int:
    """Return the cell with the shortest loaded drive from another, the robot facing as it likes; ties: the first."""
    times = [warehouse.travel.times_from(cell, heading, True)[cells] for heading in range(4)]
    return int(cells[np.min(times, axis=0).argmin()])


@frozen(eq=False)
class Locations:
    """The storage locations of a warehouse that hold no empty pod.

    Parameters
    ----------
    cells
        Their cells, ascending, shape (n,).
    ticks
        Shortest loaded driving times to the stations, shape (stations, n).
    """

    cells: Ids
    ticks: NDArray[np.int64]

    @classmethod
    def of(cls, warehouse: WarehouseView) -> Locations:
        """Look up the driving times."""
        blocked = set(warehouse.blocked_locations)
        cells = [cell for cell in sorted(warehouse.travel.layout.storage_locations) if cell not in blocked]
        ticks = [warehouse.travel.times_to(station.cell, True)[cells].min(axis=1) for station in warehouse.stations]
        return cls(np.array(cells, np.int64), np.array(ticks, np.int64))

    @property
    def nearest_ticks(self) -> NDArray[np.int64]:
        """Driving time from each to the station that is nearest to it."""
        nearest: NDArray[np.int64] = self.ticks.min(axis=0)
        return nearest

    def by_cell(self, values: Ids, other: int) -> Ids:
        """Return values of the locations by cell, and another one for cells between them and for cell -1."""
        found = np.full(int(self.cells.max(initial=0)) + 2, other)
        found[self.cells] = values
        return found

    def caches(self, share: float) -> Ids:
        """Return whose cache each belongs to: a station, or none.

        A share of all locations is divided among the stations: again and again the location and the station that are
        the shortest drive apart, of the stations whose cache is not complete.
        """
        stations, number = self.ticks.shape
        room = np.full(stations, math.ceil(share * number / stations))
        owner = np.full(number, NO_STATION)
        for pair in np.argsort(self.ticks, axis=None, kind="stable").tolist():
            station, location = divmod(pair, number)
            if room[station] and owner[location] == NO_STATION:
                owner[location] = station
                room[station] -= 1
        return owner


class Kept(Generic[T]):
    """The locations, and what is made of them, once in a run."""

    def __init__(self) -> None:
        self._robots: tuple[Robot, ...] | None = None  # whose run it is

    def of(self, warehouse: WarehouseView, make: Callable[[Locations], T]) -> tuple[Locations, T]:
        """Return the locations, and what was made of them when the run was first looked at."""
        if self._robots is not warehouse.robots:
            locations = Locations.of(warehouse)
            self._robots, self._made = warehouse.robots, (locations, make(locations))
        return self._made
