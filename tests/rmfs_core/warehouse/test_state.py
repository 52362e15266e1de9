"""The warehouse's state: capacity, parts, promises of items to requests, the backlog."""

import pytest

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import WarehouseView, columns_of
from rmfs_core.warehouse.backlog import Backlog, lines_in
from rmfs_core.warehouse.promises import next_request
from standing import put_at_station


def test_a_part_takes_up_capacity_until_its_last_item_is_picked() -> None:
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


def test_order_capacity_counts_orders_and_joins_parts() -> None:
    world = small_world({"1": ["a", "b", "c"], "2": ["a"]}, {"p": ["a", "b", "c"]}, capacities=[2], counts_orders=True)
    view = WarehouseView(world)
    assert view.size_at(world.orders[0], world.stations[0]) == 1
    world.assign(world.orders[0], world.stations[0], [0, 1, 2])
    assert world.stations[0].free_capacity == 1
    assert world.fits_smallest(single_line=False)
    world.assign(world.orders[1], world.stations[0], [0])
    assert not view.fits(world.orders[1], world.stations[0])
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


def test_orders_larger_than_any_station() -> None:
    world = small_world({"1": {"a": 5}, "2": {"a": 3}, "3": {"a": 1}}, {"p": ["a"]}, capacities=[3, 4])
    view, (large, small, one), (first, second) = WarehouseView(world), world.orders, world.stations
    assert [view.size_at(large, station) for station in world.stations] == [3, 4]
    assert [view.size_at(small, station) for station in world.stations] == [3, 3]
    world.assign(one, second, [0])
    assert (view.fits(large, first), view.fits(large, second)) == (True, False)
    world.assign(large, first, [0])
    assert (first.load, first.free_capacity) == (5, 0)
    assert not view.fits(small, first)
    world = small_world({"1": {"a": 5}, "2": {"a": 1}}, {"p": ["a"]}, capacities=[3])
    world.assign(world.orders[1], world.stations[0], [0])
    put_at_station(world, 0)
    assert not world.fits_smallest(single_line=False)
    request = next_request(world.stations[0], world.pods[0])
    assert request is not None
    world.fulfil(request, world.pods[0])
    assert world.fits_smallest(single_line=False)


def test_parts_of_periods() -> None:
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


def test_pods_are_sent_and_robots_charged_otherwise() -> None:
    world = small_world({}, {"p": ["a"], "q": ["a"]}, capacities=[5, 5])
    for pod in world.pods:
        for station in world.stations:
            world.bind(pod, station)
    world.reroute(world.pods[0], [1, 0])
    assert [pod.bound_for for pod in world.pods] == [(1, 0), (0, 1)]
    assert [[pod.id for pod in station.inbound_pods] for station in world.stations] == [[0, 1], [0, 1]]
    robot = (world := small_world({}, {"p": ["a"]})).robots[0]
    assert (robot.charge, robot.low) == (None, False)
    world.put_battery(robot, 0.25, low=True)
    assert (robot.charge, robot.low, robot.idle) == (0.25, True, False)
    world.put_battery(robot, 0.5, low=False)
    assert (robot.charge, robot.low, robot.idle) == (0.5, False, True)


def test_a_secured_item_is_not_given_away() -> None:
    world = small_world({"1": ["a"], "2": ["a"]}, {"p": {"a": 1}, "q": {"a": 1}}, capacities=[5, 5])
    here, there = world.stations
    first, second = world.pods
    world.bind(second, here)
    world.assign(world.orders[0], here, [0])
    put_at_station(world, first.id)
    world.bind(first, there)
    request = next_request(here, first)
    assert request is not None
    world.promises.secure(request, first)
    world.assign(world.orders[1], there, [0], period=2)
    assert [r.covered for r in there.open_requests] == [False]
    world.fulfil(request, first)
    assert first.free_items(0) == 0


def test_a_later_request_of_the_period_moves_an_earlier_promise() -> None:
    for later in (1, 2):
        world = small_world({"1": ["a"], "2": ["a"]}, {"p": {"a": 1}, "q": {"a": 1}}, capacities=[5, 5])
        here, there = world.stations
        for station, pod in ((here, 0), (here, 1), (there, 0)):
            world.bind(world.pods[pod], station)
        world.assign(world.orders[0], here, [0])
        world.assign(world.orders[1], there, [0], period=later)
        assert [r.covered for r in (*here.open_requests, *there.open_requests)] == [True, later == 1]


def test_the_backlog_follows_what_joins_and_leaves() -> None:
    world = small_world({"1": {"a": 2, "b": 1}, "2": {"b": 3}}, {"p": ["a", "b"]}, capacities=[9])
    backlog, station = world.backlog, world.stations[0]
    assert (len(backlog), dict(backlog.sizes), dict(backlog.line_sizes)) == (2, {3: 2}, {2: 1, 1: 1, 3: 1})
    world.assign(world.orders[0], station, [0])
    assert (backlog.lines.order_id.tolist(), backlog.lines.sku.tolist()) == ([0, 1], [1, 1])
    assert backlog.lines is backlog.lines
    world.assign(world.orders[0], station, [1])
    assert [order.id for order in backlog.orders] == [1]
    assert world.orders[0] not in backlog
    assert (dict(backlog.sizes), dict(backlog.line_sizes)) == ({3: 1}, {3: 1})
    world = small_world({"1": ["a"], "2": {"a": 1, "b": 2}, "3": ["b"], "4": ["a"]}, {"p": ["a", "b"]}, capacities=[9])
    first, second, third, fourth = world.orders
    backlog = Backlog(world.n_skus)
    backlog.add(second, third)
    backlog.close(second, [0])
    backlog.add(fourth)
    backlog.add(first)
    assert backlog.orders == (first, second, third, fourth)
    assert backlog.lines.order_id.tolist() == [0, 1, 2, 3]
    assert backlog.lines.sku.tolist() == [0, 1, 1, 0]
    assert (dict(backlog.sizes), dict(backlog.line_sizes)) == ({2: 1, 1: 3}, {2: 1, 1: 3})
    backlog.close(second, [1])
    assert backlog.orders == (first, third, fourth)
    world = small_world({"1": {"a": 2, "b": 1}, "2": {"b": 2}}, {"p": ["a", "b"]})
    first, second = world.orders
    world.assign(first, world.stations[0], [1])
    lines = lines_in(columns_of((second, first), world.n_skus))
    assert [lines.order.tolist(), lines.sku.tolist(), lines.quantity.tolist()] == [[0, 1], [1, 0], [2, 2]]
    assert len(lines_in(columns_of((), 2)).order) == 0
    with pytest.raises(ValueError, match="read-only"):
        lines.quantity[0] = 1
