"""Joint rules alternating, two-stage and lns."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from rmfs_commands.testing import check_rule, small_world
from rmfs_core import JointDecision
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.joint import Alternating, LargeNeighborhoodSearch, TwoStage
from rmfs_rules.mip import Integrated

Put = Callable[[Warehouse, int, int], None]


def decide(rule: Any, world: Warehouse, seed: int = 0) -> tuple[list[tuple[str, int]], list[tuple[str, int]]]:
    """Return (order's name, station) of each assignment, and (pod's name, station) of each trip, by name."""
    draws = (np.random.default_rng(seed),) if isinstance(rule, LargeNeighborhoodSearch) else ()
    decision = rule.assign_orders_and_pods(WarehouseView(world), *draws)
    return (
        sorted((world.orders[one.order].name, one.station) for one in decision.assignments),
        sorted((world.pods[one.pod].name, one.station) for one in decision.trips),
    )


@pytest.mark.parametrize(
    "rule",
    [
        Alternating(rounds=1, max_wait_s=60, unused_capacity_weight=0.5),
        TwoStage(first_share=0.2, max_wait_s=60),
        TwoStage(first_orders="oldest"),
        LargeNeighborhoodSearch(max_wait_s=60, share=1.0, iterations=5, unused_capacity_weight=0.5),
    ],
)
def test_it_conforms(rule: object) -> None:
    """With parameters other than the defaults, in every trial world: finite stock, order capacity, later arrivals."""
    check_rule(rule)


@pytest.mark.parametrize(
    ("rule", "wrong"),
    [
        (Alternating, {"rounds": 0}),
        (Alternating, {"unused_capacity_weight": 0}),
        (Alternating, {"max_wait_s": -1}),
        (TwoStage, {"first_share": 0}),
        (TwoStage, {"first_share": 1.5}),
        (TwoStage, {"first_orders": "best"}),
        (LargeNeighborhoodSearch, {"iterations": -1}),
        (LargeNeighborhoodSearch, {"share": 0}),
        (LargeNeighborhoodSearch, {"share": 1.1}),
        (LargeNeighborhoodSearch, {"unused_capacity_weight": 0}),
    ],
)
def test_bad_parameters(rule: type[Any], wrong: dict[str, Any]) -> None:
    """They are refused."""
    with pytest.raises(ValueError, match=next(iter(wrong))):
        rule(**wrong)


def random_world(seed: int) -> Warehouse:
    """Return a small world in the middle of a run: pods bound for stations, some orders assigned, stock often scarce.

    Every order fits a station, and all pods together have what all orders want.
    """
    rng = np.random.default_rng(seed)
    skus, n_pods = "abcdef", int(rng.integers(2, 7))
    most, finite = (3 if seed % 3 == 0 else 1), seed % 2 == 0
    orders = {
        str(i): {str(sku): int(rng.integers(1, most + 1)) for sku in rng.choice([*skus], rng.integers(1, 4), False)}
        for i in range(int(rng.integers(1, 9)))
    }
    pods: dict[str, dict[str, int | None]] = {f"p{i}": {} for i in range(n_pods)}
    for sku in skus:
        holders = rng.choice(n_pods, rng.integers(1, min(n_pods, 3) + 1), False)
        wanted = sum(order.get(sku, 0) for order in orders.values())
        for number, pod in enumerate(holders.tolist()):
            pods[f"p{pod}"][sku] = (wanted + number) // len(holders) + 1 if finite else None
    capacities = rng.integers(9, 12, rng.integers(1, 4)) if most > 1 else rng.integers(3, 7, rng.integers(1, 4))
    held = {name: contents for name, contents in pods.items() if contents}
    world = small_world(orders, held, capacities=capacities.tolist(), counts_orders=seed % 5 == 0)  # type: ignore[arg-type]
    for station in world.stations:
        for pod in rng.choice(len(held), rng.integers(0, min(len(held), 2) + 1), False).tolist():
            world.bind(world.pods[pod], station)
    return world


def apply(world: Warehouse, decision: JointDecision) -> None:
    """Carry a decision out; fail where the kernel would refuse it."""
    for trip in decision.trips:
        assert trip.station not in world.pods[trip.pod].bound_for
        world.bind(world.pods[trip.pod], world.stations[trip.station])
    for pair in decision.assignments:
        order, station = world.orders[pair.order], world.stations[pair.station]
        assert world.size_at(order, station) <= station.free_capacity
        world.assign(order, station, [line.sku for line in order.open_lines])
    for trip in decision.trips:
        wanted = {request.sku for request in world.stations[trip.station].open_requests}
        assert wanted & world.pods[trip.pod].contents.keys()
    assert not [request for station in world.stations for request in station.uncovered_requests]


def missed(decide: Callable[[WarehouseView, int], JointDecision]) -> list[float]:
    """Decide random periods, (view, seed); return by how much each misses the optimum.

    The objective that a decision reports is worked out anew: visits, and two for every free place.
    """
    missed = []
    for seed in range(60):
        world = random_world(seed)
        visits = sum(len(station.inbound_pods) for station in world.stations)
        decision = decide(WarehouseView(world), seed)
        largest = max(order.items for order in world.orders) if world.stations[0].counts_orders else 1
        apply(world, decision)
        free = sum(station.free_capacity for station in world.stations)
        objective = visits + len(decision.trips) + 2 * largest * free
        assert decision.report is None or decision.report.objective == objective
        missed.append(objective - optimum(seed))
    return missed


@cache
def optimum(seed: int) -> float:
    """Return the least objective of a random period, by the model as it is printed."""
    rule = Integrated(formulation="paper")
    report = rule.assign_orders_and_pods(WarehouseView(random_world(seed)), np.random.default_rng()).report
    assert report is not None
    assert report.objective is not None
    return report.objective


def improvable() -> Warehouse:
    """Six places, two orders of three items for them.

    The oldest comes first, and lacks as much as any other. p, which brings most of it, and q together have all of 3.
    """
    orders = {"1": ["a", "b", "c"], "2": ["d", "e", "f"], "3": ["a", "b", "x"]}
    return small_world(orders, {"p": ["a", "b"], "q": ["c", "x"], "r": ["d", "e"], "s": ["f"]}, capacities=[6])


def test_orders_for_pods_and_pods_for_orders_by_hand() -> None:
    """Order 1 lacks p and q, and then 3 lacks x alone of its three lines, 2 all of them. p and q bring what both want.

    Orders 1 and 3 fill the places with two visits; 1 and 2 would take four.
    """
    assert decide(Alternating(), improvable()) == ([("1", 0), ("3", 0)], [("p", 0), ("q", 0)])


def test_the_second_time_orders_go_by_the_pods_that_are_sent() -> None:
    """Four places. Order 1 takes two and has to have x brought, hence 3 lacks one of two lines, and 2 both of them.

    1 and 3 take three pods. But p, sent for a, has all of 2 as well: with the three there, no order lacks anything, the
    oldest go, and 1 and 2 take two.
    """
    orders, pods = {"1": ["a", "x"], "2": ["c", "d"], "3": ["x", "b"]}, {"p": ["a", "c", "d"], "q": ["x"], "r": ["b"]}
    first = decide(Alternating(rounds=1), small_world(orders, pods, capacities=[4]))
    assert first == ([("1", 0), ("3", 0)], [("p", 0), ("q", 0), ("r", 0)])
    assert decide(Alternating(), small_world(orders, pods, capacities=[4])) == (
        [("1", 0), ("2", 0)],
        [("p", 0), ("q", 0)],
    )


def test_what_is_there_goes_first(put_at_station: Put) -> None:
    """The older order would need a pod, the younger one is on the pod that is there."""
    world = small_world({"1": ["a"], "2": ["b"]}, {"p": ["a"], "q": ["b"]}, capacities=[1])
    put_at_station(world, 1, 0)
    assert decide(Alternating(), world) == ([("2", 0)], [])


def test_more_rounds_cost_no_more() -> None:
    """On random periods; some are improved, and most are decided as well as the model does."""
    one, more = (
        missed(lambda view, seed, rounds=rounds: Alternating(rounds=rounds).assign_orders_and_pods(view))
        for rounds in (1, 10)
    )
    assert all(later <= earlier for earlier, later in zip(one, more, strict=True))
    assert sum(more) < sum(one)
    assert min(more) == 0
    assert sum(more) / len(more) < 1


def test_both_stages_by_hand() -> None:
    """Six places, half of them for the first stage: order 1 takes two, hence 2 may follow, and then the load is four.

    p and q are sent for them. Of the others, 3 needs r, which is not sent; 4 and 5 are on p and q, and fill the places.
    """
    orders = {"1": ["a", "b"], "2": ["c", "d"], "3": ["e"], "4": ["b"], "5": ["d"], "6": ["a"]}
    world = small_world(orders, {"p": ["a", "b"], "q": ["c", "d"], "r": ["e"]}, capacities=[6])
    given = decide(TwoStage(first_share=0.5, first_orders="oldest"), world)
    assert given == ([("1", 0), ("2", 0), ("4", 0), ("5", 0)], [("p", 0), ("q", 0)])


def test_of_equal_pods_the_one_that_the_backlog_wants_is_sent() -> None:
    """Both have order 1; q has order 3 as well, which the second stage takes."""
    world = small_world({"1": ["a"], "2": ["x"], "3": ["b"]}, {"p": ["a"], "q": ["a", "b"], "r": ["x"]}, capacities=[2])
    assert decide(TwoStage(first_share=0.5), world) == ([("1", 0), ("3", 0)], [("q", 0)])


@pytest.mark.parametrize(("first_orders", "expected"), [("cheapest", "2"), ("oldest", "1")])
def test_which_orders_go_first(first_orders: str, expected: str) -> None:
    """One place; the younger order is on the pod that is bound for the station."""
    world = small_world({"1": ["a"], "2": ["b"]}, {"p": ["a"], "q": ["b"]}, capacities=[1])
    world.bind(world.pods[1], world.stations[0])
    assert decide(TwoStage(first_orders=first_orders), world)[0] == [(expected, 0)]


def test_a_station_with_enough_to_do_sends_for_no_pod() -> None:
    """Three of four places are taken: order 2 waits, though it would fit; with a larger share it does not."""
    for share, expected in ((0.75, []), (0.8, [("q", 0)])):
        world = small_world({"1": ["a", "b", "c"], "2": ["d"]}, {"p": ["a", "b", "c"], "q": ["d"]}, capacities=[4])
        world.bind(world.pods[0], world.stations[0])
        world.assign(world.orders[0], world.stations[0], [line.sku for line in world.orders[0].lines])
        assert decide(TwoStage(first_share=share), world)[1] == expected


def test_an_order_that_has_waited_too_long_is_not_held_up_by_the_second_stage() -> None:
    """Order 2 needs all four places, one of which is in use; order 3 would take another while its pod is there."""

    def assigned(now_s: float) -> list[tuple[str, int]]:
        world = small_world({"1": ["a"], "2": {"b": 4}, "3": ["a"]}, {"p": ["a"], "q": ["b"]}, capacities=[4])
        world.bind(world.pods[0], world.stations[0])
        world.assign(world.orders[0], world.stations[0], [0])
        world.now = round(1000 * now_s)
        return decide(TwoStage(first_share=0.1, max_wait_s=60), world)[0]

    assert assigned(59.0) == [("3", 0)]
    assert assigned(60.0) == []


def test_finite_stock_is_not_given_away_twice() -> None:
    """p, which goes to both stations, has three items of a: after the first stage one is left, for one order of two."""
    orders = {"1": {"a": 1, "b": 1}, "2": {"a": 1, "c": 1}, "3": ["a"], "4": ["a"]}
    world = small_world(orders, {"p": {"a": 3, "b": 1, "c": 1}, "r": {"a": 1}}, capacities=[3, 3])
    taken, trips = decide(TwoStage(first_share=0.5), world)
    assert len(taken) == 3
    assert ("r", 0) not in trips
    assert ("r", 1) not in trips


def test_two_stages_are_never_below_the_optimum() -> None:
    """On random periods, where the kernel would take each decision; with the whole capacity it is close."""
    whole, half = (
        missed(lambda view, seed, share=share: TwoStage(first_share=share).assign_orders_and_pods(view))
        for share in (1.0, 0.5)
    )
    assert min(whole) == min(half) == 0
    assert sum(whole) / len(whole) < 2


@pytest.mark.parametrize("seed", range(5))
def test_taking_back_by_hand(seed: int) -> None:
    """Two places. The two oldest orders take two pods, 2 and 3 one: whoever takes order 1 back finds 3 on the pod of 2.

    Choosing in turn does not find that: each order has its pod as soon as it is chosen, and the oldest go.
    """
    orders, pods = {"1": ["a"], "2": ["b"], "3": ["c"]}, {"p": ["a"], "q": ["b", "c"]}
    assert decide(LargeNeighborhoodSearch(iterations=0), small_world(orders, pods, capacities=[2])) == (
        [("1", 0), ("2", 0)],
        [("p", 0), ("q", 0)],
    )
    assert decide(LargeNeighborhoodSearch(), small_world(orders, pods, capacities=[2]), seed) == (
        [("2", 0), ("3", 0)],
        [("q", 0)],
    )


@pytest.mark.parametrize("seed", range(5))
def test_of_equal_costs_the_oldest_orders_go(seed: int) -> None:
    """Each order needs a pod of its own: nothing is better than the two oldest."""
    orders, pods = {str(i): "abcdef"[i] for i in range(6)}, {f"p{sku}": [sku] for sku in "abcdef"}
    assert decide(LargeNeighborhoodSearch(), small_world(orders, pods, capacities=[2]), seed)[0] == [("0", 0), ("1", 0)]


def test_lns_leaves_orders_that_have_waited_too_long() -> None:
    """As by hand, but order 1 has waited since 0 s, the others are as late and order 3 is left: nothing is improved."""
    orders, pods = {"1": ["a"], "2": ["b"], "3": ["c"]}, {"p": ["a"], "q": ["b", "c"]}
    world = small_world(orders, pods, capacities=[2])
    world.now = 60_000
    assert decide(LargeNeighborhoodSearch(max_wait_s=60), world)[0] == [("1", 0), ("2", 0)]
    assert decide(LargeNeighborhoodSearch(max_wait_s=61), world)[0] == [("2", 0), ("3", 0)]


def test_it_costs_less_with_the_iterations_and_is_never_below_the_optimum() -> None:
    """On random periods, where the kernel would take each decision; with none it is that of alternating."""

    def after(iterations: int) -> list[float]:
        rule = LargeNeighborhoodSearch(iterations=iterations)
        return missed(lambda view, seed: rule.assign_orders_and_pods(view, np.random.default_rng(seed)))

    results = [after(iterations) for iterations in (0, 5, 50)]
    assert results[0] == missed(lambda view, seed: Alternating().assign_orders_and_pods(view))
    for fewer, more in pairwise(results):
        assert all(later <= earlier for earlier, later in zip(fewer, more, strict=True))
        assert sum(more) < sum(fewer)
    assert min(results[-1]) == 0
    assert results[-1].count(0) >= 54
