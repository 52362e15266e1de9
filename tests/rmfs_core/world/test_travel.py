"""Travel times and fastest paths."""

import heapq
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rmfs_commands.plan.movingai import open_layout
from rmfs_commands.testing import small_layout
from rmfs_core.clock import UNREACHABLE, far
from rmfs_core.motion import Motion
from rmfs_core.scenario.model import LayoutSection
from rmfs_core.world import EAST, NORTH, WEST, CellKind, Layout, block_map, parse_map
from rmfs_core.world.travel import SPARE_TICKS, Travel, travel_on

OPEN = parse_map("#......#\n........\n..qO....\n........", "open")


def forward(
    layout: Layout, motion: Motion, start: int, heading: int, goal: int, loaded: bool
) -> Iterator[tuple[int, int, int]]:
    """Plain search on the way to a goal, as slow as it is simple: ticks, cell and heading, the nearest first."""

    def passable(cell: int) -> bool:
        kind = layout.kind[cell]
        if kind == CellKind.FLOOR or (kind == CellKind.STORAGE and not loaded):
            return True
        return bool(layout.lane[cell] >= 0 and layout.lane[cell] == layout.lane[goal])

    def moves(cell: int, heading: int) -> list[tuple[int, int, int]]:
        found = [(cell, h, motion.turn_ticks(heading, h)) for h in range(4) if h != heading]
        if passable(cell) or cell == start:
            at, length = cell, 0
            while layout.may_step(at, heading):
                at = layout.neighbour(at, heading)  # type: ignore[assignment]
                length += 1
                if not passable(at) and at != goal:
                    break
                found.append((at, heading, motion.run_ticks(length)))
                if at == goal and not passable(at):
                    break
        return found

    times = {(start, heading): 0}
    queue = [(0, start, heading)]
    while queue:
        time, cell, towards = heapq.heappop(queue)
        if time > times[cell, towards]:
            continue
        yield time, cell, towards
        for after, h, ticks in moves(cell, towards):
            if time + ticks < times.get((after, h), UNREACHABLE):
                times[after, h] = time + ticks
                heapq.heappush(queue, (time + ticks, after, h))


def dijkstra(layout: Layout, motion: Motion, goal: int, loaded: bool) -> dict[tuple[int, int], int]:
    """Return the ticks from every third cell, with every heading: the oracle of the compiled tables."""

    def shortest(start: int, heading: int) -> int:
        found = forward(layout, motion, start, heading, goal, loaded)
        return next((time for time, cell, _ in found if cell == goal), UNREACHABLE)

    cells = range(0, layout.width * layout.height, 3)
    return {(c, h): shortest(c, h) for c in cells if layout.kind[c] != CellKind.WALL for h in range(4)}


def test_a_straight_run_costs_no_turn() -> None:
    """Seven cells straight ahead take 7/1.5 + 1.5 s; facing the other way costs half a turn more."""
    travel = Travel(OPEN, Motion())
    assert travel.ticks(0, EAST, 7, loaded=False) == 6167
    assert travel.ticks(0, WEST, 7, loaded=False) == 6167 + 1250


def test_the_way_to_a_station_is_the_shortest_through_its_queue() -> None:
    """With RAWSim-O's queue 7 m from the aisle and 5 m from the ring in place of 13 m; to a place in line likewise."""

    def metres(queue: str, row: int, place: int) -> int:
        layout = parse_map(block_map(LayoutSection(queue=queue), 12), "map")
        travel, cells = Travel(layout, Motion()), layout.stations[0]
        start, goal = cells.queue[-1] - 1 + row * layout.width, cells.slot(place)
        way = [start, *(leg.to for leg in travel.fastest_path(start, EAST, goal, loaded=True))]
        return sum(layout.distance(cell, to) for cell, to in pairwise(way))

    assert [metres("plain", 0, place) for place in (0, 1, 4, 8, 12)] == [13, 12, 9, 5, 1]
    assert [metres("shortcut", 0, place) for place in (0, 1, 4, 8, 12)] == [7, 6, 9, 5, 1]
    assert [metres("shortcut", 2, place) for place in (0, 1, 4)] == [5, 4, 1]


def test_a_pod_is_not_carried_over_storage_locations() -> None:
    """With a storage location in between, a loaded robot takes the aisle below; an empty one drives straight on."""
    layout = parse_map("##.#.\n.....\n.qO..\n.....", "row")
    travel = Travel(layout, Motion())
    empty, loaded = travel.ticks(0, EAST, 3, loaded=False), travel.ticks(0, EAST, 3, loaded=True)
    assert empty == Motion().run_ticks(3)
    assert loaded > empty


@pytest.mark.parametrize(
    ("goal_kind", "loaded"),
    [
        (CellKind.STORAGE, False),
        (CellKind.STORAGE, True),
        (CellKind.STATION, True),
        (CellKind.QUEUE, True),
        (CellKind.FLOOR, True),
    ],
)
def test_tables_equal_a_plain_search(goal_kind: CellKind, loaded: bool) -> None:
    """Backward tables give the same ticks as a plain forward search from every third cell, with every heading."""
    layout = small_layout(block_columns=1)
    motion = Motion()
    goal = int((layout.kind == goal_kind).nonzero()[0][-1])
    table = Travel(layout, motion).times_to(goal, loaded)
    for (cell, heading), ticks in dijkstra(layout, motion, goal, loaded).items():
        starts_in_queue = layout.lane[cell] >= 0 and layout.lane[cell] != layout.lane[goal]
        if not (starts_in_queue and not loaded):
            assert table[cell, heading] == ticks, (cell, heading)


def test_times_from_a_station_equal_times_to_each_location() -> None:
    """Searching forwards from a station or backwards from a storage location gives the same ticks."""
    layout = small_layout()
    travel = Travel(layout, Motion())
    station = layout.stations[0].station
    times = travel.times_from(station, WEST, loaded=True)
    for location in layout.storage_locations:
        assert times[location] == travel.ticks(station, WEST, location, loaded=True)


@given(data=st.data())
@settings(deadline=None)
def test_a_table_for_who_is_near_is_right_as_far_as_it_says(data: st.DataObject) -> None:
    """Its times are those of the whole table, or too low where the way there and on takes the ticks that it says."""
    layout = small_layout(stations=2)
    whole, travel = Travel(layout, Motion()), Travel(layout, Motion())
    places = st.sampled_from(layout.storage_locations)
    for _ in range(2):  # nothing is left of the search before
        cell, heading, goal = data.draw(places), data.draw(st.integers(0, 3)), data.draw(places)
        loaded, spare_ticks = data.draw(st.booleans()), data.draw(st.sampled_from([0, SPARE_TICKS, 20_000]))
        right = whole.times_to(goal, loaded)
        table, within = travel.times_near(cell, heading, goal, loaded, spare_ticks)
        assert within == right[cell, heading] + spare_ticks
        assert (table <= right).all()
        there = np.full_like(right, UNREACHABLE)
        for ticks, *state in forward(layout, travel.motion, cell, heading, goal, loaded):
            there[tuple(state)] = ticks
        assert ((table == right) | (table + there >= within)).all()


def test_who_is_near_is_given_a_whole_table_that_is_there() -> None:
    """A table that is kept, and any of a station, is whole."""
    travel = Travel(small_layout(), Motion())
    first, second = travel.layout.storage_locations[:2]
    kept, station = travel.ways_to(first, True), travel.layout.stations[0].station
    assert travel.times_near(second, 0, first, True) == (kept, UNREACHABLE)
    assert travel.times_near(second, 0, station, True) == (travel.ways_to(station, True), UNREACHABLE)


def test_a_table_of_what_is_near_outlasts_those_of_other_cells() -> None:
    """It is written over by the next of its kind alone."""
    travel = Travel(small_layout(), Motion())
    first, second, third = travel.layout.storage_locations[:3]
    near, _ = travel.times_near(first, 0, second, True)
    before = near.copy()
    travel.times_to(third, True), travel.ways_to(third, True), travel.times_from(third, 0, True)
    assert (near == before).all()


def test_nothing_is_longer_than_a_long_way() -> None:
    """With as many ticks to spare as four bytes hold, all times are right."""
    travel = Travel(small_layout(), Motion())
    first, second = travel.layout.storage_locations[:2]
    near, within = travel.times_near(first, 0, second, True, (1 << 31) - 1)
    assert within == UNREACHABLE
    assert (near == travel.ways_to(second, True)).all()


def test_a_run_may_be_longer_than_two_bytes_count() -> None:
    """65,536 cells straight on, and one aside; on a layout that no map may have."""
    width = 65_537
    free = np.array([[True] * width, [False] * (width - 1) + [True]])
    travel, motion = Travel(open_layout(free), Motion()), Motion()
    ticks = motion.run_ticks(1) + motion.turn_ticks(NORTH, WEST) + motion.run_ticks(width - 1)
    assert travel.ticks(2 * width - 1, NORTH, 0, True) == ticks


@given(stops=st.lists(st.tuples(st.integers(0, 30), st.integers(0, 3)), min_size=1, max_size=6), loaded=st.booleans())
@settings(deadline=None)
def test_the_nearest_stop_is_that_of_the_fewest_ticks(stops: list[tuple[int, int]], loaded: bool) -> None:
    """Of equally near ones the first in the list."""
    travel = Travel(small_layout(), Motion())
    places = travel.layout.storage_locations
    goal, stops = places[-1], [(places[i % len(places)], heading) for i, heading in stops]
    ticks = [travel.ticks(*stop, goal, loaded) for stop in stops]
    assert Travel(travel.layout, travel.motion).nearest(stops, goal, loaded) == ticks.index(min(ticks))


def test_stops_without_a_way_are_not_the_nearest() -> None:
    """A wall between is farther than any way; where there are walls on all sides the first is as good as any."""
    layout = parse_map("#@#..\n.@.qO\n.@...", "split")
    travel = Travel(layout, Motion())
    assert travel.nearest([(0, EAST), (7, NORTH)], 2, loaded=True) == 1
    assert travel.nearest([(5, EAST), (0, NORTH)], 2, loaded=True) == 0


@pytest.mark.parametrize("loaded", [True, False])
def test_paths_read_the_same_times_as_rules(loaded: bool) -> None:
    """In fewer bytes, and with a number of their own where there is no way."""
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
    """The legs of a path are possible runs, and their times add up to the table's."""
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
    """Diagonals, wrong ways and loaded runs over storage locations have a reason each."""
    layout = small_layout()
    travel = Travel(layout, Motion())
    a, b, c = layout.storage_locations[:3]
    assert "no straight run" in str(travel.run_problem(a, a, b + layout.width, a, loaded=True))
    assert "may not pass" in str(travel.run_problem(a, a, c, c, loaded=True))
    assert travel.run_problem(a, a, c, c, loaded=False) is None
    assert "no robot may go" in str(travel.run_problem(0, 0, 1, 1, loaded=False))


def test_tables_are_kept_within_their_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    """When the tables outgrow their memory the least recently used go, and are right when computed again."""
    layout = small_layout()
    travel = Travel(layout, Motion())
    first = travel.times_to(layout.storage_locations[0], False).copy()
    monkeypatch.setattr("rmfs_core.world.travel.TABLES_BYTES", first.nbytes * 3)
    tables = {location: travel.times_to(location, False) for location in layout.storage_locations}
    kept = [location for location in reversed(tables) if travel.times_to(location, False) is tables[location]]
    assert kept == list(reversed(tables))[:3]
    assert (travel.times_to(layout.storage_locations[0], False) == first).all()


def test_runs_share_tables_and_no_array_that_a_search_writes_on() -> None:
    """What one run found near a goal stays while another run, perhaps of another thread, looks elsewhere."""
    layout = small_layout()
    one, other = travel_on(layout, Motion()), travel_on(layout, Motion())
    station, near, far_off = layout.stations[0].station, layout.storage_locations[0], layout.storage_locations[-1]
    times, _ = one.times_near(station, 0, near, True)
    found = times.copy()
    other.times_near(station, 0, far_off, True)
    assert (times == found).all()
    assert one.times_to(near, False) is other.times_to(near, False)


def test_no_way_is_said() -> None:
    """Asking for a path where there is none is an error that names both places."""
    layout = parse_map("#.@#\n.qO.\n....\n@@@@\n#...", "split")
    with pytest.raises(ValueError, match="no way from row 1, column 1 to row 5, column 1"):
        Travel(layout, Motion()).fastest_path(0, NORTH, 16, loaded=False)
