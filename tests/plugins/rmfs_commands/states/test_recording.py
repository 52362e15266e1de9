"""A run's decisions: recorded, read again, and decided again."""

import json
from collections import Counter
from collections.abc import Callable, Mapping
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest

import rmfs_core
from calling import refusal
from cases import cases
from rmfs_commands.cli.single_rule import load_rule
from rmfs_commands.results.files import to_json
from rmfs_commands.states import Recording, decide, read_recording, state_from_dict, state_to_dict
from rmfs_commands.states.deciding import ask, outcome_of
from rmfs_commands.states.patches import patched
from rmfs_commands.states.plain import Memento
from rmfs_commands.states.rebuilding import open_state
from rmfs_commands.states.recording import RECORDING_FILE
from rmfs_commands.states.snapshots import Snapshots
from rmfs_commands.testing import small_instance, small_layout, small_world
from rmfs_core import InputError, RuleError, hookimpl
from rmfs_core.events import OrderArrived, OrderAssigned, PodLifted, PodStored, TripDecided
from rmfs_core.info import Question, RunInfo
from rmfs_core.motion import Motion
from rmfs_core.roles import Role
from rmfs_core.rules import BoundRule
from rmfs_core.scenario import RuleChoice
from rmfs_core.scenario.model import RulesSection, Scenario
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_core.warehouse.parts import Part, ReadOnly
from rmfs_core.world import NORTH

SETTINGS = ("instance.orders=6", "rules.pp=free-flow")
RULES = """
@define
class Late:
    "POA: first come, until five orders are left."
    @hookimpl
    def assign_orders(self, warehouse):
        if len(warehouse.backlog) <= 5:
            return [OrderAssignment(99, 0)]
        return [OrderAssignment(warehouse.backlog[0].id, 0)]

@define
class Raising:
    "POA: raises."
    @hookimpl
    def assign_orders(self, warehouse): raise ZeroDivisionError("nothing to divide")
"""


def test_decisions_are_all_there(tmp_path: Path) -> None:
    files = ("orders.csv", "visits.csv")
    plain = rmfs_core.run("examples/small", overrides=SETTINGS, out=tmp_path / "plain")
    for name in ("one", "two"):
        result = rmfs_core.run("examples/small", overrides=SETTINGS, out=tmp_path / name, record=["decisions"])
        assert result.metrics == plain.metrics
    for file in files:
        assert (tmp_path / "plain" / file).read_bytes() == (tmp_path / "one" / file).read_bytes()
    assert (tmp_path / "one" / RECORDING_FILE).read_bytes() == (tmp_path / "two" / RECORDING_FILE).read_bytes()
    assert not (tmp_path / "plain" / RECORDING_FILE).exists()
    result = rmfs_core.run("examples/small", overrides=SETTINGS, out=tmp_path, record=["decisions"])
    recorded = [r for r in read_recording(tmp_path) if r.decides in (Role.POA, Role.PPS)]
    assert [(r.period, r.time_s, r.decides.label, r.rule) for r in recorded] == [
        (row["period"], row["time_s"], row["decides"], row["rule"]) for row in result.periods
    ]
    for decision, row in zip(recorded, result.periods, strict=True):
        assert len(decision.decision.get("assignments", ())) == row["assignments"]
        assert len(decision.decision.get("trips", ())) == row["trips"]


def test_recordings_and_folders(tmp_path: Path) -> None:
    rmfs_core.run("examples/small", overrides=SETTINGS, out=tmp_path, record=["decisions"])
    rmfs_core.run("examples/small", overrides=SETTINGS, out=tmp_path)
    with pytest.raises(InputError, match="run the scenario with `--record-decisions`"):
        read_recording(tmp_path)
    with pytest.raises(InputError, match=r"decisions: .* expected `out`"):
        rmfs_core.run("examples/small", record=["decisions"])


@pytest.mark.parametrize(("rule", "problem"), [("late", "named order 99"), ("raising", "nothing to divide")])
def test_what_a_failing_rule_saw_is_kept(tmp_path: Path, install: Any, rule: str, problem: str) -> None:
    install(
        "acme",
        {"late": "acme_rules:Late", "raising": "acme_rules:Raising"},
        acme_rules=f"from rmfs_core import OrderAssignment\n{RULES}",
    )
    with pytest.raises(RuleError, match=problem):
        rmfs_core.run("examples/small", overrides=[*SETTINGS, f"rules.poa={rule}"], out=tmp_path, record=["decisions"])
    *_, last = read_recording(tmp_path)
    assert (last.decides, last.decision) == (Role.POA, None)
    with pytest.raises(RuleError, match=problem):
        decide(last.state(), RuleChoice(rule))


def test_a_rule_that_the_scenario_does_not_name(record: Any, damaged: Callable[..., Path]) -> None:
    first = next(iter(record()))
    assert record().choice_of(first).rule == first.rule == "pod-match"
    other = read_recording(damaged(lambda lines: [lines[0], lines[1] | {"decides": "POA+PPS"}, *lines[2:]]))
    with pytest.raises(InputError, match=r"has no rule for POA\+PPS"):
        other.choice_of(next(iter(other)))


def test_what_is_in_hand_is_recorded(record: Any) -> None:
    states = [recorded.state() for recorded in record("stations.release=handled", "instance.orders=6")]
    held = [(state, name) for state in states for name, station in state.stations.items() if station.in_hand]
    assert {state.version for state, _ in held} == {2}
    assert {state.version for state in states if not any(s.in_hand for s in state.stations.values())} == {1}
    for state, name in held:
        opened = open_state(state)
        station = opened.warehouse.stations[list(state.stations).index(name)]
        in_hand = state.stations[name].in_hand
        assert opened.warehouse.orders[opened.names.orders[in_hand.order]].has_place_at(station.id)


def test_due_times_are_recorded(record: Any) -> None:
    due = ("instance.due.allowance_s=600", "instance.due.priority_share=0.5", "instance.due.priority_allowance_s=60")
    plain, state = (next(iter(record(*settings))).state() for settings in ((), due))
    assert (plain.version, state.version, len(state.orders)) == (1, 2, 14)
    assert {(order.due_s, order.priority) for order in state.orders.values()} == {(600.0, 0), (60.0, 1)}


def test_recordings_are_gone_through_in_order(record: Callable[..., Recording]) -> None:
    recording = record()
    found = list(recording)
    assert [one.number for one in found] == list(range(1, len(found) + 1))
    assert [one.time_s for one in found] == sorted(one.time_s for one in found)
    assert [one.period for one in found] == sorted(one.period for one in found)
    assert {one.decides.label for one in found} >= {"POA", "PPS", "PR", "TA"}
    assert [one.content for one in recording] == [one.content for one in found]
    assert found[2].place == f"{recording.file}, line 4"
    assert found[0].state().time_s == found[0].time_s
    recording = record()
    assert next(iter(read_recording(recording.file))).content == next(iter(recording)).content


@cases(
    "change problem",
    (lambda header: header | {"format": "other"}, "line 1, format: expected 'rmfs-decisions', found 'other'"),
    (lambda header: header | {"version": 99}, "version: expected version 1 of 'rmfs-decisions', found 99"),
    (lambda header: {key: value for key, value in header.items() if key != "state"}, "lacks `scenario` or `state`"),
    (lambda header: header | {"scenario": 5}, "lacks `scenario` or `state`"),
    (lambda header: header | {"scenario": {"rules": {}}}, "line 1, scenario"),
)
def test_a_header_that_is_none_is_refused(damaged, change, problem) -> None:
    assert problem in refusal(lambda: read_recording(damaged(lambda lines: [change(lines[0]), *lines[1:]])))


@cases(
    "change problem",
    (lambda line: line | {"decides": "lunch"}, "no role is called 'lunch'"),
    (lambda line: line | {"decides": "PP"}, "found PP of period 1"),
    (
        lambda line: {key: value for key, value in line.items() if key != "rule"},
        "this is no recorded decision: it lacks rule",
    ),
    (lambda line: line | {"change": 5}, "change: expected a JSON object, found 5"),
    (lambda line: line | {"decision": "POA"}, "decision: expected a JSON object, found 'POA'"),
    (lambda line: line | {"rule": ["demand"]}, "line 4, rule: expected a rule's name, found ['demand']"),
    (lambda line: line | {"report": [1]}, "report: expected a JSON object, found [1]"),
    (lambda line: 5, "expected a JSON object, found int"),
)
def test_a_line_that_is_no_decision_is_named(damaged, change, problem) -> None:
    recording = read_recording(damaged(lambda lines: [*lines[:3], change(lines[3]), *lines[4:]]))
    found = iter(recording)
    assert [next(found).number, next(found).number] == [1, 2]
    with pytest.raises(InputError) as caught:
        next(found)
    assert "line 4" in str(caught.value)
    assert problem in str(caught.value)


ORDERS = {"A": ["milk", "tea"], "B": {"jam": 2}}
PODS = {"P1": {"milk": 3, "tea": 1}, "P2": ["jam"]}
POA, PPS = ({"ask": {"decides": decides, "period": 1}} for decides in ("POA", "PPS"))


class Run:
    """A run that the tests drive by hand: the warehouse, and what is known of it after each look."""

    def __init__(self, *, counts_orders: bool = False) -> None:
        self.world: Warehouse = small_world(ORDERS, PODS, capacities=(4, 4), counts_orders=counts_orders)
        scenario = Scenario(rules=RulesSection(poa=RuleChoice("first-come"), pps=RuleChoice("demand")), seed=7)
        instance, layout = small_instance(ORDERS, PODS), small_layout(2)
        self.snapshots = Snapshots(RunInfo(scenario, instance, layout, Motion(), WarehouseView(self.world)))
        self.known: dict[str, Any] = deepcopy(self.snapshots.state)

    def look(self, call: dict[str, Any]) -> dict[str, Any]:
        patch = deepcopy(self.snapshots.look(call))
        self.known = patched(self.known, patch)
        assert self.known == self.snapshots.state
        return patch

    def orders_arrive(self) -> None:
        for order in self.world.orders:
            self.snapshots.told(OrderArrived(0, order.id))

    def assign(self, order: int, station: int, *skus: int) -> None:
        items = self.world.assign(self.world.orders[order], self.world.stations[station], list(skus))
        self.snapshots.told(OrderAssigned(0, order, station, skus, items, 1, complete=False))

    def bind(self, pod: int, station: int) -> None:
        self.world.bind(self.world.pods[pod], self.world.stations[station])
        self.snapshots.told(TripDecided(0, pod, station))


@pytest.fixture
def run() -> Run:
    return Run()


def test_orders_come_with_the_events_that_tell_of_them(run: Run) -> None:
    assert "orders" not in run.look(POA)
    run.orders_arrive()
    milk_and_tea = {"lines": {"milk": 1, "tea": 1}, "arrival_s": 0, "parts": []}
    assert run.look(POA)["orders"] == {"A": milk_and_tea, "B": {"lines": {"jam": 2}, "arrival_s": 0, "parts": []}}
    run.assign(0, 1, 1)
    assert run.look(POA)["orders"] == {"A": {"parts": [{"station": "2", "skus": ["tea"], "period": 1}]}}
    assert "orders" not in run.look(POA)


def test_a_pod_that_is_fetched_and_stored_elsewhere(run: Run) -> None:
    world = run.world
    pod, robot, before = world.pods[0], world.robots[0], world.pods[0].cell
    run.bind(0, 0)
    run.bind(0, 1)
    assert run.look(PPS)["pods"] == {"P1": {"bound_for": ["1", "2"]}}
    world.take_task(robot, pod)
    world.lift(robot, pod)
    run.snapshots.told(PodLifted(0, 0, robot.id, pod.id, before))
    world.reserve(place := world.free_locations[0])
    patch = run.look(PPS)
    assert (patch["pods"], patch["robots"]) == ({"P1": {"cell": None}}, {"1": {"task": "P1"}})
    assert (patch["waiting"], patch["reserved"]) == ([], [place])
    world.move(robot, place, NORTH)
    world.store(robot, pod)
    run.snapshots.told(PodStored(0, 0, robot.id, pod.id, place))
    patch = run.look(PPS)
    assert patch["pods"] == {"P1": {"cell": place}}
    assert patch["robots"] == {"1": {"cell": place, "task": None}}
    assert (patch["waiting"], patch["reserved"]) == (["P1"], [])


def test_what_belongs_to_one_call_is_gone_at_the_next(run: Run) -> None:
    assert run.look({**POA, "backlog": ["B"], "random": {"state": "1"}}) == {
        **POA,
        "backlog": ["B"],
        "random": {"state": "1"},
    }
    assert run.look({**PPS, "random": {"state": "2"}}) == {
        "ask": {"decides": "PPS"},
        "random": {"state": "2"},
        "backlog": None,
    }
    assert run.look(PPS) == {"random": None}


JOINT = ("rules.poa=", "rules.pps=")
REPLENISHED = (
    'instance.replenishment={process="reorder-point", reorder_point=12, order_up_to=20, bundle_items=5, lead_s=5}',
    "instance.orders=18",
    "instance.items_per_sku=3",
    "instance.pod_capacity=25",
    "layout.replenishment_west=2",
    "rules.roa=first-bundle",
    "rules.rps=correlated",
)
AT_PICKING = ("layout.replenishment_west=", "stations.also_replenish=true", "rules.roa=", "rules.rps=")
RULE_SETS = {
    "sequential": ("rules.pr=random",),
    "common-lines and nearest-pod": ("rules.poa=common-lines", "rules.pps=nearest-pod", "rules.pr=fixed"),
    "first-come, finite stock": ("rules.poa=first-come", "instance.items_per_sku=20"),
    "a prefilter": ('rules.filters=[{rule="most-covered",n=3}]',),
    "order capacity, arrivals": (
        "stations.order_capacity=2",
        "instance.arrivals.process=poisson",
        "instance.arrivals.orders_per_hour=200",
    ),
    "integrated": (*JOINT, "rules.poa_pps=integrated"),
    "split-among-stations": (*JOINT, "rules.poa_pps=split-among-stations"),
    "split-over-time": (*JOINT, "rules.poa_pps=split-over-time", "rules.pr=random"),
    "order capacity, split-over-time": (*JOINT, "rules.poa_pps=split-over-time", "stations.order_capacity=2"),
    "places that are kept until items are handled": ("stations.release=handled", "stations.order_capacity=2"),
    "a backlog that is refilled": ('instance.arrivals={process="refill", backlog=4}', "stations.release=handled"),
    "orders larger than any station": ("stations.item_capacity=3",),
    "orders larger than any station, integrated": (*JOINT, "rules.poa_pps=integrated", "stations.item_capacity=3"),
    "robots that rest": (
        "rules.idle=rest-middle",
        "instance.arrivals.process=poisson",
        "instance.arrivals.orders_per_hour=200",
    ),
    "robots that charge": (
        "rules.idle=charge-when-low",
        "layout.chargers=1",
        "robots.battery={capacity_wh=55, loaded_w=900, charging_w=20000, detour=1.2}",
    ),
    "replenishment": (*REPLENISHED, "rules.roa=same-pod", "rules.rps=random"),
    "replenishment at picking stations": (*REPLENISHED, *AT_PICKING, "rules.roa_rps=pod-first"),
    "packing capacity": (*JOINT, 'rules.poa_pps={rule="split-over-time",packing_capacity=2}'),
}


@pytest.mark.parametrize("settings", RULE_SETS.values(), ids=RULE_SETS)
def test_every_decision_of_a_run_is_made_again(record: Any, settings: tuple[str, ...]) -> None:
    recording = record(*settings)
    kinds: Counter[str] = Counter()
    rules: dict[str, BoundRule] = {}
    for recorded in recording:
        state = recorded.state()
        assert state_from_dict(json.loads(to_json(state_to_dict(state)))) == state
        if recorded.decides not in rules:
            rules[recorded.decides] = load_rule(recording.choice_of(recorded), (recorded.decides,))
        again = ask(open_state(recorded.state(), recorded.place), rules[recorded.decides])
        assert again.decision == recorded.decision, recorded.place
        assert again.report == recorded.report, recorded.place
        assert outcome_of(recorded.state(), recorded.decides, recorded.decision or {}) == again.outcome
        kinds[recorded.decides.label] += 1
    assert min(kinds.values()) >= 2
    decided = [role for role in (Role.ROA, Role.RPS, Role.ROA_RPS) if getattr(recording.scenario.rules, role.key)]
    assert kinds.keys() >= {"PR", "TA", *(role.label for role in decided)}


def test_drawn_numbers_come_back(record: Any) -> None:
    recording = record("rules.pr=random")
    drawn = [recorded for recorded in recording if recorded.decides is Role.PR and "random" in recorded.content]
    assert len(drawn) >= 5
    forgotten = 0
    for recorded in drawn:
        choice = recording.choice_of(recorded)
        assert decide(recorded.state(), choice).decision == recorded.decision
        fresh = state_from_dict({key: value for key, value in recorded.content.items() if key != "random"})
        forgotten += decide(fresh, choice).decision != recorded.decision
    assert forgotten


@cases(
    "settings",
    ("instance.items_per_sku=20", "stations.order_capacity=2"),
    ("rules.poa=", "rules.pps=", "rules.poa_pps=split-over-time", 'rules.filters=[{rule="most-covered",n=4}]'),
    ("stations.order_capacity=2", "rules.poa=", "rules.pps=", "rules.poa_pps=split-over-time"),
    ("rules.pp=free-flow", "stations.item_capacity=3"),
    ("rules.pp=sipp",),
    REPLENISHED,
    ("stations.release=handled", "stations.order_capacity=2"),
    ("stations.release=handled", "rules.poa=", "rules.pps=", "rules.poa_pps=split-over-time"),
    ('instance.arrivals={process="refill", backlog=4}', "stations.release=handled"),
    (
        'stations.open={1 = [["00:00", "00:02"]], 2 = [["00:01", "24:00"]]}',
        'robots.available=[["00:00", "00:03"], ["00:03", "24:00", 1]]',
        "rules.activate={rule='backlog-threshold', open_above=2, timeout_s=60}",
    ),
)
def test_rules_see_what_they_saw_in_the_run(tmp_path: Path, settings: tuple[str, ...]) -> None:
    """A state as JSON is the warehouse at each decision, to the last public value; so is its memento, restored."""
    seen: list[tuple[dict[Any, Any], Memento]] = []

    class Note:
        @hookimpl
        def run_started(self, run: RunInfo) -> None:
            self.skus = run.instance.skus

        @hookimpl
        def rule_asked(self, question: Question) -> None:
            if question.decides not in (Role.FILTER, Role.PP):
                seen.append((public_values(question.warehouse), Memento.of(question.warehouse, self.skus)))

    overrides = ["instance.orders=14", "instance.max_lines=5", "stations.item_capacity=6", *settings]
    rmfs_core.run("examples/small", overrides=overrides, out=tmp_path, record=["decisions"], observers=[Note()])
    for recorded, (values, memento) in zip(read_recording(tmp_path), seen, strict=True):
        opened = open_state(recorded.state())
        again = public_values(opened.view)
        assert Memento.of(opened.view, opened.instance.skus) == memento
        assert {key: value for key, value in again.items() if values[key] != value} == {}
        assert again.keys() == values.keys()
    assert len(seen) > 20


COLUMNS = {"backlog_lines", "capacities", "free_items", "lines", "stock", "version"}
"""Arrays made of the other values, which are compared by themselves; and a number that holds for one run."""


def public_values(view: WarehouseView) -> dict[Any, Any]:
    """Return what a view and everything in it show, by whose it is and what it is called."""
    parts: list[Any] = [view, *view.orders, *view.pods, *view.stations, *view.robots, *view.bundles]
    parts += [request for station in view.stations for request in station.open_requests]
    parts += [station for station in view.replenishment_stations if not station.picks]
    parts += [bundle for station in view.replenishment_stations for bundle in station.bundles]
    values: dict[Any, Any] = {}
    for part in parts:
        for name in dir(part):
            if not name.startswith("_") and name not in COLUMNS | {"label", "travel"}:
                value = getattr(part, name)
                if not callable(value):
                    values[plain(part), name] = plain(value)
    for pod in view.pods:
        values["free", pod.id] = [pod.free_items(sku) for sku in pod.contents]
        values["home", pod.id] = view.home(pod)
    lines, stock = view.backlog_lines, view.stock
    values["lines"] = [of.tolist() for of in (lines.order, lines.sku, lines.quantity)]
    values["stock"] = [of.tolist() for of in (*stock[:6], stock.at, stock.location, stock.space)]
    values["sums"] = [of.tolist() for of in (view.open_demand(), view.available(), view.ordered())]
    return values


def plain(value: Any) -> Any:
    """Return a value as one that can be compared across two warehouses."""
    if isinstance(value, Part):
        return ("part", value.order.id, value.station, value.period, value.items, value.unpicked_items)
    if isinstance(value, ReadOnly):
        return (type(value).__name__, getattr(value, "id", None))
    if isinstance(value, Mapping):
        return list(value.items())
    if isinstance(value, tuple) and not hasattr(value, "_fields"):
        return [plain(entry) for entry in value]
    return value
