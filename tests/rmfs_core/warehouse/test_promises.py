"""Promises of items to requests: held against stock, whatever is done."""

from hypothesis import given, settings
from hypothesis import strategies as st

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_core.warehouse.promises import next_request
from standing import put_at_station


def test_a_secured_item_is_not_given_away() -> None:
    """From the start of a pick its item is promised to it: an order that comes meanwhile is not covered by it."""
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
    check_promises(world)


def test_an_item_is_promised_once() -> None:
    """Two requests for a SKU, one item inbound: one request is covered, the other waits for a second pod."""
    world = small_world({"1": ["a"], "2": ["a"]}, {"p": {"a": 1}, "q": {"a": 1}})
    station = world.stations[0]
    world.bind(world.pods[0], station)
    for order in world.orders:
        world.assign(order, station, [0])
    assert [request.covered for request in station.open_requests] == [True, False]
    assert WarehouseView(world).available()[0, 0] == 0
    world.bind(world.pods[1], station)
    assert all(request.covered for request in station.open_requests)


def test_what_comes_first_serves_the_oldest_and_promises_follow() -> None:
    """A pod that overtakes serves the oldest request although its item was promised to a younger one."""
    world = small_world({"1": ["a"], "2": ["a"]}, {"p": {"a": 1}, "q": {"a": 1}})
    station, (first, second) = world.stations[0], world.pods
    for order in world.orders:
        world.assign(order, station, [0])
    world.bind(first, station)
    put_at_station(world, second.id)
    oldest, younger = station.open_requests
    assert next_request(station, second) is oldest
    world.fulfil(oldest, second)
    assert younger.covered
    assert second.contents[0] == 0
    assert first.free_items(0) == 0
    assert next_request(station, second) is None


def test_an_item_promised_elsewhere_is_not_served_here() -> None:
    """A pod bound for two stations keeps the item it promised to the second when it stands at the first."""
    world = small_world({"1": ["a"], "2": ["a"]}, {"p": {"a": 1}, "q": {"a": 1}}, capacities=[5, 5])
    here, there = world.stations
    pod = world.pods[0]
    world.bind(pod, here)
    world.bind(pod, there)
    world.assign(world.orders[0], there, [0])
    put_at_station(world, 1, 0)
    world.assign(world.orders[1], here, [0])
    assert [request.pod for request in here.open_requests] == [world.pods[1]]
    assert next_request(here, pod) is None


def test_a_later_request_of_the_period_moves_an_earlier_promise() -> None:
    """The first pod goes to both stations, the second to one: an item moves to the second, but not to a later period's.

    So a decision is refused only if no choice of promises serves it.
    """
    for later in (1, 2):
        world = small_world({"1": ["a"], "2": ["a"]}, {"p": {"a": 1}, "q": {"a": 1}}, capacities=[5, 5])
        here, there = world.stations
        for station, pod in ((here, 0), (here, 1), (there, 0)):
            world.bind(world.pods[pod], station)
        world.assign(world.orders[0], here, [0])
        world.assign(world.orders[1], there, [0], period=later)
        assert [r.covered for r in (*here.open_requests, *there.open_requests)] == [True, later == 1]
        check_promises(world)


@given(
    stock=st.lists(st.dictionaries(st.sampled_from("abc"), st.integers(1, 3), min_size=1), min_size=1, max_size=4),
    orders=st.lists(st.dictionaries(st.sampled_from("abc"), st.integers(1, 2), min_size=1), min_size=1, max_size=5),
    data=st.data(),
)
@settings(deadline=None)
def test_promises_never_exceed_stock(
    stock: list[dict[str, int]], orders: list[dict[str, int]], data: st.DataObject
) -> None:
    """Whatever is bound, assigned and picked in whatever order: promises fit stock and covered requests."""
    names = {sku for wanted in orders for sku in wanted} - {sku for held in stock for sku in held}
    orders = [{sku: n for sku, n in wanted.items() if sku not in names} for wanted in orders]
    world = small_world(
        {str(i): wanted for i, wanted in enumerate(orders) if wanted},
        {str(i): held for i, held in enumerate(stock)},
        capacities=[50, 50],
        robots=len(stock),
    )
    for _ in range(data.draw(st.integers(1, 25))):
        step = data.draw(st.sampled_from(["assign", "bind", "pick"]))
        station = data.draw(st.sampled_from(world.stations))
        if step == "assign" and world.backlog:
            order = data.draw(st.sampled_from(world.backlog.orders))
            world.assign(order, station, [line.sku for line in order.open_lines])
        elif step == "bind":
            pod = data.draw(st.sampled_from(world.pods))
            if station.id not in pod.bound_for:
                world.bind(pod, station)
        elif station.inbound_pods:
            pod = data.draw(st.sampled_from(station.inbound_pods))
            request = next_request(station, pod)
            if request is not None:
                world.fulfil(request, pod)
        check_promises(world)
        free = WarehouseView(world).free_items
        for pod, sku, number in zip(free.pod.tolist(), free.sku.tolist(), free.number.tolist(), strict=True):
            assert world.pods[pod].free_items(sku) == number


def check_promises(world: Warehouse) -> None:
    """Compare promises with stock and requests."""
    requests = [request for station in world.stations for request in station.open_requests]
    for pod in world.pods:
        for sku, number in pod.contents.items():
            promised = sum(r.items for r in requests if r.pod is pod and r.sku == sku)
            assert 0 <= promised <= number
            assert pod.free_items(sku) == number - promised
    for request in requests:
        inbound = world.stations[request.station].inbound_pods
        if request.covered:
            assert request.pod in inbound
        else:
            assert all(pod.free_items(request.sku) <= 0 for pod in inbound)
