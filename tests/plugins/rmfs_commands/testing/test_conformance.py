"""`check_rule`: what it demands of a rule, what it says of one that fails, and rules that need something."""

import fractions
import gc
import itertools
import json
import random
from collections.abc import Callable
from typing import Any, ClassVar

import pytest
from attrs import define, field

import rmfs_core
from calling import refusal
from cases import cases
from rmfs_commands.testing import ConformanceError, check_rule, conformance_report, trial
from rmfs_core import (
    BundleAssignment,
    BundleDecision,
    InputError,
    JointDecision,
    Leg,
    OrderAssignment,
    Path,
    PodMove,
    RobotMove,
    hookimpl,
)
from rmfs_core.events import ItemPicked, PodLifted
from rmfs_core.rule_helpers import nearest_free_location, send_pods, store_bundles
from rmfs_core.warehouse import Order, WarehouseView
from rmfs_rules.idle import ChargeWhenLow, RestMiddle, RestNearest, Stay

numbers = itertools.count()


def first_fitting(warehouse: WarehouseView, orders: tuple[Order, ...]) -> list[OrderAssignment]:
    for order, station in itertools.product(orders, warehouse.stations):
        if warehouse.fits(order, station):
            return [OrderAssignment(order.id, station.id)]
    return []


@define
class NoSuchStation:
    @hookimpl
    def assign_orders(self, warehouse):
        return [OrderAssignment(warehouse.backlog[0].id, len(warehouse.stations))]


@define
class WrongType:
    @hookimpl
    def plan_path(self, goal):
        return goal


@define
class BreakingObserver:
    """Fails at the first pick, or at what it measures, within a library."""

    measures: object = None

    @hookimpl
    def on_event(self, event):
        if self.measures is None and isinstance(event, ItemPicked):
            fractions.Fraction("a pick")

    @hookimpl
    def measured(self):
        return self.measures() if callable(self.measures) else self.measures


@define
class GlobalRandom:
    @hookimpl
    def choose_storage_location(self, warehouse):
        return random.choice(warehouse.free_storage_locations)


@define
class CountsOutside:
    @hookimpl
    def choose_storage_location(self, warehouse):
        return warehouse.free_storage_locations[next(numbers) % 7]


@define
class GoesThroughASet:
    """Takes orders as a set of their names has them: otherwise in every Python process."""

    @hookimpl
    def assign_orders(self, warehouse):
        by_name = {order.name: order for order in warehouse.backlog}
        return first_fitting(warehouse, tuple(by_name[name] for name in {*by_name}))


@define
class Remembers:
    asked: int = field(default=0, init=False)

    @hookimpl
    def choose_storage_location(self, warehouse):
        self.asked += 1
        return warehouse.free_storage_locations[self.asked % 7]


@define
class EmptiesPods:
    @hookimpl
    def choose_storage_location(self, warehouse, pod):
        (behind,) = gc.get_referents(pod.contents)
        behind.popitem()
        return nearest_free_location(warehouse, pod)


@define
class NamesRobots:
    warehouse: Any = field(default=None, init=False)

    @hookimpl
    def run_started(self, run):
        self.warehouse = run.warehouse

    @hookimpl
    def on_event(self, event):
        robot = self.warehouse.robots[0]
        object.__setattr__(robot, "name", f"{robot.name}!")


@define
class ReservesItself:
    reserves: ClassVar[str] = "full paths"

    @hookimpl
    def plan_path(self, goal, traffic):
        traffic.table.hold(traffic.query.robot, goal, traffic.query.start_tick)
        return Path([Leg(goal)])


@define
class NeverAssigns:
    @hookimpl
    def assign_orders(self):
        return []


@define
class ForgetsThree:
    @hookimpl
    def filter_backlog(self, orders):
        return [order for order in orders if order.name != "3"]


@define
class FirstStationOnly:
    @hookimpl
    def assign_orders(self, warehouse):
        return [
            OrderAssignment(order.id, 0) for order in warehouse.backlog if warehouse.fits(order, warehouse.stations[0])
        ][:1]


@define
class WaitsAndWaits:
    wait_ticks: int

    @hookimpl
    def plan_path(self, robot):
        return Path([Leg(robot.cell, self.wait_ticks)])


def rename(warehouse: WarehouseView) -> None:
    object.__setattr__(warehouse.robots[0], "name", "1!")


@define
class Waker:
    """Lets every order through, and wants to wake up all the while."""

    wakes: Callable[[Any], object]

    @hookimpl
    def filter_backlog(self, orders):
        return orders

    @hookimpl
    def wake_at(self, warehouse):
        return self.wakes(warehouse)


@define
class Assumes:
    """Decides nothing, but fails where something is not as it takes for granted."""

    wrong: Callable[[Any], bool]

    @hookimpl
    def filter_backlog(self, warehouse, orders):
        assert not self.wrong(warehouse)
        return orders


@define
class Finishes:
    @hookimpl
    def run_ended(self, status):
        assert status == "complete"


ONE, FINITE, LARGE = "one station", "finite stock", "an order as large as the largest station"
TURNS = "stations that take turns"


@cases(
    "rule kind world problem",
    (Waker(lambda warehouse: warehouse.now_s), "impossible decision", ONE, "wake_at, at 0.000 s: wants to wake at 0.0"),
    (Waker(lambda warehouse: warehouse.wakes), "exception", ONE, "wake_at, at 0.000 s: raised AttributeError"),
    (Waker(lambda warehouse: warehouse.now_s + 1e-6), "starved order", ONE, "decisions the run is not over"),
    (Waker(rename), "mutation of the view", ONE, "wake_at changed name of robot 1! (id 0) at 0.000 s"),
    (NoSuchStation(), "impossible decision", ONE, "named station 1, which does not exist"),
    (WrongType(), "impossible decision", ONE, "expected Path"),
    (BreakingObserver(), "exception", ONE, f"Invalid literal for Fraction: 'a pick' ({__file__}, line 68)."),
    (BreakingObserver(json.JSONDecoder), "impossible decision", ONE, "measured, at "),
    (BreakingObserver(lambda: json.loads("{")), "exception", ONE, f"({__file__}, line "),
    (GlobalRandom(), "nondeterminism", ONE, "RobotMoved"),
    (CountsOutside(), "nondeterminism", FINITE, "RobotMoved"),
    (GoesThroughASet(), "nondeterminism", ONE, "OrderAssigned"),
    (Remembers(), "state kept", FINITE, "RobotMoved"),
    (EmptiesPods(), "mutation of the view", ONE, "choose_storage_location changed contents of pod "),
    (NamesRobots(), "mutation of the view", ONE, "on_event changed name of robot 1! (id 0) at 0.000 s"),
    (ReservesItself(), "mutation of the view", ONE, "plan_path changed the reservations at 0.000 s"),
    (NeverAssigns(), "starved order", ONE, "stands still"),
    (ForgetsThree(), "starved order", ONE, "stands still"),
    (FirstStationOnly(), "starved order", LARGE, "stands still"),
    (Assumes(lambda now: any(o.due_s for o in now.backlog)), "exception", "due times and priorities", "Assertion"),
    (Assumes(lambda now: any(o.priority > 1 for o in now.backlog)), "exception", "due times and priorities", "Asse"),
    (Assumes(lambda now: not now.stations[-1].open and len(now.stations) == 3), "exception", TURNS, "AssertionError"),
    (Finishes(), "exception", "a horizon", "AssertionError"),
    (WaitsAndWaits(1), "starved order", ONE, "after 100 decisions the run is not over"),
    (WaitsAndWaits(60_000), "starved order", ONE, "are not complete after 14400 s"),
    ids=lambda value: "" if isinstance(value, str) else type(value).__name__,
)
def test_what_a_rule_does_wrong_is_named(rule, kind, world, problem, monkeypatch) -> None:
    if rule == WaitsAndWaits(1) or "not over" in problem:
        monkeypatch.setattr(trial, "MOST_CALLS", 100)  # the default is patient
    with pytest.raises(ConformanceError) as caught:
        check_rule(rule)
    finding = caught.value.report.findings[0]
    assert (finding.kind, finding.world) == (kind, world)
    assert problem in finding.problem
    assert f'{kind}, in the world "{world}"' in str(caught.value)


def test_a_failure_is_an_assertion_error() -> None:
    with pytest.raises(AssertionError, match="NeverAssigns does not conform"):
        check_rule(NeverAssigns())
    rule = Watches()
    check_rule(rule)
    assert rule.seen == []


@define
class OldestThatFits:
    @hookimpl
    def assign_orders(self, warehouse):
        return first_fitting(warehouse, warehouse.backlog)


@define
class AnyPod:
    @hookimpl
    def select_pods(self, warehouse, max_fetches):
        return send_pods(warehouse, max_fetches, lambda station, pods, wanted: pods[0])


@define
class AnyPlace:
    """PR with randomness that the seed reaches, and a memory that ends with the run."""

    asked: int = field(default=0, init=False)

    @hookimpl
    def run_started(self):
        self.asked = 0

    @hookimpl
    def choose_storage_location(self, warehouse, rng):
        self.asked += 1
        free = warehouse.free_storage_locations
        return free[(self.asked + int(rng.integers(9))) % len(free)]


@define
class Watches:
    seen: list[object] = field(factory=list, init=False)

    @hookimpl
    def on_event(self, event):
        self.seen.append(event)


@pytest.mark.parametrize("rule", [OldestThatFits(), AnyPod(), AnyPlace(), Watches()], ids=lambda r: type(r).__name__)
def test_rules_that_do_nothing_wrong_have_no_findings(rule: object) -> None:
    report = check_rule(rule)
    assert report.findings == ()
    assert len(report.worlds) == 37
    assert all(
        times.calls >= len(report.worlds) and 0 < times.total_s / times.calls <= times.longest_s
        for times in report.times.values()
    )
    assert str(report).endswith("No findings.")


@define
class NeedsEndlessPods(AnyPod):
    needs: ClassVar[tuple[str, ...]] = ("unlimited stock", "item capacity")


def test_where_rules_are_tried() -> None:
    report = check_rule(NeedsEndlessPods())
    lacking = {"order capacity", "replenishment at picking stations", "replenishment stations"}
    assert {name for name in report.left_out if "finite stock" not in name} == lacking
    assert (len(report.left_out), len(report.worlds)) == (19, 18)
    assert 'Left out: "finite stock", for it needs pods whose SKUs never run out' in str(report)
    report = conformance_report(Both())
    assert report.decides == ("POA", "POA+PPS")
    assert {finding.kind for finding in report.findings} == {"starved order"}
    assert {*report.times} == {"assign_orders", "assign_orders_and_pods"}
    report = check_rule(OldestBundles())
    assert report.decides == ("POA", "ROA", "ROA+RPS")
    assert {*report.times} == {"assign_orders", "assign_bundles", "assign_bundles_and_pods"}
    found = conformance_report(OldestBundles(together=False)).findings
    worlds = {"replenishment at picking stations", "replenishment stations"}
    assert {(finding.kind, finding.world) for finding in found} == {("starved order", world) for world in worlds}
    found = conformance_report(NeverCharges()).findings
    worlds = {"batteries", "batteries, finite stock"}
    assert {(finding.kind, finding.world) for finding in found} == {("starved order", world) for world in worlds}
    for finding in found:
        assert "3 robots with too little charge for a task" in finding.problem
        assert finding.problem.endswith('by needs = ("no batteries",))')
    for rule in (Stay(), RestNearest(), RestMiddle()):
        assert {*check_rule(rule).left_out} == {"batteries", "batteries, finite stock"}
    assert not check_rule(ChargeWhenLow()).left_out
    assert {finding.kind for finding in conformance_report(MovesWhatIsInUse()).findings} == {"impossible decision"}
    found = conformance_report(KeepsBooks()).findings
    assert {(finding.kind, finding.world.split(",")[0]) for finding in found} == {("impossible decision", "moved pods")}
    finding = conformance_report(EmptiesBundles()).findings[0]
    assert (finding.kind, finding.world) == ("mutation of the view", "replenishment at picking stations")
    assert finding.problem.startswith("assign_bundles changed items of bundle ")


@define
class Both(OldestThatFits):
    """Decides POA well, and POA and PPS together never."""

    @hookimpl
    def assign_orders_and_pods(self):
        return JointDecision()


@define
class OldestBundles(OldestThatFits):
    """POA and ROA without a fault, and ROA and RPS together."""

    together: bool = True

    @hookimpl
    def assign_bundles(self, warehouse):
        free = [station.id for station in warehouse.replenishment_stations if station.free_bundle_capacity]
        return [BundleAssignment(warehouse.bundles[0].id, free[0])]

    @hookimpl
    def assign_bundles_and_pods(self, warehouse, max_fetches):
        stores = store_bundles(warehouse, max_fetches, lambda pods, bundle: -pods.room)
        free = any(station.free_bundle_capacity for station in warehouse.replenishment_stations)
        waiting = warehouse.bundles and free and self.together
        return BundleDecision(self.assign_bundles(warehouse) if waiting else [], stores)


@define
class NeverCharges:
    often: float = 0.0

    @hookimpl
    def idle_robots(self, warehouse, rng):
        chargers = [cell for cell in warehouse.free_rest_cells if cell in warehouse.travel.layout.chargers]
        low = [robot for robot in warehouse.resting_robots if robot.low and robot.cell not in chargers]
        sent = zip(low, chargers, strict=False) if rng.random() < self.often else ()
        return [RobotMove(robot.id, cell, 0.9) for robot, cell in sent]


@define
class MovesWhatIsInUse:
    @hookimpl
    def move_pods(self, warehouse):
        used = [pod for pod in warehouse.pods if pod.location is not None and pod.bound_for]
        return [PodMove(pod.id, warehouse.free_storage_locations[0]) for pod in used[:1]]


@define
class KeepsBooks:
    """PR that takes it for granted that only pods on their way from stations are stored."""

    free: set[int] = field(factory=set, init=False)

    @hookimpl
    def run_started(self, run):
        self.free = {*run.warehouse.free_storage_locations}

    @hookimpl
    def on_event(self, event):
        if isinstance(event, PodLifted):
            self.free.add(event.cell)

    @hookimpl
    def choose_storage_location(self):
        cell = min(self.free)
        self.free.remove(cell)
        return cell


@define
class EmptiesBundles:
    @hookimpl
    def assign_bundles(self, warehouse):
        bundle, station = warehouse.bundles[0], warehouse.replenishment_stations[0]
        object.__setattr__(bundle, "items", 0)
        return [BundleAssignment(bundle.id, station.id)]


@define
class Misspelt:
    @hookimpl
    def asign_orders(self, warehouse):
        return []


@define
class Idle:
    """Implements nothing."""


@define
class NeedsMagic(AnyPod):
    needs: ClassVar[tuple[str, ...]] = ("magic",)


@cases(
    "rule problem",
    (Misspelt(), "did you mean `assign_orders`"),
    (Idle(), "class Idle: it implements no hook"),
    (NeedsMagic(), r"class NeedsMagic: .*needs = \('magic',\); expected a tuple of 'unlimited stock', 'item"),
    (object(), "expected a class decorated with @attrs.define"),
    (AnyPod, r"class AnyPod: expected an instance with its parameters: AnyPod\(...\)"),
    ids=lambda value: type(value).__name__,
)
def test_what_is_no_rule_is_refused(rule: object, problem: str) -> None:
    with pytest.raises(InputError, match=problem):
        check_rule(rule)


def test_kinds_are_reported_once() -> None:
    text = str(conformance_report(NeverAssigns()))
    assert text.count("starved order, in the world") == 1
    assert '(also in "several stations", "finite stock"' in text


RULE = """
from rmfs_core.rule_helpers import send_pods
@define
class Eager:
    needs = ({need!r},)
    @hookimpl
    def select_pods(self, warehouse, max_fetches):
        return send_pods(warehouse, max_fetches, lambda station, pods, wanted: pods[0])
@define
class Keeps:
    needs = ({need!r},)
    @hookimpl
    def filter_backlog(self, orders): return orders
"""


@cases(
    "need key sentence",
    ("unlimited stock", "instance.items_per_sku=500", "needs pods whose SKUs never run out, but the instance has"),
    ("item capacity", "stations.order_capacity=6", "needs stations that count items, but the scenario sets"),
)
def test_a_scenario_that_lacks_it_is_refused(install: Callable[..., None], need: str, key: str, sentence: str) -> None:
    install("acme", {"eager": "acme_rules:Eager", "keeps": "acme_rules:Keeps"}, acme_rules=RULE.format(need=need))
    for choice in ("rules.pps=eager", 'rules.filters=["keeps"]'):
        name = choice.partition("=")[2].strip('[]"')
        with pytest.raises(InputError) as caught:
            rmfs_core.run("examples/small", overrides=[choice, key])
        assert str(caught.value).startswith(f'--set {choice}: rule "{name}" (acme 1.0)')
        assert sentence in str(caught.value)


@pytest.mark.parametrize("rule", ["stay", "rest-nearest", "rest-middle"])
def test_rules_that_send_nobody_to_chargers_are_refused_with_batteries(rule: str) -> None:
    with pytest.raises(
        InputError, match=f'^--set rules.idle={rule}: rule "{rule}" .* needs robots without batteries, as it sends'
    ):
        rmfs_core.run("examples/charging", overrides=[f"rules.idle={rule}"])


@cases(
    "trait sentence",
    (
        "needs = ('magic',)",
        "has needs = ('magic',); expected a tuple of 'unlimited stock', 'item capacity' or 'no batteries'",
    ),
    ("needs = 'unlimited stock'", "has needs = 'unlimited stock'; expected a tuple of 'unlimited stock', 'item"),
    ("libraries = ('numpy', 3)", "has libraries = ('numpy', 3); expected a tuple of installed distributions' names"),
    ("splits_over_time = 1", "has splits_over_time = 1; expected True or False"),
    ("packing_capacity = -1", "has packing_capacity = -1; expected a whole number >= 0, or None"),
    ("reserves = 'all'", "has reserves = 'all'; expected 'fleet', 'full paths', 'windows' or None"),
    ("prepare = 'fast'", "has prepare = 'fast'; expected a method"),
)
def test_a_trait_of_the_wrong_type_is_refused(install: Callable[..., None], trait: str, sentence: str) -> None:
    rule = f"@define\nclass Odd:\n    {trait}\n    @hookimpl\n    def select_pods(self):\n        return []\n"
    install("acme", {"odd": "acme_rules:Odd"}, acme_rules=rule)
    assert refusal(lambda: rmfs_core.run("examples/small", overrides=["rules.pps=odd"])).startswith(
        f'--set rules.pps=odd: rule "odd" (acme 1.0) {sentence}'
    )
