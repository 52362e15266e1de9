"""Rules that assign orders, and filters of what is shown to them; test_oracles.py has some on random worlds."""

from typing import Any

import numpy as np
import pytest

import rmfs_core
from cases import cases
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
from standing import assigned as decide


def test_orders_go_by_age_due_time_or_lines_in_common() -> None:
    world = small_world({"1": ["a", "b"], "2": ["a"], "3": ["b"], "4": ["a"]}, {"p": ["a", "b"]}, capacities=[15, 15])
    world.bind(world.pods[0], world.stations[1])
    assert decide(world, FirstCome()) == [("1", 0), ("2", 1), ("3", 1), ("4", 0)]
    world = small_world(ORDERS, {"p": ["a"]}, capacities=[6, 4], due_s=DUE_S)
    assert decide(world, EarliestDue()) == [("late", 0), ("small", 1), ("twin", 0), ("large", 0), ("never", 1)]
    world = small_world(ORDERS, {"p": ["a"]}, capacities=[20], due_s=DUE_S)
    assert [name for name, _ in decide(world, LeastSlack())] == ["late", "small", "twin", "large", "never"]
    assert [name for name, _ in decide(world, LeastSlack(item_s=15))] == ["late", "large", "small", "twin", "never"]
    world = small_world(
        {"first": ["a", "b"], "1": ["c"], "2": ["a"], "3": ["b", "a", "d"]},
        {"p": ["a", "b", "c", "d"]},
        capacities=[1, 5],
    )
    world.assign(world.orders[0], world.stations[1], [0, 1])
    assert decide(world, CommonLines()) == [("3", 1), ("1", 0)]
    world = between({"near": ["a", "c"], "far": ["a", "b"]}, one=["a", "b"], two=["c"])
    assert decide(world, NearBestPod()) == [("one", 1), ("two", 0)]


ORDERS = {"never": {"a": 1}, "large": {"a": 4}, "small": {"a": 1}, "twin": {"a": 1}, "late": {"a": 1}}
DUE_S = {"large": 160, "small": 120, "twin": 120, "late": 5}


@cases(
    "rule wrong problem",
    (LeastSlack, {"item_s": -1}, "'item_s' must be >= 0"),
    (PodMatch, {"spread": -1.0}, "'spread' must be >= 0"),
    (Workload, {"prefer": "least"}, "'prefer' must be in"),
    (MostCovered, {"n": 0}, "'n' must be >= 1"),  # a filter that keeps nothing would stop the run
    (MostCovered, {"n": 1, "lines": "some"}, "'lines' must be in"),
)
def test_wrong_parameters_are_refused(rule: type[Any], wrong: dict[str, Any], problem: str) -> None:
    with pytest.raises(ValueError, match=problem):
        rule(**wrong)


def between(pods: dict[str, list[str]], **orders: list[str]) -> Warehouse:
    places = len(small_layout(2).storage_locations)
    fill = {f"empty {i}": ["z"] for i in range(places - len(pods) - 2)}
    (first, held), *others = pods.items()
    world = small_world(orders, {first: held, **fill, **dict(others)}, capacities=[9, 9])
    times = [world.travel.times_to(station.cell, True) for station in world.stations]
    near, far = ([int(table[pod.cell].min()) for table in times] for pod in (world.pods[0], world.pods[-1]))
    assert near[0] < near[1]
    assert far[1] < far[0]
    return world


def test_pods_that_come_decide() -> None:
    world = small_world({"old": ["a", "c"], "new": ["b", "c"]}, {"p": ["b", "c"], "q": ["a"]}, capacities=[2])
    world.bind(world.pods[0], world.stations[0])
    assert decide(world, PodMatch()) == [("new", 0)]
    orders = {"1": ["a"], "2": ["a"], "3": ["b"]}
    world = small_world(orders, {"p": {"a": 1, "b": 1}, "q": {"a": 5}}, capacities=[2])
    world.bind(world.pods[0], world.stations[0])
    assert decide(world, PodMatch()) == [("1", 0), ("3", 0)]
    unlimited = small_world(orders, {"p": ["a", "b"]}, capacities=[2])
    unlimited.bind(unlimited.pods[0], unlimited.stations[0])
    assert decide(unlimited, PodMatch()) == [("1", 0), ("2", 0)]
    loaded = small_world({"x": {"a": 3}, "1": {"a": 1}}, {"p": ["a"]}, capacities=[9, 9])
    loaded.assign(loaded.orders[0], loaded.stations[0], [0])
    loaded.bind(loaded.pods[0], loaded.stations[0])  # one item that it brings against three yet to pick
    assert decide(loaded, PodMatch(spread=0.25)) == decide(loaded, PodMatch()) == [("1", 0)]
    assert decide(loaded, PodMatch(spread=0.5)) == [("1", 1)]


ARRIVALS_S = (0, 10, 100, 130, 150, 200)


def arrived_by(now_s: float) -> Warehouse:
    warehouse = small_world({}, {"p": ["a"]})
    known = small_world({str(i): ["a"] for i in range(len(ARRIVALS_S))}, {"p": ["a"]})
    warehouse.orders = known.orders
    for order, arrival_s in zip(known.orders, ARRIVALS_S, strict=True):
        if arrival_s <= now_s:
            warehouse.order_arrives(order, round(1000 * arrival_s))
    warehouse.advance(round(1000 * now_s))
    return warehouse


@cases(
    "rule now_s released wakes_s",
    (Waves(every_s=100), 0, 1, None),
    (Waves(every_s=100), 10, 1, 100),
    (Waves(every_s=100), 99, 1, 100),
    (Waves(every_s=100), 100, 3, None),  # what arrives with a wave belongs to it
    (Waves(every_s=100), 150, 3, 200),
    (Waves(every_s=100), 200, 6, None),
    (Waves(every_s=100), 230, 6, None),
    (Waves(every_s=1000, orders=2), 10, 1, 1000),
    (Waves(every_s=1000, orders=2), 100, 3, None),
    (Waves(every_s=1000, orders=2), 130, 3, 1000),
    (Waves(every_s=1000, orders=2), 150, 5, None),
)
def test_waves_by_the_clock_and_by_number(rule: Waves, now_s: float, released: int, wakes_s: float | None) -> None:
    """A round is asked for where an order waits for the next wave."""
    view = WarehouseView(arrived_by(now_s))
    assert [order.name for order in rule.filter_backlog(view, view.orders)] == [str(i) for i in range(released)]
    assert rule.wake_at(view) == wakes_s


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
