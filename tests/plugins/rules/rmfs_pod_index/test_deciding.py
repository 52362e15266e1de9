"""A period from what is seen to what is decided."""

from __future__ import annotations

from collections.abc import Callable

from rmfs_core import PodTrip
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_pod_index import PodIndex
from rmfs_pod_index.deciding import Deciding
from rmfs_pod_index.known import Known
from rmfs_testing import small_world


def test_a_pod_at_a_station_that_it_serves_is_not_to_be_had(
    put_at_station: Callable[[Warehouse, int, int], None],
) -> None:
    """One that leaves is, as is one that is stored."""
    world = small_world({"1": ["a"], "2": ["b"]}, {"p": ["a"], "q": ["b"], "r": ["a"]}, capacities=[2, 2])
    put_at_station(world, 0, 0)
    put_at_station(world, 1, 1)
    world.assign(world.orders[0], world.stations[0], [0])
    view = WarehouseView(world)
    known = Known(PodIndex(), view)
    known.hear(view)
    assert Deciding(known, view).busy() == [0]


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


def test_where_equal_pods_are_is_asked_anew() -> None:
    """Both have the SKU; where they were when last asked would make the other one the nearer."""
    world = small_world({"1": ["a"]}, {str(i): ["a"] for i in range(2)}, capacities=[1])
    view = WarehouseView(world)
    known = Known(PodIndex(), view)
    known.hear(view)
    (trip,) = Deciding(known, view).decision().trips
    cells = known.account.period.pods["cell"]
    cells[:] = cells[::-1].copy()
    (again,) = Deciding(known, view).decision().trips
    assert again.pod == trip.pod
    assert cells.tolist() == [pod.cell for pod in world.pods]
