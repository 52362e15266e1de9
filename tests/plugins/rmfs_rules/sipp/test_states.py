"""States of the compiled search and their queue: first out is what is due first."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from rmfs_commands.testing import small_layout
from rmfs_core.motion import Motion
from rmfs_core.traffic import Reservations, roads_on
from rmfs_core.world.travel import travel_on
from rmfs_rules.sipp.states import (
    AHEAD,
    ARRIVAL,
    DONE,
    DUE,
    PARENT,
    PLACE,
    REST,
    STAMP,
    Memory,
    Problem,
    known,
    memory_for,
    put,
    reach,
    take,
    turned,
)

GAPS = 3
STATES = 4 * GAPS
ROADS = roads_on(travel_on(small_layout(), Motion()))
GOAL = ROADS.layout.storage_locations[0]


def searching(number: int, memory: Memory) -> Problem:
    """Return what a search goes by, with so many gaps."""
    return Problem(0, GOAL, number, 0, ROADS.tracks(GOAL, False), Reservations(ROADS.cells).arrays, memory)


@given(st.lists(st.tuples(st.integers(0, STATES - 1), st.integers(0, 3), st.integers(0, 3)), max_size=60), st.data())
def test_the_queue_gives_out_what_is_due_first(queued: list[tuple[int, int, int]], data: st.DataObject) -> None:
    """Among equally due states the one nearest to the goal, then the lowest number; what is due earlier moves up."""
    memory = memory_for(GAPS)
    states = memory.states
    states[:, PLACE] = -1
    waiting, expected = 0, dict[int, tuple[int, int, int]]()
    for state, due, rest in queued:
        if expected and data.draw(st.booleans()):
            first = min(expected, key=expected.__getitem__)
            assert take(waiting, memory) == first
            waiting -= 1
            assert states[first, PLACE] == -1
            del expected[first]
        key = (due, rest, state)
        if state not in expected or key < expected[state]:
            states[state, DUE], states[state, REST] = due, rest
            waiting = put(state, waiting, memory)
            expected[state] = key
        assert waiting == len(expected)
    out = []
    while waiting:
        out.append(take(waiting, memory))
        waiting -= 1
    assert out == sorted(expected, key=expected.__getitem__)


def test_a_state_is_noted_as_it_is_reached() -> None:
    """With its time to the goal, the estimates of its four headings, and nothing driven yet."""
    cell, memory = ROADS.layout.storage_locations[-1], memory_for(GAPS)
    into, time = 4 * 2 + 1, 5000
    assert reach(into, time, 3, cell, 90_000, 12_345, 0, searching(7, memory)) == 1
    row = memory.states[into]
    assert memory.queue[0] == into
    assert (row[STAMP], row[ARRIVAL], row[PARENT], row[DUE], row[DONE]) == (7, time, 3, 12_345, -1)
    assert row[REST] == ROADS.travel.ticks(cell, 1, GOAL, False)
    for heading in range(4):
        turn = ROADS.travel.motion.turn_ticks(1, heading)
        assert row[AHEAD + heading] == time + turn + ROADS.travel.ticks(cell, heading, GOAL, False)


def test_reaching_a_state_anew_queues_it_once() -> None:
    """In the same search it moves in the queue; what an earlier search left there counts for nothing."""
    memory = memory_for(GAPS)
    first, later = searching(1, memory), searching(2, memory)
    assert reach(5, 9000, 0, 0, 99_000, 20_000, 0, first) == 1
    assert reach(5, 8000, 0, 0, 99_000, 19_000, 1, first) == 1
    assert (memory.states[5, ARRIVAL], memory.states[5, DUE]) == (8000, 19_000)
    assert reach(5, 9000, 0, 0, 99_000, 20_000, 0, later) == 1
    assert take(1, memory) == 5


def test_who_comes_early_enough_to_turn_is_known() -> None:
    """Another heading in the same gap counts when there is time for the turn, with a tick to spare for rounding."""
    memory = memory_for(GAPS)
    states, search = memory.states, searching(3, memory)
    states[4 + 0, STAMP], states[4 + 0, ARRIVAL] = 3, 1000  # second gap, facing east
    for into, time, expected in (
        (4 + 0, 1000, True),
        (4 + 0, 999, False),
        (4 + 1, 1625, False),
        (4 + 1, 1626, True),
        (4 + 3, 1626, True),
        (4 + 2, 2250, False),
        (4 + 2, 2251, True),
        (8 + 1, 9000, False),
        (0 + 1, 9000, False),
    ):
        assert known(into, time, search) is expected, (into, time)
    assert not known(4 + 1, 9000, searching(4, memory))  # of an earlier search
    assert not turned(4 + 0, 9000, search)  # the same heading is no turn
