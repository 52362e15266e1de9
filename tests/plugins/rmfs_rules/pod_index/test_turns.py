"""The turns of stations."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from attrs import evolve
from hypothesis import given, settings
from hypothesis import strategies as st

from literal_pod_index import Literal
from rmfs_commands.testing import small_instance, small_world
from rmfs_core import JointDecision, OrderAssignment, PodTrip
from rmfs_core.warehouse import Station, Warehouse, WarehouseView
from rmfs_rules.helpers import largest_capacity
from rmfs_rules.helpers.oversize import Oversize, with_oversize
from rmfs_rules.pod_index import PodIndex
from rmfs_rules.pod_index.alone import assign_alone


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


@st.composite
def worlds(draw: st.DrawFn) -> Callable[[], Warehouse]:
    """Draw a world in the middle of a run; calling the result builds it, the same each time."""
    scarce = draw(st.booleans())
    lines = st.dictionaries(st.sampled_from("abcdef"), st.integers(1, 1 if scarce else 4), min_size=1, max_size=3)
    orders = {str(i): order for i, order in enumerate(draw(st.lists(lines, min_size=1, max_size=6)))}
    items = st.integers(1, 3) if scarce else st.just(None)
    contents = st.dictionaries(st.sampled_from("abcdef"), items, min_size=1, max_size=3)
    pods = {str(i): pod for i, pod in enumerate(draw(st.lists(contents, min_size=1, max_size=6)))}
    capacities = draw(st.lists(st.integers(1, 6), min_size=1, max_size=3))
    counts_orders, few = draw(st.booleans()), st.integers(0, 20)
    arrivals = sorted(draw(st.lists(st.sampled_from([0, 0, 1000, 60_000, 500_000]), min_size=6, max_size=6)))
    due = draw(st.lists(st.sampled_from([None, None, 100_000, 900_000]), min_size=6, max_size=6))
    priority = draw(st.lists(st.sampled_from([0, 0, 0, 1, -2]), min_size=6, max_size=6))
    begun = draw(st.lists(st.tuples(few, few, st.booleans()), max_size=3))
    bound = draw(st.lists(st.tuples(few, few), max_size=4))
    at_station = draw(st.booleans())

    def build() -> Warehouse:
        plain = small_world(orders, pods, capacities=capacities, counts_orders=counts_orders)  # type: ignore[arg-type]
        instance = small_instance(orders, pods)  # type: ignore[arg-type]
        later = [
            evolve(order, arrival_tick=tick, due_tick=due_tick, priority=steps)
            for order, tick, due_tick, steps in zip(instance.orders, arrivals, due, priority, strict=False)
        ]
        instance = evolve(instance, orders=tuple(later))
        world = Warehouse(instance, plain.travel, plain.stations, plain.robots, plain.homes)
        for order in world.orders:
            world.order_arrives(order)
        world.now = 600_000
        for number, at, whole in begun:
            order, station = world.orders[number % len(orders)], world.stations[at % len(capacities)]
            chosen = order.open_lines[: None if whole else 1]
            size = 1 if counts_orders else sum(line.quantity for line in chosen)
            if chosen and not order.waits_for_stock and size <= station.free_capacity:
                world.assign(order, station, [line.sku for line in chosen])
        if at_station:
            world.place_at_station(world.robots[0], world.pods[0], world.stations[0])
        for number, at in bound:
            pod, station = world.pods[number % len(pods)], world.stations[at % len(capacities)]
            if station.id not in pod.bound_for:
                world.bind(pod, station)
        return world

    return build


@given(
    build=worlds(),
    visit_s=st.sampled_from([47.0, 300.0]),
    stay=st.sampled_from([0.0, 0.83, 1.37]),
    near=st.sampled_from([0.0, 0.21]),
    urge_s=st.sampled_from([0, 170, 2000]),
    most_pods=st.integers(1, 3),
    packing_capacity=st.sampled_from([None, None, 1, 3]),
    hidden=st.integers(0, 2),
)
@settings(max_examples=150, deadline=None)
def test_decisions_are_those_of_the_literal_rule(
    build: Callable[[], Warehouse], hidden: int, **parameters: Any
) -> None:
    """Whatever the stock, the places, the orders begun, and those that a filter leaves out."""
    rule = PodIndex(elsewhere=0.71, cost_s=310, **parameters)
    world = build()
    view = WarehouseView(world)
    if hidden:
        view = view.showing(view.backlog[hidden:])

    def literal(without: Station | None = None) -> JointDecision:
        taken, trips = Literal(rule, view, without).decide()
        parts: dict[tuple[int, int], list[int]] = {}
        for order, at, sku in taken:
            parts.setdefault((order, at), []).append(sku)
        return JointDecision(
            [OrderAssignment(order, at, tuple(skus)) for (order, at), skus in parts.items()],
            [PodTrip(*trip) for trip in trips],
        )

    expected = literal()
    if any(line.quantity > largest_capacity(view) for order in view.backlog for line in order.open_lines):
        large = Oversize.of(view, rule.max_wait_s, splits=True, over_time=True)
        expected = with_oversize(view, large, literal, lambda large: assign_alone(view, large))
    assert rule.assign_orders_and_pods(view) == expected
