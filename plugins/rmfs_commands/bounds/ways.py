"""How far, and how long, a pod must be carried at least, whatever is in the way.

Counted are the straight runs, from stop to stop along the lanes of the layout, and for times the turns between them;
every cell may be crossed, storage and queues as well. So the path from one cell to another is never longer than one by
way of a third, with pods set down and lifted in between: what is least holds for whatever detour a run makes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from rmfs_core.world.travel import Travel
from rmfs_core.world.travel_search import times_from, times_on, times_to, wide, work_on

_Search = Callable[[int], NDArray[np.int64]]


@frozen(eq=False)
class Ways:
    """The least from each cell to each station, back to storage, and from robots.

    Parameters
    ----------
    metres, ticks
        From each cell to each station. int64, shape (stations, cells).
    back_m
        From a station to a storage location, of all pairs the nearest.
    again_ticks
        From a station to another, or by way of another cell to itself, of all pairs the nearest.
    fetch_ticks
        To each cell from the robot that is nearest to it at the start. int64, shape (cells,).
    """

    metres: NDArray[np.int64]
    ticks: NDArray[np.int64]
    back_m: int
    again_ticks: int
    fetch_ticks: NDArray[np.int64]


def find_ways(travel: Travel, robots: Iterable[int]) -> Ways:
    """Return the least ways on a layout, where ``robots`` are the cells that robots start in."""
    layout = travel.layout
    metres, no_time = np.arange(len(travel.runs), dtype=np.int64), np.zeros(4, dtype=np.int64)
    to_m, from_m = _searches(travel, metres, no_time)
    to_ticks, from_ticks = _searches(travel, travel.runs, travel.turns)
    stations = [cells.station for cells in layout.stations]
    storage = list(layout.storage_locations)
    ticks = np.array([to_ticks(cell) for cell in stations])
    nearest = ticks.min(axis=0)
    on = [np.delete(from_ticks(cell) + nearest, cell).min() for cell in stations]
    return Ways(
        np.array([to_m(cell) for cell in stations]),
        ticks,
        min(int(from_m(cell)[storage].min()) for cell in stations),
        int(min(on)),
        np.min([from_ticks(cell) for cell in sorted(set(robots))], axis=0),
    )


def _searches(travel: Travel, runs: NDArray[np.int64], turns: NDArray[np.int64]) -> tuple[_Search, _Search]:
    """Return the searches for the least ways to a cell and from it, by what runs of so many cells and turns take."""
    layout, cells = travel.layout, len(travel.layout.kind)
    anywhere, no_lane = np.ones(cells, dtype=np.bool_), np.full(cells, -1, dtype=np.int64)
    for array in (anywhere, runs, turns, no_lane):
        array.setflags(write=False)  # the searches are compiled for arrays like those of `Travel`
    times = np.empty(4 * cells, times_on(cells, runs, turns))
    grid = layout.moves, anywhere, travel.offsets, runs, turns, work_on(layout.height, layout.width, runs, turns)

    def to(cell: int) -> NDArray[np.int64]:
        times_to(cell, times, *grid)
        return wide(times).reshape(-1, 4).min(axis=1)  # type: ignore[no-any-return]

    def back(cell: int) -> NDArray[np.int64]:
        headings = range(4 if turns.any() else 1)
        return np.min([times_from(cell, heading, times, no_lane, *grid) for heading in headings], axis=0)  # type: ignore[no-any-return]

    return to, back
