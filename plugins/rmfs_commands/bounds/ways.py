"""How far, and how long, a pod must be carried at least, whatever is in the way.

Counted are the straight runs alone, from stop to stop along the lanes of the layout; every cell may be crossed, storage
and queues as well, and turns take no time. So the path from one cell to another is never longer than one by way of a
third, with pods set down and lifted in between: what is least holds for whatever detour a run makes.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from rmfs_core.world.travel import Travel
from rmfs_core.world.travel_search import times_from, times_on, times_to, wide, work_on

_Search = Callable[[int], NDArray[np.int64]]


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
    metres.setflags(write=False)
    to_m, back_m = _searches(travel, metres)
    to_ticks, _ = _searches(travel, travel.runs)
    stations = [cells.station for cells in layout.stations]
    storage = list(layout.storage_locations)
    return Ways(
        np.array([to_m(cell) for cell in stations]),
        np.array([to_ticks(cell) for cell in stations]),
        min(int(back_m(cell)[storage].min()) for cell in stations),
    )


def _searches(travel: Travel, runs: NDArray[np.int64]) -> tuple[_Search, _Search]:
    """Return the searches for the least ways to a cell and from it, by what runs of so many cells take."""
    layout, cells = travel.layout, len(travel.layout.kind)
    anywhere, no_time = np.ones(cells, dtype=np.bool_), np.zeros(4, dtype=np.int64)
    no_lane = np.full(cells, -1, dtype=np.int64)
    for array in (anywhere, no_time, no_lane):
        array.setflags(write=False)  # the searches are compiled for arrays like those of `Travel`
    times = np.empty(4 * cells, times_on(cells, runs, no_time))
    grid = layout.moves, anywhere, travel.offsets, runs, no_time, work_on(layout.height, layout.width, runs, no_time)

    def to(cell: int) -> NDArray[np.int64]:
        times_to(cell, times, *grid)
        return wide(times).reshape(-1, 4).min(axis=1)  # type: ignore[no-any-return]

    def back(cell: int) -> NDArray[np.int64]:
        return times_from(cell, 0, times, no_lane, *grid)  # type: ignore[no-any-return]

    return to, back
