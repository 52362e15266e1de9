"""The warehouse that a state describes."""

from __future__ import annotations

import json
from typing import Any

import pytest

from rmfs_commands.states import state_from_dict
from rmfs_commands.states.rebuilding import LacksError, OpenState, open_state
from rmfs_core import InputError


def opened_from(content: dict[str, Any]) -> OpenState:
    """Return the opened of a state."""
    return open_state(state_from_dict(content))


def test_defaults(by_hand: dict[str, Any]) -> None:
    """By hand: everything is open, nothing is anywhere, and the first period is decided at the last arrival."""
    by_hand["orders"]["A"]["arrival_s"] = 12.5
    opened = opened_from(by_hand)
    view, station = opened.view, opened.view.stations[0]
    assert [order.name for order in view.backlog] == ["B", "A"]
    assert (view.now_s, opened.period, opened.shown) == (12.5, 1, None)
    assert (station.name, station.free_capacity, station.queue_room) == ("north", 4, 13)
    assert [pod.name for pod in view.free_pods] == ["P1", "P2"]
    assert view.unlimited_stock
    assert view.robots == ()
    assert opened.instance.skus == ("milk", "tea", "jam")


def test_what_is_under_way(at_work: dict[str, Any]) -> None:
    """Half of A is picked: it takes up its two places, wants one item, which the pod in the line has for it."""
    opened = opened_from(at_work)
    view, station = opened.view, opened.view.stations[0]
    a = next(order for order in view.orders if order.name == "A")
    assert (station.load, station.free_capacity, station.queue_room) == (2, 2, 3)
    assert [(request.order.name, request.sku, request.covered) for request in station.open_requests] == [("A", 1, True)]
    assert (a.unpicked_items, a.open_lines, a.stations) == (1, (), (0,))
    assert view.open_demand().tolist() == [0, 1, 2]
    p1, p2 = view.pods
    assert (p1.location, p1.robot, p1.bound_for, p1.free_items(1)) == (None, 0, (0,), 0)
    assert view.home(p1) == 12
    assert [pod.name for pod in view.waiting_pods] == ["P2"]
    assert p2.cell == 13
    assert [robot.name for robot in view.idle_robots] == ["r2"]
    assert 13 not in view.free_storage_locations
    assert opened.period == 2


def test_requests_alone_tell_what_is_assigned(at_work: dict[str, Any]) -> None:
    """Left out, `parts` are the lines that stations have requests of; the other lines are open."""
    del at_work["orders"]["A"]["parts"]
    opened = opened_from(at_work)
    a = next(order for order in opened.view.orders if order.name == "A")
    assert [line.sku for line in a.open_lines] == [0]
    assert opened.view.stations[0].load == 1


def test_a_pod_in_a_line_is_carried_by_some_robot(at_work: dict[str, Any]) -> None:
    """Where robots are not listed, as many are there as carry pods, and stand where their pods do."""
    del at_work["robots"]
    opened = opened_from(at_work)
    (robot,) = opened.view.robots
    assert (robot.pod, robot.cell) == (0, opened.view.stations[0].cell)
    assert opened.warehouse.pod_at(opened.view.stations[0]) is opened.view.pods[0]


def test_prefiltered(by_hand: dict[str, Any]) -> None:
    """The view's backlog is what the state says that the rule is shown."""
    opened = opened_from({**by_hand, "backlog": ["B"]})
    assert [order.name for order in opened.view.backlog] == ["B"]
    assert opened.shown == {opened.names.orders["B"]}
    assert opened.view.backlog_lines.quantity.tolist() == [2]


def test_blocks_in_place_of_a_map(at_work: dict[str, Any]) -> None:
    """The numbers of a block layout make the grid as in a scenario."""
    blocks = {"block_rows": 3, "block_columns": 1, "stations_east": 1}
    at_work["layout"] = {"blocks": blocks}
    at_work["stations"]["north"]["queue_length"] = 12
    at_work["robots"] = {}
    at_work["pods"] = {
        "P1": {"contents": {"milk": 3, "tea": 1}},
        "P2": {"contents": {"jam": 5}, "cell": 41},
    }
    opened = opened_from(at_work)
    assert opened.view.travel.layout.height == 10
    assert opened.view.pods[1].cell == 41


def test_without_a_layout_places_cannot_be_asked_for(by_hand: dict[str, Any]) -> None:
    """A view of a state without a layout says what is missing."""
    view = opened_from(by_hand).view
    for ask in (
        lambda: view.travel,
        lambda: view.free_storage_locations,
        lambda: view.blocked_locations,
        lambda: view.home(view.pods[0]),
    ):
        with pytest.raises(LacksError, match=r"driving times|storage locations"):
            ask()


@pytest.mark.parametrize(
    ("change", "place", "problem"),
    [
        ({"stations": {}}, "stations", "found none"),
        ({"skus": ["milk", "milk"]}, "skus", "a name twice"),
        ({"skus": ["milk", "jam"]}, "orders.A.lines.tea", 'names SKU "tea", which the state does not list'),
        ({"time_s": 3}, "time_s", "an order arrives at 30"),
        ({"backlog": ["C"]}, "backlog[0]", 'names order "C"'),
        ({"backlog": ["A"]}, "backlog[0]", "has no open line left"),
        ({"waiting": []}, "waiting", "expected the stored pods that are inbound and no robot's task: P2"),
        ({"empty_pods": [13]}, "pods.P2.cell", "found 13, where there is another pod already"),
        ({"pods": {"P2": {"cell": 0}}}, "pods.P2.cell", "no storage location"),
        ({"pods": {"P2": {"cell": None}}}, "pods.P2.cell", "is missing"),
        ({"pods": {"P1": {"cell": 12}}}, "pods.P1.cell", "stands in a station's line"),
        ({"pods": {"P1": {"bound_for": []}}}, "pods.P1.bound_for", "expected the stations that have the pod"),
        ({"pods": {"P1": {"bound_for": ["south"]}}}, "pods.P1.bound_for", 'names station "south"'),
        ({"robots": {"r2": {"task": "P1"}}}, "robots.r2.task", "another robot's task"),
        ({"robots": {"r2": {"task": "P3"}}}, "robots.r2.task", 'names pod "P3"'),
        ({"robots": {"r2": {"cell": 999}}}, "robots.r2.cell", "expected a cell of the layout, 0 to 76"),
        ({"robots": {"r2": {"cell": None}}}, "robots.r2.cell", "expected a cell of the layout"),
        ({"stations": {"north": {"inbound": ["P2"]}}}, "stations.north.line[0]", "which `inbound` does not"),
        ({"stations": {"north": {"inbound": ["P1", "P1"]}}}, "stations.north.inbound[1]", "twice"),
        ({"stations": {"north": {"line": ["P1", "P1"]}}}, "stations.north.line", "stands in a line already"),
        ({"stations": {"north": {"queue_length": 4}}}, "stations.north.queue_length", "the layout has 3"),
        (
            {"stations": {"north": {"requests": [{"order": "A", "sku": "tea"}] * 2}}},
            "stations.north.requests[1]",
            "requests more",
        ),
        (
            {"stations": {"north": {"requests": [{"order": "A", "sku": "tea", "pod": "P2"}]}}},
            "stations.north.requests[0].pod",
            "not inbound here with an item",
        ),
        (
            {
                "stations": {
                    "north": {
                        "requests": [{"order": "A", "sku": "tea", "id": 1}, {"order": "A", "sku": "milk", "id": 1}]
                    }
                }
            },
            "stations.north.requests",
            "the id 1 after 1",
        ),
        (
            {"orders": {"A": {"parts": [{"station": "north", "skus": ["jam"]}]}}},
            "orders.A.parts[0].skus",
            "no line of the order",
        ),
        ({"stations": {"south": {"item_capacity": 1}}}, "stations", "found 2; expected 1, as the layout has them"),
        ({"layout": {"map": ["#"]}}, "layout", "no picking station"),
        ({"layout": {"map": ["?"]}}, "layout.map, row 1, column 1", "unknown sign"),
        ({"layout": None}, "robots.r1.cell", "found a cell, but the state has no layout"),
    ],
)
def test_contradictions(at_work: dict[str, Any], change: dict[str, Any], place: str, problem: str) -> None:
    """A state that contradicts itself is refused with the path of the key."""
    with pytest.raises(InputError) as caught:
        opened_from(merged(at_work, change))
    assert caught.value.place == f"state, {place}"
    assert problem in caught.value.problem


def merged(content: Any, change: dict[str, Any]) -> Any:
    """Return a copy of a state with some keys changed; None takes a key out."""
    copy = json.loads(json.dumps(content))
    for key, value in change.items():
        if value is None:
            del copy[key]
        elif isinstance(value, dict) and value and isinstance(copy.get(key), dict):
            copy[key] = merged(copy[key], value)
        else:
            copy[key] = value
    return copy
