"""Pairs of order and station, and the parameters that POA rules share: ties, late orders, the fast lane."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from rmfs_commands.testing import check_rule, small_world
from rmfs_core.warehouse import Station, Warehouse, WarehouseView
from rmfs_rules.common_lines import CommonLines
from rmfs_rules.due import EarliestDue, LeastSlack
from rmfs_rules.first_come import FirstCome
from rmfs_rules.helpers import assign_best_pairs, sum_per_order
from rmfs_rules.helpers.pairs import Pairs
from rmfs_rules.near_best_pod import NearBestPod
from rmfs_rules.pod_match import PodMatch
from rmfs_rules.workload import Workload

PAIRS = (PodMatch, CommonLines, FirstCome, Workload, NearBestPod)
OF_PAIRS = pytest.mark.parametrize("rule", PAIRS)
"""Rules with all of these parameters."""
OF_ORDERS = pytest.mark.parametrize("rule", [*PAIRS, EarliestDue, LeastSlack])
"""Rules with a fast lane."""
FOUR = {"1": ["a"], "2": ["a"], "3": ["a"], "4": ["a"]}
PutAtStation = Callable[[Warehouse, int, int], None]


def decide(world: Warehouse, rule: Any, seed: int = 0) -> list[tuple[str, int]]:
    """Return (order's name, station) of each assignment."""
    arguments = (WarehouseView(world), np.random.default_rng(seed))[
        : 1 if isinstance(rule, (EarliestDue, LeastSlack)) else 2
    ]
    return [(world.orders[one.order].name, one.station) for one in rule.assign_orders(*arguments)]


@OF_PAIRS
def test_of_orders_that_are_alike_one_goes_first(rule: type[Any]) -> None:
    """The oldest, the one due first, or one by lot."""
    world = small_world(FOUR, {"p": ["a"]}, capacities=[2], due_s={"3": 50, "2": 90})
    assert [name for name, _ in decide(world, rule())] == ["1", "2"]
    assert [name for name, _ in decide(world, rule(tie_break="due"))] == ["3", "2"]
    first = Counter(decide(world, rule(tie_break="random"), seed)[0][0] for seed in range(400))
    assert set(first) == set(FOUR)
    assert all(55 <= number <= 145 for number in first.values())


@OF_PAIRS
def test_late_orders_go_first_if_asked_for(rule: type[Any]) -> None:
    """After 60 s orders 2 and 4 are late, whatever the pod at the station is good for; 3 is due, but not yet late."""
    orders = {"x": ["a"], "1": ["a"], "2": ["b"], "3": ["b"], "4": ["b"]}
    world = small_world(orders, {"p": ["a"], "q": ["b"]}, capacities=[4], due_s={"2": 50, "3": 60, "4": 40})
    world.assign(world.orders[0], world.stations[0], [0])
    world.bind(world.pods[0], world.stations[0])
    world.now = 60_000
    assert [name for name, _ in decide(world, rule(late_first=True))] == ["2", "4", "1"]
    assert decide(world, rule())[0][0] == "1"


@OF_ORDERS
def test_a_place_is_kept_for_what_the_pod_at_the_station_completes(
    rule: type[Any], put_at_station: PutAtStation
) -> None:
    """The pod there has `a`; of two free places one is left for such an order, and nothing else takes it."""
    orders = {"x": ["a"], "1": ["b"], "2": ["b"], "3": ["a", "b"], "4": ["a"]}
    pods = {"p": ["a"], "q": ["b"]}
    world = small_world(orders, pods, capacities=[3])
    put_at_station(world, 0, 0)
    world.assign(world.orders[0], world.stations[0], [0])
    assert {name for name, _ in decide(world, rule(fast_lane=1))} in ({"1", "4"}, {"4"})  # 4 may come before 1
    del orders["4"]
    world = small_world(orders, pods, capacities=[3])
    put_at_station(world, 0, 0)
    world.assign(world.orders[0], world.stations[0], [0])
    assert [name for name, _ in decide(world, rule(fast_lane=1))] == ["1"]


@OF_ORDERS
def test_a_station_with_nothing_to_do_keeps_no_place(rule: type[Any]) -> None:
    """Else an order as large as the station would never come in."""
    world = small_world({"1": {"a": 3}}, {"p": ["a"]}, capacities=[3])
    assert decide(world, rule(fast_lane=1)) == [("1", 0)]


@OF_ORDERS
def test_a_pod_on_its_way_completes_nothing_yet(rule: type[Any]) -> None:
    """Nobody takes the place before it is there."""
    world = small_world({"x": ["a"], "1": ["a"]}, {"p": ["a"]}, capacities=[2])
    world.assign(world.orders[0], world.stations[0], [0])
    world.bind(world.pods[0], world.stations[0])
    assert decide(world, rule(fast_lane=1)) == []


@OF_ORDERS
def test_items_on_the_pod_are_for_one_order_each(rule: type[Any], put_at_station: PutAtStation) -> None:
    """Of three items one is promised to order x; order 1 takes one, order 2 the last one; none is left for order 3."""
    orders = {"x": {"a": 1}, "1": {"a": 1}, "2": {"a": 1}, "3": {"a": 1}}
    world = small_world(orders, {"p": {"a": 3}, "q": {"a": 9}}, capacities=[4])
    put_at_station(world, 0, 0)
    world.assign(world.orders[0], world.stations[0], [0])
    assert [name for name, _ in decide(world, rule(fast_lane=3))] == ["1", "2"]
    assert [name for name, _ in decide(world, rule())] == ["1", "2", "3"]


@OF_ORDERS
def test_orders_are_the_places_where_they_are_counted(rule: type[Any], put_at_station: PutAtStation) -> None:
    """The last of three places is for an order that the pod can complete, however large."""
    orders = {"x": ["a"], "1": ["b"], "2": ["b"], "3": {"a": 5}}
    world = small_world(orders, {"p": ["a"], "q": ["b"]}, capacities=[3], counts_orders=True)
    put_at_station(world, 0, 0)
    world.assign(world.orders[0], world.stations[0], [0])
    assert {name for name, _ in decide(world, rule(fast_lane=1))} in ({"1", "3"}, {"3"})  # 3 may come before 1


def test_orders_without_a_due_time_are_never_late() -> None:
    """They are due at the end of time: of two that match, the one that is late goes first."""
    world = small_world(FOUR, {"p": ["a"]}, due_s={"2": 4.5, "3": 3})
    world.now = 4000
    assert [name for name, _ in decide(world, FirstCome(late_first=True))] == ["3", "1", "2", "4"]


def test_a_score_is_a_sum_over_open_lines() -> None:
    """Of min(items, what the SKU counts at most); without a table all orders score the same."""
    world = small_world({"1": {"a": 1, "b": 1}, "2": {"a": 3}, "3": {"b": 2}}, {"p": ["a", "b"]}, capacities=[3])
    view = WarehouseView(world)
    for table, first in (([[2, 0]], 1), ([[1, 1]], 0), ([[1, 3]], 0), ([[0, 3]], 2), ([[0, 0]], 0), (None, 0)):
        assert Pairs(view, None if table is None else np.array(table)).assign()[0].order == first


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("counts", [False, True])
@pytest.mark.parametrize("due", [False, True])
def test_tables_decide_as_scores_of_all_orders(seed: int, counts: bool, due: bool) -> None:
    """Over several decisions, between which orders leave: the same as with scores made of all lines."""
    rng = np.random.default_rng(seed)
    names = [f"s{i}" for i in range(12)]
    orders = {
        str(i): {sku: int(rng.integers(1, 4)) for sku in rng.choice(names, rng.integers(1, 6), replace=False)}
        for i in range(300)
    }
    due_s = {name: float(rng.integers(9)) for name in orders}
    world = small_world(orders, {"p": names}, capacities=[6, 11, 7], counts_orders=counts, due_s=due_s)
    view, assigned = WarehouseView(world), 0
    for turn in range(8):
        available = rng.integers(0, 4, (3, 12)) * (rng.random((3, 12)) < 0.2 + 0.1 * turn)

        def score(station: Station, now: np.ndarray = available) -> np.ndarray:
            lines = view.backlog_lines
            return sum_per_order(view, np.minimum(now[station.id, lines.sku], lines.quantity))

        rank = np.array([order.due_s for order in view.backlog]) if due else None
        answer = Pairs(view, available, rank=view.lines.due_s if due else None).assign()
        assert answer == assign_best_pairs(view, score, rank=rank)
        assigned += len(answer)
        for one in answer[: int(rng.integers(1, 5))]:
            order = world.orders[one.order]
            world.assign(order, world.stations[one.station], [line.sku for line in order.open_lines])
            if rng.random() < 0.7:
                for request in world.stations[one.station].open_requests:
                    world.fulfil(request, world.pods[0])
    assert assigned > 5


def test_who_takes_is_told_until_nothing_more_fits() -> None:
    """Each assignment but the one that fills the last free place is told before the next is chosen."""
    world = small_world({"0": ["a"], "1": ["a"], "2": ["b"]}, {"p": ["a", "b"]}, capacities=[1, 1])
    told: list[tuple[int, int]] = []

    def take(pairs: Pairs, station: Station, place: int) -> None:
        told.append((station.id, int(pairs.lines.order_id[place])))
        pairs.change(1, 1, 5)  # now station 1 has what the youngest order wants

    chosen = Pairs(WarehouseView(world), np.zeros((2, 2), np.int64)).assign(take)
    assert [(one.station, one.order) for one in chosen] == [(0, 0), (1, 2)]
    assert told == [(0, 0)]


def test_ties_go_to_the_station_that_is_preferred() -> None:
    """Of the stations with an order's highest score the lowest by ``prefer`` takes it."""
    view = WarehouseView(small_world({"0": {"a": 1}}, {"p": ["a"]}, capacities=[4, 4]))
    assert [one.station for one in Pairs(view).assign()] == [0]
    assert [one.station for one in Pairs(view).assign(prefer=lambda _, station: -station.id)] == [1]
    better = np.array([[9], [0]])
    assert [one.station for one in Pairs(view, better).assign(prefer=lambda _, station: -station.id)] == [0]


def test_a_begun_order_takes_no_second_place_at_its_station() -> None:
    """Where orders are counted it fits a full station that it has a place at; another does not."""
    world = small_world({"0": ["a", "b"], "1": ["c"]}, {"p": ["a", "b", "c"]}, capacities=[1], counts_orders=True)
    world.assign(world.orders[0], world.stations[0], [0])
    chosen = Pairs(WarehouseView(world)).assign()
    assert [(one.order, one.station) for one in chosen] == [(0, 0)]


def test_lots_do_not_depend_on_orders_that_have_left() -> None:
    """Nor on whether a filter shows all orders: the same draw for the orders that are there."""
    world = small_world({str(i): ["a"] for i in range(9)}, {"p": ["a"]}, capacities=[3])
    world.assign(world.orders[2], world.stations[0], [0])
    rule, view = FirstCome(tie_break="random"), WarehouseView(world)
    for seed in range(9):
        other = rule.assign_orders(view.showing(view.backlog), np.random.default_rng(seed))
        assert rule.assign_orders(view, np.random.default_rng(seed)) == other


@OF_PAIRS
@pytest.mark.parametrize(
    ("wrong", "problem"), [({"tie_break": "newest"}, "'tie_break' must be in"), ({"fast_lane": -1}, "must be >= 0")]
)
def test_wrong_parameters_are_refused(rule: type[Any], wrong: dict[str, Any], problem: str) -> None:
    """Before the run."""
    with pytest.raises(ValueError, match=problem):
        rule(**wrong)


def test_rules_conform_with_all_of_them() -> None:
    """No order starves for want of a place that is kept."""
    assert check_rule(PodMatch(tie_break="random", late_first=True, fast_lane=2)).findings == ()
