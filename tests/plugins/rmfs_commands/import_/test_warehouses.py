"""Instance files and layouts of RAWSim-O: what is read, what is noted, what is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from rawsimo_files import keys, xinst
from rmfs_commands.import_.notes import Note, Notes
from rmfs_commands.import_.warehouses import Moving, Picking, Storing, commonest, read_instance_file, read_layout_file
from rmfs_core.errors import InputError
from rmfs_core.world import parse_map

HALL = ".......\n.##.##.\n.......\n.##→→→O\n.......\n"
LAYOUT = parse_map(HALL, "hall")
ALONE = xinst(LAYOUT, {}, [(1, 1)])


def file(folder: Path, text: str) -> Path:
    """Write a file."""
    path = folder / "x.xinst"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_warehouse_is_read_whole(tmp_path: Path) -> None:
    """Its map, places from 1, how robots move and stations pick."""
    notes = Notes()
    found = read_instance_file(file(tmp_path, xinst(LAYOUT, {3: (2, 2), 4: (4, 3)}, [(1, 7)], name="hall")), notes)
    assert found.text_map == HALL
    assert (found.pods, found.places, found.pod_capacity) == (["p3", "p4"], [(2, 2), (4, 3)], [500, 500])
    assert (found.robots, found.robot_places) == (1, [(1, 7)])
    assert (found.moving, found.picking) == (Moving(1.0, 1.0, 1.5, 2.5, 2.2), [Picking(6, 13.0, 7.0)])
    assert found.read == {"waypoints": 35, "storage locations": 6, "picking stations": 1, "robots": 1, "pods": 2}
    assert notes.taken == []


def test_input_stations_are_replenishment_stations(tmp_path: Path) -> None:
    """With their queues, the weight of the bundles that they take, and the time that storing one takes."""
    around = parse_map("......@@\n.##.##@@\n......@@\n.##→→O@@\n......@@\n", "hall")
    notes = Notes()
    text = xinst(around, {}, [(1, 1)], inputs=[(15, (7, 6), (23, 22, 21))])
    found = read_instance_file(file(tmp_path, text), notes)
    assert found.text_map == "......→↓\n.##.##@I\n.....┘<<\n.##→→O@@\n......@@\n"
    assert (found.storing, found.read["replenishment stations"]) == ([Storing(400.0, 10.0)], 1)
    assert notes.taken == []


def test_input_stations_that_cannot_be_drawn_are_walls(tmp_path: Path) -> None:
    """With their queues, and the lanes that lead away from them; the reason is said."""
    around = parse_map("......@@\n.##.##@@\n......@@\n.##→→O@@\n......@@\n", "hall")
    notes = Notes()
    text = xinst(around, {}, [(1, 1)], inputs=[(15, (14,), (23, 22, 21))])
    text = text.replace("<Queues>15/14</Queues>", "")
    found = read_instance_file(file(tmp_path, text), notes)
    assert found.storing == ()
    assert found.text_map == "......@@\n.##.##@@\n......@@\n.##→→O@@\n......@@\n"
    reason = "input station 0 has no queue; expected waypoints from which ways lead to it, as its `Queues`"
    assert Note("input stations (replenishment)", 1, f"walls; stock is not filled up: {reason}") in notes.taken
    assert Note("waypoints of lanes that lead nowhere, such as those of replenishment", 3, "walls") in notes.taken


def test_what_stands_in_the_wrong_place_is_moved(tmp_path: Path) -> None:
    """A pod to the nearest free storage location, a robot to the nearest free cell; both are counted."""
    notes = Notes()
    pods, robots = {0: (2, 2), 1: (2, 2), 2: (3, 7)}, [(1, 1), (1, 1)]
    found = read_instance_file(file(tmp_path, xinst(LAYOUT, pods, robots)), notes)
    assert found.places == [(2, 2), (2, 3), (2, 6)]
    assert found.robot_places == [(1, 1), (1, 2)]
    assert [note.number for note in notes.taken] == [2, 1]
    assert {note.instead for note in notes.taken} == {"the nearest free one"}


def test_robots_move_as_most_of_them(tmp_path: Path) -> None:
    """There is one speed for all, and one acceleration; a station without a time for picking holds pods as long."""
    notes = Notes()
    brakes = 'PodTransferTime="3" MaxAcceleration="0.5" MaxDeceleration="0.4" MaxVelocity="1" TurnSpeed="3"'
    text = xinst(LAYOUT, {}, [(1, 1)], robot=brakes, station='Capacity="12" ItemTransferTime="8"')
    found = read_instance_file(file(tmp_path, text), notes)
    assert (found.moving, found.picking) == (Moving(0.5, 0.4, 1.0, 3.0, 3.0), [Picking(12, 8.0, 8.0)])
    assert notes.taken == [Note("bots that brake otherwise than they start", 1, "as they start")]
    assert commonest([1, 2, 2, 1, 3]) == 1


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            xinst(LAYOUT, {0: (2, 2), 1: (2, 3)}, [(1, 1)]).replace('Pod ID="1"', 'Pod ID="0"'),
            "found Pod 0 again; expected",
        ),
        (xinst(LAYOUT, {}, [(1, 1)], tiers=2), "found 2 tiers; expected one"),
        (xinst(LAYOUT, {}, [(1, 1)], pitch=1.05), "found waypoint 1 at x 1.575, y 0.525, the first one at x 0.525"),
        (xinst(LAYOUT, {}, []), "found no bot; expected at least one"),
        (
            ALONE.replace("<OutputStation ", "<Other ").replace("</OutputStation>", "</Other>"),
            "found no output station; expected at least",
        ),
        (
            ALONE.replace("<Queues>27/", "<Queues>27/x"),
            "expected the number of a waypoint",
        ),
        (ALONE.replace('Waypoint ID="2"', 'Waypoint ID="1"'), "found waypoint 1 again; expected"),
        (ALONE.replace('Capacity="6"', 'Capacity="0"'), "expected a whole number from 1 to"),
        (xinst(LAYOUT, dict.fromkeys(range(7), (2, 2)), [(1, 1)]), "found no free cell for all pods; expected fewer"),
    ],
)
def test_what_cannot_be_read_is_said(tmp_path: Path, text: str, message: str) -> None:
    """In one sentence, with the file and the line where there is one."""
    with pytest.raises(InputError) as caught:
        read_instance_file(file(tmp_path, text), Notes())
    assert str(caught.value).startswith(f"{tmp_path}/x.xinst")
    assert message in str(caught.value)


def test_a_layout_has_the_defaults_of_rawsimo(tmp_path: Path) -> None:
    """Where it leaves keys out; what rmfs draws otherwise is noted."""
    notes = Notes()
    found = read_layout_file(file(tmp_path, keys("LayoutConfiguration", {})), notes)
    assert found.layout == {
        **{"block_rows": 9, "block_columns": 7, "block_length": 4, "hall_width": 7},
        **{"stations_east": 4, "stations_west": 0, "pod_fill": 0.85, "replenishment_west": 4},
    }
    assert found.storing == [Storing(1000.0, 10.0)] * 4
    assert (found.queue_length, found.robots, len(found.pods), found.picking[0]) == (
        12,
        32,
        428,
        Picking(12, 10.0, 3.0),
    )
    halls = "halls whose lanes lead across (AisleLayoutType Tim)"
    assert notes.taken == [Note(halls, 1, "lanes that lead along the hall")]


def test_other_layouts_are_noted(tmp_path: Path) -> None:
    """What rmfs has no word for is counted, with what is drawn in its place."""
    notes = Notes()
    values = {"AisleLayoutType": "HighwayHallway", "AislesTwoDirectional": "true", "NReplenishmentStationWest": 4}
    values |= {
        "NReplenishmentStationNorth": 2,
        "CounterClockwiseRingwayDirection": "false",
        "DistanceEntryExitStation": 5,
        "NElevatorsEast": 1,
    }
    found = read_layout_file(file(tmp_path, keys("LayoutConfiguration", values)), notes)
    assert found.queue_length == 20
    assert [note.number for note in notes.taken] == [2, 1, 4, 14, 1]
    assert found.layout["replenishment_west"] == 4


def test_input_stations_that_have_no_room_are_left_out(tmp_path: Path) -> None:
    """The reason is said; picking stations that have none are refused."""
    notes = Notes()
    values = {"NrHorizontalAisles": 4, "NPickStationEast": 2, "AisleLayoutType": "HighwayHallway"}
    found = read_layout_file(file(tmp_path, keys("LayoutConfiguration", values)), notes)
    assert (found.storing, "replenishment_west" in found.layout) == ([], False)
    (note,) = notes.taken
    assert (note.what, note.number) == ("input stations in the east and west (replenishment)", 4)
    assert note.instead.startswith("left out; stock is not filled up: found 4 stations beside 5 rows of blocks")


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"TierCount": 2}, "found 2 tiers; expected one"),
        ({"NPickStationNorth": 1}, "found 1 picking station in the north; expected them in the east and the west"),
        ({"PodAmount": 1.5}, "expected a number from 1e-06 to 1 as `PodAmount` of LayoutConfiguration, found '1.5'"),
        ({"NrHorizontalAisles": 9999, "NrVerticalAisles": 9999}, "expected at most 100,000"),
        ({"NrHorizontalAisles": 4, "PodAmount": 0.01}, "found 4 stations beside 5 rows of blocks; at most 2 fit"),
        ({"NPickStationEast": 0}, "found no picking station; expected at least one on either side"),
        ({"WidthHall": 10_000, "NrHorizontalAisles": 40}, "expected at most 1,000,000 cells in all"),
    ],
)
def test_layouts_that_cannot_be_drawn_are_refused(tmp_path: Path, values: dict[str, object], message: str) -> None:
    """With the line of the key."""
    with pytest.raises(InputError) as caught:
        read_layout_file(file(tmp_path, keys("LayoutConfiguration", values)), Notes())
    assert message in str(caught.value)
