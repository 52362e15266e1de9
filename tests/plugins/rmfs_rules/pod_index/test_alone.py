"""An order that an empty station takes alone, and the pods that are sent for it."""

from __future__ import annotations

from collections.abc import Callable

from rmfs_commands.testing import small_world
from rmfs_core import JointDecision, OrderAssignment
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.helpers import ticks_to_station
from rmfs_rules.helpers.oversize import Oversize
from rmfs_rules.pod_index.alone import assign_alone

Put = Callable[[Warehouse, int, int], None]


def sent(world: Warehouse, station: int = 0) -> list[str] | None:
    """Return the names of the pods that are sent for the first order, None where it is not assigned."""
    decision = assign_alone(WarehouseView(world), Oversize(world.orders[0], world.stations[station], True))
    if decision == JointDecision():
        return None
    assert list(decision.assignments) == [OrderAssignment(0, station)]
    assert all(trip.station == station for trip in decision.trips)
    return [world.pods[trip.pod].name for trip in decision.trips]


def test_the_pods_with_most_of_what_is_missing_are_sent() -> None:
    """r has most of both lines; then q has the other item of b, and p nothing that is still wanted."""
    pods = {"p": {"a": 2}, "q": {"b": 1, "z": 9}, "r": {"a": 3, "b": 2}}
    assert sent(small_world({"1": {"a": 3, "b": 3}}, pods, capacities=[4])) == ["r", "q"]


def test_the_nearest_of_equals_is_sent() -> None:
    """All eight have enough; the nearest is not the first one of them."""
    pods = {str(i): ["a"] if i else ["b"] for i in range(9)}
    world = small_world({"1": {"a": 5}}, pods, capacities=[4])
    ticks = [ticks_to_station(WarehouseView(world), pod, world.stations[0]) for pod in world.pods]
    nearest = min(range(1, 9), key=lambda pod: ticks[pod])
    assert ticks[nearest] < ticks[1]
    assert sent(world) == [str(nearest)]


def test_what_pods_have_that_are_there_need_not_be_brought(put_at_station: Put) -> None:
    """q brings the one item that p lacks; without q nothing is assigned."""
    pods = {"p": {"a": 4}, "q": {"a": 1}}
    world = small_world({"1": {"a": 5}}, pods, capacities=[4])
    put_at_station(world, 0, 0)
    assert sent(world) == ["q"]
    world = small_world({"1": {"a": 5}}, {"p": {"a": 4}}, capacities=[4])
    put_at_station(world, 0, 0)
    assert sent(world) is None


def test_pods_that_serve_elsewhere_are_not_to_be_had(put_at_station: Put) -> None:
    """Once p leaves the other station it is."""
    world = small_world({"1": {"a": 5}, "2": ["a"]}, {"p": {"a": 6}}, capacities=[4, 4])
    put_at_station(world, 0, 1)
    assert sent(world) == ["p"]
    world.assign(world.orders[1], world.stations[1], [0])
    assert sent(world) is None
