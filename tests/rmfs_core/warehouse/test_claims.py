"""The warehouse's state: capacity, parts, promises of items, the backlog; orders that the stock can serve or not."""

from collections import Counter

import pytest
from attrs import evolve
from hypothesis import given, settings
from hypothesis import strategies as st

import rmfs_core
from replenished import RULES as REPLENISHED
from replenished import prepared, replenished_world, scenario_of
from rmfs_commands.states.restoring import begin_to_wait
from rmfs_commands.testing import small_instance, small_world
from rmfs_core import StandstillError, hookimpl
from rmfs_core.events import BundleStored, OrderArrived, OrderAssigned, OrderCompleted, OrderInStock
from rmfs_core.info import RunInfo
from rmfs_core.scenario.model import RuleChoice
from rmfs_core.warehouse import Order, Station, Warehouse, WarehouseView
from rmfs_core.warehouse.claims import Claims
from rmfs_core.warehouse.promises import next_request
from rmfs_core.world import BundleData, Instance
from standing import put_at_station

POA = ("common-lines", "earliest-due", "first-come", "least-slack", "near-best-pod", "pod-match", "random")
RULES = (*(f"poa={name}" for name in (*POA, "station-queue", "workload")), "poa_pps=two-stage", "poa_pps=pod-index")


def bring(world: Warehouse, sku: int, items: int) -> list[str]:
    bundle = world.bundle_arrives(sku, items)
    world.assign_bundle(bundle, world.stations[1])
    world.bind_bundle(bundle, world.pods[0])
    return [order.name for order in world.store_bundle(bundle, world.pods[0])]


def names(view: WarehouseView) -> tuple[list[str], list[str]]:
    return [order.name for order in view.backlog], [order.name for order in view.orders_waiting_for_stock]


def test_orders_wait_for_their_share_of_stock() -> None:
    orders = {"1": {"a": 1}, "2": {"a": 1, "b": 1}, "3": {"a": 1}, "4": {"a": 1}}
    view = WarehouseView(world := replenished_world(orders, {"p": {"a": 2}}, wait_for_stock=True))
    assert names(view) == (["1", "3"], ["2", "4"])
    assert [order.waits_for_stock for order in view.orders] == [False, True, False, True]
    assert view.open_demand().tolist() == [4, 1]
    assert [order.name for order in view.orders_since(2)] == ["3", "4"]
    assert world.claims is not None
    assert world.claims.missing == [0, 1]
    assert [bring(world, 1, 1), bring(world, 0, 1)] == [[], ["2"]]  # order 2 lacks both SKUs
    assert names(view) == (["1", "2", "3"], ["4"])
    assert view.backlog_lines.order_id.tolist() == [0, 1, 1, 2]


def test_a_bundle_costs_no_look_at_orders_that_want_more_than_there_is(monkeypatch: pytest.MonkeyPatch) -> None:
    looked: list[str] = []
    lacking = Claims.lacking

    def noting(stock: Claims, order: Order) -> int | None:
        looked.append(order.name)
        return lacking(stock, order)

    monkeypatch.setattr(Claims, "lacking", noting)
    orders = {str(i): {"a": 3} for i in range(50)} | {"less": {"a": 2}, "both": {"a": 1, "b": 1}}
    world = replenished_world(orders, {"p": {"b": 1}}, wait_for_stock=True)
    looked.clear()
    assert bring(world, 1, 1) == ["both"]
    assert [bring(world, 1, 1) for _ in range(5)] == [[], ["less"], [], [], ["0"]]
    assert looked == ["both", "less", "0"]


def test_nothing_waits_for_what_never_runs_out_or_where_nothing_is_to_wait() -> None:
    orders = {str(i): {"a": 9, "b": 1} for i in range(5)}
    world = replenished_world(orders, {"p": ["a", "b"], "q": {"a": 1}}, wait_for_stock=True)
    assert len(world.backlog) == 5
    assert names(WarehouseView(replenished_world({"1": {"a": 1}}, {"p": {"b": 1}}))) == (["1"], [])


def test_orders_begin_to_wait_in_a_warehouse_under_way() -> None:
    orders = {"1": {"a": 2}, "2": {"a": 1, "b": 1}, "3": {"a": 1}, "4": {"a": 1}}
    view = WarehouseView(world := replenished_world(orders, {"p": {"a": 3, "b": 1}}))
    world.assign(world.orders[1], world.stations[0], [1])  # its other line is in the backlog
    begin_to_wait(world, {})
    assert names(view) == (["1", "2"], ["3", "4"])
    assert view.backlog_lines.order_id.tolist() == [0, 1]
    told = WarehouseView(world := replenished_world(orders, {"p": {"a": 3, "b": 1}}))
    begin_to_wait(world, {0: True, 3: False})
    assert names(told) == (["2", "3", "4"], ["1"])
    enough = WarehouseView(world := replenished_world(orders, {"p": {"a": 9, "b": 9}}))
    begin_to_wait(world, {})
    assert names(enough) == (["1", "2", "3", "4"], [])


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_who_waits_is_who_would_by_a_look_at_all_of_them(data: st.DataObject) -> None:
    lines = st.dictionaries(st.sampled_from("abc"), st.integers(1, 3), min_size=1)
    orders = {str(i): held for i, held in enumerate(data.draw(st.lists(lines, min_size=1, max_size=9)))}
    held = data.draw(st.dictionaries(st.sampled_from("abc"), st.integers(1, 4), min_size=1))
    world = replenished_world(orders, {"p": held}, wait_for_stock=True)
    for _ in range(data.draw(st.integers(0, 8))):
        if len(world.backlog) and data.draw(st.booleans()):
            order = data.draw(st.sampled_from(world.backlog.orders))
            world.assign(order, world.stations[0], [order.open_lines[0].sku])
        else:
            waiting = list(world.claims.waiting.values()) if world.claims is not None else []
            sku, items = data.draw(st.integers(0, world.n_skus - 1)), data.draw(st.integers(1, 3))
            left = unclaimed(world)
            left[sku] += items
            expected = []
            for order in waiting:
                if all(left[wanted] >= quantity for wanted, quantity in order.lines):
                    left.subtract(dict(order.lines))
                    expected.append(order.name)
            assert bring(world, sku, items) == expected
        assert world.claims is not None
        left = unclaimed(world)
        assert {sku: n for sku, n in world.claims.unclaimed.items() if n} == {sku: n for sku, n in left.items() if n}
        assert min(left.values(), default=0) >= 0


def unclaimed(world: Warehouse) -> Counter[int]:
    """Add up what pods hold, less open requests and the backlog's open lines."""
    left = Counter[int]()
    for pod in world.pods:
        left.update(dict(pod.contents))
    for station in world.stations:
        for request in station.open_requests:
            left[request.sku] -= request.items
    for order in world.backlog.orders:
        left.subtract(dict(order.open_lines))
    return left


def without_lamps(*bundles: BundleData) -> Instance:
    orders = {"gone-1": {"lamp": 1}, "gone-2": {"lamp": 1}}
    orders |= {f"ok-{i}": {"mug" if i < 3 else "tea": 1} for i in range(1, 5)}
    return evolve(small_instance(orders, {"A1": {"mug": 20}, "A2": {"tea": 20}}), bundles=bundles)


@pytest.mark.parametrize("rule", RULES)
def test_orders_that_stock_cannot_serve_take_no_places(rule: str) -> None:
    key, name = rule.split("=")
    stations = {"order_capacity": 2, "queue_length": 3}
    scenario = scenario_of({"process": "file", "file": "bundles.csv"}, robots=3, stations=stations)
    pps = None if key == "poa_pps" else scenario.rules.pps
    none: dict[str, RuleChoice | None] = {"poa": None, "poa_pps": None}
    scenario = evolve(scenario, rules=evolve(scenario.rules, **none | {"pps": pps, key: RuleChoice(name)}))
    run = prepared(scenario, without_lamps(BundleData("D-1", arrival_tick=7_200_000, sku=2, items=5))).done()
    done = {event.order: event.tick for event in run.of(OrderCompleted)}
    assert max(done[order] for order in (2, 3, 4, 5)) < 150_000
    assert min(done[order] for order in (0, 1)) > 7_200_000
    (stored,) = run.of(BundleStored)
    told = [(event.order, event.tick) for event in run.of(OrderInStock)]
    assert told == [(0, stored.tick), (1, stored.tick)]


def test_what_a_run_says_of_orders_that_wait() -> None:
    scenario = scenario_of(
        {"process": "file", "file": "bundles.csv"},
        stations={"order_capacity": 2, "queue_length": 3},
        rules=REPLENISHED | {"wait_for_stock": False, "poa": "first-come"},
    )
    run = prepared(scenario, without_lamps(BundleData("D-1", arrival_tick=600_000, sku=2, items=5))).done()
    assert [event.order for event in run.of(OrderAssigned)][:2] == [0, 1]
    assert run.of(OrderInStock) == []
    run = prepared(scenario_of({"process": "file", "file": "bundles.csv"}), without_lamps())
    with pytest.raises(StandstillError, match="2 orders wait for stock of"):
        run.simulation.run()
    lead = "instance.replenishment.lead_s=3600"
    result = rmfs_core.run("examples/replenished", overrides=[lead, "run.until_s=2000", "rules.pp=free-flow"])
    (note,) = result.notes
    assert note.startswith("At the end ")
    assert note.split(" for stock of ")[0].endswith("orders wait")


def test_a_backlog_that_is_kept_filled_counts_orders_that_wait() -> None:
    """Else orders would come without end while none of them can be served."""
    over = ["instance.arrivals={process='refill', backlog=10}", "instance.replenishment.lead_s=3600"]
    come = Watch()
    rmfs_core.run("examples/replenished", overrides=[*over, "run.until_s=3000", "rules.pp=free-flow"], observers=[come])
    assert come.most == 10
    assert come.waited


class Watch:
    """Observer that has the most orders which were in the backlog or waited for stock."""

    most, waited = 0, False

    @hookimpl
    def run_started(self, run: RunInfo) -> None:
        self.view = run.warehouse

    @hookimpl
    def on_event(self, event: object) -> None:
        if isinstance(event, OrderArrived):
            waiting = len(self.view.orders_waiting_for_stock)
            self.most = max(self.most, self.view.backlog_size + waiting)
            self.waited |= waiting > 0


def pick_all(world: Warehouse, station: Station) -> list[int]:
    """Pick all that the first pod can serve; return the free capacity before each pick."""
    free, pod = [], world.pods[0]
    while (request := next_request(station, pod)) is not None:
        free.append(station.free_capacity)
        world.fulfil(request, pod)
    return free


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
    assert pick_all(world, station) == [0, 0]
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
