"""What path planning needs to know of a layout."""

from __future__ import annotations

import numpy as np
import pytest

from rmfs_commands.layouts import parse_map
from rmfs_core.clock import UNREACHABLE, far
from rmfs_core.motion import Motion
from rmfs_core.traffic import Roads, roads_on
from rmfs_core.world import CellKind
from rmfs_core.world.travel import travel_on

LAYOUT = parse_map("#.#...\n......\n.qqO..\n......", "row")
ROADS = roads_on(travel_on(LAYOUT, Motion()))


def test_a_run_has_one_object() -> None:
    """Whoever asks within a run gets the same roads; those of another run write on arrays of its own."""
    travel = travel_on(LAYOUT, Motion())
    assert roads_on(travel) is roads_on(travel)
    assert roads_on(travel_on(LAYOUT, Motion())) is not roads_on(travel)


def test_passing_times_reach_across_the_grid() -> None:
    """The longest run is the longer side of the grid."""
    assert (ROADS.cells, len(ROADS.passing.common)) == (24, 7)
    tall = parse_map("#\n.\n" + ".\n" * 7, "tall")
    assert len(Roads(travel_on(tall, Motion())).passing.common) == 10
    assert ROADS.turns == (0, 625, 1250, 625)


@pytest.mark.parametrize(
    ("goal", "loaded", "storage", "queue"),
    [
        (2, False, True, False),  # without a pod under stored ones; no queue on the way to storage
        (2, True, False, False),
        (15, True, False, True),  # the station: its queue may be crossed
        (13, False, True, True),  # a place in it
    ],
)
def test_tracks_say_what_may_be_crossed(goal: int, loaded: bool, storage: bool, queue: bool) -> None:
    """It depends on the load and the goal; the floor always may, a station never."""
    tracks = ROADS.tracks(goal, loaded)
    kind = LAYOUT.kind
    assert set(tracks.passable[kind == CellKind.STORAGE].tolist()) == {storage}
    assert set(tracks.passable[kind == CellKind.QUEUE].tolist()) == {queue}
    assert set(tracks.passable[kind == CellKind.STATION].tolist()) == {False}
    assert tracks.passable[kind == CellKind.FLOOR].all()


def test_tracks_have_the_times_of_their_goal() -> None:
    """What a search is guided by are the exact times without other robots; nobody changes the arrays."""
    tracks = ROADS.tracks(2, True)
    times = ROADS.travel.times_to(2, True)
    np.testing.assert_array_equal(tracks.times, np.where(times < UNREACHABLE, times, far(tracks.times)))
    assert tracks.times[2].tolist() == [0] * 4
    assert tracks.times[1, 0] == tracks.runs[1] < ROADS.tracks(0, True).times[1, 0]
    assert (tracks.moves is LAYOUT.moves, tracks.offsets.tolist()) == (True, [1, -6, -1, 6])
    for array in (tracks.passable, tracks.times, tracks.runs, tracks.enter):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0
