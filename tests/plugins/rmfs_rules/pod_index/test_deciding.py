"""A period from what is seen to what is decided."""

from __future__ import annotations

from collections.abc import Callable

from rmfs_commands.testing import small_world
from rmfs_core import PodTrip
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.pod_index import PodIndex
from rmfs_rules.pod_index.deciding import told


def test_a_pod_at_a_station_that_it_serves_is_not_to_be_had(
    put_at_station: Callable[[Warehouse, int, int], None],
) -> None:
    """One that leaves is: that whose SKU is not the one that was assigned."""

    def sent(assigned: int) -> list[PodTrip]:
        world = small_world({"1": ["a"], "2": ["b"], "3": ["a"]}, {"p": ["a"], "q": ["b"]}, capacities=[1, 1])
        put_at_station(world, 0, 0)
        world.assign(world.orders[assigned], world.stations[0], [assigned])
        return list(PodIndex().assign_orders_and_pods(WarehouseView(world)).trips)

    assert sent(0) == [PodTrip(1, 1)]
    assert sent(1) == [PodTrip(0, 1)]


def test_the_nearest_of_equal_pods_is_sent_from_where_it_is_now(
    put_at_station: Callable[[Warehouse, int, int], None],
) -> None:
    """Both have the SKU; the nearer one visits the station, and is put down farther away than the other one."""
    world = small_world({"1": ["a"]}, {"p": ["a"], "q": ["a"]}, capacities=[1])
    view, station, rule = WarehouseView(world), world.stations[0], PodIndex()
    (trip,) = rule.assign_orders_and_pods(view).trips
    put_at_station(world, trip.pod, 0)
    pod, robot = world.pods[trip.pod], station.line[0]
    world.leave(robot, pod, station)
    to_station = view.travel.times_to(station.cell, True).min(axis=1)
    far = max(world.free_locations, key=lambda cell: int(to_station[cell]))
    assert to_station[far] > to_station[world.pods[1 - trip.pod].cell]
    world.reserve(far)
    world.move(robot, far, 0)
    world.store(robot, pod)
    assert list(rule.assign_orders_and_pods(view).trips) == [PodTrip(1 - trip.pod, 0)]


def test_what_is_told_of_stations() -> None:
    """One of them is kept for something else."""
    world = small_world({"1": ["a", "b"]}, {"p": ["a"]}, capacities=[2, 3])
    world.assign(world.orders[0], world.stations[0], [0])
    world.bind(world.pods[0], world.stations[1])
    stations = told(world.stations, without=world.stations[1])
    assert (stations.room.tolist(), stations.load.tolist(), stations.capacity.tolist()) == ([1, 0], [1, 0], [2, 3])
    assert (stations.inbound.tolist(), stations.counts_orders.tolist()) == ([0, 1], [0, 0])
    assert stations.going_on.tolist() == [1, 0]
