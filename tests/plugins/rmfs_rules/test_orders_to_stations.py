"""Rules that assign orders, and filters of what is shown to them; test_oracles.py has some on random worlds."""

from __future__ import annotations

import inspect
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import rmfs_core
from rmfs_commands.testing import small_layout, small_world
from rmfs_core import hookimpl
from rmfs_core.events import Event, OrderArrived, OrderAssigned
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.common_lines import CommonLines
from rmfs_rules.due import EarliestDue, LeastSlack
from rmfs_rules.first_come import FirstCome
from rmfs_rules.most_covered import MostCovered
from rmfs_rules.near_best_pod import NearBestPod
from rmfs_rules.pod_match import PodMatch
from rmfs_rules.waves import Waves
from rmfs_rules.workload import Workload
from standing import put_at_station


def decide(world: Warehouse, rule: Any, view: WarehouseView | None = None) -> list[tuple[str, int]]:
    """Return (order's name, station) of each assignment; plain numbers, and whole orders."""
    given = {"warehouse": view or WarehouseView(world), "rng": np.random.default_rng(0)}
    wanted = inspect.signature(rule.assign_orders).parameters
    answer = rule.assign_orders(**{name: value for name, value in given.items() if name in wanted})
    assert all(type(one.order) is int and type(one.station) is int and one.skus is None for one in answer)
    return [(world.orders[one.order].name, one.station) for one in answer]


def test_orders_are_assigned_by_age_to_the_station_with_the_lowest_load() -> None:
    world = small_world({"1": ["a", "b"], "2": ["a"], "3": ["b"], "4": ["a"]}, {"p": ["a", "b"]}, capacities=[15, 15])
    world.bind(world.pods[0], world.stations[1])
    assert decide(world, FirstCome()) == [("1", 0), ("2", 1), ("3", 1), ("4", 0)]


def test_the_next_oldest_that_fits_is_taken_when_the_oldest_does_not() -> None:
    world = small_world({"0": ["a"], "1": ["a", "b", "c"], "2": ["a", "b"]}, {"p": ["a", "b", "c"]}, capacities=[1, 3])
    world.assign(world.orders[0], world.stations[1], [0])
    assert decide(world, FirstCome()) == [("2", 1)]


ORDERS = {"never": {"a": 1}, "large": {"a": 4}, "small": {"a": 1}, "twin": {"a": 1}, "late": {"a": 1}}
DUE_S = {"large": 160, "small": 120, "twin": 120, "late": 5}


def test_the_order_that_is_due_first_goes_first() -> None:
    world = small_world(ORDERS, {"p": ["a"]}, capacities=[6, 4], due_s=DUE_S)
    assert decide(world, EarliestDue()) == [("late", 0), ("small", 1), ("twin", 0), ("large", 0), ("never", 1)]


def test_the_order_with_least_time_to_spare_goes_first() -> None:
    """Slack: late -8, large 160 - 52 = 108, small and twin 107; with 15 s an item large has 100, they have 105."""
    world = small_world(ORDERS, {"p": ["a"]}, capacities=[20], due_s=DUE_S)
    assert [name for name, _ in decide(world, LeastSlack())] == ["late", "small", "twin", "large", "never"]
    assert [name for name, _ in decide(world, LeastSlack(item_s=15))] == ["late", "large", "small", "twin", "never"]


def test_only_open_items_take_time() -> None:
    world = small_world({"1": {"a": 1, "b": 3}, "2": {"a": 1}}, {"p": ["a", "b"]}, due_s={"1": 160, "2": 120})
    assert decide(world, LeastSlack(item_s=15))[0] == ("1", 0)
    world.assign(world.orders[0], world.stations[0], [1])
    assert decide(world, LeastSlack(item_s=15))[0] == ("2", 0)


@pytest.mark.parametrize("seed", range(30))
def test_no_order_that_fits_has_to_wait_for_one_with_more_time(seed: int) -> None:
    rng = np.random.default_rng(seed)
    orders = {str(i): {"a": int(rng.integers(1, 6))} for i in range(12)}
    due_s = {str(i): float(rng.integers(0, 200)) for i in range(12) if rng.random() < 0.7}
    for rule, item_s in ((EarliestDue(), 0), (LeastSlack(item_s=20), 20)):
        world = small_world(orders, {"p": ["a"]}, capacities=[7, 9], due_s=due_s)

        def rank(name: str, item_s: int = item_s) -> tuple[float, int]:
            return due_s.get(name, np.inf) - item_s * orders[name]["a"], int(name)

        for name, station in decide(world, rule):
            open_orders = [(order, at) for order in world.backlog.orders for at in world.stations]
            fitting = {order.name for order, at in open_orders if world.size_at(order, at) <= at.free_capacity}
            assert name == min(fitting, key=rank)
            assert station == min((s.load, s.id) for s in world.stations if s.free_capacity >= orders[name]["a"])[1]
            world.assign(world.orders[int(name)], world.stations[station], [0])


def test_a_time_below_zero_is_refused() -> None:
    with pytest.raises(ValueError, match="'item_s' must be >= 0"):
        LeastSlack(item_s=-1)


def busy() -> Warehouse:
    """Return a world in which station 0 works on one order of three items, station 1 on two of one, of five each."""
    orders = {"x": {"a": 3}, "y": {"a": 1}, "z": {"a": 1}, "1": {"a": 2}, "2": {"a": 1}, "3": {"a": 1}}
    world = small_world(orders, {"p": ["a"]}, capacities=[5, 5])
    for order, station in ((0, 0), (1, 1), (2, 1)):
        world.assign(world.orders[order], world.stations[station], [0])
    return world


def test_the_station_with_fewest_orders_is_filled_first() -> None:
    assert decide(busy(), Workload()) == [("1", 0), ("2", 1), ("3", 1)]


def test_or_the_one_with_most() -> None:
    assert decide(busy(), Workload(prefer="most")) == [("1", 1), ("2", 1), ("3", 0)]


def test_picked_orders_are_no_work() -> None:
    world = busy()
    world.bind(world.pods[0], world.stations[1])
    for request in world.stations[1].open_requests:
        world.fulfil(request, world.pods[0])
    assert decide(world, Workload())[0] == ("1", 1)


def test_other_preferences_are_refused() -> None:
    with pytest.raises(ValueError, match="'prefer' must be in"):
        Workload(prefer="least")


def between(pods: dict[str, list[str]], **orders: list[str]) -> Warehouse:
    """Return a world of two stations, in which the first pod is nearest to station 0 and the last one to station 1."""
    places = len(small_layout(2).storage_locations)
    fill = {f"empty {i}": ["z"] for i in range(places - len(pods) - 2)}
    (first, held), *others = pods.items()
    world = small_world(orders, {first: held, **fill, **dict(others)}, capacities=[9, 9])
    times = [world.travel.times_to(station.cell, True) for station in world.stations]
    near, far = ([int(table[pod.cell].min()) for table in times] for pod in (world.pods[0], world.pods[-1]))
    assert near[0] < near[1]
    assert far[1] < far[0]
    return world


def test_an_order_goes_where_its_best_pod_is_near() -> None:
    world = between({"near": ["a", "c"], "far": ["a", "b"]}, one=["a", "b"], two=["c"])
    assert decide(world, NearBestPod()) == [("one", 1), ("two", 0)]


def test_of_equally_good_pods_the_one_that_is_nearest_to_a_station_counts() -> None:
    world = between({"near": ["a"], "far": ["a"]}, one=["a"])
    times = [world.travel.times_to(station.cell, True) for station in world.stations]
    drives = {(s, pod.id): int(times[s][pod.cell].min()) for s in (0, 1) for pod in (world.pods[0], world.pods[-1])}
    assert decide(world, NearBestPod()) == [("one", min(drives, key=lambda pair: drives[pair])[0])]


def test_pods_in_use_do_not_count() -> None:
    world = between({"near": ["a"], "far": ["a", "b"]}, one=["a", "b"])
    assert decide(world, NearBestPod()) == [("one", 1)]
    world.bind(world.pods[-1], world.stations[0])
    assert decide(world, NearBestPod()) == [("one", 0)]


def test_an_order_that_no_free_pod_has_goes_to_the_lowest_load() -> None:
    world = between({"near": ["c"], "far": ["a"]}, begun=["c"], one=["a"])
    world.assign(world.orders[0], world.stations[0], [line.sku for line in world.orders[0].open_lines])
    world.bind(world.pods[-1], world.stations[0])
    assert decide(world, NearBestPod()) == [("one", 1)]


def test_the_order_with_most_skus_in_common_goes_to_the_station() -> None:
    world = small_world(
        {"first": ["a", "b"], "1": ["c"], "2": ["a"], "3": ["b", "a", "d"]},
        {"p": ["a", "b", "c", "d"]},
        capacities=[1, 5],
    )
    world.assign(world.orders[0], world.stations[1], [0, 1])
    assert decide(world, CommonLines()) == [("3", 1), ("1", 0)]


def test_lines_count_and_not_items() -> None:
    world = small_world({"first": ["a", "b"], "1": {"a": 5}, "2": ["a", "b"]}, {"p": ["a", "b"]}, capacities=[7])
    world.assign(world.orders[0], world.stations[0], [0, 1])
    assert decide(world, CommonLines()) == [("2", 0)]


def test_requests_of_the_same_decision_count() -> None:
    world = small_world({"1": ["a"], "2": ["b"], "3": ["a"]}, {"p": ["a", "b"]}, capacities=[2])
    assert decide(world, CommonLines()) == [("1", 0), ("3", 0)]


def test_what_was_picked_is_in_common_no_more() -> None:
    world = small_world({"first": ["a", "b"], "1": ["a"], "2": ["b"]}, {"p": ["a", "b"]}, capacities=[3])
    station = world.stations[0]
    world.bind(world.pods[0], station)
    world.assign(world.orders[0], station, [0, 1])
    world.fulfil(station.open_requests[0], world.pods[0])
    assert decide(world, CommonLines()) == [("2", 0)]


def test_the_order_with_most_items_on_inbound_pods_is_assigned() -> None:
    world = small_world({"old": ["a", "c"], "new": ["b", "c"]}, {"p": ["b", "c"], "q": ["a"]}, capacities=[2])
    world.bind(world.pods[0], world.stations[0])
    assert decide(world, PodMatch()) == [("new", 0)]


def test_items_count_and_not_lines() -> None:
    world = small_world({"two": {"a": 1, "b": 1}, "three": {"a": 3}}, {"p": ["a", "b"]}, capacities=[3])
    world.bind(world.pods[0], world.stations[0])
    assert decide(world, PodMatch()) == [("three", 0)]


def test_ties_go_to_the_oldest_order_then_to_the_lowest_load_then_to_the_lowest_id() -> None:
    world = small_world({"0": ["a", "b"], "1": ["a"], "2": ["a"], "3": ["a"]}, {"p": ["a", "b"]}, capacities=[15, 15])
    assert decide(world, PodMatch()) == [("0", 0), ("1", 1), ("2", 1), ("3", 0)]


def test_load_from_earlier_decisions_counts() -> None:
    world = small_world({"0": ["a"], "1": ["a"]}, {"p": ["a"]}, capacities=[15, 15])
    world.assign(world.orders[0], world.stations[0], [0])
    assert decide(world, PodMatch()) == [("1", 1)]


def test_an_order_that_does_not_fit_is_passed_over() -> None:
    orders = {"0": ["d", "e", "f"], "big": ["a", "b", "c"], "small": ["d"]}
    world = small_world(orders, {"p": ["a", "b", "c"], "q": ["d"]}, capacities=[2, 3])
    world.assign(world.orders[0], world.stations[1], [line.sku for line in world.orders[0].lines])
    world.bind(world.pods[0], world.stations[0])
    assert decide(world, PodMatch()) == [("small", 0)]


def test_nothing_fits_or_nothing_is_there() -> None:
    world = small_world({"0": ["a", "b"], "big": ["a", "b"]}, {"p": ["a", "b"]}, capacities=[1, 2])
    world.assign(world.orders[0], world.stations[1], [line.sku for line in world.orders[0].lines])
    assert decide(world, PodMatch()) == []
    assert decide(small_world({}, {"p": ["a"]}), PodMatch()) == []


def test_order_capacity_takes_orders_of_any_size() -> None:
    world = small_world(
        {"1": ["a", "b", "c"], "2": ["a", "b"], "3": ["a"]}, {"p": ["a", "b", "c"]}, capacities=[2], counts_orders=True
    )
    assert decide(world, PodMatch()) == [("1", 0), ("2", 0)]


def test_finite_stock_is_counted_once() -> None:
    orders = {"1": ["a"], "2": ["a"], "3": ["b"]}
    world = small_world(orders, {"p": {"a": 1, "b": 1}, "q": {"a": 5}}, capacities=[2])
    world.bind(world.pods[0], world.stations[0])
    assert decide(world, PodMatch()) == [("1", 0), ("3", 0)]
    unlimited = small_world(orders, {"p": ["a", "b"]}, capacities=[2])
    unlimited.bind(unlimited.pods[0], unlimited.stations[0])
    assert decide(unlimited, PodMatch()) == [("1", 0), ("2", 0)]


def test_an_item_on_a_pod_bound_for_two_stations_is_taken_at_both() -> None:
    world = small_world(
        {"1": ["a"], "2": ["a"], "3": ["b"]}, {"p": {"a": 1}, "q": {"b": 1}, "r": {"a": 9}}, capacities=[1, 1]
    )
    for pod, station in ((0, 0), (0, 1), (1, 1)):
        world.bind(world.pods[pod], world.stations[station])
    assert decide(world, PodMatch()) == [("1", 0), ("3", 1)]


def test_only_open_lines_count() -> None:
    world = small_world({"1": ["a", "b"], "2": ["c"]}, {"p": ["a"], "q": ["c", "b"]}, capacities=[2, 1])
    world.assign(world.orders[0], world.stations[0], [0])
    world.bind(world.pods[0], world.stations[1])
    assert decide(world, PodMatch()) == [("1", 1), ("2", 0)]


def test_only_the_filtered_backlog_is_assigned() -> None:
    world = small_world({"1": ["a"], "2": ["b"], "3": ["a", "b"]}, {"p": ["a", "b"]}, capacities=[3])
    world.bind(world.pods[0], world.stations[0])
    assert decide(world, PodMatch(), WarehouseView(world, world.orders[1:])) == [("3", 0), ("2", 0)]


ARRIVALS_S = (0, 10, 100, 130, 150, 200)


def arrived_by(now_s: float, arrivals_s: tuple[float, ...] = ARRIVALS_S) -> Warehouse:
    """Return a world in which orders have arrived by a time."""
    warehouse = small_world({}, {"p": ["a"]})
    known = small_world({str(i): ["a"] for i in range(len(arrivals_s))}, {"p": ["a"]})
    warehouse.orders = known.orders
    for order, arrival_s in zip(known.orders, arrivals_s, strict=True):
        if arrival_s <= now_s:
            warehouse.order_arrives(order, round(1000 * arrival_s))
    warehouse.advance(round(1000 * now_s))
    return warehouse


def released(rule: Waves, now_s: float) -> tuple[list[str], float | None]:
    """Return the names of the orders that are released at a time, and when the rule wants to wake up."""
    view = WarehouseView(arrived_by(now_s))
    return [order.name for order in rule.filter_backlog(view, view.orders)], rule.wake_at(view)


@pytest.mark.parametrize(
    ("now_s", "names", "wakes_s"),
    [
        (0, ["0"], None),
        (10, ["0"], 100),
        (99, ["0"], 100),
        (100, ["0", "1", "2"], None),  # what arrives with a wave belongs to it
        (150, ["0", "1", "2"], 200),
        (200, ["0", "1", "2", "3", "4", "5"], None),
        (230, ["0", "1", "2", "3", "4", "5"], None),
    ],
)
def test_waves_by_the_clock(now_s: float, names: list[str], wakes_s: float | None) -> None:
    """Every 100 s, and a round then if an order waits for it."""
    assert released(Waves(every_s=100), now_s) == (names, wakes_s)


@pytest.mark.parametrize(
    ("now_s", "names", "wakes_s"),
    [
        (10, ["0"], 1000),
        (100, ["0", "1", "2"], None),
        (130, ["0", "1", "2"], 1000),
        (150, ["0", "1", "2", "3", "4"], None),
    ],
)
def test_waves_by_number(now_s: float, names: list[str], wakes_s: float | None) -> None:
    assert released(Waves(every_s=1000, orders=2), now_s) == (names, wakes_s)


def test_waves_behind_another_filter() -> None:
    view = WarehouseView(arrived_by(120))
    assert [order.name for order in Waves(every_s=100).filter_backlog(view, view.orders[1:2])] == ["1"]


class Waits:
    """Observer of when orders arrive and are assigned."""

    def __init__(self) -> None:
        self.arrived: dict[int, int] = {}
        self.assigned: dict[int, int] = {}

    @hookimpl
    def on_event(self, event: Event) -> None:
        if isinstance(event, OrderArrived):
            self.arrived[event.order] = event.tick
        if isinstance(event, OrderAssigned):
            self.assigned[event.order] = event.tick


def test_a_run_in_waves_is_complete() -> None:
    overrides = ["instance.orders=30", "instance.arrivals={process='poisson', orders_per_hour=200}"]
    seen = Waits()
    result = rmfs_core.run(
        "examples/small", overrides=[*overrides, "rules.filters=[{rule='waves', every_s=120}]"], observers=[seen]
    )
    assert result.status == "complete"
    waves = {order: -(-tick // 120_000) * 120_000 for order, tick in seen.arrived.items()}
    assert all(seen.assigned[order] >= wave for order, wave in waves.items())
    assert np.mean([seen.assigned[order] == wave for order, wave in waves.items()]) > 0.3


def kept(world: Warehouse, n: int, lines: str = "all") -> list[str]:
    """Return the names of the orders that the filter keeps."""
    view = WarehouseView(world)
    return [order.name for order in MostCovered(n, lines).filter_backlog(view, view.backlog)]


def test_the_highest_share_wins_and_ties_go_to_the_older() -> None:
    orders = {"half": ["a", "x"], "all": ["b"], "none": ["x"], "all too": ["a", "b"], "most": ["a", "b", "y"]}
    world = small_world(orders, {"p": ["a", "b"], "q": ["x", "y"]})
    world.bind(world.pods[0], world.stations[0])
    assert kept(world, 1) == ["all"]
    assert kept(world, 4) == ["all", "all too", "most", "half"]
    assert kept(world, 9) == ["all", "all too", "most", "half", "none"]


def test_without_pods_at_stations_the_oldest_stay() -> None:
    world = small_world({"1": ["a"], "2": ["b"], "3": ["a"]}, {"p": ["a", "b"]})
    assert kept(world, 2) == ["1", "2"]


def test_lines_that_are_assigned_count_or_do_not() -> None:
    world = small_world({"begun": ["a", "b"], "third": ["a", "x", "y"]}, {"p": ["a"], "q": ["b", "x", "y"]})
    world.bind(world.pods[0], world.stations[0])
    assert kept(world, 1) == ["begun"]
    world.assign(world.orders[0], world.stations[0], [0], 1)
    assert kept(world, 1) == ["begun"]
    assert kept(world, 1, "open") == ["third"]


def test_shares_behind_another_filter() -> None:
    world = small_world({"1": ["a"], "2": ["b"], "3": ["a", "b"], "4": ["a"]}, {"p": ["a"], "q": ["b"]})
    world.bind(world.pods[0], world.stations[0])
    view = WarehouseView(world)
    assert [order.name for order in MostCovered(2).filter_backlog(view, view.backlog[1:])] == ["4", "3"]


@pytest.mark.parametrize("seed", range(30))
def test_brute_force_keeps_the_same(seed: int) -> None:
    rng = np.random.default_rng(seed)
    skus = "abcdefgh"
    orders = {str(i): list(rng.choice(list(skus), rng.integers(1, 5), replace=False)) for i in range(12)}
    pods = {f"p{i}": list(rng.choice(list(skus), 2, replace=False)) for i in range(8)} | {"all": list(skus)}
    world = small_world(orders, pods, capacities=(15, 15), robots=4)
    put_at_station(world, 0, 0)
    world.bind(world.pods[1], world.stations[1])
    there = {*pods["p0"], *pods["p1"]}

    def rank(name: str) -> tuple[Fraction, int]:
        return -Fraction(sum(sku in there for sku in orders[name]), len(orders[name])), int(name)

    n = int(rng.integers(1, 13))
    assert kept(world, n) == sorted(orders, key=rank)[:n]


def test_n_has_to_be_positive() -> None:
    """A filter that keeps nothing would stop the run."""
    with pytest.raises(ValueError, match=r"'n' must be >= 1"):
        MostCovered(0)


def test_lines_have_to_be_all_or_open() -> None:
    with pytest.raises(ValueError, match="'lines' must be in"):
        MostCovered(1, "some")
