"""The view that rules get."""

from __future__ import annotations

import pytest

from rmfs_commands.testing import small_instance, small_world
from rmfs_core.warehouse import Warehouse, WarehouseView


def test_the_view_is_for_looking_only() -> None:
    """What a rule sees cannot be set or filled by accident."""
    world = small_world({"1": ["a"]}, {"p": ["a"]})
    view = WarehouseView(world)
    with pytest.raises(AttributeError):
        view.stations[0].load = 3  # type: ignore[misc]
    with pytest.raises(AttributeError):
        view.pods[0].location = 3  # type: ignore[misc]
    with pytest.raises(AttributeError, match=r"Station\.capacity is read-only"):
        view.stations[0].capacity = 1000
    with pytest.raises(AttributeError):
        view.travel.motion = None  # type: ignore[misc,assignment]
    with pytest.raises(TypeError):
        view.pods[0].contents[0] = 3  # type: ignore[index]
    for array in (view.backlog_lines.sku, view.travel.layout.lane, view.travel.layout.kind):
        with pytest.raises(ValueError, match="read-only"):
            array[:] = 0
    assert isinstance(view.free_storage_locations, tuple)
    view.open_demand()[0] = 99
    assert view.open_demand()[0] == 1


def test_the_view_shows_the_warehouse_as_it_is_now() -> None:
    """Not as it was when the view was made."""
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
    """A location is taken as long as its pod stands there, and from when another pod is on its way to it."""
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


def test_what_the_prefilters_left_is_the_backlog() -> None:
    """Arrays and tuple alike; what has arrived is known all the same."""
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


def test_a_view_of_some_orders_is_of_the_same_kind() -> None:
    """Whatever is left out of a view stays left out where it shows some orders alone."""

    class Reduced(WarehouseView):
        __slots__ = ()

    world = small_world({"1": ["a"], "2": ["a"]}, {"p": ["a"]})
    shown = Reduced(world).showing(world.orders[1:])
    assert isinstance(shown, Reduced)
    assert (shown.backlog, shown.backlog_size, shown.filtered) == (world.orders[1:], 1, True)


def test_demand_is_what_is_not_picked_yet() -> None:
    """In the backlog or at a station; what inbound pods have to spare is counted for each station."""
    world = small_world({"1": {"a": 2}, "2": ["a", "b"]}, {"p": {"a": 4, "b": 1}, "q": {"b": 3}}, capacities=[5, 5])
    view, (here, there), (p, q) = WarehouseView(world), world.stations, world.pods
    assert view.open_demand().tolist() == [3, 1]
    world.place_at_station(world.robots[0], p, here)
    world.bind(q, there)
    world.assign(world.orders[0], here, [0])
    assert view.open_demand().tolist() == [3, 1]
    assert view.available().tolist() == [[2, 1], [0, 3]]
    world.fulfil(here.open_requests[0], p)
    assert view.open_demand().tolist() == [2, 1]
    assert view.available().tolist() == [[2, 1], [0, 3]]  # the other item is still promised
    assert (view.n_skus, view.unlimited_stock) == (2, False)
    assert (view.pods_with(1), view.pods_with(0)) == ((p, q), (p,))


def test_an_order_fits_where_there_is_room_for_what_is_open() -> None:
    """Items or orders, as the station counts; lines that are assigned already take up nothing more."""
    world = small_world({"1": {"a": 3, "b": 1}}, {"p": ["a", "b"]}, capacities=[4, 3])
    view, (wide, narrow), order = WarehouseView(world), world.stations, world.orders[0]
    assert [view.fits(order, station) for station in (wide, narrow)] == [True, False]
    world.assign(order, wide, [1])
    assert (view.size_at(order, narrow), view.fits(order, narrow)) == (3, True)
    assert view.split_orders_open == 1


def test_what_is_available_follows_pods_and_promises() -> None:
    """Items are there when a pod is bound, less what is promised; picks and leaving take the rest away."""
    world = small_world({"1": ["a"]}, {"p": {"a": 3, "b": 2}}, capacities=[5, 5])
    view, pod, (station, other) = WarehouseView(world), world.pods[0], world.stations
    assert view.available().tolist() == [[0, 0], [0, 0]]
    world.bind(pod, station)
    world.bind(pod, other)
    assert view.available().tolist() == [[3, 2], [3, 2]]
    world.assign(world.orders[0], station, [0])
    assert view.available().tolist() == [[2, 2], [2, 2]]
    world.take_task(world.robots[0], pod)
    world.lift(world.robots[0], pod)
    world.join_line(world.robots[0], station)
    (request,) = station.open_requests
    world.fulfil(request, pod)
    assert view.available().tolist() == [[2, 2], [2, 2]]
    world.leave(world.robots[0], pod, station)
    assert view.available().tolist() == [[0, 0], [2, 2]]
    view.available()[1, 1] = 9
    assert view.available()[1, 1] == 2


def test_items_ordered_until_now_are_counted() -> None:
    """Of all orders that have arrived, assigned or picked or not."""
    world = small_world({"1": {"a": 3}, "2": {"b": 1, "a": 1}}, {"p": {"a": 2, "b": 1}})
    world.assign(world.orders[0], world.stations[0], [0])
    assert WarehouseView(world).ordered().tolist() == [4, 1]
