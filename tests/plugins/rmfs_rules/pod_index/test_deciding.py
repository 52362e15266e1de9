"""A period from what is seen to what is decided."""

from __future__ import annotations

from collections.abc import Callable

from rmfs_commands.testing import small_world
from rmfs_core import PodTrip
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.pod_index import PodIndex
from rmfs_rules.pod_index.deciding import Deciding
from rmfs_rules.pod_index.known import Known


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


def test_what_is_decided_leaves_nothing_to_decide() -> None:
    """Until something happens: the same world is looked at once."""
    world = small_world({"1": ["a"], "2": ["b"]}, {"p": ["a"], "q": ["b"]}, capacities=[1])
    view = WarehouseView(world)
    known = Known(PodIndex(most_pods=1), view)
    known.hear(view)
    decision = Deciding(known, view).decision()
    assert list(decision.trips) == [PodTrip(0, 0)]
    world.assign(world.orders[0], world.stations[0], [0])
    world.bind(world.pods[0], world.stations[0])
    known.hear(view)
    assert known.nothing_to_do(view)
    assert known.nothing_to_do(view)
    request = world.stations[0].open_requests[0]
    world.close(request)
    world.release(request)
    known.hear(view)
    assert not known.nothing_to_do(view)


def test_where_equal_pods_are_is_known_when_they_have_moved(
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
