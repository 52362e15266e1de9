"""The trial worlds are what the conformance suite says of them."""

from __future__ import annotations

from collections.abc import Sequence

import pytest
from attrs import define, evolve, field

from rmfs_commands.testing.trial import WatchedRule, run_trial
from rmfs_commands.testing.trial_worlds import TrialWorld, trial_worlds
from rmfs_core import hookimpl
from rmfs_core.events import Event, PodMoveDecided, RobotRested
from rmfs_core.info import RunInfo
from rmfs_core.roles import Role
from rmfs_core.warehouse import WarehouseView

WORLDS = {world.name: world for world in trial_worlds()}


@define
class Look:
    """Observer that notes how full the queues and how large the backlog became."""

    least_room: int = field(default=99, init=False)
    seen: int = field(default=0, init=False)
    warehouse: object = field(default=None, init=False)

    @hookimpl
    def run_started(self, run):
        self.warehouse = run.warehouse

    @hookimpl
    def on_event(self, event: Event):
        self.seen += 1
        self.least_room = min([self.least_room, *(station.queue_room for station in self.warehouse.stations)])


def look_at(world: TrialWorld) -> Look:
    """Run a world with the plain rules under watch; it has no problem."""
    look = Look()
    outcome = run_trial(world, WatchedRule(look, {}), (Role.OBSERVER,))
    assert outcome.problems == ()
    return look


@pytest.mark.parametrize("name", WORLDS)
def test_the_plain_rules_complete_every_order(name: str) -> None:
    """Whatever a finding says is the fault of the rule under test."""
    assert (look_at(WORLDS[name]).seen > 0) == (not name.startswith("no order"))


@pytest.mark.parametrize("name", WORLDS)
def test_a_renamed_world_differs_in_nothing_but_names(name: str) -> None:
    """SKUs, orders and pods sort as before, and all else is the same."""
    before, after = WORLDS[name], WORLDS[name].renamed()
    assert (before.name, before.scenario, before.layout) == (after.name, after.scenario, after.layout)
    for kind in ("orders", "pods"):
        old, new = ([evolve(part, name="") for part in getattr(world.instance, kind)] for world in (before, after))
        assert old == new
    for old, new in zip(names_in(before), names_in(after), strict=True):
        assert not {*old} & {*new}
        assert ranks(old) == ranks(new)


def names_in(world: TrialWorld) -> tuple[Sequence[str], ...]:
    """Return the names of SKUs, orders and pods."""
    given = world.instance
    return given.skus, [order.name for order in given.orders], [pod.name for pod in given.pods]


def ranks(names: Sequence[str]) -> list[int]:
    """Return the place of each name among them in alphabetical order."""
    return [sorted(names).index(name) for name in names]


def test_queues_are_full_where_they_shall_be() -> None:
    """There a station has no room left; with one robot there always is some."""
    assert look_at(WORLDS["full queues"]).least_room == 0
    assert look_at(WORLDS["a single robot"]).least_room > 0


def test_every_world_exists_with_finite_stock() -> None:
    """Each pod holds the same SKUs, and of each SKU there is at least what is ordered."""
    for name, world in WORLDS.items():
        if not world.instance.unlimited_stock:
            continue
        finite = WORLDS[f"{name}, finite stock"].instance
        assert [[sku for sku, _ in pod.contents] for pod in finite.pods] == [
            [sku for sku, _ in pod.contents] for pod in world.instance.pods
        ]
        assert not finite.unlimited_stock
        left = [0] * len(finite.skus)
        for sku, number in (held for pod in finite.pods for held in pod.contents):
            left[sku] += number
        for sku, quantity in (line for order in finite.orders for line in order.lines):
            left[sku] -= quantity
        assert min(left) >= 0


def test_stock_is_finite_and_just_enough() -> None:
    """All that is there is ordered."""
    instance = WORLDS["finite stock"].instance
    ordered = sum(order.items for order in instance.orders)
    assert ordered == sum(number or 0 for pod in instance.pods for _, number in pod.contents)
    assert not instance.unlimited_stock


def test_one_order_fits_only_an_empty_largest_station() -> None:
    """It takes all of it."""
    world = WORLDS["an order as large as the largest station"]
    assert max(order.items for order in world.instance.orders) == max(world.scenario.stations.item_capacity)


def test_one_order_fits_no_station_beside_others() -> None:
    """The largest station has fewer places than it has items."""
    world = WORLDS["an order larger than the largest station"]
    assert max(order.items for order in world.instance.orders) > max(world.scenario.stations.item_capacity)


def test_some_lines_fit_no_station_beside_others() -> None:
    """Two orders have such lines, one of them only such: however orders are split, they go alone."""
    world = WORLDS["a line longer than the largest station"]
    largest = max(world.scenario.stations.item_capacity)
    longer = [[quantity > largest for _, quantity in order.lines] for order in world.instance.orders]
    assert sum(any(lines) for lines in longer) == 2
    assert [all(lines) for lines in longer].count(True) == 1


def test_lines_of_many_items_are_brought_by_several_pods() -> None:
    """They have 10 to 40 items, and few pods hold as many."""
    instance = WORLDS["lines of 10 to 40 items on finite stock"].instance
    lines = [line for order in instance.orders for line in order.lines]
    assert (min(quantity for _, quantity in lines), max(quantity for _, quantity in lines)) == (10, 40)
    most = {sku: max(dict(pod.contents).get(sku, 0) for pod in instance.pods) for sku, _ in lines}
    assert sum(quantity > most[sku] for sku, quantity in lines) > len(lines) / 2


def test_orders_come_later() -> None:
    """None is there at the start, and the last long after the one before."""
    ticks = [order.arrival_tick for order in WORLDS["later orders"].instance.orders]
    assert min(ticks) > 0
    assert ticks[-1] - ticks[-2] > 1_000_000


@define
class Idleness:
    """Observer that notes what robots without a task do, and whether orders were under way meanwhile."""

    beside_picking: list[Event] = field(factory=list, init=False)
    low: bool = field(default=False, init=False)
    warehouse: WarehouseView | None = field(default=None, init=False)

    @hookimpl
    def run_started(self, run: RunInfo):
        self.warehouse = run.warehouse

    @hookimpl
    def on_event(self, event: Event):
        assert self.warehouse is not None
        self.low |= any(robot.low for robot in self.warehouse.robots)
        if any(station.open_requests for station in self.warehouse.stations):
            self.beside_picking.append(event)


@pytest.mark.parametrize("stock", ["", ", finite stock"])
def test_robots_charge_and_pods_are_moved_while_orders_are_picked(stock: str) -> None:
    """In the worlds of that name."""
    charging, moving = Idleness(), Idleness()
    run_trial(WORLDS[f"batteries{stock}"], WatchedRule(charging, {}), (Role.OBSERVER,))
    run_trial(WORLDS[f"moved pods{stock}"], WatchedRule(moving, {}), (Role.OBSERVER,))
    assert charging.low
    assert any(isinstance(event, RobotRested) for event in charging.beside_picking)
    assert sum(isinstance(event, PodMoveDecided) for event in moving.beside_picking) >= 3


def test_robots_stations_and_capacity_are_as_named() -> None:
    """One station, several, one robot, orders counted."""
    assert len(WORLDS["one station"].layout.stations) == 1
    assert len(WORLDS["several stations"].layout.stations) == 3
    assert WORLDS["a single robot"].scenario.robots.count == 1
    assert WORLDS["order capacity"].scenario.stations.order_capacity == (2, 1)
    assert WORLDS["no order"].instance.orders == ()
