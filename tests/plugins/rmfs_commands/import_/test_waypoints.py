"""Waypoints as a text map: what is drawn, what is left out and counted, what is refused."""

from __future__ import annotations

from collections.abc import Mapping

import pytest
from attrs import evolve
from hypothesis import given
from hypothesis import strategies as st

from rmfs_commands.import_.notes import Note, Notes
from rmfs_commands.import_.waypoints import Drawn, StationPoints, Waypoint, draw, nearest
from rmfs_core.errors import InputError
from rmfs_core.scenario.model import LayoutSection
from rmfs_core.world import CellKind, Layout, block_map, parse_map

HALL = "......\n.##.#.\n......\n.##→→O\n......\n"


def graph(layout: Layout) -> tuple[dict[int, Waypoint], list[StationPoints]]:
    """Return the waypoints of a layout, numbered as its cells are, and its stations."""
    points = {}
    for cell, kind in enumerate(layout.kind):
        if kind != CellKind.WALL:
            beside = (layout.neighbour(cell, heading) for heading in range(4) if layout.may_step(cell, heading))
            ways = tuple(other for other in beside if other is not None)
            x, y = cell % layout.width + 0.5, cell // layout.width + 0.5
            points[cell] = Waypoint(x, y, ways, bool(kind == CellKind.STORAGE), f"x.xinst, line {cell}")
    stations = [
        StationPoints(i, cells.station, (cells.station, *cells.queue), f"x.xinst, line {cells.station}")
        for i, cells in enumerate(layout.stations)
    ]
    return points, stations


def drawn(
    points: Mapping[int, Waypoint], stations: list[StationPoints], left_out: tuple[int, ...] = (), size: float = 0
) -> tuple[Drawn, list[Note]]:
    """Draw; return what was noted, too."""
    notes = Notes()
    return draw(points, stations, left_out, (size, size), "x.xinst", notes), notes.taken


@given(
    rows=st.integers(1, 6),
    columns=st.integers(1, 3),
    length=st.integers(1, 4),
    hall=st.integers(1, 4),
    sides=st.tuples(st.integers(0, 2), st.integers(0, 2)),
    queue=st.sampled_from(["plain", "shortcut"]),
    queue_length=st.integers(1, 9),
)
def test_what_was_a_layout_is_the_same_one(
    rows: int, columns: int, length: int, hall: int, sides: tuple[int, int], queue: str, queue_length: int
) -> None:
    """Every block layout, as waypoints, is drawn so that it reads back as itself; there is nothing to note."""
    fitting = (rows - 1) // 2
    east, west = (min(number, fitting) for number in sides)
    if not east + west:
        rows, east = max(rows, 3), 1
    section = LayoutSection(rows, columns, length, hall, east, west, queue=queue)
    layout = parse_map(block_map(section, queue_length), "layout")
    found, notes = drawn(*graph(layout))
    assert notes == []
    assert found.layout.stations == layout.stations
    assert found.layout.kind.tolist() == layout.kind.tolist()
    assert found.layout.moves.tolist() == layout.moves.tolist()


def test_the_grid_may_begin_anywhere() -> None:
    """Waypoints stand whole metres apart, wherever the first one is; walls around them stay."""
    points, stations = graph(parse_map(HALL, "hall"))
    moved = {i: evolve(point, x=point.x - 3.25, y=point.y + 2) for i, point in points.items()}
    found, notes = drawn(moved, stations)
    assert found.text == "@@@@@@\n@@@@@@\n" + HALL
    assert (found.cell(-2.75, 2.5), found.cell(-2.0, 7.4), found.cell(99, -99), notes) == (12, 37, 5, [])
    larger = drawn(points, stations, size=8)[0].text.splitlines()
    assert larger == [f"{row}@@" for row in HALL.splitlines()] + ["@" * 8] * 3


def test_a_queue_may_be_told_from_its_other_end() -> None:
    """Ways say which end is at the station."""
    points, stations = graph(parse_map(HALL, "hall"))
    turned = [evolve(stations[0], queue=tuple(reversed(stations[0].queue)))]
    assert drawn(points, turned)[0].layout.stations == parse_map(HALL, "hall").stations


def test_lanes_of_what_is_left_out_become_walls() -> None:
    """As those that lead from an input station back to the hall: nobody gets there any more."""
    layout = parse_map("......\n.##.#.\n......\n.##→→O\n......\n@@^@@@\n", "hall")
    points, stations = graph(parse_map("......\n.##.#.\n......\n.##→→O\n......\n@.....\n", "hall"))
    lane = {i: point for i, point in points.items() if i < 30 or i in (31, 32)}
    lane[31] = evolve(lane[31], ways=(32,))
    lane[32] = evolve(lane[32], ways=(26,))
    lane = {i: evolve(p, ways=tuple(w for w in p.ways if w in lane and (i > 30 or w < 32))) for i, p in lane.items()}
    found, notes = drawn(lane, stations, left_out=(31,))
    assert found.text.splitlines()[-1] == "@@@@@@"
    assert notes == [Note("waypoints of lanes that lead nowhere, such as those of replenishment", 1, "walls")]
    assert layout.height == found.layout.height


def test_ways_that_cannot_be_drawn_are_counted() -> None:
    """To a waypoint elsewhere, out of a queue, and those that a map has although the graph has not."""
    points, stations = graph(parse_map(HALL, "hall"))
    points[0] = evolve(points[0], ways=(*points[0].ways, 4))
    points[21] = evolve(points[21], ways=(*points[21].ways, 27))
    points[1] = evolve(points[1], ways=tuple(way for way in points[1].ways if way != 7))
    _, notes = drawn(points, stations)
    assert notes == [
        Note("ways that a text map cannot say", 1, "left out"),
        Note("no ways between cells that a text map always joins", 1, "ways"),
        Note("ways between waypoints that are not side by side", 1, "left out"),
    ]


def test_a_dead_end_that_is_entered_stays_one() -> None:
    """A sign of one way would close the way in: an arm towards a wall keeps it open."""
    layout = parse_map("─....\n.###.\n.....\n.#→→O\n.....\n", "hall")
    points, stations = graph(layout)
    points[0] = evolve(points[0], ways=(1,))
    points[5] = evolve(points[5], ways=tuple(way for way in points[5].ways if way != 0))
    found, notes = drawn(points, stations)
    assert (found.layout.may_step(1, 2), found.layout.may_step(0, 0), notes) == (True, True, [])


@pytest.mark.parametrize(
    ("number", "change", "message"),
    [
        (
            3,
            {"x": 3.6},
            "x.xinst, line 3: found waypoint 3 at x 3.6, y 0.5, the first one at x 0.5, y 0.5; expected",
        ),
        (3, {"x": 1.5}, "x.xinst, line 3: found waypoints 1 and 3 in one place; expected one"),
        (3, {"ways": (99,)}, "x.xinst, line 3: a way leads to waypoint 99; there is none of that number"),
        (3, {"x": 1e6 + 0.5}, "x.xinst: found 1,000,001 x 5 m; expected at most 1,000,000 cells of 1 m x 1 m"),
        (3, {"x": 1e5 + 0.5}, "x.xinst: found a map of 100,001 x 5 cells; expected at most 5,000 in a row or column"),
        (22, {"ways": ()}, "x.xinst, line 23: output station 0 has no queue; expected waypoints from which ways lead"),
        (21, {"ways": ()}, "no aisle leads into the end of this queue"),
        (28, {"ways": ()}, ""),
    ],
)
def test_what_is_no_grid_or_no_warehouse_is_refused(number: int, change: dict[str, object], message: str) -> None:
    """With the line of the waypoint, or the cell of the map that was drawn."""
    points, stations = graph(parse_map(HALL, "hall"))
    points[number] = evolve(points[number], **change)
    if number == 21:
        points[20] = evolve(points[20], ways=())
    if not message:
        drawn(points, stations)
        return
    with pytest.raises(InputError) as caught:
        drawn(points, stations)
    assert message in str(caught.value)


def test_stations_without_waypoints_are_refused() -> None:
    """And queues of waypoints that are not there, and files without any."""
    points, stations = graph(parse_map(HALL, "hall"))
    with pytest.raises(InputError, match="found no waypoint of output station 0; expected one"):
        drawn(points, [evolve(stations[0], waypoint=77)])
    with pytest.raises(InputError, match="the queue has waypoint 78; there is none of that number"):
        drawn(points, [evolve(stations[0], queue=(78,))])
    with pytest.raises(InputError, match="found no waypoint; expected some"):
        drawn({}, stations)


def test_the_nearest_free_cell_is_the_first_of_equals() -> None:
    """None, where there is none."""
    layout = parse_map(HALL, "hall")
    storage = frozenset({CellKind.STORAGE})
    assert nearest(layout, 0, storage, ()) == 7
    assert nearest(layout, 0, storage, (7,)) == 8
    assert nearest(layout, 0, storage, layout.storage_locations) is None
