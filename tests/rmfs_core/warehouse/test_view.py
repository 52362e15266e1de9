"""Orders, pods, stations, robots and their batteries, as rules see them in the view."""

import pytest

from rmfs_commands.processes.battery import Battery
from rmfs_commands.testing import small_instance, small_world
from rmfs_core.scenario.model import BatterySection
from rmfs_core.warehouse import Station, Warehouse, WarehouseView
from rmfs_core.warehouse.parts import OrderLine
from rmfs_core.world import StationCells


@pytest.fixture
def world() -> Warehouse:
    """One order of three items and one of two; a pod with two of a, another with endless b; two stations."""
    return small_world(
        {"first": {"a": 2, "b": 1}, "second": {"b": 2}}, {"p": {"a": 2, "b": 1}, "q": ["b"]}, capacities=[5, 5]
    )


def test_what_is_set_once_stays(world: Warehouse) -> None:
    things = (world.orders[0], world.pods[0], world.stations[0], world.robots[0])
    for thing, name in zip(things, ("items", "name", "capacity", "id"), strict=True):
        with pytest.raises(AttributeError, match=rf"^{type(thing).__name__}\.{name} is read-only$"):
            setattr(thing, name, 3)
    assert Station(0, StationCells(3, (4,)), 5, False, 1, name="north").label == "north (id 0)"


def test_an_order_is_open_until_it_is_assigned_and_unpicked_until_it_is_picked(world: Warehouse) -> None:
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


def test_a_stations_line_and_room(world: Warehouse) -> None:
    station, (p, q), (one, other) = world.stations[0], world.pods, world.robots
    room = station.queue_length + 1
    assert station.queue_room == room
    world.place_at_station(one, q, station)
    world.place_at_station(other, p, station)
    assert (station.line, station.pods_in_line, station.queue_room) == ((one, other), (1, 0), room - 2)
    assert (one.cell, other.cell) == (station.cell, station.cells.queue[0])
    world.claim_slot(station)
    assert station.queue_room == room - 3


def test_parts_say_what_they_are(world: Warehouse) -> None:
    station, pod, robot = world.stations[0], world.pods[0], world.robots[0]
    world.place_at_station(robot, pod, station)
    world.assign(world.orders[0], station, [0])
    assert repr(world.orders[1]) == "Order('second', lines=(OrderLine(sku=1, quantity=2),))"
    assert repr(station.open_requests[0]) == "Request(order='first', sku=0, items=2, station=0, covered=True)"
    assert repr(pod) == "Pod('p', location=None, bound_for=[0])"
    assert repr(station) == "Station(1, load=2/5, open_items=2)"
    assert repr(robot) == f"Robot(1, cell={station.cell}, task=0, pod=0)"


def test_the_picker_is_free_now_or_when_the_item_in_hand_is_handled(world: Warehouse) -> None:
    station = world.stations[0]
    world.advance(4_000)
    assert station.picker_free_s == 4
    world.occupy_picker(station, 17_000)
    assert station.picker_free_s == 17
    world.advance(20_000)
    assert station.picker_free_s == 20


def test_an_item_is_in_hand_until_it_is_handled(world: Warehouse) -> None:
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


def test_the_view_is_for_looking_only() -> None:
    view = WarehouseView(small_world({"1": ["a"]}, {"p": ["a"]}))
    for thing, name in ((view.stations[0], "load"), (view.pods[0], "location"), (view.travel, "motion")):
        with pytest.raises(AttributeError):
            setattr(thing, name, 3)
    with pytest.raises(TypeError):
        view.pods[0].contents[0] = 3  # type: ignore[index]
    lines, stock, layout = view.lines, view.stock, view.travel.layout
    for array in (view.backlog_lines.sku, view.free_items.number, lines.items, stock.items, layout.lane, layout.kind):
        with pytest.raises(ValueError, match="read-only"):
            array[:] = 0
    assert isinstance(view.free_storage_locations, tuple)
    view.open_demand()[0] = view.available()[0, 0] = 99
    assert (view.open_demand()[0], view.available()[0, 0]) == (1, 0)


def test_the_view_shows_the_warehouse_as_it_is_now() -> None:
    world = small_world({"1": ["a"], "2": ["b"]}, {"p": ["a"], "q": ["b"]}, capacities=[5])
    view = WarehouseView(world)
    pod, robot, station = world.pods[0], world.robots[0], world.stations[0]
    assert (view.now_tick, view.now_s) == (0, 0.0)
    assert (view.free_pods, view.waiting_pods, view.idle_robots) == (world.pods, (), world.robots)
    world.advance(1500)
    world.bind(pod, station)
    assert (view.now_tick, view.now_s) == (1500, 1.5)
    assert (view.free_pods, view.waiting_pods) == (world.pods[1:], (pod,))
    world.take_task(robot, pod)
    assert (view.waiting_pods, view.idle_robots) == ((), world.robots[1:])
    assert view.order(1) is world.orders[1]
    with pytest.raises(KeyError):
        view.order(2)


def test_pods_leave_when_they_have_nothing_left_to_serve() -> None:
    """Standing at a station, bound nowhere else, no request that they could serve."""
    world = small_world({"1": ["a"]}, {"p": ["a"], "q": ["a"]}, capacities=[5, 5])
    view, (here, there), pod = WarehouseView(world), world.stations, world.pods[0]
    world.place_at_station(world.robots[0], pod, here)
    assert view.leaving_pods == (pod,)
    world.assign(world.orders[0], here, [0])
    assert view.leaving_pods == ()
    world.fulfil(here.open_requests[0], pod)
    assert view.leaving_pods == (pod,)
    world.bind(pod, there)
    assert view.leaving_pods == ()


def test_locations_are_free_blocked_or_reserved() -> None:
    world = small_world({"1": ["a"]}, {"p": ["a"], "q": ["a"]}, capacities=[5])
    view, pod = WarehouseView(world), world.pods[0]
    home, other = pod.cell, world.pods[1].cell
    assert view.home(pod) == home
    assert not {home, other} & set(view.free_storage_locations)
    world.place_at_station(world.robots[0], pod, world.stations[0])
    assert home in view.free_storage_locations
    world.reserve(home)
    assert (home in view.free_storage_locations, view.reserved_locations) == (False, (home,))
    assert view.free_storage_locations == tuple(sorted(view.free_storage_locations))
    assert view.blocked_locations == ()
    assert view.home(pod) == home
    blocked = Warehouse(
        small_instance({}, {"p": ["a"]}), world.travel, world.stations, [], [home], blocked=[world.homes[1], 3, 2]
    )
    assert WarehouseView(blocked).blocked_locations == tuple(sorted((other, 3, 2)))


def test_backlogs_of_views() -> None:
    world = small_world({"1": ["a"], "2": {"b": 2}, "3": ["a", "b"]}, {"p": ["a", "b"]}, capacities=[5])
    whole = WarehouseView(world)
    assert (whole.filtered, [order.name for order in whole.backlog]) == (False, ["1", "2", "3"])
    assert whole.backlog_lines.order.tolist() == [0, 1, 2, 2]
    left = WarehouseView(world, [world.orders[2], world.orders[1]])
    assert (left.filtered, [order.name for order in left.backlog]) == (True, ["3", "2"])
    lines = left.backlog_lines
    assert [lines.order.tolist(), lines.sku.tolist(), lines.quantity.tolist()] == [[0, 0, 1], [0, 1, 1], [1, 1, 2]]
    assert left.backlog_lines is lines
    assert left.orders == whole.orders == world.orders

    class Reduced(WarehouseView):
        __slots__ = ()

    world = small_world({"1": ["a"], "2": ["a"]}, {"p": ["a"]})
    shown = Reduced(world).showing(world.orders[1:])
    assert isinstance(shown, Reduced)
    assert (shown.backlog, shown.backlog_size, shown.filtered) == (world.orders[1:], 1, True)


def test_a_robot_that_works_draws_nothing_for_standing() -> None:
    """It stands for 20 s at 20 W and drives for 5 s at 100 W; then it is charged for 8 s at 500 W, and drives for 2."""
    clock = [0]
    section = BatterySection(capacity_wh=10, empty_w=100, idle_w=20, charging_w=500)
    battery = Battery(section, 0.0, lambda: clock[0], charge=0.5)
    clock[0] = 25_000
    battery.work(5_000, section.empty_w, charging=False)
    assert battery.left_j(25_000, charging=False) == 18_000 - 20 * 20 - 5 * 100
    clock[0] = 35_000
    battery.work(2_000, section.empty_w, charging=True)
    assert battery.left_j(35_000, charging=False) == 17_100 + 8 * 500 - 2 * 100
