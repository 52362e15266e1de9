"""Rules that plan paths: the fastest alone, and among others' reservations; compiled searches against plain ones."""

import heapq
import math
from unittest.mock import patch

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import plain_sipp as plain
from cases import cases
from crowds import crowd, newcomer, paper_roads, two_way
from reserving import EVEN, hold_until, stay
from rmfs_commands.layouts import parse_map
from rmfs_commands.testing import small_layout
from rmfs_core import Path
from rmfs_core.motion import Motion
from rmfs_core.world import EAST, NORTH, WEST
from rmfs_core.world.travel import Travel, travel_on
from rmfs_rules.sipp import Pbs, Sipp, compiled
from rmfs_rules.sipp.backwards import earliest
from rmfs_rules.sipp.priorities import Node, Search
from rmfs_rules.sipp.states import Problem, memory_for
from rmfs_rules.whca import WhcaN
from rmfs_rules.whca.compiled import search
from rmfs_traffic import (
    FOREVER,
    FleetTraffic,
    Occupancy,
    Query,
    Reservations,
    Roads,
    TimedPath,
    Traffic,
    occupancy,
    roads_on,
    timed_path,
)
from rmfs_traffic.searching import Asked, gap_at


@pytest.mark.parametrize("spare_ticks", [(), (0,), (0, 1_000, 10_000), (5_000,)])
def test_paths_are_the_same_with_times_of_what_is_near(spare_ticks, monkeypatch) -> None:
    monkeypatch.setattr("rmfs_rules.sipp.rule.LATER_TICKS", spare_ticks)
    roads = paper_roads()
    table, queries = crowd(roads, Sipp(), 60, 2)
    now, rng = min(query.start_tick for query in queries), np.random.default_rng(2)
    for _ in range(30):
        query = newcomer(roads, table, 1000, now, rng)
        path = Sipp().search(roads, table, query)
        fresh = Roads(Travel(roads.layout, roads.travel.motion))
        assert Sipp().plan_path(Traffic(fresh, table, query)) == path.path


CORRIDOR = parse_map("......\n@@@@@#\nqO....", "corridor")


def corridor(motion: Motion = EVEN) -> tuple[Roads, Reservations]:
    roads = roads_on(travel_on(CORRIDOR, motion))
    return roads, Reservations(roads.cells)


def test_a_cell_is_waited_for_however_long() -> None:
    """Ticks beyond 32 bits."""
    (roads, table), query = corridor(), Query(0, 0, 0, 1, 4)
    hold_until(table, 1, 1, 0, 30 * 86_400_000)
    path, expected = Sipp().search(roads, table, query), plain.search(roads, table, query)
    assert path.end_tick == expected.end_tick > 1 << 31


@pytest.mark.parametrize(("speed", "width"), [(1.0, 4), (1e-6, 8)])
def test_no_path_is_no_path_however_long_ways_take(speed: float, width: int) -> None:
    roads, query = Roads(Travel(CORRIDOR, Motion(top_speed_m_per_s=speed))), Query(0, 0, 0, 5, 4)
    assert roads.tracks(4, False).times.itemsize == width
    table = Reservations(roads.cells)
    table.hold(1, 2, 0)
    assert Sipp().plan_path(Traffic(roads, table, query)) is None
    assert Sipp().search(roads, table, query) is None


def test_who_is_there_already_stays() -> None:
    """A robot at its goal has an empty path, unless someone else has reserved the cell for later."""
    roads, table = corridor()
    path = Sipp().search(roads, table, Query(0, 3, 0, 500, 3))
    assert (path.legs, path.end_tick) == ((), 500)
    hold_until(table, 1, 3, 20_000, 21_000)
    path = Sipp().search(roads, table, Query(0, 3, 0, 500, 3))
    assert path.end_tick == 22_000


OPEN = parse_map("#.....\n....#.\n.qO...\n.#....", "open")
AISLES = parse_map(".>>>.\nv###^\n.<<<.\nqO...", "aisles")


def everything(roads: Roads, table: Reservations, query: Query, end: int) -> int | None:
    """Try every wait of a second, turn and run until a time; return the arrival. Slow, simple, and on EVEN exact."""
    layout, travel, motion = roads.layout, roads.travel, roads.travel.motion
    # A storage location is no way through for a robot with a pod
    ends = -1 if travel.passable(query.goal, query.loaded)[query.goal] else query.goal

    def free(cell: int, since: int, until: int) -> bool:
        return all(who == query.robot or b <= since or a >= until for who, a, b in table.reserved(cell))

    seen = {(query.start_tick, query.cell, query.heading)}
    queue = [*seen]
    while queue:
        tick, cell, heading = heapq.heappop(queue)
        if cell == query.goal and free(cell, tick, FOREVER):
            return tick
        if tick > end:
            return None
        if cell == ends != query.cell:
            continue
        after = [(tick + 1000, cell, heading)] if free(cell, tick, tick + 1000) else []
        for towards in range(4):
            begin, at, k = tick + motion.turn_ticks(heading, towards), cell, 0
            if not free(cell, tick, begin + 1000):
                continue
            while layout.may_step(at, towards):
                at, k = at + int(roads.offsets[towards]), k + 1
                if travel.run_problem(query.cell, cell, at, query.goal, query.loaded) is not None:
                    break
                if free(at, begin + 1000 * (k - 1), begin + 1000 * k):
                    after.append((begin + 1000 * k, at, towards))
                if at == ends or not free(at, begin + 1000 * (k - 1), begin + 1000 * (k + 1)):
                    break
        for state in after:
            if state not in seen:
                seen.add(state)
                heapq.heappush(queue, state)
    return None


def assert_valid(roads: Roads, table: Reservations, query: Query, path: TimedPath) -> None:
    """The path's legs are possible, and the table has room for what it occupies."""
    table.check(query.robot, occupancy(roads, path))
    cell = query.cell
    for leg in path.legs:
        assert leg.wait_ticks >= 0
        assert leg.to == cell or roads.travel.run_problem(query.cell, cell, leg.to, query.goal, query.loaded) is None
        cell = leg.to


@given(data=st.data())
@settings(deadline=None, max_examples=150)
def test_no_path_arrives_earlier(data: st.DataObject) -> None:
    """On whole seconds, both searches arrive exactly when the first of all possible paths does."""
    roads = roads_on(travel_on(data.draw(st.sampled_from([OPEN, AISLES])), EVEN))
    cells = [c for c in range(roads.cells) if roads.layout.kind[c] in {1, 2}]
    start, goal = data.draw(st.sampled_from(cells)), data.draw(st.sampled_from(cells))
    table = Reservations(roads.cells)
    for _ in range(data.draw(st.integers(0, 12))):
        cell = data.draw(st.sampled_from(cells))
        since = data.draw(st.integers(0, 15))
        until = since + data.draw(st.integers(1, 6))
        if table.is_free(1, stay(cell, since * 1000, until * 1000)) and cell != start:
            hold_until(table, 1, cell, since * 1000, until * 1000)
    query = Query(0, start, data.draw(st.integers(0, 3)), 0, goal, data.draw(st.booleans()))
    path, slow = Sipp().search(roads, table, query), plain.search(roads, table, query)
    assert (path is None) == (slow is None)
    if path is None or slow is None:
        assert everything(roads, table, query, 40_000) is None
        return
    assert_valid(roads, table, query, path)
    assert_valid(roads, table, query, slow)
    assert path.end_tick == slow.end_tick == everything(roads, table, query, 100_000)


@pytest.mark.parametrize("roads", [paper_roads(), two_way(paper_roads())], ids=["one-way", "two-way"])
def test_compiled_and_plain_arrive_together_in_a_crowd(roads: Roads) -> None:
    used = Sipp()
    table, queries = crowd(roads, used, 100, 3)
    now = min(query.start_tick for query in queries)
    rng = np.random.default_rng(3)
    for _ in range(20):
        query = newcomer(roads, table, 1000, now, rng)
        path, slow = used.search(roads, table, query), plain.search(roads, table, query)
        assert (None if path is None else path.end_tick) == (None if slow is None else slow.end_tick)
        assert Sipp().search(roads, table, query) == path


@given(robots=st.integers(40, 120), seed=st.integers(0, 1000))
@settings(deadline=None, max_examples=6)
def test_a_path_does_not_depend_on_what_is_over(robots: int, seed: int) -> None:
    """A table that knows nothing of the past, and of which cells came first, leads to the same path."""
    roads, planner = two_way(paper_roads()), Sipp()
    table, queries = crowd(roads, planner, robots, seed, 4)
    now = min(query.start_tick for query in queries)
    anew = Reservations(roads.cells)
    for cell in reversed(range(roads.cells)):
        for owner, since, until in table.reserved(cell):
            if until > now:
                hold_until(anew, owner, cell, max(since, now), until)
    rng = np.random.default_rng(seed)
    for _ in range(40):
        query = newcomer(roads, table, 1000, now, rng)
        assert planner.search(roads, anew, query) == planner.search(roads, table, query)


LANE = parse_map("#........#\n@q@.......\n@O........", "lane")
"""The queue cell, 11, has one way in, over cell 1; cell 8 is floor in the same row."""


def limits(roads: Roads, table: Reservations, query: Query, labels: int) -> tuple[int, int]:
    """Return the tick before which no path arrives, and the one from which on none does."""
    tracks = roads.tracks(query.goal, query.loaded)
    memory = memory_for(len(table.arrays.since))
    gap, _ = gap_at(query.cell, query.start_tick, query.robot, table.arrays)
    due = query.start_tick + int(tracks.times[query.cell, query.heading])
    problem = Problem(query.robot, query.goal, 1, 0, tracks, table.arrays, memory)
    return earliest(Asked(*Asked.by(query)), gap, due, query.latest, labels, problem)


@given(data=st.data())
@settings(deadline=None, max_examples=150)
def test_who_looks_from_the_goal_arrives_as_early(data: st.DataObject) -> None:
    """Among any reservations, paths arrive within the limits, and a search that begins anew arrives as without."""
    motion = data.draw(st.sampled_from([Motion(), Motion(1e12, 1.0, 4.0), Motion(0.5, 2.0, 3.3)]))
    roads = roads_on(travel_on(data.draw(st.sampled_from([OPEN, AISLES])), motion))
    cells = [c for c in range(roads.cells) if roads.layout.kind[c] in {1, 2}]
    start, goal = data.draw(st.sampled_from(cells)), data.draw(st.sampled_from(cells))
    table = Reservations(roads.cells)
    for _ in range(data.draw(st.integers(0, 16))):
        cell, since = data.draw(st.sampled_from(cells)), data.draw(st.integers(0, 30))
        until = data.draw(st.sampled_from([since + 1, since + 4, since + 10, FOREVER // 1000]))
        if table.is_free(1, stay(cell, since * 1000, until * 1000)) and cell not in {start, goal}:
            hold_until(table, 1, cell, since * 1000, until * 1000)
    latest = data.draw(st.sampled_from([FOREVER, 40_000]))
    query = Query(0, start, data.draw(st.integers(0, 3)), 500, goal, data.draw(st.booleans()), latest)
    slow = plain.search(roads, table, query)
    with patch.object(compiled, "LITTLE", 0):
        path = Sipp().search(roads, table, query)
    assert (None if path is None else path.end_tick) == (None if slow is None else slow.end_tick)
    if slow is not None and start != goal:
        for labels in (0, 1, 4, 9, 40, 10_000):
            first, last = limits(roads, table, query, labels)
            assert first <= slow.end_tick < last


@pytest.mark.parametrize("robots", [30, 100])
def test_crowds(robots: int) -> None:
    roads = paper_roads()
    table, queries = crowd(roads, Sipp(), robots, 5)
    now, rng = min(query.start_tick for query in queries), np.random.default_rng(5)
    for _ in range(25):
        query = newcomer(roads, table, 1000, now, rng)
        path = Sipp().search(roads, table, query)
        for labels in (8, compiled.LABELS):
            first, last = limits(roads, table, query, labels)
            assert first <= path.end_tick < last
        with patch.object(compiled, "LITTLE", 3):
            again = Sipp().search(roads, table, query)
        assert again.end_tick == path.end_tick


def test_the_last_run_decides() -> None:
    roads, table = roads_on(travel_on(LANE, Motion())), Reservations(30)
    hold_until(table, 1, 1, 0, 60_000)
    query = Query(0, 8, 2, 0, 11, True)
    path = Sipp().search(roads, table, query)
    assert path.end_tick > 60_000
    assert limits(roads, table, query, compiled.LABELS)[0] == path.end_tick
    roads, table = roads_on(travel_on(LANE, Motion())), Reservations(30)
    hold_until(table, 1, 1, 9_000, FOREVER)
    assert Sipp().search(roads, table, Query(0, 3, 2, 0, 11, True)) is not None
    late = Query(0, 8, 2, 5_000, 11, True)
    assert Sipp().search(roads, table, late) is None
    first, last = limits(roads, table, late, compiled.LABELS)
    assert first == last


def arrivals(roads: Roads, answer: dict[int, Path], queries: list[Query], arrives: dict[int, int]) -> int:
    """Sum of all arrivals with an answer, which is held against a table."""
    table = Reservations(roads.cells)
    total = 0
    for query in queries:
        if query.robot in answer:
            path = timed_path(roads, query, answer[query.robot].legs)
            assert path.end == query.goal
            table.commit(query.robot, occupancy(roads, path))
            total += path.end_tick
        else:
            total += arrives[query.robot]
    return total


def test_the_sum_of_arrivals_is_never_worse_and_sometimes_better() -> None:
    roads, rng = paper_roads(), np.random.default_rng(5)
    better = 0
    for _ in range(8):
        queries: list[Query] = []
        table = Reservations(roads.cells)
        reserved: dict[int, Occupancy] = {}
        arrives: dict[int, int] = {}
        for robot in range(30):
            query = newcomer(roads, table, robot, 0, rng)
            path = Sipp().search(roads, table, query)
            if path is None:
                continue
            queries.append(query)
            reserved[robot], arrives[robot] = occupancy(roads, path), path.end_tick
            table.commit(robot, reserved[robot])
        setting_out = queries[-3:]
        for query in setting_out:
            table.release(query.robot)
            del reserved[query.robot], arrives[query.robot]
        for query in setting_out:
            table.hold(query.robot, query.cell, 0)
        asked = [*setting_out, *queries[:-3]]
        traffic = FleetTraffic(roads, table, {}, reserved, arrives)
        costs = [arrivals(roads, Pbs(most_nodes=most).plan_paths(asked, traffic), asked, arrives) for most in (0, 20)]
        assert costs[1] <= costs[0]
        better += costs[1] < costs[0]
    assert better


BAY = roads_on(travel_on(parse_map("........\n@@@.@@@@", "bay"), EVEN))


def test_who_goes_first_is_handed_on() -> None:
    node = Node({}, frozenset({(1, 2), (2, 3), (5, 3)}))
    assert node.ahead(3) == {1, 2, 5}
    assert node.ahead(1) == set()
    assert node.behind(1) == [1, 2, 3]
    assert node.behind(3) == [3]


def test_who_cannot_pass_gets_no_path() -> None:
    """A robot that stays where another would have to drive: there is no answer for that one."""
    table = Reservations(BAY.cells)
    coming, new = Query(0, 7, WEST, 0, 2), Query(1, 1, EAST, 0, 7)
    table.hold(1, 1, 0)
    path = Sipp().search(BAY, table, coming)
    table.commit(0, occupancy(BAY, path))
    traffic = FleetTraffic(BAY, table, {}, {0: occupancy(BAY, path)}, {0: path.end_tick})
    assert Search(Sipp(), [new, coming], traffic).best(20) == {}


@pytest.mark.parametrize("most", [0, 20])
def test_with_room_both_arrive(most: int) -> None:
    hall = roads_on(travel_on(parse_map("........\n........", "hall"), EVEN))
    table = Reservations(hall.cells)
    coming, new = Query(0, 7, WEST, 0, 0), Query(1, 8, NORTH, 0, 15)
    table.hold(1, 8, 0)
    path = Sipp().search(hall, table, coming)
    table.commit(0, occupancy(hall, path))
    traffic = FleetTraffic(hall, table, {}, {0: occupancy(hall, path)}, {0: path.end_tick})
    found = Search(Sipp(), [new, coming], traffic).best(most)
    assert found.keys() == {1}
    assert timed_path(hall, new, found[1].legs).end_tick == hall.travel.ticks(8, NORTH, 15, False)


def test_waits_are_of_two_seconds() -> None:
    roads, table = corridor(Motion())
    hold_until(table, 1, 1, 0, 3100)
    first = Sipp().search(roads, table, Query(0, 0, 0, 0, 4))
    other = WhcaN(window_s=math.inf).search(roads, table, Query(0, 0, 0, 0, 4))
    assert (first.legs[0].wait_ticks, other.legs[0].wait_ticks) == (3100, 4000)
    assert WhcaN(max_nodes=1).search(*corridor(Motion()), Query(0, 0, 0, 0, 4)) is None


def test_a_way_that_stays_blocked_is_waited_for_within_the_window_only() -> None:
    roads, table = corridor(Motion())
    table.hold(1, 3, 0)
    path = WhcaN().search(roads, table, Query(0, 0, 0, 0, 4))
    assert path.end == 2
    assert path.end_tick >= 20_000
    assert WhcaN(window_s=math.inf).search(roads, table, Query(0, 0, 0, 0, 4)) is None


YARD = parse_map("......\n@@@..#\nqO....", "yard")


@cases("robots seed", (8, 0), (16, 1), *(pytest.param(*one, marks=pytest.mark.slow) for one in ((32, 2), (48, 3))))
def test_sipp_never_arrives_later(robots: int, seed: int) -> None:
    roads, sipp, whca = paper_roads(), Sipp(), WhcaN(window_s=math.inf)
    table, _ = crowd(roads, sipp, robots, seed)
    rng = np.random.default_rng(seed)
    earlier = found = 0
    for _ in range(250):
        query = newcomer(roads, table, 1000, 0, rng)
        first, other = sipp.search(roads, table, query), whca.search(roads, table, query)
        if other is None:
            continue
        assert first.end_tick <= other.end_tick
        table.check(1000, occupancy(roads, other))
        earlier += first.end_tick < other.end_tick
        found += 1
    assert found > 150
    assert earlier > 0


@given(robots=st.integers(1, 15), seed=st.integers(0, 1000), window_s=st.floats(1, 60))
@settings(deadline=None, max_examples=60)
def test_windowed_paths_end_where_they_can_be_held(robots: int, seed: int, window_s: float) -> None:
    roads = roads_on(travel_on(small_layout(stations=2), Motion()))
    table, _ = crowd(roads, Sipp(), robots, seed)
    query = newcomer(roads, table, 1000, 5000, np.random.default_rng(seed))
    table.hold(1000, query.cell, 5000)
    path = WhcaN(window_s=window_s).search(roads, table, query)
    assert path.end == query.goal or path.end_tick >= 5000 + 1000 * window_s - 1
    table.commit(1000, occupancy(roads, path))


def rows(
    table: Reservations, roads: Roads, goal: int, window_end: int, max_nodes: int = 1000
) -> list[list[int]] | None:
    """Return what the search finds for robot 0, at rest in cell 0 and facing east, with waits of 2 s."""
    found = search(
        (0, 0, EAST, 0, goal), window_end, 2000, max_nodes, tuple(roads.tracks(goal, False)), tuple(table.arrays)
    )
    return None if found is None else found.tolist()


def test_rows_and_windows() -> None:
    roads = roads_on(travel_on(YARD, EVEN))
    table = Reservations(roads.cells)
    assert rows(table, roads, 9, FOREVER) == [[3, 0], [9, 0]]  # east, a quarter turn, south
    hold_until(table, 1, 1, 0, 3000)
    assert rows(table, roads, 9, FOREVER) == [[3, 4000], [9, 0]]  # two waits make 4 s
    assert rows(table, roads, 0, FOREVER) == []
    roads, table = corridor()
    hold_until(table, 1, 1, 0, 9000)
    assert rows(table, roads, 4, 5000) == [[0, 6000]]
    assert rows(table, roads, 4, FOREVER) == [[4, 10_000]]
    hold_until(table, 1, 0, 12_000, 20_000)
    hold_until(table, 1, 4, 0, 30_000)
    assert rows(table, roads, 4, 20_000) == [[3, 10_000], [3, 8000]]
    roads = roads_on(travel_on(YARD, EVEN))
    table = Reservations(roads.cells)
    assert rows(table, roads, 9, FOREVER, max_nodes=1) is None
    table.hold(1, 9, 20_000)
    assert rows(table, roads, 9, FOREVER) is None
    assert rows(table, roads, 9, 5000) is not None  # the window ends before anybody comes
    hold_until(table, 1, 0, 0, 1000)
    assert rows(table, roads, 3, FOREVER) is None
    walled = roads_on(travel_on(parse_map("..@...\n..@...\nqO@...", "walled"), EVEN))
    assert rows(Reservations(walled.cells), walled, 4, FOREVER) is None
