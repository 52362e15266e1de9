"""How far, and how long, a pod must be carried at least, whatever is in the way.

Counted are the straight runs alone, from stop to stop along the lanes of the layout; every cell may be crossed, storage
and queues as well, and turns take no time. So the way from one place to another is never longer than one by way of a
third, with pods set down and lifted in between: what is least holds for whatever detour a run makes.
"""

from __future__ import annotations

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from rmfs_core.world.travel import Travel
from rmfs_core.world.travel_search import times_from, times_to, work_on


@frozen(eq=False)
class Ways:
    """The least from each cell to each station, and back to storage.

    Parameters
    ----------
    metres, ticks
        From each cell to each station. int64, shape (stations, cells).
    back_m
        From a station to a storage location, of all pairs the nearest.
    """

    metres: NDArray[np.int64]
    ticks: NDArray[np.int64]
    back_m: int


def find_ways(travel: Travel) -> Ways:
    """Return the least ways on a layout."""
    layout = travel.layout
    metres = np.arange(len(travel.runs), dtype=np.int64)
    anywhere, no_time = np.ones(len(layout.kind), dtype=np.bool_), np.zeros(4, dtype=np.int64)
    for array in (metres, anywhere, no_time):
        array.setflags(write=False)  # the searches are compiled for arrays like those of `Travel`
    no_lane = np.full(len(layout.kind), -1, dtype=np.int64)
    no_lane.setflags(write=False)
    grid = layout.moves, anywhere, travel.offsets
    short, long = (work_on(len(layout.kind), runs, no_time) for runs in (metres, travel.runs))
    stations = [cells.station for cells in layout.stations]
    storage = list(layout.storage_locations)
    return Ways(
        np.array([times_to(cell, *grid, metres, no_time, short).min(axis=1) for cell in stations]),
        np.array([times_to(cell, *grid, travel.runs, no_time, long).min(axis=1) for cell in stations]),
        min(int(times_from(cell, 0, no_lane, *grid, metres, no_time, short)[storage].min()) for cell in stations),
    )
