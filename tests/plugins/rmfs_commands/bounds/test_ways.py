"""The least ways, by hand and against driving times."""

from __future__ import annotations

import numpy as np

from rmfs_commands.bounds.ways import find_ways
from rmfs_commands.testing import small_layout
from rmfs_core.clock import UNREACHABLE
from rmfs_core.motion import Motion
from rmfs_core.world import Layout, parse_map
from rmfs_core.world.travel import travel_on

LANE = parse_map("#.....qO\n#..@@...", "lane")
"""Two storage locations in the west, the station in the east with its way out below."""


def test_by_hand() -> None:
    """7 and 8 cells to the station, in one run of 7 / 1.5 + 1.5 s, or two; 9 cells back, by the row below."""
    ways = find_ways(travel_on(LANE, Motion()))
    north, south = LANE.storage_locations
    assert ways.metres[0, [north, south]].tolist() == [7, 8]
    assert ways.ticks[0, [north, south]].tolist() == [6167, 6167 + 2000]
    assert ways.back_m == 9


def distances_driven(layout: Layout) -> list[tuple[int, int]]:
    """Return the metres of a fastest path with a pod from each storage location, and the cells it goes between."""
    travel, station = travel_on(layout, Motion()), layout.stations[0].station
    found = []
    for cell in layout.storage_locations:
        at, metres = cell, 0
        for leg in travel.fastest_path(cell, 1, station, loaded=True):
            metres += layout.distance(at, leg.to)
            at = leg.to
        found.append((cell, metres))
    return found


def test_no_drive_is_shorter() -> None:
    """Whatever the heading, no drive with a pod takes less time or fewer metres than the least."""
    layout = small_layout(2)
    travel = travel_on(layout, Motion())
    ways = find_ways(travel)
    for station, cells in enumerate(layout.stations):
        driven = travel.times_to(cells.station, True).min(axis=1)
        assert (ways.ticks[station] <= driven).all()
        assert (driven[list(layout.storage_locations)] < UNREACHABLE).all()
    assert all(ways.metres[0, cell] <= metres for cell, metres in distances_driven(layout))
    assert np.median([ways.metres[0, cell] / metres for cell, metres in distances_driven(layout)]) > 0.75
