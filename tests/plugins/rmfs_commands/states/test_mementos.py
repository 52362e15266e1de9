"""From a state's names to the ids of a warehouse, with what it leaves out filled in."""

from __future__ import annotations

from typing import Any

import pytest

from rmfs_commands.states.mementos import memento_of
from rmfs_commands.states.names import Names
from rmfs_commands.states.plain import Memento
from rmfs_commands.states.state_json import state_from_dict
from rmfs_core.errors import InputError
from rmfs_core.world import NORTH, Layout, parse_map


@pytest.fixture
def layout(folder_map: list[str]) -> Layout:
    """Return the layout of the small text map."""
    return parse_map("\n".join(folder_map), "map")


def made(content: dict[str, Any], layout: Layout) -> Memento:
    """Return the warehouse of a state."""
    state = state_from_dict(content, "state.json")
    return memento_of(state, Names(state, "state.json"), layout)


def test_a_state_with_places_is_taken_as_it_is(at_work: dict[str, Any], layout: Layout) -> None:
    """Time in ticks, names as ids, robots with their tasks, what waits and who is in line."""
    found = made(at_work, layout)
    assert (found.now, found.skus) == (60_500, ("milk", "tea", "jam"))
    assert [(order.data.name, order.data.arrival_tick) for order in found.orders] == [("A", 0), ("B", 30_000)]
    assert [(part.station, part.skus, part.period) for part in found.orders[0].parts] == [(0, (0, 1), 1)]
    assert [(pod.cell, pod.home, pod.bound_for) for pod in found.pods] == [(None, 12, (0,)), (13, 13, (0,))]
    assert [(robot.name, robot.cell, robot.task) for robot in found.robots] == [("r1", 54, 0), ("r2", 0, None)]
    (station,) = found.stations
    assert (station.capacity, station.counts_orders, station.inbound, station.line) == (4, False, (0, 1), (0,))
    assert station.queue_room == 3 + 1 - 1
    assert found.waiting == (1,)  # bound for a station, stored, and nobody fetches it


def test_requests_are_numbered_on(at_work: dict[str, Any], layout: Layout) -> None:
    """After as many as were assigned; a number that is given counts."""
    station = at_work["stations"]["north"]
    two = [{"order": "A", "sku": "tea", "id": 7}, {"order": "A", "sku": "milk"}]
    changed = at_work | {"stations": {"north": station | {"requests": two}}}
    assert [request.id for request in made(changed, layout).stations[0].requests] == [7, 8]
    assert [request.id for request in made(at_work, layout).stations[0].requests] == [2]


def test_what_a_state_leaves_out_is_filled_in(by_hand: dict[str, Any], layout: Layout) -> None:
    """Without a layout pods stand in storage locations, one after another; the queue is the paper's."""
    found = made(by_hand, layout)
    assert found.now == 0
    assert [pod.cell for pod in found.pods] == list(layout.storage_locations[:2])
    assert (found.stations[0].queue_length, found.stations[0].queue_room) == (12, 13)
    assert (found.robots, found.waiting) == ((), ())


def test_pods_in_a_line_are_carried_by_somebody(by_hand: dict[str, Any], layout: Layout) -> None:
    """A robot for each that the state tells none of, in its place in the line; what is requested is assigned."""
    station = {"item_capacity": 4, "line": ["P2", "P1"], "requests": [{"order": "A", "sku": "tea"}]}
    found = made(by_hand | {"stations": {"north": station}}, layout)
    cells = layout.stations[0]
    assert [(robot.task, robot.cell, robot.heading) for robot in found.robots] == [
        (1, cells.station, NORTH),
        (0, cells.queue[0], NORTH),
    ]
    assert [pod.cell for pod in found.pods] == [None, None]
    assert found.stations[0].inbound == (1, 0)
    assert [(part.station, part.skus) for part in found.orders[0].parts] == [(0, (1,))]


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"time_s": 10}, "found 10.0, but an order arrives at 30.0; expected none later"),
        ({"waiting": ["P3"]}, 'names pod "P3", which the state does not list'),
        ({"robots": {"r1": {"cell": 0, "task": "P9"}}}, 'names pod "P9", which the state does not list'),
        ({"stations": {"north": {"item_capacity": 4, "queue_length": 9}}}, "found 9; the layout has 3 cells"),
        (
            {
                "layout": None,
                "pods": {"P1": {"contents": {"milk": 1, "tea": 1}}, "P2": {"contents": {"jam": 1}, "cell": 3}},
            },
            "found a cell, but the state has no layout",
        ),
    ],
)
def test_what_contradicts_itself_is_refused(
    at_work: dict[str, Any], layout: Layout, changes: dict[str, Any], problem: str
) -> None:
    """With the place in the state."""
    content = {key: value for key, value in (at_work | changes).items() if value is not None}
    if "layout" not in content:
        content["robots"] = {}
    with pytest.raises(InputError) as caught:
        made(content, layout)
    assert problem in str(caught.value)
    assert str(caught.value).startswith("state.json")
