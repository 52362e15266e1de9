"""Trial worlds, snapshots and traces for tests of rules."""

import re
from collections.abc import Callable, Sequence
from typing import Any, ClassVar

import pytest
from attrs import define, evolve, field

import rmfs_core
import rmfs_core.testing
from cases import cases
from reserving import hold_until
from rmfs_commands.testing import small_instance, small_layout, small_world, trial
from rmfs_commands.testing.snapshot import Snapshot
from rmfs_commands.testing.trial import CallTimes, Outcome, WatchedRule, run_trial
from rmfs_commands.testing.trial_worlds import TrialWorld, trial_worlds
from rmfs_core import Leg, OrderAssignment, hookimpl
from rmfs_core.events import DecisionMade, Event, OrderCompleted, PodMoveDecided, RobotRested
from rmfs_core.info import Question, RunInfo
from rmfs_core.roles import Role
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_core.warehouse.promises import next_request
from rmfs_core.world import NORTH, CellKind
from rmfs_traffic import Query, Reservations, Roads, Traffic

WORLD = trial_worlds()[0]
"""One station, ten orders."""


def tried(rule: Any, *roles: Role, world: TrialWorld = WORLD) -> tuple[Outcome, dict[str, CallTimes]]:
    times: dict[str, CallTimes] = {}
    return run_trial(world, WatchedRule(rule, times), roles), times


@define
class First:
    @hookimpl
    def assign_orders(self, warehouse):
        station = warehouse.stations[0]
        return [OrderAssignment(order.id, 0) for order in warehouse.backlog if warehouse.fits(order, station)][:1]


def test_all_events_are_kept() -> None:
    outcome, times = tried(First(), Role.POA)
    assert outcome.problems == ()
    assert sum(isinstance(event, OrderCompleted) for event in outcome.events) == len(WORLD.instance.orders)
    decisions = [event for event in outcome.events if isinstance(event, DecisionMade)]
    assert {event.rule for event in decisions if event.decides is Role.POA} == {"First"}
    assert {event.wall_s for event in decisions} == {0.0}
    assert outcome.events == tried(First(), Role.POA)[0].events
    assert times.keys() == {"assign_orders"}
    assert times["assign_orders"].calls == sum(event.decides is Role.POA for event in decisions)


@define
class Watching(First):
    told: list[str] = field(factory=list)

    @hookimpl
    def run_started(self, run: RunInfo) -> None:
        self.told.append("run_started")

    @hookimpl
    def rule_asked(self, question: Question) -> None:
        self.told.append("rule_asked")

    @hookimpl
    def rule_answered(self, question: Question, answer: object) -> None:
        self.told.append("rule_answered")

    @hookimpl
    def run_ended(self, tick: int, status: str) -> None:
        self.told.append(status)

    @hookimpl
    def measured(self) -> dict[str, float]:
        self.told.append("measured")
        return {}


def test_rules_that_observe_are_told_and_watched() -> None:
    rule = Watching()
    outcome, times = tried(rule, Role.POA, Role.OBSERVER)
    assert outcome.problems == ()
    assert rule.told[0] == "run_started"
    assert rule.told[-2:] == ["complete", "measured"]
    assert rule.told.count("rule_asked") == rule.told.count("rule_answered") > times["assign_orders"].calls
    tuple_of_kinds, mapping, heard = Choosy(), Choosy(), []
    mapping.hears = {OrderCompleted: [lambda event: heard.append(event.order)]}
    for rule in (tuple_of_kinds, mapping):
        outcome, times = tried(rule, Role.POA, Role.OBSERVER)
        assert outcome.problems == ()
        assert times["on_event"].calls == len(WORLD.instance.orders)
    assert tuple_of_kinds.heard == heard != []
    assert mapping.heard == []
    rule = Choosy()
    watched = WatchedRule(rule, {})
    rule.hears = {OrderCompleted: [lambda _: object.__setattr__(watched.view.pods[0], "name", "mine")]}
    (kind, problem), *_ = run_trial(WORLD, watched, (Role.POA, Role.OBSERVER)).problems
    assert (kind, problem[:24]) == ("mutation of the view", "on_event changed name of")
    outcome, _ = tried(Renames(), Role.POA)
    assert "exception" in [kind for kind, _ in outcome.problems]


@define
class Choosy(First):
    hears: Any = (OrderCompleted,)
    heard: list[int] = field(factory=list)

    @hookimpl
    def on_event(self, event: OrderCompleted) -> None:
        self.heard.append(event.order)


@define
class Renames:
    @hookimpl
    def assign_orders(self, warehouse):
        object.__setattr__(warehouse.pods[0], "name", "mine")
        raise ValueError("no idea")


def test_runs_that_get_nowhere_are_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trial, "MOST_CALLS", 3)
    outcome, times = tried(First(), Role.POA)
    ((kind, problem),) = outcome.problems
    assert kind == "starved order"
    said = r"after 3 decisions the run is not over: it was asked assign_orders 3 times, until [\d.]+ s"
    assert re.fullmatch(said, problem)
    assert times["assign_orders"].calls == 3
    monkeypatch.setattr(trial, "MOST_CALLS", 30)
    ((kind, problem),) = tried(Sleepless(), Role.POA)[0].problems
    assert kind == "starved order"
    assert "wake_at 15 times" in problem
    assert problem.endswith(", until 15.000 s")


@define
class Sleepless(First):
    @hookimpl
    def assign_orders(self):
        return []

    @hookimpl
    def wake_at(self, warehouse):
        return warehouse.now_s + 1


def test_rules_between_runs() -> None:
    rule = WatchedRule(First(), {})
    for _ in range(2):
        assert run_trial(WORLD, rule, (Role.POA,)).problems == ()
    assert rule.asked.total() == rule.times["assign_orders"].calls // 2
    outcome, _ = tried(Ruthless(), Role.PP, world=trial_worlds()[1])
    (mutation, _), (kind, problem) = outcome.problems
    assert (mutation, kind) == ("mutation of the view", "impossible trace")
    assert re.fullmatch(r"at [\d.]+ s robot \d and robot \d (both hold|drive through) .* more\)", problem)


@define
class Ruthless:
    """PP that takes from the other robots what they have reserved, and drives as if it were alone."""

    reserves: ClassVar[str] = "full paths"

    @hookimpl
    def plan_path(self, warehouse, robot, goal, traffic):
        for other in warehouse.robots:
            if other is not robot:
                traffic.table.release(other.id)
        query = traffic.query
        legs = warehouse.travel.fastest_path(query.cell, query.heading, query.goal, query.loaded)
        return rmfs_core.Path(legs or [Leg(query.cell)])


WORLDS = {world.name: world for world in trial_worlds()}


@define
class Look:
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
    look = Look()
    assert run_trial(world, WatchedRule(look, {}), (Role.OBSERVER,)).problems == ()
    return look


@pytest.mark.parametrize("name", WORLDS)
def test_the_plain_rules_complete_every_order(name: str) -> None:
    assert (look_at(WORLDS[name]).seen > 0) == (not name.startswith("no order"))


@pytest.mark.parametrize("name", WORLDS)
def test_a_renamed_world_differs_in_nothing_but_names(name: str) -> None:
    before, after = WORLDS[name], WORLDS[name].renamed()
    assert (before.name, before.scenario, before.layout) == (after.name, after.scenario, after.layout)
    for kind in ("orders", "pods"):
        old, new = ([evolve(part, name="") for part in getattr(world.instance, kind)] for world in (before, after))
        assert old == new
    for old, new in zip(names_in(before), names_in(after), strict=True):
        assert not {*old} & {*new}
        assert ranks(old) == ranks(new)


def names_in(world: TrialWorld) -> tuple[Sequence[str], ...]:
    given = world.instance
    return given.skus, [order.name for order in given.orders], [pod.name for pod in given.pods]


def ranks(names: Sequence[str]) -> list[int]:
    return [sorted(names).index(name) for name in names]


def test_trial_worlds_are_hard() -> None:
    assert look_at(WORLDS["full queues"]).least_room == 0
    assert look_at(WORLDS["a single robot"]).least_room > 0
    instance = WORLDS["finite stock"].instance
    ordered = sum(order.items for order in instance.orders)
    assert ordered == sum(number or 0 for pod in instance.pods for _, number in pod.contents)
    assert not instance.unlimited_stock
    world = WORLDS["an order as large as the largest station"]
    assert max(order.items for order in world.instance.orders) == max(world.scenario.stations.item_capacity)
    world = WORLDS["an order larger than the largest station"]
    assert max(order.items for order in world.instance.orders) > max(world.scenario.stations.item_capacity)
    world = WORLDS["a line longer than the largest station"]
    largest = max(world.scenario.stations.item_capacity)
    longer = [[quantity > largest for _, quantity in order.lines] for order in world.instance.orders]
    assert sum(any(lines) for lines in longer) == 2
    assert [all(lines) for lines in longer].count(True) == 1
    instance = WORLDS["lines of 10 to 40 items on finite stock"].instance
    lines = [line for order in instance.orders for line in order.lines]
    assert (min(quantity for _, quantity in lines), max(quantity for _, quantity in lines)) == (10, 40)
    most = {sku: max(dict(pod.contents).get(sku, 0) for pod in instance.pods) for sku, _ in lines}
    assert sum(quantity > most[sku] for sku, quantity in lines) > len(lines) / 2
    ticks = [order.arrival_tick for order in WORLDS["later orders"].instance.orders]
    assert min(ticks) > 0
    assert ticks[-1] - ticks[-2] > 1_000_000


def test_every_world_exists_with_finite_stock() -> None:
    for name, world in WORLDS.items():
        if f"{name}, finite stock" not in WORLDS:
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


@define
class Idleness:
    beside_picking: list[Event] = field(factory=list, init=False)
    low: bool = field(default=False, init=False)
    warehouse: WarehouseView | None = field(default=None, init=False)

    @hookimpl
    def run_started(self, run: RunInfo):
        self.warehouse = run.warehouse

    @hookimpl
    def on_event(self, event: Event):
        self.low |= any(robot.low for robot in self.warehouse.robots)
        if any(station.open_requests for station in self.warehouse.stations):
            self.beside_picking.append(event)


@pytest.mark.parametrize("stock", ["", ", finite stock"])
def test_robots_charge_and_pods_are_moved_while_orders_are_picked(stock: str) -> None:
    charging, moving = Idleness(), Idleness()
    run_trial(WORLDS[f"batteries{stock}"], WatchedRule(charging, {}), (Role.OBSERVER,))
    run_trial(WORLDS[f"moved pods{stock}"], WatchedRule(moving, {}), (Role.OBSERVER,))
    assert charging.low
    assert any(isinstance(event, RobotRested) for event in charging.beside_picking)
    assert sum(isinstance(event, PodMoveDecided) for event in moving.beside_picking) >= 3


def test_small_worlds_are_as_named() -> None:
    assert len(WORLDS["one station"].layout.stations) == 1
    assert len(WORLDS["several stations"].layout.stations) == 3
    assert WORLDS["a single robot"].scenario.robots.count == 1
    assert WORLDS["order capacity"].scenario.stations.order_capacity == (2, 1)
    assert WORLDS["no order"].instance.orders == ()
    wide, narrow = (len(small_layout(block_columns=columns).storage_locations) for columns in (4, 2))
    assert wide == 2 * narrow
    layout = small_layout(2, block_columns=3)
    world = small_world({"1": {"a": 9}}, {"p": ["a"]}, capacities=(1, 1), counts_orders=True, layout=layout)
    assert world.travel.layout is layout
    assert all(station.counts_orders for station in world.stations)
    assert world.size_at(world.orders[0], world.stations[0]) == 1
    assert {int(layout.kind[pod.cell]) for pod in world.pods} == {CellKind.STORAGE}


def test_instances_are_written_down_by_names() -> None:
    given = small_instance({"1": ["b", "c"], "2": {"a": 3}}, {"p": ["a", "b"], "q": {"a": 2}}, arrivals_s={"2": 1.5})
    assert given.skus == ("a", "b", "c")
    assert [(order.name, order.arrival_tick, order.lines) for order in given.orders] == [
        ("1", 0, ((1, 1), (2, 1))),
        ("2", 1500, ((0, 3),)),
    ]
    assert [(pod.name, pod.contents) for pod in given.pods] == [("p", ((0, None), (1, None))), ("q", ((0, 2),))]
    assert not given.unlimited_stock
    due = ({"1": ["a"], "2": ["a"]}, {"p": ["a"]})
    assert [order.due_tick for order in small_instance(*due, due_s={"2": 1.5}).orders] == [None, 1500]
    assert [order.due_s for order in small_world(*due, due_s={"2": 1.5}).orders] == [None, 1.5]


@pytest.mark.parametrize("stations", [1, 2, 4])
@pytest.mark.parametrize(("queue_length", "drawn"), [(1, 3), (3, 3), (4, 6)])
def test_a_layout_has_the_stations_asked_for(stations: int, queue_length: int, drawn: int) -> None:
    """On its east side, each with a queue as long as asked for, or longer: queues go up and down rows of blocks."""
    layout = small_layout(stations, queue_length=queue_length)
    assert [len(cells.queue) for cells in layout.stations] == [drawn] * stations
    middle = layout.width // 2
    assert all(cells.station % layout.width > middle for cells in layout.stations)
    assert len(layout.storage_locations) >= 8
    assert layout is small_layout(stations, queue_length=queue_length)


def test_a_world_begins_with_everything_waiting() -> None:
    world = small_world({"1": ["a"], "2": ["b"]}, {"p": ["a"], "q": ["b"]}, capacities=(4, 9), robots=3)
    locations = world.travel.layout.storage_locations
    assert world.now == 0
    assert [order.name for order in world.backlog.orders] == ["1", "2"]
    assert [pod.location for pod in world.pods] == list(locations[:2])
    assert [(robot.cell, robot.heading, robot.idle) for robot in world.robots] == [
        (locations[-1 - i], NORTH, True) for i in range(3)
    ]
    assert [(station.capacity, station.counts_orders) for station in world.stations] == [(4, False), (9, False)]
    assert [station.queue_room for station in world.stations] == [3 + 1, 3 + 1]


def world() -> Warehouse:
    built = small_world({"1": ["a"], "2": ["b"]}, {"p": {"a": 2}, "q": {"b": 3}}, capacities=(4, 4))
    built.assign(built.orders[0], built.stations[0], [0])
    return built


@cases(
    "change named",
    (lambda built: built.advance(built.now + 1), "of the warehouse"),
    (lambda built: built.bind(built.pods[0], built.stations[0]), "of the warehouse"),
    (lambda built: built.assign(built.orders[1], built.stations[1], [1]), "backlog of the warehouse"),
    (lambda built: built.send(built.robots[0], built.robots[1].cell), "of the warehouse"),
    (lambda built: object.__setattr__(built.pods[1], "name", "r"), "name of pod r"),
)
def test_whatever_changes_is_named(change: Callable[[Warehouse], None], named: str) -> None:
    built = world()
    view = WarehouseView(built)
    before = Snapshot.of(view)
    change(built)
    assert named in before.first_change(Snapshot.of(view))


def test_watching_changes_nothing_and_sees_reservations() -> None:
    built = world()
    view = WarehouseView(built)
    before = Snapshot.of(view)
    assert view.backlog_lines.quantity.tolist() == [1]
    assert view.pods_with(0)
    assert view.travel.times_to(view.stations[0].cell, True).min() == 0
    assert before.first_change(Snapshot.of(view)) is None
    built = world()
    view = WarehouseView(built)
    roads = Roads(built.travel)
    traffic = Traffic(roads, Reservations(roads.cells), Query(0, 0, 0, 0, 5))
    before = Snapshot.of(view, traffic)
    assert before.first_change(Snapshot.of(view, traffic)) is None
    hold_until(traffic.table, 1, 3, 0, 500)
    assert before.first_change(Snapshot.of(view, traffic)) == "the reservations"


def test_items_are_told_apart_from_those_that_are_free() -> None:
    built = world()
    view = WarehouseView(built)
    (pod, _), station = built.pods, built.stations[0]
    before = Snapshot.of(view)
    built.place_at_station(built.robots[0], pod, station)
    promised = Snapshot.of(view)
    request = next_request(station, pod)
    built.promises.secure(request, pod)
    built.fulfil(request, pod)
    picked = Snapshot.of(view)
    assert [note.stock[pod] for note in (before, promised, picked)] == [((0, 2, 2),), ((0, 2, 1),), ((0, 1, 1),)]
    assert before.first_change(promised) is not None
    assert promised.first_change(picked) is not None
