"""When a path can arrive, seen from the goal, against the searches that find the path."""

from __future__ import annotations

from unittest.mock import patch

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import plain_sipp as plain
from crowds import crowd, newcomer, paper_roads
from reserving import hold_until, stay
from rmfs_commands.layouts import parse_map
from rmfs_core.motion import Motion
from rmfs_core.traffic import FOREVER, Query, Reservations, Roads, roads_on
from rmfs_core.world.travel import travel_on
from rmfs_rules.helpers.searching import Asked, gap_at
from rmfs_rules.sipp import Sipp, compiled
from rmfs_rules.sipp.backwards import earliest
from rmfs_rules.sipp.states import Problem, memory_for

OPEN = parse_map("#.....\n....#.\n.qO...\n.#....", "open")
AISLES = parse_map(".>>>.\nv###^\n.<<<.\nqO...", "aisles")
LANE = parse_map("#........#\n@q@.......\n@O........", "lane")
"""The queue cell, 11, has one way in, over cell 1; cell 8 is floor in the same row."""


def limits(roads: Roads, table: Reservations, query: Query, labels: int) -> tuple[int, int]:
    """Return the tick before which no path arrives, and the one from which on none does."""
    tracks = roads.tracks(query.goal, query.loaded)
    memory = memory_for(len(table.arrays.since))
    gap, _ = gap_at(query.cell, query.start_tick, query.robot, table.arrays)
    due = query.start_tick + int(tracks.times[query.cell, query.heading])
    search = Problem(query.robot, query.goal, 1, 0, tracks, table.arrays, memory)
    return earliest(Asked.by(query), gap, due, query.latest, labels, search)  # type: ignore[no-any-return]


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
    """Among robots with committed paths, paths arrive within the limits, whatever the number of labels."""
    roads = paper_roads()
    table, queries = crowd(roads, Sipp(), robots, 5)
    now, rng = min(query.start_tick for query in queries), np.random.default_rng(5)
    for _ in range(25):
        query = newcomer(roads, table, 1000, now, rng)
        path = Sipp().search(roads, table, query)
        assert path is not None
        for labels in (8, compiled.LABELS):
            first, last = limits(roads, table, query, labels)
            assert first <= path.end_tick < last
        with patch.object(compiled, "LITTLE", 3):
            again = Sipp().search(roads, table, query)
        assert again is not None
        assert again.end_tick == path.end_tick


def test_the_last_run_decides() -> None:
    """Where others pass before the goal for long, the first arrival is known from the goal alone, to the tick."""
    roads, table = roads_on(travel_on(LANE, Motion())), Reservations(30)
    hold_until(table, 1, 1, 0, 60_000)
    query = Query(0, 8, 2, 0, 11, True)
    path = Sipp().search(roads, table, query)
    assert path is not None
    assert path.end_tick > 60_000
    assert limits(roads, table, query, compiled.LABELS)[0] == path.end_tick


def test_no_way_in_after_others_have_come_to_stay() -> None:
    """Who comes after the only way in is closed for good is told so from the goal."""
    roads, table = roads_on(travel_on(LANE, Motion())), Reservations(30)
    hold_until(table, 1, 1, 9_000, FOREVER)
    assert Sipp().search(roads, table, Query(0, 3, 2, 0, 11, True)) is not None
    late = Query(0, 8, 2, 5_000, 11, True)
    assert Sipp().search(roads, table, late) is None
    first, last = limits(roads, table, late, compiled.LABELS)
    assert first == last
