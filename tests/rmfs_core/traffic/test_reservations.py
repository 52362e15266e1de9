"""The reservation table."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from plain_sipp import gaps
from reserving import hold_until
from rmfs_commands.layouts import parse_map
from rmfs_core.decisions import Leg
from rmfs_core.motion import Motion
from rmfs_core.traffic import FOREVER, Occupancy, Reservations, ReservedError, Roads, drive
from rmfs_core.traffic.paths import Stop
from rmfs_core.world import EAST
from rmfs_core.world.travel import Travel

OPEN = Roads(Travel(parse_map("#....\n.....\n.qO..\n.....", "open"), Motion()))


def occupy(*intervals: tuple[int, int, int]) -> Occupancy:
    return Occupancy(*(np.array(column, dtype=np.int64) for column in zip(*intervals, strict=True)))


def test_gaps_are_what_reservations_leave() -> None:
    table = Reservations(3)
    hold_until(table, 7, 1, 10, 20)
    hold_until(table, 8, 1, 20, 30)
    assert gaps(table, 1, -1) == [(-FOREVER, 10), (30, FOREVER)]
    assert gaps(table, 1, owner=8) == [(-FOREVER, 10), (20, FOREVER)]
    table.hold(9, 1, 40)
    assert gaps(table, 1, -1) == [(-FOREVER, 10), (30, 40)]
    assert gaps(table, 0, -1) == [(-FOREVER, FOREVER)]
    assert table.blocker(1, 0) == 7
    assert table.blocker(1, 30) == 9
    assert table.blocker(1, 30, owner=9) is None


def test_a_commit_replaces_what_was_there_and_takes_nothing_of_others() -> None:
    table = Reservations(3)
    table.hold(1, 2, 5)
    table.commit(0, occupy((0, 0, 10)))
    with pytest.raises(ReservedError, match="cell 2 is reserved by 1 from tick 5 for ever") as refused:
        table.commit(0, occupy((1, 0, 10), (2, 0, 6)))
    assert (refused.value.cell, refused.value.owner) == (2, 1)
    assert table.reserved(0) == [(0, 0, 10)]
    assert table.reserved(1) == []
    table = Reservations(4)
    table.commit(0, occupy((0, 0, 10), (1, 5, FOREVER)))
    table.commit(0, occupy((1, 5, 20), (2, 15, FOREVER)))
    assert (table.reserved(0), table.reserved(1)) == ([], [(0, 5, 20)])
    assert table.reserved(2) == [(0, 15, FOREVER)]
    table.release(0)
    assert table.arrays.count.sum() == 0


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
        outcomes: list[object] = []
        try:
            rows, end = one.settle(owner, OPEN, start, np.array(ends, dtype=np.int64).reshape(-1, 2))
            outcomes.append((rows.tolist(), end))
        except ValueError as error:  # what another has, or no straight run
            outcomes.append((type(error), str(error)))
        try:
            occupied, end = drive(OPEN, start, [Leg(*leg) for leg in ends])
            two.commit(owner, occupied)
            outcomes.append(([occupied.cells.tolist(), occupied.since.tolist(), occupied.until.tolist()], end))
        except ValueError as error:
            outcomes.append((type(error), str(error)))
        assert outcomes[0] == outcomes[1]
        assert all(one.reserved(cell) == two.reserved(cell) for cell in range(OPEN.cells))


def test_who_copies_or_seizes() -> None:
    table = Reservations(3)
    table.commit(1, occupy((0, 5, 9)))
    other = table.copy()
    assert [other.reserved(cell) for cell in range(3)] == [[(1, 5, 9)], [], []]
    other.release(1)
    for tick in range(0, 1000, 10):
        hold_until(other, 2, 0, tick, tick + 5)
    table.hold(3, 1, 0)
    assert [table.reserved(cell) for cell in range(3)] == [[(1, 5, 9)], [(3, 0, FOREVER)], []]
    assert len(other.reserved(0)) == 100
    assert other.reserved(1) == []
    table = Reservations(4)
    table.commit(1, occupy((0, 0, 10), (1, 8, 20), (2, 18, FOREVER)))
    table.commit(2, occupy((1, 20, 30), (3, 28, FOREVER)))
    table.commit(3, occupy((1, 0, 5)))
    assert table.seize(0, occupy((1, 6, FOREVER))) == {1, 2}
    assert [table.reserved(cell) for cell in range(4)] == [
        [(1, 0, 10)], [(3, 0, 5), (0, 6, FOREVER)], [(1, 18, FOREVER)], [(2, 28, FOREVER)],
    ]  # fmt: skip
    table.release(1)
    assert (table.reserved(0), table.reserved(2)) == ([], [])
    table = Reservations(2)
    table.commit(0, occupy((0, 0, 10), (0, 20, 30), (1, 5, 11)))
    table.forget_before(10)
    assert (table.reserved(0), table.reserved(1)) == ([(0, 20, 30)], [(0, 5, 11)])


@given(
    steps=st.lists(
        st.one_of(
            st.tuples(st.just("hold"), st.integers(0, 3), st.integers(0, 2), st.integers(0, 60), st.integers(1, 9)),
            st.tuples(st.just("release"), st.integers(0, 3)),
            st.tuples(st.just("forget"), st.integers(0, 60)),
        ),
        max_size=60,
    )
)
@settings(deadline=None)
def test_the_table_equals_a_list_of_who_has_what(steps: list[tuple[str | int, ...]]) -> None:
    table, model = Reservations(3), {}
    forgotten = 0
    for step in steps:
        match step:
            case ("hold", int(who), int(cell), int(since), int(length)):
                ticks = [(cell, tick) for tick in range(since, since + length)]
                free = all(model.get(tick, who) == who for tick in ticks)
                if any(tick < forgotten for _, tick in ticks):
                    continue
                if free:
                    hold_until(table, who, cell, since, since + length)
                    model.update(dict.fromkeys(ticks, who))
                else:
                    with pytest.raises(ReservedError):
                        hold_until(table, who, cell, since, since + length)
            case ("release", int(who)):
                table.release(who)
                model = {tick: owner for tick, owner in model.items() if owner != who}
            case ("forget", int(until)):
                forgotten = max(forgotten, until)
                table.forget_before(until)
    got = {(cell, t): who for cell in range(3) for who, a, b in table.reserved(cell) for t in range(a, b)}
    later = {key: who for key, who in model.items() if key[1] >= forgotten}
    assert {key: who for key, who in got.items() if key[1] >= forgotten} == later
    for cell in range(3):
        entries = table.reserved(cell)
        assert all(a < b for _, a, b in entries)
        assert all(one[2] <= other[1] for one, other in pairwise(entries))


def test_the_pool_grows() -> None:
    table = Reservations(2)
    for i in range(500):
        hold_until(table, i % 7, i % 2, 10 * ((i * 37) % 500), 10 * ((i * 37) % 500) + 5)
    assert table.arrays.count.sum() == 500
    assert [a for _, a, _ in table.reserved(0)] == sorted(10 * ((i * 37) % 500) for i in range(0, 500, 2))
    table = Reservations(OPEN.cells)
    table.hold(9, 19, 0)
    for i in range(300):
        hold_until(table, i % 7, 5 + i % 5, 100_000 + 10 * i, 100_000 + 10 * i + 5)
    table.settle(8, OPEN, Stop(5, EAST, 0), np.array([(9, 0), (14, 0)]))
    assert [table.reserved(cell)[0][0] for cell in (5, 6, 7, 8, 9, 14)] == [8] * 6
    assert table.arrays.count.sum() == 307
