"""Random trips: as many starts and goals as robots, all different, each goal in reach of its start."""

from __future__ import annotations

import numpy as np

from rmfs_commands.plan.movingai import Trip
from rmfs_core.clock import UNREACHABLE
from rmfs_core.errors import InputError
from rmfs_core.randomness import stream
from rmfs_core.wording import counted
from rmfs_core.world import CellKind
from rmfs_traffic import Roads


def random_trips(roads: Roads, robots: int, seed: int, place: str) -> tuple[Trip, ...]:
    """Draw trips between storage locations, or between floor cells on a map that has too few of them.

    Robots that stand in storage locations leave the aisles to the others, so that everyone gets through.

    Raises
    ------
    InputError
        When the map has too few cells for so many robots.
    """
    layout = roads.layout
    storage, floor = (np.flatnonzero(layout.kind == kind) for kind in (CellKind.STORAGE, CellKind.FLOOR))
    places = storage if len(storage) >= 2 * robots else np.concatenate([storage, floor])
    rng = stream(seed, "trips")
    cells = [int(cell) for cell in rng.permutation(np.sort(places))]
    trips: list[Trip] = []
    while len(trips) < robots and cells:
        goal = cells.pop()
        times = roads.travel.times_to(goal, False)
        start = next((cell for cell in reversed(cells) if times[cell].max() < UNREACHABLE), None)
        if start is not None:
            cells.remove(start)
            trips.append(Trip(start, goal))
    if len(trips) < robots:
        raise InputError(
            place,
            f"found starts and goals for {counted(len(trips), 'robot')}; expected {robots}",
        )
    return tuple(trips)
