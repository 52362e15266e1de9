"""Orders, requests, pods, stations and robots as rules see them."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import Order, Pod, Robot, Station, Warehouse
from rmfs_core.warehouse.parts import UNLIMITED, OrderLine
from rmfs_core.world import NORTH, OrderData, PodData, StationCells


@pytest.fixture
def world() -> Warehouse:
    """One order of three items and one of two; a pod with two of a, another with endless b; two stations."""
    return small_world(
        {"first": {"a": 2, "b": 1}, "second": {"b": 2}}, {"p": {"a": 2, "b": 1}, "q": ["b"]}, capacities=[5, 5]
    )


PARTS: list[tuple[Callable[[Warehouse], object], str]] = [
    (lambda world: world.orders[0], "items"),
    (lambda world: world.pods[0], "name"),
    (lambda world: world.stations[0], "capacity"),
    (lambda world: world.robots[0], "id"),
]


@pytest.mark.parametrize(("part", "name"), PARTS)
def test_what_is_set_once_stays(world: Warehouse, part: Callable[[Warehouse], object], name: str) -> None:
    """The class and the attribute are named."""
    thing = part(world)
    with pytest.raises(AttributeError, match=rf"^{type(thing).__name__}\.{name} is read-only$"):
        setattr(thing, name, 3)


def test_people_know_names_and_rules_return_ids() -> None:
    """Messages have both; stations and robots that nobody named are counted from 1."""
    cells = StationCells(3, (4,))
    assert Order(7, OrderData("A-1", 0, ()), lambda: 0).label == "A-1 (id 7)"
    assert Station(0, cells, 5, False, 1).label == "1 (id 0)"
    assert Station(0, cells, 5, False, 1, name="north").label == "north (id 0)"
    assert Robot(1, 0, NORTH).label == "2 (id 1)"


def test_an_order_is_open_until_its_lines_are_assigned_and_unpicked_until_its_items_are_picked(
    world: Warehouse,
) -> None:
    """Lines leave one by one; what was assigned is kept as parts, the last item ends it."""
    order, (here, there), pod = world.orders[0], world.stations, world.pods[0]
    assert (order.items, order.open_items, order.unpicked_items, order.split) == (3, 3, 3, False)
    assert order.lines == order.open_lines == (OrderLine(0, 2), OrderLine(1, 1))
    world.place_at_station(world.robots[0], pod, here)
    world.assign(order, here, [0])
    assert (order.open_lines, order.open_items, order.unpicked_items) == ((OrderLine(1, 1),), 1, 3)
    assert order.split  # a line is left for later
    assert order.part_of(here.id, 1) is order.parts[0]
    assert (order.part_of(there.id, 1), order.part_of(here.id, 2)) == (None, None)
    world.assign(order, there, [1])
    assert (order.open_lines, order.stations, order.split) == ((), (0, 1), True)
    first = here.open_requests[0]
    world.fulfil(first, pod)
    part = order.parts[0]
    assert (part.skus, part.items, part.unpicked_items, order.unpicked_items) == ((0,), 2, 1, 2)


def test_stations_of_an_order_are_told_once() -> None:
    """In the order of assignment, however many parts they have."""
    world = small_world({"o": ["a", "b", "c"]}, {"p": ["a", "b", "c"]}, capacities=[5, 5])
    order, (here, there) = world.orders[0], world.stations
    for sku, station, period in ((0, there, 1), (1, here, 2), (2, there, 2)):
        world.assign(order, station, [sku], period)
    assert len(order.parts) == 3
    assert order.stations == (1, 0)


def test_a_pods_free_items_are_what_it_has_not_promised(world: Warehouse) -> None:
    """Endless stock stays endless; a SKU that the pod never had is none."""
    (p, q), station = world.pods, world.stations[0]
    assert (p.free_items(0), p.free_items(1), p.free_items(9)) == (2, 1, 0)
    world.bind(p, station)
    world.assign(world.orders[0], station, [0])
    assert (p.free_items(0), p.contents[0]) == (0, 2)
    world.bind(q, station)
    world.assign(world.orders[1], station, [1])
    assert (q.free_items(1), q.contents[1]) == (UNLIMITED, UNLIMITED)
    assert UNLIMITED == 2**40


def test_a_pod_is_where_its_robot_is(world: Warehouse) -> None:
    """From the task on it has a robot, from the lift on no location, and it moves with its robot."""
    pod, robot, station = world.pods[0], world.robots[0], world.stations[0]
    home = pod.cell
    assert (pod.location, pod.robot, robot.idle) == (home, None, True)
    world.bind(pod, station)
    world.take_task(robot, pod)
    assert (pod.location, pod.robot, robot.task, robot.pod, robot.idle) == (home, robot.id, pod.id, None, False)
    assert robot.cell != home == pod.cell
    world.move(robot, home, NORTH)
    world.lift(robot, pod)
    world.move(robot, 5, 2)
    assert (pod.location, pod.cell, pod.bound_for) == (None, 5, (0,))
    assert (robot.pod, robot.cell, robot.heading) == (pod.id, 5, 2)


def test_a_pod_knows_its_stock_as_numbers() -> None:
    """Unlimited is a number, too, so that sums need no special case."""
    pod = Pod(0, PodData("p", ((0, None), (1, 3))), cell=7)
    assert dict(pod.contents) == {0: UNLIMITED, 1: 3}
    assert (pod.cell, pod.location, pod.bound_for) == (7, 7, ())


@pytest.mark.parametrize(("counts_orders", "load"), [(False, 3), (True, 1)])
def test_a_stations_load_is_items_or_orders(counts_orders: bool, load: int) -> None:
    """As its capacity is."""
    world = small_world({"o": {"a": 2, "b": 1}}, {"p": ["a", "b"]}, capacities=[5], counts_orders=counts_orders)
    station = world.stations[0]
    world.assign(world.orders[0], station, [0, 1])
    assert (station.load, station.free_capacity) == (load, 5 - load)


def test_a_stations_requests_and_pods_are_in_order(world: Warehouse) -> None:
    """Requests by age, one a line and promised pod; pods by trip; what no pod holds an item for is uncovered."""
    station, (p, q) = world.stations[0], world.pods
    world.bind(q, station)
    world.bind(p, station)
    for order in world.orders:
        world.assign(order, station, [line.sku for line in order.open_lines])
    requests = [(request.order.name, request.sku, request.items) for request in station.open_requests]
    assert requests == [("first", 0, 2), ("first", 1, 1), ("second", 1, 2)]
    assert station.inbound_pods == (q, p)
    assert station.uncovered_requests == ()
    other = world.stations[1]
    assert (other.open_requests, other.inbound_pods) == ((), ())


def test_a_stations_line_and_room(world: Warehouse) -> None:
    """Robots that stand there and their pods; room is for as many as have not claimed a place, itself included."""
    station, (p, q), (one, other) = world.stations[0], world.pods, world.robots
    room = station.queue_length + 1
    assert station.queue_room == room
    world.place_at_station(one, q, station)
    world.place_at_station(other, p, station)
    assert (station.line, station.pods_in_line, station.queue_room) == ((one, other), (1, 0), room - 2)
    assert (one.cell, other.cell) == (station.cell, station.cells.queue[0])
    world.claim_place(station)
    assert station.queue_room == room - 3


def test_parts_say_what_they_are(world: Warehouse) -> None:
    """For who debugs a rule: names, places, loads."""
    station, pod, robot = world.stations[0], world.pods[0], world.robots[0]
    world.place_at_station(robot, pod, station)
    world.assign(world.orders[0], station, [0])
    assert repr(world.orders[1]) == "Order('second', lines=(OrderLine(sku=1, quantity=2),))"
    assert repr(station.open_requests[0]) == "Request(order='first', sku=0, items=2, station=0, covered=True)"
    assert repr(pod) == "Pod('p', location=None, bound_for=[0])"
    assert repr(station) == "Station(1, load=2/5, open_items=2)"
    assert repr(robot) == f"Robot(1, cell={station.cell}, task=0, pod=0)"


def test_the_picker_is_free_now_or_when_the_item_in_hand_is_handled(world: Warehouse) -> None:
    """A time of the run; it never lies in the past."""
    station = world.stations[0]
    world.advance(4_000)
    assert station.picker_free_s == 4
    world.occupy_picker(station, 17_000)
    assert station.picker_free_s == 17
    world.advance(20_000)
    assert station.picker_free_s == 20


def test_an_item_is_in_hand_until_it_is_handled(world: Warehouse) -> None:
    """It is told by order and SKU."""
    station, pod = world.stations[0], world.pods[0]
    world.assign(world.orders[0], station, [0])
    world.place_at_station(world.robots[0], pod, station)
    request = station.open_requests[0]
    assert station.in_hand is None
    world.fulfil(request, pod, handled=False)
    assert station.in_hand == (request.order.id, 0)
    world.release(request)
    assert station.in_hand is None


def test_a_pod_is_expected_when_its_robot_has_fetched_and_brought_it(world: Warehouse) -> None:
    """The drive there, lifting, and the drive to the station; nobody knows before a robot has the task."""
    station, pod, robot, travel = world.stations[0], world.pods[0], world.robots[0], world.travel
    assert pod.expected_arrival_s is None
    world.bind(pod, station)
    assert pod.expected_arrival_s is None
    world.take_task(robot, pod)
    carry = travel.times_to(station.cell, loaded=True)[pod.location]
    fetch = travel.ticks(robot.cell, robot.heading, world.homes[0], loaded=False)
    assert pod.expected_arrival_s == (fetch + 2200 + carry.min()) / 1000
    world.advance(90_000)
    world.move(robot, world.homes[0], 0)
    world.lift(robot, pod)
    assert pod.expected_arrival_s == 90 + carry[0] / 1000
    world.join_line(robot, station)
    assert pod.expected_arrival_s == 90
    world.leave(robot, pod, station)
    assert pod.expected_arrival_s is None


def test_a_closed_station_has_room_for_nothing(world: Warehouse) -> None:
    """By its timetable or by the activation rule; what it has stays."""
    station = world.stations[0]
    world.assign(world.orders[1], station, [1])
    assert (station.open, station.free_capacity, station.opens_s, station.closes_s) == (True, 3, None, None)
    world.staff(station, True, 60_000)
    world.activate(station, False)
    assert (station.open, station.staffed, station.active, station.closes_s) == (False, True, False, 60)
    world.activate(station, True)
    world.staff(station, False, 90_000)
    assert (station.open, station.free_capacity, station.load) == (False, 0, 2)
    assert (station.opens_s, station.closes_s) == (90, None)


def test_a_robot_off_duty_is_not_idle(world: Warehouse) -> None:
    """Though it has nothing to do."""
    world.put_on_duty(1)
    assert [(robot.on_duty, robot.idle, robot.task) for robot in world.robots] == [
        (True, True, None),
        (False, False, None),
    ]
