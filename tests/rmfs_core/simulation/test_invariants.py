"""Invariants of every run, on random small instances, layouts and rule sets."""

from __future__ import annotations

from collections import Counter, defaultdict
from pathlib import Path
from typing import Any

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rmfs_commands.layouts import block_map, parse_map
from rmfs_core import hookimpl
from rmfs_core.events import (
    Event,
    ItemPicked,
    OrderArrived,
    OrderAssigned,
    OrderCompleted,
    PodLifted,
    PodStored,
    RobotMoved,
    VisitEnded,
    VisitStarted,
)
from rmfs_core.rules import RuleSet
from rmfs_core.scenario.model import (
    LayoutSection,
    RobotsSection,
    RuleChoice,
    RulesSection,
    Scenario,
    StationsSection,
)
from rmfs_core.simulation.engine import Simulation
from rmfs_core.world import Instance, OrderData, PodData


@st.composite
def instances(draw: st.DrawFn) -> Instance:
    """Orders of up to 4 lines, arriving at any time, and pods with enough stock, finite or not."""
    n_skus = draw(st.integers(1, 6))
    lines = st.dictionaries(st.integers(0, n_skus - 1), st.integers(1, 2), min_size=1, max_size=4)
    orders = draw(st.lists(st.tuples(lines, st.integers(0, 300_000)), max_size=12))
    orders.sort(key=lambda order: order[1])
    wanted: Counter[int] = Counter()
    for order, _ in orders:
        wanted.update(order)
    finite = draw(st.booleans())
    pods: list[dict[int, int | None]] = [{} for _ in range(draw(st.integers(1, 8)))]
    for sku in range(n_skus):
        holders = draw(st.lists(st.sampled_from(range(len(pods))), min_size=1, max_size=3, unique=True))
        left = wanted[sku]
        for i, pod in enumerate(holders):
            share = left if i == len(holders) - 1 else draw(st.integers(0, left))
            left -= share
            if not finite:
                pods[pod][sku] = None
            elif share:
                pods[pod][sku] = share
    return Instance(
        tuple(map(str, range(n_skus))),
        tuple(OrderData(str(i), tick, tuple(order.items())) for i, (order, tick) in enumerate(orders)),
        tuple(PodData(str(i), tuple(held.items())) for i, held in enumerate(pods)),
    )


@st.composite
def scenarios(draw: st.DrawFn) -> Scenario:
    """Small block layouts with any shipped rules."""

    def choose(*names: str) -> RuleChoice:
        return RuleChoice(draw(st.sampled_from(names)))

    rows = draw(st.integers(3, 7))
    fitting = (rows - 1) // 2
    east = draw(st.integers(1, fitting))
    west = draw(st.integers(0, fitting))
    by_orders = draw(st.booleans())
    return Scenario(
        rules=RulesSection(
            poa=choose("pod-match", "common-lines", "first-come", "near-best-pod", "station-queue"),
            pps=choose("demand", "nearest-pod", "completes", "random"),
            pr=choose("nearest", "fixed", "random", "turnover-classes", "cache", "utility"),
            ta=choose("nearest-robot", "balanced", "assignment"),
        ),
        seed=draw(st.integers(0, 1000)),
        layout=LayoutSection(
            block_rows=rows,
            block_columns=draw(st.integers(1, 3)),
            block_length=draw(st.integers(2, 4)),
            hall_width=draw(st.integers(1, 3)),
            stations_east=east,
            stations_west=west,
            pod_fill=draw(st.floats(0.1, 1.0)),
        ),
        robots=RobotsSection(count=draw(st.integers(1, 6))),
        stations=StationsSection(
            item_capacity=draw(st.integers(8, 15)),
            order_capacity=draw(st.integers(1, 4)) if by_orders else None,
            queue_length=draw(st.integers(1, 5)),
        ),
    )


class Watch:
    """Observer that follows the run and holds every event against the invariants."""

    def __init__(self, scenario: Scenario, instance: Instance) -> None:
        self.scenario = scenario
        self.instance = instance
        self.stock = [dict(pod.contents) for pod in instance.pods]
        self.left = [Counter(dict(order.lines)) for order in instance.orders]
        self.in_backlog = [dict(order.lines) for order in instance.orders]
        self.arrived: set[int] = set()
        self.parts: dict[tuple[int, int], list[Counter[int]]] = defaultdict(list)
        self.carried: dict[int, int] = {}
        self.at_station: dict[int, int] = {}
        self.robot_cell: dict[int, int] = {}
        self.completed: list[int] = []
        self.tick = 0

    @hookimpl
    def on_event(self, event: Event) -> None:
        assert event.tick >= self.tick, "time goes forwards"
        self.tick = event.tick
        handler: Any = getattr(self, type(event).__name__, None)
        if handler is not None:
            handler(event)

    def OrderArrived(self, event: OrderArrived) -> None:
        assert event.tick == self.instance.orders[event.order].arrival_tick
        self.arrived.add(event.order)

    def OrderAssigned(self, event: OrderAssigned) -> None:
        assert event.order in self.arrived
        part = Counter({sku: self.in_backlog[event.order].pop(sku) for sku in event.skus})
        assert event.items == part.total()
        assert event.complete == (not self.in_backlog[event.order])
        self.parts[event.order, event.station].append(part)
        self.check_capacity(event.station)

    def check_capacity(self, station: int) -> None:
        sizes = [
            sum(dict(self.instance.orders[order].lines)[sku] for sku in part)
            for (order, at), parts in self.parts.items()
            if at == station
            for part in parts
            if part.total() > 0
        ]
        section = self.scenario.stations
        if section.order_capacity is not None:
            assert len(sizes) <= section.order_capacity
        else:
            assert sum(sizes) <= section.item_capacity

    def PodLifted(self, event: PodLifted) -> None:
        assert event.pod not in self.carried.values()
        assert event.robot not in self.carried
        self.carried[event.robot] = event.pod

    def PodStored(self, event: PodStored) -> None:
        assert self.carried.pop(event.robot) == event.pod
        assert self.robot_cell[event.robot] == event.cell

    def RobotMoved(self, event: RobotMoved) -> None:
        assert self.robot_cell.get(event.robot, event.origin) == event.origin, "no jumps"
        assert event.pod == self.carried.get(event.robot)
        self.robot_cell[event.robot] = event.to

    def VisitStarted(self, event: VisitStarted) -> None:
        assert event.station not in self.at_station, "one pod at a station at a time"
        assert self.carried[event.robot] == event.pod
        self.at_station[event.station] = event.pod

    def VisitEnded(self, event: VisitEnded) -> None:
        assert self.at_station.pop(event.station) == event.pod

    def ItemPicked(self, event: ItemPicked) -> None:
        assert self.at_station[event.station] == event.pod
        held = self.stock[event.pod]
        assert event.sku in held
        if held[event.sku] is not None:
            held[event.sku] -= 1  # type: ignore[operator]
            assert held[event.sku] >= 0  # type: ignore[operator]
        self.left[event.order][event.sku] -= 1
        assert self.left[event.order][event.sku] >= 0, "each item is picked once"
        part = next(part for part in self.parts[event.order, event.station] if part[event.sku] > 0)
        part[event.sku] -= 1

    def OrderCompleted(self, event: OrderCompleted) -> None:
        assert self.left[event.order].total() == 0
        self.completed.append(event.order)


def simulate(scenario: Scenario, instance: Instance) -> Watch:
    """Run a scenario under watch."""
    rules = RuleSet.load(scenario.rules, str(Path()))
    watch = Watch(scenario, instance)
    rules.register_observer(watch)
    layout = parse_map(block_map(scenario.layout, scenario.stations.queue_length), "layout")
    Simulation(scenario, instance, layout, rules).run()
    return watch


@given(scenario=scenarios(), instance=instances())
@settings(deadline=None, max_examples=150, suppress_health_check=[HealthCheck.too_slow])
def test_invariants_hold_in_every_run(scenario: Scenario, instance: Instance) -> None:
    """Items are conserved, capacity is kept, a pod is in one place, and every order is complete at the end."""
    watch = simulate(scenario, instance)
    assert sorted(watch.completed) == list(range(len(instance.orders)))
    assert all(left.total() == 0 for left in watch.left)
