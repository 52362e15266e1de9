"""The compiled searches, called as `travel` does, on a grid small enough to work out by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from rmfs_commands.layouts import parse_map
from rmfs_core.motion import Motion
from rmfs_core.world import EAST, NORTH, SOUTH, WEST, Layout, travel_search
from rmfs_core.world.travel_search import FAR, Work, descend, times_near, times_on, wide, work_on

LAYOUT = parse_map("....\n.@@.\n.##.", "horseshoe")
"""A way round a wall; cells 9 and 10 are storage locations between its ends."""


def column(*values: int) -> NDArray[np.int64]:
    """Return whole numbers as an array that is read-only, as those are that the searches are compiled for."""
    array = np.array(values, dtype=np.int64)
    array.setflags(write=False)
    return array


OFFSETS = column(1, -4, -1, 4)
RUNS = column(0, 10, 14, 17, 20, 22)
"""A long run takes less time than short ones after each other, as with acceleration."""
TURNS = column(0, 3, 6, 3)
LANE = column(*[-1] * 12)


def floor_of(layout: Layout, *but: int) -> NDArray[np.bool_]:
    """Return which cells may be crossed: all but the walls and some."""
    cells: NDArray[np.bool_] = layout.kind > 0
    cells[list(but)] = False
    cells.setflags(write=False)
    return cells


def grid(crossed: NDArray[np.bool_]) -> tuple[NDArray[np.int64] | NDArray[np.int8] | NDArray[np.bool_], ...]:
    """Return what all searches are handed: moves, passable cells, offsets, runs and turns."""
    return LAYOUT.moves, crossed, OFFSETS, RUNS, TURNS


WORK = work_on(3, 4, RUNS, TURNS)


def times_to(goal: int, *arrays: Any) -> NDArray[np.int64]:
    """Return the ticks of the search of that name by cell and heading, on memory of its own."""
    times = np.empty(4 * len(arrays[0]), times_on(len(arrays[0]), *arrays[3:5]))
    travel_search.times_to(goal, times, *arrays)
    return wide(times).reshape(-1, 4)  # type: ignore[no-any-return]


def times_from(start: int, heading: int, lane: NDArray[np.int64], *arrays: Any) -> NDArray[np.int64]:
    """Return the ticks of the search of that name by cell, as `times_to` does."""
    times = np.empty(4 * len(arrays[0]), times_on(len(arrays[0]), *arrays[3:5]))
    return travel_search.times_from(start, heading, times, lane, *arrays)  # type: ignore[no-any-return]


def test_whole_runs_and_turns_are_added_up() -> None:
    """From the south-west to the south-east corner: north two, east three, south two, and two turns in between."""
    times = times_to(11, *grid(floor_of(LAYOUT, 9, 10)), WORK)
    assert times[8, NORTH] == 14 + 3 + 17 + 3 + 14
    assert times[8, SOUTH] == 6 + times[8, NORTH]
    assert times[8, EAST] == 3 + times[8, NORTH]
    assert times[11].tolist() == [0, 0, 0, 0]


def test_a_cell_that_is_not_passable_is_an_end_only() -> None:
    """Straight through the storage locations it is one run; where they may not be crossed, one is still a goal."""
    assert times_to(11, *grid(floor_of(LAYOUT)), WORK)[8, EAST] == 17
    blocked = times_to(9, *grid(floor_of(LAYOUT, 9, 10)), WORK)
    assert blocked[8, EAST] == 10
    assert blocked[11, WEST] == blocked[11, NORTH] + 3  # round the wall, not over cell 10
    assert blocked[11, NORTH] == 14 + 3 + 17 + 3 + 14 + 3 + 10


def test_a_search_for_who_is_near_ends_early() -> None:
    """Ways are as long as that from the state and some ticks; what is on none of them has what is left there."""
    arrays, times = grid(floor_of(LAYOUT, 9, 10)), np.zeros(48, dtype=np.int32)
    right, table = times_to(11, *arrays, WORK), times.reshape(-1, 4)
    assert times_near(11, times, 4 * 3 + SOUTH, 4, *arrays, WORK) == 14 + 4
    assert table[[3, 11], SOUTH].tolist() == [14, 0]
    assert table[7].tolist() == [
        18 - 10 - 3,
        18 - 10 - 6,
        18 - 10 - 3,
        18 - 10,
    ]  # a cell of 2 ticks, a stop of 8, turns
    assert table[2].tolist() == [0, 18 - 10 - 6, 18 - 10 - 3, 18 - 10 - 6]  # turned to the west first
    assert table[0, WEST] == 18 - 14 - 3
    assert times_near(11, times, 4 * 8 + NORTH, 50, *arrays, WORK) == right[8, NORTH] + 50
    assert (table[[8, 4, 0, 1, 2, 3]] == right[[8, 4, 0, 1, 2, 3]]).any(axis=1).all()
    assert times_near(8, times, 4 * 5, 50, *arrays, WORK) == FAR
    assert (wide(times).reshape(-1, 4) == times_to(8, *arrays, WORK)).all()


def test_what_cannot_be_reached_is_far() -> None:
    """Walls, and what lies behind them."""
    times = times_to(8, *grid(floor_of(LAYOUT)), WORK)
    assert (times[5] == FAR).all()
    cut = parse_map("..@.", "cut")
    far = times_to(0, cut.moves, floor_of(cut), column(1, -4, -1, 4), RUNS, TURNS, work_on(1, 4, RUNS, TURNS))
    assert far[1].tolist() == [10 + 6, 10 + 3, 10, 10 + 3]
    assert (far[3] == FAR).all()


def test_forward_and_backward_searches_agree() -> None:
    """From each cell with each heading to each cell: the fastest arrival, whatever the heading there."""
    crossed = floor_of(LAYOUT)
    cells = [int(cell) for cell in np.flatnonzero(crossed)]
    to = {goal: times_to(goal, *grid(crossed), WORK) for goal in cells}
    for start in cells:
        for heading in range(4):
            forward = times_from(start, heading, LANE, *grid(crossed), WORK)
            assert [forward[goal] for goal in cells] == [to[goal][start, heading] for goal in cells]


def test_a_queue_is_not_entered_on_the_way_elsewhere() -> None:
    """Searching forwards, cells of another lane end every run; those of one's own do not."""
    row = parse_map(".....", "row")
    lane = column(-1, -1, 0, -1, -1)
    arrays = row.moves, floor_of(row), column(1, -5, -1, 5), RUNS, TURNS, work_on(1, 5, RUNS, TURNS)
    assert times_from(0, EAST, lane, *arrays).tolist() == [0, 10, FAR, FAR, FAR]
    assert times_from(2, EAST, lane, *arrays).tolist() == [6 + 14, 6 + 10, 0, 10, 14]


def test_a_path_is_read_off_the_table() -> None:
    """The ends of its runs; of equally fast paths the one that goes on ahead, and stops first."""
    crossed = floor_of(LAYOUT, 9, 10)
    table = times_to(11, *grid(crossed), WORK)
    table.setflags(write=False)
    assert descend(8, NORTH, 11, table, *grid(crossed)).tolist() == [0, 3, 11]
    assert descend(11, NORTH, 11, table, *grid(crossed)).tolist() == []
    with pytest.raises(ValueError, match="the table of times does not belong to this goal"):
        descend(8, NORTH, 9, table, *grid(crossed))


@pytest.mark.parametrize(("speed", "width"), [(1.5, 4), (0.0001, 8)])
def test_times_take_eight_bytes_where_four_are_too_few(speed: float, width: int) -> None:
    """A drive of weeks is as exact as one of seconds."""
    motion = Motion(top_speed_m_per_s=speed)
    runs, turns = column(*map(motion.run_ticks, range(120))), column(*(motion.turn_ticks(0, h) for h in range(4)))
    work: Work = work_on(1, 120, runs, turns)
    assert np.dtype(times_on(120, runs, turns)).itemsize == width
    row = parse_map("." * 120, "row")
    times = times_to(0, row.moves, floor_of(row), column(1, -120, -1, 120), runs, turns, work)
    assert times[119].tolist() == [runs[119] + turns[2], runs[119] + turns[1], runs[119], runs[119] + turns[1]]


@pytest.mark.parametrize("acceleration_m_per_s2", [0.2, 1.0, 50.0])
def test_runs_that_are_left_out_are_the_fastest_nowhere(acceleration_m_per_s2: float) -> None:
    """On open floor the times are those of all runs there are, however fast robots speed up: no time falls by a run."""
    floor = parse_map("\n".join(["." * 20] * 12), "floor")
    motion = Motion(acceleration_m_per_s2=acceleration_m_per_s2)
    runs, turns = column(*map(motion.run_ticks, range(21))), column(*(motion.turn_ticks(0, h) for h in range(4)))
    arrays = floor.moves, floor_of(floor), column(1, -20, -1, 20), runs, turns, work_on(12, 20, runs, turns)
    times = times_to(87, *arrays)
    for cell, heading in np.ndindex(240, 4):
        at, length = cell, 0
        while (after := floor.neighbour(at, heading)) is not None:
            at, length = after, length + 1
            assert times[cell, heading] <= runs[length] + times[at, heading]
        assert all(times[cell, heading] <= turns[(h - heading) % 4] + times[cell, h] for h in range(4))
    assert (times_from(87, EAST, column(*[-1] * 240), *arrays) > 0).sum() == 239


@pytest.mark.parametrize("runs", [RUNS, column(0, 10, 20, 29, 39, 49)], ids=["curved", "straight, rounded"])
@pytest.mark.parametrize("seed", range(4))
def test_against_a_search_that_leaves_nothing_out(seed: int, runs: NDArray[np.int64]) -> None:
    """On random maps: a search over all turns, each with each run after it, and no limits, finds the same times."""
    rng = np.random.default_rng(seed)
    rows = ["".join(rng.choice([".", "@", "#"], 6, p=[0.7, 0.2, 0.1])) for _ in range(6)]
    layout = parse_map("\n".join(rows), "random")
    crossed = layout.kind == layout.kind[rows[0].index(".") if "." in rows[0] else 0]
    crossed.setflags(write=False)
    arrays = layout.moves, crossed, column(1, -6, -1, 6), runs, TURNS
    work, lane, near = work_on(6, 6, runs, TURNS), column(*[-1] * 36), np.zeros(144, dtype=np.int32)
    for goal in np.flatnonzero(layout.kind).tolist():
        times = times_to(goal, *arrays, work)
        assert (times == plain_times_to(goal, *arrays)).all()
        for start, heading in np.ndindex(36, 4):
            if crossed[start] and crossed[goal]:
                assert times_from(start, heading, lane, *arrays, work)[goal] == times[start, heading]
        start = int(rng.choice(np.flatnonzero(crossed)))
        spare = int(rng.choice([0, 7, 60]))
        within = times_near(goal, near, 4 * start + EAST, spare, *arrays, work)
        assert within == (times[start, EAST] + spare if times[start, EAST] < FAR else FAR)
        there, table = plain_times_from(start, EAST, goal, *arrays), wide(near).reshape(-1, 4)
        assert (table <= times).all()
        assert ((table == times) | (table + there >= within)).all()


def plain_times_from(
    start: int, heading: int, goal: int, moves: Any, passable: Any, offsets: Any, runs: Any, turns: Any
) -> NDArray[np.int64]:
    """Relax every turn and every run, on the way to a goal, until nothing falls any more."""
    times = np.full((len(moves), 4), FAR)
    times[start, heading] = 0
    while True:
        before = times.copy()
        for cell, facing in np.ndindex(times.shape):
            for towards in range(4):
                turned = int(turns[(towards - facing) % 4]) + times[cell, facing]
                times[cell, towards] = min(times[cell, towards], turned)
            at, length = cell, 0
            while (passable[at] or at == start) and moves[at] >> facing & 1:
                at, length = at + offsets[facing], length + 1
                if passable[at] or at == goal:
                    times[at, facing] = min(times[at, facing], times[cell, facing] + runs[length])
        if (times == before).all():
            return times


def plain_times_to(goal: int, moves: Any, passable: Any, offsets: Any, runs: Any, turns: Any) -> NDArray[np.int64]:
    """Relax every turn with every run after it until nothing falls any more."""
    times = np.full((len(moves), 4), FAR)
    times[goal] = 0
    while True:
        before = times.copy()
        for cell, heading in np.ndindex(times.shape):
            for towards in range(4):
                at, length = cell, 0
                turned = int(turns[(towards - heading) % 4])
                times[cell, heading] = min(times[cell, heading], turned + times[cell, towards])
                while moves[at] >> towards & 1:
                    at, length = at + offsets[towards], length + 1
                    if not (passable[at] or at == goal):
                        break
                    times[cell, heading] = min(times[cell, heading], turned + runs[length] + times[at, towards])
        if (times == before).all():
            return times
