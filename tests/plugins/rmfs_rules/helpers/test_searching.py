"""The reservation table in compiled searches, against the table itself; and the way from rows to a path."""

from itertools import pairwise

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from reserving import hold_until, stay
from rmfs_commands.layouts import parse_map
from rmfs_core.motion import Motion
from rmfs_core.traffic import FOREVER, Reservations, roads_on
from rmfs_core.world.travel import travel_on
from rmfs_rules.helpers.searching import free_for_good, gap_at, narrow, search_once
from rmfs_rules.whca.compiled import last_end

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


EVEN = Motion(acceleration_m_per_s2=1e12, top_speed_m_per_s=1.0, full_turn_s=4.0)
"""A second for each cell and each quarter turn."""


def test_a_search_is_tried_once_where_nothing_is_reserved() -> None:
    asked = []
    roads = roads_on(travel_on(parse_map("......\n.#..#.\nqO....", "yard"), EVEN))
    search_once(lambda _, table, query: asked.append((int(table.arrays.count.sum()), query.cell, query.goal)), roads)
    locations = roads.layout.storage_locations
    assert asked == [(0, locations[0], locations[-1])]
