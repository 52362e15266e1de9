"""Passing times of runs, paths with times and cells, what planning knows of a layout, and the reservation table."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cases import cases
from reserving import EVEN, hold_until, occupy, stay
from rmfs_commands.layouts import parse_map
from rmfs_core.clock import UNREACHABLE, far, to_seconds
from rmfs_core.decisions import Leg, Path
from rmfs_core.motion import Motion
from rmfs_core.world import EAST, NORTH, WEST, CellKind
from rmfs_core.world.travel import Travel, travel_on
from rmfs_rules.sipp.windows import narrow
from rmfs_rules.whca.compiled import last_end
from rmfs_traffic import (
    FOREVER,
    PassingTimes,
    Query,
    Reservations,
    ReservedError,
    Roads,
    drive,
    occupancy,
    passing_s,
    roads_on,
    timed_path,
)
from rmfs_traffic.paths import Stop, run_between
from rmfs_traffic.searching import free_for_good, gap_at, search_once

MOTIONS = st.builds(
    Motion, acceleration_m_per_s2=st.floats(0.1, 5), top_speed_m_per_s=st.floats(0.3, 5), full_turn_s=st.floats(0.4, 8)
)


def test_runs_and_turns() -> None:
    passing = PassingTimes(Motion(), 5)
    assert (Motion().run_ticks(3), passing.leave[3, 0]) == (3500, 1415)
    assert list(passing.enter[3, :4]) == [0, 0, 1414, 2085]
    assert list(passing.leave[3, :3]) == [1415, 2086, 3500]
    run = Motion().run_ticks(1)
    ends = [timed_path(OPEN, Query(0, 6, heading, 0, 7), (Leg(7),)).end_tick - run for heading in range(4)]
    assert ends == [0, 625, 1250, 625]


@given(motion=MOTIONS, cells=st.integers(1, 30))
@settings(deadline=None)
def test_passing_times_invert_the_position(motion: Motion, cells: int) -> None:
    for cell, seconds in enumerate(passing_s(motion, cells)):
        assert motion.position_m(cells, float(seconds)) == pytest.approx(cell, abs=1e-6)


@given(motion=MOTIONS, cells=st.integers(1, 30))
@settings(deadline=None)
def test_rounding_goes_outward(motion: Motion, cells: int) -> None:
    passing = PassingTimes(motion, 30)
    exact = passing_s(motion, cells)
    for cell in range(cells):
        assert to_seconds(int(passing.leave[cells, cell])) >= exact[cell + 1] - 1e-8
        assert to_seconds(int(passing.leave[cells, cell])) <= exact[cell + 1] + 2e-3
    for cell in range(1, cells + 1):
        assert to_seconds(int(passing.enter[cells, cell])) <= exact[cell - 1] + 1e-8
        assert to_seconds(int(passing.enter[cells, cell])) >= exact[cell - 1] - 1e-3
    assert passing.common[cells] <= cells


OPEN = Roads(Travel(parse_map("#....\n.....\n.qO..\n.....", "open"), Motion()))


def test_a_path_occupies_its_cells() -> None:
    path = timed_path(OPEN, Query(0, 5, EAST, 1000, 2), (Leg(7), Leg(2, wait_ticks=500)))
    assert (path.end, path.end_heading, path.end_tick) == (2, NORTH, 1000 + 2828 + 500 + 625 + 2000)
    taken = occupancy(OPEN, path, since=-50)
    assert taken.cells.tolist() == [5, 6, 7, 2]
    assert taken.since.tolist() == [-50, 1000, 2414, 4953]
    assert taken.until.tolist() == [2415, 3829, 6953, FOREVER]
    legs = (Leg(7), Leg(2))
    assert timed_path(OPEN, Query(0, 5, EAST, 0, 2), legs).path == Path(legs)
    still = timed_path(OPEN, Query(0, 5, WEST, 70, 5), ())
    assert (still.end, still.end_heading, still.end_tick) == (5, WEST, 70)


def test_what_is_no_straight_run_is_refused() -> None:
    with pytest.raises(ValueError, match=r"^row 2, column 1 to row 1, column 3 is no straight run$"):
        timed_path(OPEN, Query(0, 5, EAST, 0, 2), (Leg(2),))
    assert run_between(OPEN, 5, 9) == (EAST, 4)
    assert run_between(OPEN, 17, 2) == (NORTH, 3)


@given(wait=st.integers(0, 5000), other=st.integers(0, 5000), stops=st.lists(st.integers(5, 9), max_size=4))
def test_a_path_always_has_a_cell(wait: int, other: int, stops: list[int]) -> None:
    legs = tuple(Leg(cell, wait + i * other) for i, cell in enumerate(stops))
    path = timed_path(OPEN, Query(0, 5, EAST, 300, 9), legs)
    taken = occupancy(OPEN, path)
    assert taken.since[0] == 300
    assert (taken.since < taken.until).all()
    assert (taken.since[1:] <= taken.until[:-1]).all()
    assert (abs(np.diff(taken.cells)) == 1).all()
    again, end = drive(OPEN, Stop(5, EAST, 300), legs)
    assert (again.cells.tolist(), again.until.tolist()) == (taken.cells.tolist(), taken.until.tolist())
    assert end == (path.end, path.end_heading, path.end_tick)
    assert (taken.cells[-1], taken.until[-1]) == (path.end, FOREVER)
    assert taken.since[-1] <= path.end_tick


LAYOUT = parse_map("#.#...\n......\n.qqO..\n......", "row")
ROADS = roads_on(travel_on(LAYOUT, Motion()))


def test_a_run_has_one_object_and_passing_times_reach_across_the_grid() -> None:
    travel = travel_on(LAYOUT, Motion())
    assert roads_on(travel) is roads_on(travel)
    assert roads_on(travel_on(LAYOUT, Motion())) is not roads_on(travel)
    assert (ROADS.cells, len(ROADS.passing.common)) == (24, 7)
    tall = parse_map("#\n.\n" + ".\n" * 7, "tall")
    assert len(Roads(travel_on(tall, Motion())).passing.common) == 10
    assert ROADS.turns == (0, 625, 1250, 625)


@cases(
    "goal loaded storage queue",
    (2, False, True, False),  # without a pod under stored ones; no queue on the way to storage
    (2, True, False, False),
    (15, True, False, True),  # the station: its queue may be crossed
    (13, False, True, True),  # a place in it
)
def test_tracks_say_what_may_be_crossed(goal: int, loaded: bool, storage: bool, queue: bool) -> None:
    tracks = ROADS.tracks(goal, loaded)
    kind = LAYOUT.kind
    assert set(tracks.passable[kind == CellKind.STORAGE].tolist()) == {storage}
    assert set(tracks.passable[kind == CellKind.QUEUE].tolist()) == {queue}
    assert set(tracks.passable[kind == CellKind.STATION].tolist()) == {False}
    assert tracks.passable[kind == CellKind.FLOOR].all()


def test_tracks_have_the_times_of_their_goal() -> None:
    tracks = ROADS.tracks(2, True)
    times = ROADS.travel.times_to(2, True)
    np.testing.assert_array_equal(tracks.times, np.where(times < UNREACHABLE, times, far(tracks.times)))
    assert tracks.times[2].tolist() == [0] * 4
    assert tracks.times[1, 0] == tracks.runs[1] < ROADS.tracks(0, True).times[1, 0]
    assert (tracks.moves is LAYOUT.moves, tracks.offsets.tolist()) == (True, [1, -6, -1, 6])
    for array in (tracks.passable, tracks.times, tracks.runs, tracks.enter):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0


def test_a_refused_commit_says_who_has_the_cell() -> None:
    table = Reservations(3)
    table.hold(1, 2, 5)
    with pytest.raises(ReservedError, match="cell 2 is reserved by 1 from tick 5 forever") as refused:
        table.commit(0, occupy((1, 0, 10), (2, 0, 6)))
    assert (refused.value.cell, refused.value.owner) == (2, 1)


@given(
    paths=st.lists(
        st.tuples(
            st.integers(0, 2),  # owner
            st.sampled_from([5, 6, 7, 12]),  # from where
            st.integers(0, 9000),  # and when
            st.lists(st.tuples(st.sampled_from([5, 7, 9, 12, 17, 19]), st.integers(0, 3000)), max_size=4),
        ),
        max_size=12,
    )
)
def test_a_path_is_settled_as_it_is_committed(paths: list[tuple[int, int, int, list[tuple[int, int]]]]) -> None:
    one, two = Reservations(OPEN.cells), Reservations(OPEN.cells)
    for owner, cell, tick, ends in paths:
        start = Stop(cell, EAST, tick)
        problem = None
        try:
            occupied, end = drive(OPEN, start, [Leg(*leg) for leg in ends])
            two.commit(owner, occupied)
        except ValueError as error:  # what another has, or no straight run
            problem = type(error), str(error)
        try:
            rows, settled = one.settle(owner, OPEN, start, np.array(ends, dtype=np.int64).reshape(-1, 2))
        except ValueError as error:
            assert (type(error), str(error)) == problem
        else:
            assert problem is None
            assert (rows.tolist(), settled) == (
                [occupied.cells.tolist(), occupied.since.tolist(), occupied.until.tolist()],
                end,
            )
        assert all(one.reserved(cell) == two.reserved(cell) for cell in range(OPEN.cells))


WHO = st.integers(0, 2)
TAKEN = st.dictionaries(st.integers(0, 2), st.tuples(st.integers(0, 40), st.integers(1, 9)), min_size=1)
"""Cells, each from when and how long."""


@given(
    steps=st.lists(
        st.one_of(
            st.tuples(st.sampled_from(["add", "add", "commit", "seize"]), WHO, TAKEN),
            st.tuples(st.just("release"), WHO),
            st.tuples(st.just("forget"), st.integers(0, 9)),
            st.tuples(st.sampled_from(["copy", "swap"])),
        ),
        min_size=20,
        max_size=60,
    )
)
@settings(deadline=None)
def test_the_table_equals_a_list_of_who_has_what(steps: list[tuple[Any, ...]]) -> None:
    """So does a copy of it, which is changed in turn with it."""
    table, model, forgotten = Reservations(3), dict[tuple[int, int], int](), 0
    other = table.copy(), model, forgotten
    for step in steps:
        match step:
            case (str(how), int(who), dict(taken)):
                path = occupy(*((cell, forgotten + since, forgotten + since + n) for cell, (since, n) in taken.items()))
                rows = zip(path.cells.tolist(), path.since.tolist(), path.until.tolist(), strict=True)
                ticks = [(cell, tick) for cell, since, until in rows for tick in range(since, until)]
                lost = {(cell, model[cell, tick]) for cell, tick in ticks if model.get((cell, tick), who) != who}
                if how == "seize":
                    assert table.seize(who, path) == {loser for _, loser in lost}
                elif lost:
                    with pytest.raises(ReservedError):
                        getattr(table, how)(who, path)
                    continue
                else:
                    getattr(table, how)(who, path)
                mine = set() if how == "add" else {who}
                model = {at: one for at, one in model.items() if one not in mine and (at[0], one) not in lost}
                model |= dict.fromkeys(ticks, who)
            case ("release", int(who)):
                table.release(who)
                model = {at: one for at, one in model.items() if one != who}
            case ("forget", int(ticks)):
                forgotten += ticks
                table.forget_before(forgotten)
            case ("copy",):
                other = table.copy(), model, forgotten
            case _:
                other, (table, model, forgotten) = (table, model, forgotten), other
    for one, has, over in ((table, model, forgotten), other):
        got = {(cell, t): who for cell in range(3) for who, a, b in one.reserved(cell) for t in range(a, b)}
        later = {at: who for at, who in has.items() if at[1] >= over}
        assert {at: who for at, who in got.items() if at[1] >= over} == later
        for cell in range(3):
            entries = one.reserved(cell)
            assert all(a < b for _, a, b in entries)
            assert all(earlier[2] <= after[1] for earlier, after in pairwise(entries))
            for since in range(over, over + 50, 3):
                after = [(tick, who) for (at, tick), who in later.items() if at == cell and who and tick >= since]
                assert one.blocker(cell, since, owner=0) == min(after, default=(0, None))[1]


def test_the_pool_grows() -> None:
    table = Reservations(2)
    for i in range(500):
        hold_until(table, i % 7, i % 2, 10 * ((i * 37) % 500), 10 * ((i * 37) % 500) + 5)
    assert table.arrays.count.sum() == 500
    assert [a for _, a, _ in table.reserved(0)] == sorted(10 * ((i * 37) % 500) for i in range(0, 500, 2))
    before, other = table.reserved(1), table.copy()
    for grown in (other, table):
        for i in range(600):
            hold_until(grown, 8, 0, 10_000 + 10 * i, 10_005 + 10 * i)
        assert (len(grown.reserved(0)), grown.reserved(1)) == (850, before)
    table = Reservations(OPEN.cells)
    table.hold(9, 19, 0)
    for i in range(300):
        hold_until(table, i % 7, 5 + i % 5, 100_000 + 10 * i, 100_000 + 10 * i + 5)
    table.settle(8, OPEN, Stop(5, EAST, 0), np.array([(9, 0), (14, 0)]))
    assert [table.reserved(cell)[0][0] for cell in (5, 6, 7, 8, 9, 14)] == [8] * 6
    assert table.arrays.count.sum() == 307


ME = 0
HELD = st.lists(st.tuples(st.integers(0, 2), st.integers(0, 30), st.integers(1, 8)), max_size=8)


def table_with(held: list[tuple[int, int, int]], cell: int = 1) -> Reservations:
    """Return a table of three cells in which owners have one as said (owner, since, how long), unless another does."""
    table = Reservations(3)
    for owner, since, length in held:
        if table.is_free(owner, stay(cell, since, since + length)):
            hold_until(table, owner, cell, since, since + length)
    return table


def free(table: Reservations, since: int, until: int, cell: int = 1) -> bool:
    return table.is_free(ME, stay(cell, since, until))


@given(HELD, st.integers(0, 40))
def test_a_gap_is_where_nobody_else_has_the_cell(held: list[tuple[int, int, int]], tick: int) -> None:
    """It ends where somebody else comes; ticks of one gap have one number, which no other gap has."""
    table = table_with(held)
    number, end = gap_at(1, tick, ME, table.arrays)
    assert (number < 0) == (end < 0) == (not free(table, tick, tick + 1))
    if number >= 0:
        assert free(table, tick, end)
        assert end == FOREVER or not free(table, end, end + 1)
        for other in range(41):
            if free(table, other, other + 1):
                same = free(table, min(tick, other), max(tick, other) + 1)
                assert (gap_at(1, other, ME, table.arrays)[0] == number) == same


@given(HELD)
def test_a_cell_is_free_for_good_after_all_others(held: list[tuple[int, int, int]]) -> None:
    """Own reservations do not count; `last_end` looks at everybody's, but not at what never ends."""
    table = table_with(held)
    others = [until for owner, _, until in table.reserved(1) if owner != ME]
    assert free_for_good(1, ME, table.arrays) == max(others, default=0)
    assert last_end(table.arrays) == max((until for _, _, until in table.reserved(1)), default=0)
    table.hold(5, 2, 3)
    assert free_for_good(2, ME, table.arrays) == FOREVER
    assert last_end(table.arrays) == max((until for _, _, until in table.reserved(1)), default=0)


@given(
    HELD,
    st.lists(st.tuples(st.integers(0, 5), st.integers(0, 9)), min_size=1, max_size=4),
    st.integers(0, 4),
    st.integers(1, 5),
)
def test_windows_are_narrowed_to_departures_that_are_free(held, pieces, enter, stay) -> None:
    table, leave = table_with(held), enter + stay
    low, high = np.zeros((2, 64), np.int64), np.zeros((2, 64), np.int64)
    at = 0
    for i, (apart, length) in enumerate(pieces):
        low[0, i], high[0, i] = at + apart, at + apart + length
        at += apart + length + 2
    n = narrow(low, high, 0, len(pieces), 1, 1, enter, leave, ME, table.arrays)
    before = {t for i in range(len(pieces)) for t in range(low[0, i], high[0, i] + 1)}
    windows = [(int(low[1, i]), int(high[1, i])) for i in range(n)]
    assert {t for begin, end in windows for t in range(begin, end + 1)} == {
        t for t in before if free(table, t + enter, t + leave)
    }
    assert windows == sorted(windows)
    assert all(end < begin for (_, end), (begin, _) in pairwise(windows))


def test_a_search_is_tried_once_where_nothing_is_reserved() -> None:
    asked = []
    roads = roads_on(travel_on(parse_map("......\n.#..#.\nqO....", "yard"), EVEN))
    search_once(lambda _, table, query: asked.append((int(table.arrays.count.sum()), query.cell, query.goal)), roads)
    locations = roads.layout.storage_locations
    assert asked == [(0, locations[0], locations[-1])]
