"""The turns of stations."""

from __future__ import annotations

from collections.abc import Callable

from rmfs_commands.testing import small_world
from rmfs_core import PodTrip
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.pod_index import PodIndex


def test_the_station_with_the_fewest_pods_is_first(put_at_station: Callable[[Warehouse, int, int], None]) -> None:
    """Of two with a free place, the one without a pod gets the pod and the line."""
    world = small_world({"1": ["a"]}, {"p": ["z"], "q": ["a"]}, capacities=[1, 1])
    put_at_station(world, 0, 0)
    decision = PodIndex(urge_s=0).assign_orders_and_pods(WarehouseView(world))
    assert list(decision.trips) == [PodTrip(1, 1)]
    assert [(one.order, one.station) for one in decision.assignments] == [(0, 1)]


def test_a_pod_is_sent_once_in_a_period() -> None:
    """It serves the station that it was sent to; the other has nothing to take."""
    world = small_world({"1": ["a"], "2": ["a"], "3": ["a"]}, {"p": ["a"]}, capacities=[2, 2])
    decision = PodIndex(urge_s=0).assign_orders_and_pods(WarehouseView(world))
    assert list(decision.trips) == [PodTrip(0, 0)]
    assert [(one.order, one.station) for one in decision.assignments] == [(0, 0), (1, 0)]
