"""The warehouse's state: capacity, parts, the backlog."""

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import WarehouseView
from rmfs_core.warehouse.promises import next_request
from standing import put_at_station


def test_a_part_takes_up_capacity_until_its_last_item_is_picked() -> None:
    """Three items stay counted while one of them is left, and are free all at once then (spec: item capacity)."""
    world = small_world({"1": ["a", "b", "c"]}, {"p": ["a", "b", "c"]}, capacities=[5])
    station, pod = world.stations[0], world.pods[0]
    put_at_station(world, 0)
    world.assign(world.orders[0], station, [0, 1, 2])
    free = []
    while (request := next_request(station, pod)) is not None:
        free.append(station.free_capacity)
        world.fulfil(request, pod)
    assert free == [2, 2, 2]
    assert station.free_capacity == 5


def test_order_capacity_counts_orders() -> None:
    """With order capacity each order takes one place, however many items it has."""
    world = small_world({"1": ["a", "b", "c"], "2": ["a"]}, {"p": ["a", "b", "c"]}, capacities=[2], counts_orders=True)
    view = WarehouseView(world)
    assert view.size_at(world.orders[0], world.stations[0]) == 1
    world.assign(world.orders[0], world.stations[0], [0, 1, 2])
    assert world.stations[0].free_capacity == 1
    assert world.fits_smallest(single_line=False)
    world.assign(world.orders[1], world.stations[0], [0])
    assert not view.fits(world.orders[1], world.stations[0])


def test_with_order_capacity_a_later_part_joins_the_earlier_one() -> None:
    """It takes no further place while the earlier one is there; the place is free when both are picked."""
    world = small_world({"1": ["a", "b"], "2": ["a"]}, {"p": ["a", "b"]}, capacities=[1], counts_orders=True)
    order, station = world.orders[0], world.stations[0]
    put_at_station(world, 0)
    world.assign(order, station, [0], period=1)
    assert (world.size_at(order, station), world.size_at(world.orders[1], station)) == (0, 1)
    world.assign(order, station, [1], period=2)
    free = []
    while (request := next_request(station, world.pods[0])) is not None:
        free.append(station.free_capacity)
        world.fulfil(request, world.pods[0])
    assert free == [0, 0]
    assert station.free_capacity == 1


def test_an_order_larger_than_any_station_takes_all_of_an_empty_one() -> None:
    """It fits when the station is empty, a smaller station as well; until it is picked nothing else does."""
    world = small_world({"1": {"a": 5}, "2": {"a": 3}, "3": {"a": 1}}, {"p": ["a"]}, capacities=[3, 4])
    view, (large, small, one), (first, second) = WarehouseView(world), world.orders, world.stations
    assert [view.size_at(large, station) for station in world.stations] == [3, 4]
    assert [view.size_at(small, station) for station in world.stations] == [3, 3]
    world.assign(one, second, [0])
    assert (view.fits(large, first), view.fits(large, second)) == (True, False)
    world.assign(large, first, [0])
    assert (first.load, first.free_capacity) == (5, 0)
    assert not view.fits(small, first)


def test_a_rule_is_asked_when_a_station_is_empty_for_an_order_larger_than_any() -> None:
    """Else only when the smallest order fits."""
    world = small_world({"1": {"a": 5}, "2": {"a": 1}}, {"p": ["a"]}, capacities=[3])
    world.assign(world.orders[1], world.stations[0], [0])
    put_at_station(world, 0)
    assert not world.fits_smallest(single_line=False)
    request = next_request(world.stations[0], world.pods[0])
    assert request is not None
    world.fulfil(request, world.pods[0])
    assert world.fits_smallest(single_line=False)


def test_one_period_makes_one_part_of_an_order_at_a_station() -> None:
    """Lines assigned one by one in the same period count together until the last is picked; the order is not split."""
    world = small_world({"1": ["a", "b", "c"]}, {"p": ["a", "b", "c"]}, capacities=[5])
    order, station = world.orders[0], world.stations[0]
    put_at_station(world, 0)
    for sku in range(3):
        world.assign(order, station, [sku], period=1)
    assert not order.split
    assert world.split_orders_open == 0
    first = next_request(station, world.pods[0])
    assert first is not None
    world.fulfil(first, world.pods[0])
    assert station.load == 3


def test_a_partly_assigned_order_keeps_its_age() -> None:
    """Lines left over stay in the backlog in the order's old place; the order counts as split until it is picked."""
    world = small_world({"1": ["a", "b"], "2": ["a"]}, {"p": ["a", "b"]})
    world.assign(world.orders[0], world.stations[0], [1])
    assert [order.name for order in world.backlog.orders] == ["1", "2"]
    assert [line.sku for line in world.orders[0].open_lines] == [0]
    assert world.split_orders_open == 1
    lines = world.backlog.lines
    assert (lines.order.tolist(), lines.sku.tolist()) == ([0, 1], [0, 0])
    world.assign(world.orders[0], world.stations[0], [0], period=2)
    put_at_station(world, 0)
    while (request := next_request(world.stations[0], world.pods[0])) is not None:
        world.fulfil(request, world.pods[0])
    assert world.split_orders_open == 0


def test_requests_of_a_station_are_given_other_ids() -> None:
    """They are served in the order told; the next request has an id after all of them."""
    world = small_world({"1": ["a", "b"], "2": ["a"]}, {"p": ["a", "b"]}, capacities=[5])
    station = world.stations[0]
    world.assign(world.orders[0], station, [0, 1])
    first, second = station.open_requests
    world.renumber(station, [(4, second, 1), (7, first, 1)])
    assert [(request.id, request.sku) for request in station.open_requests] == [(4, 1), (7, 0)]
    put_at_station(world, 0)
    served = next_request(station, world.pods[0])
    assert served is not None
    assert served.id == 4
    world.assign(world.orders[1], station, [0])
    assert [request.id for request in station.open_requests] == [4, 7, 8]


def test_a_pod_visits_its_stations_in_another_order() -> None:
    """Each station expects its pods as their trips were decided, all the same."""
    world = small_world({}, {"p": ["a"], "q": ["a"]}, capacities=[5, 5])
    for pod in world.pods:
        for station in world.stations:
            world.bind(pod, station)
    world.reroute(world.pods[0], [1, 0])
    assert [pod.bound_for for pod in world.pods] == [(1, 0), (0, 1)]
    assert [[pod.id for pod in station.inbound_pods] for station in world.stations] == [[0, 1], [0, 1]]


def test_a_robot_is_given_a_battery_as_it_is_at_a_moment() -> None:
    """How full it is, and whether that is too low for a task."""
    robot = (world := small_world({}, {"p": ["a"]})).robots[0]
    assert (robot.charge, robot.low) == (None, False)
    world.put_battery(robot, 0.25, low=True)
    assert (robot.charge, robot.low, robot.idle) == (0.25, True, False)
    world.put_battery(robot, 0.5, low=False)
    assert (robot.charge, robot.low, robot.idle) == (0.5, False, True)
