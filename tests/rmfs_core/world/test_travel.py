"""Travel times and fastest paths; the compiled searches on grids small enough to work out by hand."""

import heapq
from collections.abc import Iterator
from itertools import pairwise, product
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from cases import cases
from rmfs_commands.layouts import block_map, parse_map
from rmfs_commands.plan.movingai import open_layout
from rmfs_commands.testing import small_layout
from rmfs_core.clock import UNREACHABLE, far
from rmfs_core.motion import Motion
from rmfs_core.scenario.model import LayoutSection
from rmfs_core.world import EAST, NORTH, WEST, CellKind
from rmfs_core.world.travel import SPARE_TICKS, Travel, travel_on
from rmfs_core.world.travel_search import wide

OPEN = parse_map("#......#\n........\n..qO....\n........", "open")


def arrays_to(goal: int, travel: Travel, loaded: bool) -> tuple[Any, ...]:
    """Return what the plain searches are handed: moves, the cells on the way to a goal, offsets, runs and turns."""
    layout, kind = travel.layout, travel.layout.kind
    floor = (kind == CellKind.FLOOR) | ((kind == CellKind.STORAGE) & (not loaded))
    own_lane = (layout.lane >= 0) & (layout.lane == layout.lane[goal])
    return layout.moves, floor | own_lane, travel.offsets, travel.runs, travel.turns


def test_ways_by_hand() -> None:
    travel = Travel(OPEN, Motion())
    assert travel.ticks(0, EAST, 7, loaded=False) == 6167
    assert travel.ticks(0, WEST, 7, loaded=False) == 6167 + 1250

    def metres(queue: str, row: int, place: int) -> int:
        layout = parse_map(block_map(LayoutSection(queue=queue), 12), "map")
        travel, cells = Travel(layout, Motion()), layout.stations[0]
        start, goal = cells.queue[-1] - 1 + row * layout.width, cells.slot(place)
        way = [start, *(leg.to for leg in travel.fastest_path(start, EAST, goal, loaded=True))]
        return sum(layout.distance(cell, to) for cell, to in pairwise(way))

    assert [metres("plain", 0, place) for place in (0, 1, 4, 8, 12)] == [13, 12, 9, 5, 1]
    assert [metres("shortcut", 0, place) for place in (0, 1, 4, 8, 12)] == [7, 6, 9, 5, 1]
    assert [metres("shortcut", 2, place) for place in (0, 1, 4)] == [5, 4, 1]
    layout = parse_map("##.#.\n.....\n.qO..\n.....", "row")
    travel = Travel(layout, Motion())
    empty, loaded = travel.ticks(0, EAST, 3, loaded=False), travel.ticks(0, EAST, 3, loaded=True)
    assert empty == Motion().run_ticks(3)
    assert loaded > empty


@cases(
    "goal_kind loaded",
    (CellKind.STORAGE, False),
    (CellKind.STORAGE, True),
    (CellKind.STATION, True),
    (CellKind.QUEUE, True),
    (CellKind.FLOOR, True),
)
def test_tables_equal_a_plain_search(goal_kind: CellKind, loaded: bool) -> None:
    layout = small_layout(block_columns=1)
    goal = int((layout.kind == goal_kind).nonzero()[0][-1])
    travel = Travel(layout, Motion())
    expected = plain_times_to(goal, *arrays_to(goal, travel, loaded))
    starts_in_queue = (layout.lane >= 0) & (layout.lane != layout.lane[goal])
    asked = (layout.kind != CellKind.WALL) & (loaded | ~starts_in_queue)
    np.testing.assert_array_equal(travel.times_to(goal, loaded)[asked], expected[asked])


def test_tables_of_what_is_near() -> None:
    travel = Travel(small_layout(), Motion())
    first, second = travel.layout.storage_locations[:2]
    kept, station = travel.ways_to(first, True), travel.layout.stations[0].station
    assert travel.times_near(second, 0, first, True) == (kept, UNREACHABLE)
    assert travel.times_near(second, 0, station, True) == (travel.ways_to(station, True), UNREACHABLE)
    travel = Travel(small_layout(), Motion())
    first, second, third = travel.layout.storage_locations[:3]
    near, _ = travel.times_near(first, 0, second, True)
    before = near.copy()
    travel.times_to(third, True), travel.ways_to(third, True), travel.times_from(third, 0, True)
    assert (near == before).all()


def test_long_ways_and_runs() -> None:
    travel = Travel(small_layout(), Motion())
    first, second = travel.layout.storage_locations[:2]
    near, within = travel.times_near(first, 0, second, True, (1 << 31) - 1)
    assert within == UNREACHABLE
    assert (near == travel.ways_to(second, True)).all()
    width = 65_537
    free = np.array([[True] * width, [False] * (width - 1) + [True]])
    travel, motion = Travel(open_layout(free), Motion()), Motion()
    ticks = motion.run_ticks(1) + motion.turn_ticks(NORTH, WEST) + motion.run_ticks(width - 1)
    assert travel.ticks(2 * width - 1, NORTH, 0, True) == ticks


@given(stops=st.lists(st.tuples(st.integers(0, 30), st.integers(0, 3)), min_size=1, max_size=6), loaded=st.booleans())
@settings(deadline=None)
def test_the_nearest_stop_is_that_of_the_fewest_ticks(stops: list[tuple[int, int]], loaded: bool) -> None:
    travel = Travel(small_layout(), Motion())
    places = travel.layout.storage_locations
    goal, stops = places[-1], [(places[i % len(places)], heading) for i, heading in stops]
    ticks = [travel.ticks(*stop, goal, loaded) for stop in stops]
    assert Travel(travel.layout, travel.motion).nearest(stops, goal, loaded) == ticks.index(min(ticks))


def test_no_way_is_said() -> None:
    layout = parse_map("#@#..\n.@.qO\n.@...", "split")
    travel = Travel(layout, Motion())
    assert travel.nearest([(0, EAST), (7, NORTH)], 2, loaded=True) == 1
    assert travel.nearest([(5, EAST), (0, NORTH)], 2, loaded=True) == 0
    travel, lane = Travel(OPEN, Motion()), OPEN.lane >= 0  # which nobody drives through, but from
    assert (travel.times_from(0, EAST, loaded=True)[lane] == UNREACHABLE).all()
    (own,) = OPEN.stations
    for start, goal in ((own.station, 0), (own.queue[-1], own.station)):
        assert travel.times_from(start, EAST, loaded=True)[goal] == travel.ticks(start, EAST, goal, loaded=True)
    layout = parse_map("#.@#\n.qO.\n....\n@@@@\n#...", "split")
    with pytest.raises(ValueError, match="no path from row 1, column 1 to row 5, column 1"):
        Travel(layout, Motion()).fastest_path(0, NORTH, 16, loaded=False)


@pytest.mark.parametrize("loaded", [True, False])
def test_paths_read_the_same_times_as_rules(loaded: bool) -> None:
    layout = parse_map("#@#..\n.@.qO\n.@...", "split")
    travel = Travel(layout, Motion())
    for goal in (2, 9, 13):
        ways, times = travel.ways_to(goal, loaded), travel.times_to(goal, loaded)
        assert ways.itemsize == 4 < times.itemsize
        assert (np.where(ways >= far(ways), UNREACHABLE, ways.astype(np.int64)) == times).all()
        assert (times[0] == UNREACHABLE).all()


@given(data=st.data())
@settings(deadline=None)
def test_fastest_paths_take_the_time_of_the_table(data: st.DataObject) -> None:
    layout = small_layout(stations=2)
    travel = Travel(layout, Motion())
    loaded = data.draw(st.booleans())
    places = layout.storage_locations + (tuple(s.station for s in layout.stations) if loaded else ())
    start, goal = data.draw(st.sampled_from(places)), data.draw(st.sampled_from(places))
    heading = data.draw(st.integers(0, 3))
    total, at, facing = 0, start, heading
    for leg in travel.fastest_path(start, heading, goal, loaded):
        assert travel.run_problem(start, at, leg.to, goal, loaded) is None
        towards = travel.heading(at, leg.to)
        assert towards is not None
        total += travel.motion.turn_ticks(facing, towards) + travel.motion.run_ticks(layout.distance(at, leg.to))
        at, facing = leg.to, towards
    assert at == goal
    assert total == travel.ticks(start, heading, goal, loaded)


def test_impossible_runs_are_named() -> None:
    layout = small_layout()
    travel = Travel(layout, Motion())
    a, b, c = layout.storage_locations[:3]
    assert "no straight run" in str(travel.run_problem(a, a, b + layout.width, a, loaded=True))
    assert "may not pass" in str(travel.run_problem(a, a, c, c, loaded=True))
    assert travel.run_problem(a, a, c, c, loaded=False) is None
    assert "no robot may go" in str(travel.run_problem(0, 0, 1, 1, loaded=False))


def test_tables_are_shared_and_kept_within_their_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    layout = small_layout()
    travel = Travel(layout, Motion())
    first = travel.times_to(layout.storage_locations[0], False).copy()
    monkeypatch.setattr("rmfs_core.world.travel.TABLES_BYTES", first.nbytes * 3)
    tables = {location: travel.times_to(location, False) for location in layout.storage_locations}
    kept = [location for location in reversed(tables) if travel.times_to(location, False) is tables[location]]
    assert kept == list(reversed(tables))[:3]
    assert (travel.times_to(layout.storage_locations[0], False) == first).all()
    layout = small_layout()
    one, other = travel_on(layout, Motion()), travel_on(layout, Motion())
    station, near, far_off = layout.stations[0].station, layout.storage_locations[0], layout.storage_locations[-1]
    times, _ = one.times_near(station, 0, near, True)
    found = times.copy()
    other.times_near(station, 0, far_off, True)
    assert (times == found).all()
    assert one.times_to(near, False) is other.times_to(near, False)


@pytest.mark.parametrize(("speed", "turn_s", "width"), [(1.5, 2.5, 4), (0.0001, 2.5, 8), (1.5, 4800.0, 8)])
def test_times_take_eight_bytes_where_four_are_too_few(speed: float, turn_s: float, width: int) -> None:
    travel = Travel(parse_map("." * 120, "row"), Motion(top_speed_m_per_s=speed, full_turn_s=turn_s))
    runs, turns = travel.runs, travel.turns
    times = travel.ways_to(0, True)
    assert times.itemsize == width
    assert times[119].tolist() == [runs[119] + turns[2], runs[119] + turns[1], runs[119], runs[119] + turns[1]]


@pytest.mark.parametrize("acceleration_m_per_s2", [0.2, 1.0, 50.0])
@pytest.mark.parametrize("seed", range(4))
def test_against_a_search_that_leaves_nothing_out(seed: int, acceleration_m_per_s2: float) -> None:
    """Also where hardly any run is left out, or hardly any is needed."""
    rng = np.random.default_rng(seed)
    rows = ["".join(rng.choice([".", "@", "#"], 6, p=[0.7, 0.2, 0.1])) for _ in range(6)]
    layout = parse_map("\n".join(rows), "random")
    travel, cells = Travel(layout, Motion(acceleration_m_per_s2=acceleration_m_per_s2)), np.flatnonzero(layout.kind)
    for goal, loaded in product(cells.tolist(), (False, True)):
        arrays = arrays_to(goal, travel, loaded)
        times, start = travel.times_to(goal, loaded), int(rng.choice(cells))
        assert (times == plain_times_to(goal, *arrays)).all()
        for cell, heading in product(cells.tolist(), range(4)):
            assert travel.times_from(cell, heading, loaded)[goal] == times[cell, heading]
        spare = int(rng.choice([0, SPARE_TICKS, 20_000]))
        near, within = travel.times_near(start, EAST, goal, loaded, spare)
        reached = times[start, EAST] < UNREACHABLE
        assert within == (times[start, EAST] + spare if reached else UNREACHABLE)
        there, table = plain_times_from(start, EAST, goal, *arrays), wide(near.reshape(-1)).reshape(-1, 4)
        assert (table <= times).all()
        assert ((table == times) | (table + there >= within)).all()


def plain_times_from(
    start: int, heading: int, goal: int, moves: Any, passable: Any, offsets: Any, runs: Any, turns: Any
) -> NDArray[np.int64]:
    """Search on the way to a goal, as plain as it is slow: ticks by cell and heading."""

    def after(cell: int, heading: int) -> Iterator[tuple[int, int, int]]:
        yield from ((cell, h, int(turns[(h - heading) % 4])) for h in range(4))
        at, length = cell, 0
        while (passable[at] or at == start) and moves[at] >> heading & 1:
            at, length = at + int(offsets[heading]), length + 1
            if passable[at] or at == goal:
                yield at, heading, int(runs[length])

    times = np.full((len(moves), 4), UNREACHABLE)
    times[start, heading] = 0
    queue = [(0, start, heading)]
    while queue:
        time, *state = heapq.heappop(queue)
        if time == times[*state]:
            for cell, towards, ticks in after(*state):
                if time + ticks < times[cell, towards]:
                    times[cell, towards] = time + ticks
                    heapq.heappush(queue, (time + ticks, cell, towards))
    return times


def plain_times_to(goal: int, moves: Any, passable: Any, offsets: Any, runs: Any, turns: Any) -> NDArray[np.int64]:
    """Relax every turn with every run after it until nothing falls any more."""
    times = np.full((len(moves), 4), UNREACHABLE)
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
