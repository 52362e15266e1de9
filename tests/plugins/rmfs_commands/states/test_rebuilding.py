"""The warehouse that a state describes: as plain data, and back."""

import json
from collections.abc import Callable
from typing import Any

import pytest
from attrs import evolve

from cases import cases
from rmfs_commands.layouts import parse_map
from rmfs_commands.states import state_from_dict
from rmfs_commands.states.mementos import memento_of
from rmfs_commands.states.names import Names
from rmfs_commands.states.plain import Memento, PartMemento, RequestMemento
from rmfs_commands.states.rebuilding import LacksError, OpenState, open_state
from rmfs_commands.states.restoring import ContradictionError, restore
from rmfs_commands.testing import small_world
from rmfs_core import InputError
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_core.warehouse.promises import next_request
from rmfs_core.world import NORTH, Layout, OrderData, PodData


def test_a_memento_has_no_time_before_the_start_and_no_fifth_heading() -> None:
    memento = Memento.of(WarehouseView(small_world({}, {"p": ["a"]})), ("a",))
    with pytest.raises(ValueError, match="'now' must be >= 0: -1"):
        evolve(memento, now=-1)
    with pytest.raises(ValueError, match="'heading' must be in range"):
        evolve(memento.robots[0], heading=4)


@pytest.fixture
def layout(folder_map: list[str]) -> Layout:
    return parse_map("\n".join(folder_map), "map")


def made(content: dict[str, Any], layout: Layout) -> Memento:
    state = state_from_dict(content, "state.json")
    return memento_of(state, Names(state, "state.json"), layout)


def test_requests_are_numbered_on(at_work: dict[str, Any], layout: Layout) -> None:
    station = at_work["stations"]["north"]
    two = [{"order": "A", "sku": "tea", "id": 7}, {"order": "A", "sku": "milk"}]
    changed = at_work | {"stations": {"north": station | {"requests": two}}}
    assert [request.id for request in made(changed, layout).stations[0].requests] == [7, 8]
    assert [request.id for request in made(at_work, layout).stations[0].requests] == [2]


def test_what_a_state_leaves_out_is_filled_in(by_hand: dict[str, Any], layout: Layout) -> None:
    found = made(by_hand, layout)
    assert found.now == 0
    assert [pod.cell for pod in found.pods] == list(layout.storage_locations[:2])
    assert (found.stations[0].queue_length, found.stations[0].queue_room) == (12, 13)
    assert (found.robots, found.waiting) == ((), ())


def test_pods_in_a_line_are_carried_by_somebody(by_hand: dict[str, Any], layout: Layout) -> None:
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


def opened_from(content: dict[str, Any]) -> OpenState:
    return open_state(state_from_dict(content))


def test_what_a_state_leaves_out_has_defaults(by_hand: dict[str, Any]) -> None:
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


def test_a_state_under_way_is_rebuilt(at_work: dict[str, Any]) -> None:
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
    del at_work["orders"]["A"]["parts"]
    opened = opened_from(at_work)
    a = next(order for order in opened.view.orders if order.name == "A")
    assert [line.sku for line in a.open_lines] == [0]
    assert opened.view.stations[0].load == 1


def test_prefiltered(by_hand: dict[str, Any]) -> None:
    opened = opened_from({**by_hand, "backlog": ["B"]})
    assert [order.name for order in opened.view.backlog] == ["B"]
    assert opened.shown == {opened.names.orders["B"]}
    assert opened.view.backlog_lines.quantity.tolist() == [2]


def test_blocks_in_place_of_a_map(at_work: dict[str, Any]) -> None:
    blocks = {"block_rows": 3, "block_columns": 1, "stations_east": 1}
    at_work["layout"] = {"blocks": blocks}
    at_work["stations"]["north"]["queue_length"] = 12
    at_work["robots"] = {}
    at_work["pods"] = {"P1": {"contents": {"milk": 3, "tea": 1}}, "P2": {"contents": {"jam": 5}, "cell": 41}}
    opened = opened_from(at_work)
    assert opened.view.travel.layout.height == 10
    assert opened.view.pods[1].cell == 41


def test_without_a_layout_places_cannot_be_asked_for(by_hand: dict[str, Any]) -> None:
    view = opened_from(by_hand).view
    for ask in (
        lambda: view.travel,
        lambda: view.free_storage_locations,
        lambda: view.blocked_locations,
        lambda: view.home(view.pods[0]),
    ):
        with pytest.raises(LacksError, match=r"driving times|storage locations"):
            ask()


JAM = {"order": "B", "sku": "jam"}


@cases(
    "change place problem",
    ({"stations": {}}, "stations", "found none"),
    ({"skus": ["milk", "milk"]}, "skus", "a name twice"),
    ({"skus": ["milk", "jam"]}, "orders.A.lines.tea", 'names SKU "tea", which the state does not list'),
    ({"time_s": 3}, "time_s", "an order arrives at 30"),
    ({"backlog": ["C"]}, "backlog[0]", 'names order "C"'),
    ({"backlog": ["A"]}, "backlog[0]", "has no open line left"),
    ({"waiting": ["P3"]}, "waiting[0]", 'names pod "P3", which the state does not list'),
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
                "north": {"requests": [{"order": "A", "sku": "tea", "id": 1}, {"order": "A", "sku": "milk", "id": 1}]}
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
    (
        {"stations": {"north": {"item_capacity": 2, "requests": [{"order": "A", "sku": "tea"}, JAM, JAM]}}},
        "stations.north.item_capacity",
        "found 2; expected at least 4",
    ),
    ({"stations": {"south": {"item_capacity": 1}}}, "stations", "found 2; expected 1, as the layout has them"),
    ({"layout": {"map": ["#"]}}, "layout", "no picking station"),
    ({"layout": {"map": ["?"]}}, "layout.map, row 1, column 1", "unknown sign"),
    ({"layout": None}, "robots.r1.cell", "found a cell, but the state has no layout"),
)
def test_contradictions(at_work: dict[str, Any], change: dict[str, Any], place: str, problem: str) -> None:
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


SKUS = ("a", "b")


def half_done() -> Warehouse:
    """Return a world in which pod 0 stands at the station, pod 1 waits, and order 0 wants an item of each."""
    world = small_world({"1": {"a": 2, "b": 1}}, {"p": ["a"], "q": {"b": 4}})
    world.assign(world.orders[0], world.stations[0], [0, 1])
    world.place_at_station(world.robots[0], world.pods[0], world.stations[0])
    world.bind(world.pods[1], world.stations[0])
    request = next_request(world.stations[0], world.pods[0])
    world.fulfil(request, world.pods[0])
    return world


def test_a_restored_warehouse_is_another_one() -> None:
    world = half_done()
    before = Memento.of(WarehouseView(world), SKUS)
    again = restore(before, world.travel)
    for warehouse in (again, world):
        station, pod = warehouse.stations[0], warehouse.pods[0]
        request = next_request(station, pod)
        assert (request.id, request.pod) == (1, pod)
        warehouse.fulfil(request, pod)
        assert next_request(station, pod) is None
        if warehouse is again:
            assert Memento.of(WarehouseView(world), SKUS) == before
    assert Memento.of(WarehouseView(again), SKUS) == Memento.of(WarehouseView(world), SKUS)


def test_what_is_in_hand_keeps_its_place() -> None:
    """An item that is picked and not yet handled; another one that was not picked here cannot be in hand."""
    world = small_world({"1": {"a": 1}, "2": {"b": 1}}, {"p": ["a"]}, capacities=[2])
    station = world.stations[0]
    world.assign(world.orders[0], station, [0])
    world.place_at_station(world.robots[0], world.pods[0], station)
    world.fulfil(station.open_requests[0], world.pods[0], handled=False)
    told = Memento.of(WarehouseView(world), SKUS)
    assert told.stations[0].in_hand == (0, 0)
    again = restore(told, world.travel)
    assert (again.stations[0].load, again.orders[0].unpicked_items, again.orders[0].complete) == (1, 0, False)
    wrong = evolve(told, stations=(evolve(told.stations[0], in_hand=(1, 1)),))
    with pytest.raises(ContradictionError, match=r"stations\.0\.in_hand: names no item picked here"):
        restore(wrong, world.travel)


def test_the_last_item_of_a_too_large_order_in_hand() -> None:
    world = small_world({"1": {"a": 1, "b": 1}, "2": {"b": 1}}, {"p": ["a", "b"]}, capacities=[1])
    station, pod = world.stations[0], world.pods[0]
    world.assign(world.orders[0], station, [0, 1])
    world.place_at_station(world.robots[0], pod, station)
    for request in station.open_requests:
        world.fulfil(request, pod, handled=request.sku == 0)
    told = Memento.of(WarehouseView(world), SKUS)
    assert restore(told, world.travel).stations[0].load == 2
    world.assign(world.orders[1], station, [1])
    with pytest.raises(ContradictionError, match=r"stations\.0\.item_capacity: found 1; expected at least 3"):
        restore(Memento.of(WarehouseView(world), SKUS), world.travel)


def test_promises_that_are_not_told_are_made() -> None:
    world = half_done()
    told = Memento.of(WarehouseView(world), SKUS)
    (station,) = told.stations
    untold = tuple(request._replace(pod=None) for request in station.requests)
    again = restore(evolve(told, stations=(evolve(station, requests=untold),)), world.travel)
    assert Memento.of(WarehouseView(again), SKUS) == told


@cases(
    "part change path problem",
    # what a state with names cannot get wrong; the rest is tried there
    ("orders", {"parts": (PartMemento(1, (0,), 1),)}, ("orders", 0, "parts", 0, "station"), "expected 0 to 0"),
    ("orders", {"parts": (PartMemento(0, (-1,), 1),)}, ("orders", 0, "parts", 0), "found the id -1"),
    ("stations", {"requests": (RequestMemento(0, 9, 0, None),)}, ("stations", 0, "requests", 0), "the id 9"),
    ("stations", {"inbound": (0, 2)}, ("stations", 0, "inbound", 1), "found the id 2; expected 0 to 1"),
    ("stations", {"line": (0, -1)}, ("stations", 0, "line", 1), "found the id -1"),
    ("stations", {"line": (0, 1)}, ("stations", 0, "line", 1), 'names pod "q", which no robot carries'),
    ("robots", {"task": 2}, ("robots", 0, "task"), "found the id 2"),
    ("robots", {"cell": 10_000}, ("robots", 0, "cell"), "expected a cell of the layout"),
    ("robots", {"cell": 11}, ("robots", 0, "cell"), "expected a cell of the layout, 0 to 119, no wall"),
    ("orders", {"data": OrderData("1", arrival_tick=0, lines=((0, 2), (9, 1)))}, ("orders", 0, "lines"), "the id 9"),
    ("orders", {"data": OrderData("1", arrival_tick=0, lines=((0, -2),))}, ("orders", 0, "lines"), "found -2 items"),
    ("pods", {"data": PodData("p", ((-1, 3),))}, ("pods", 0, "contents"), "the id -1"),
    ("pods", {"data": PodData("p", ((0, 3),)), "capacity": 2}, ("pods", 0, "capacity"), "expected at least 3, what"),
    ("pods", {"home": 0}, ("pods", 0, "home"), "found 0; expected a storage location"),
    ("stations", {"queue_room": -1}, ("stations", 0, "queue_room"), "found -1; expected 0 to "),
    ("stations", {"queue_room": 99}, ("stations", 0, "queue_room"), "found 99; expected 0 to "),
)
def test_what_a_memento_may_not_say_is_refused(part, change, path, problem) -> None:
    world = half_done()
    memento = Memento.of(WarehouseView(world), SKUS)
    first, *others = getattr(memento, part)
    assert restore(memento, world.travel).now == memento.now
    with pytest.raises(ContradictionError) as caught:
        restore(evolve(memento, **{part: (evolve(first, **change), *others)}), world.travel)
    assert caught.value.path == path
    assert problem in caught.value.problem
    assert str(caught.value) == f"{'.'.join(map(str, path))}: {caught.value.problem}"


@cases(
    "changed key",
    (lambda memento: {"stations": memento.stations * 2}, "stations"),
    (lambda memento: {"blocked": (0,)}, "blocked"),
    (lambda memento: {"reserved": (10_000,)}, "reserved"),
    (lambda memento: {"blocked": (memento.pods[1].home,), "reserved": (memento.pods[1].home,)}, "reserved"),
)
def test_contradictions_of_the_whole(changed: Callable[[Memento], dict[str, Any]], key: str) -> None:
    world = half_done()
    memento = Memento.of(WarehouseView(world), SKUS)
    with pytest.raises(ContradictionError) as caught:
        restore(evolve(memento, **changed(memento)), world.travel)
    assert caught.value.path == (key,)
