"""Bundles, from their arrival to the pod, in small warehouses and in random ones, and where they come from."""

import tempfile
from collections import Counter
from itertools import islice
from pathlib import Path
from typing import Any

import pytest
from attrs import define, evolve
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import rmfs_core
from cases import cases
from replenished import prepared, replenished_world, scenario_of
from rmfs_commands.processes.supply import Supply
from rmfs_commands.testing import small_instance, validate_trace
from rmfs_core import BundleAssignment, BundleDecision, InputError, StandstillError, StoreBundle, hookimpl
from rmfs_core.events import (
    BundleArrived,
    BundleBound,
    BundleStored,
    Event,
    ItemPicked,
    OrderCompleted,
    TripDecided,
    VisitEnded,
    VisitStarted,
)
from rmfs_core.info import RunInfo
from rmfs_core.roles import Role
from rmfs_core.scenario import Scenario, scenario_from_dict
from rmfs_core.scenario.model import RuleChoice, RunSection
from rmfs_core.simulation.applying import apply_replenishment
from rmfs_core.simulation.asking import ImpossibleError
from rmfs_core.simulation.setup import open_warehouse
from rmfs_core.warehouse import Bundle, Warehouse, WarehouseView
from rmfs_core.warehouse.parts import OrderLine
from rmfs_core.world import BundleData, Instance, OrderData, PodData, make_instance, make_layout
from saying import said

FILE = {"process": "file", "file": "bundles.csv"}


def brought(instance: Instance, *bundles: tuple[float, int, int]) -> Instance:
    data = [
        BundleData(f"B{i}", arrival_tick=round(s * 1000), sku=sku, items=items)
        for i, (s, sku, items) in enumerate(bundles, 1)
    ]
    return evolve(instance, bundles=tuple(data))


def at_station(warehouse: Warehouse, sku: int, items: int) -> Bundle:
    bundle = warehouse.bundle_arrives(sku, items)
    warehouse.assign_bundle(bundle, warehouse.stations[1])
    return bundle


def test_stored_items_cover_requests_where_the_pod_is_bound_for() -> None:
    warehouse = replenished_world({"1": {"b": 1}}, {"p": {"a": 1}})
    pod, station = warehouse.pods[0], warehouse.stations[0]
    warehouse.assign(warehouse.orders[0], station, [1])
    warehouse.bind(pod, station)
    bundle = at_station(warehouse, 1, 4)
    warehouse.bind_bundle(bundle, pod)
    assert len(station.uncovered_requests) == 1
    warehouse.store_bundle(bundle, pod)
    assert station.open_requests[0].pod is pod
    assert pod.free_items(1) == 3


def waiting_and_assigned() -> Warehouse:
    warehouse = replenished_world({}, {"p": {"a": 3}, "q": {"b": 6}, "r": {"a": 1}}, pod_capacity=6)
    at_station(warehouse, 0, 2)
    at_station(warehouse, 1, 2)
    warehouse.bundle_arrives(0, 1)
    warehouse.bind(warehouse.pods[2], warehouse.stations[0])
    return warehouse


@cases(
    "role answer problem",
    (Role.ROA, [BundleAssignment(2, 1)], "(id 2) to station 2 (id 1), but all 2 units of capacity are used"),
    (Role.ROA, [BundleAssignment(2, 0)], "bundle 3 (id 2) to station 1 (id 0), but it stores none"),
    (Role.ROA, [BundleAssignment(0, 1)], "assigned bundle 0 to station 2 (id 1), but no such bundle waits"),
    (Role.ROA, [BundleAssignment(2, 5)], "named station 5, which does not exist"),
    (Role.ROA, [StoreBundle(0, 0)], "expected BundleAssignment only"),
    (Role.RPS, [StoreBundle(2, 0)], "no such bundle is at a station without a pod"),
    (Role.RPS, [StoreBundle(0, 0), StoreBundle(0, 2)], "no such bundle is at a station without a pod"),
    (Role.RPS, [StoreBundle(0, 1)], "which takes 2 of space; the pod has 0 left"),
    (Role.RPS, [StoreBundle(0, 0), StoreBundle(1, 0)], "which takes 2 of space; the pod has 1 left"),
    (Role.RPS, [StoreBundle(0, "p")], "named pod 'p'; expected a whole number"),
    (Role.ROA_RPS, [StoreBundle(0, 0)], "expected BundleDecision"),
)
def test_impossible_decisions_are_refused(role: Role, answer: Any, problem: str) -> None:
    given = {"role": role, "max_fetches": 9, "keep": lambda _: None}
    assert problem in said(ImpossibleError, apply_replenishment, waiting_and_assigned(), answer, **given)


def test_pods_that_are_bound_already_need_no_robot() -> None:
    warehouse = waiting_and_assigned()
    events: list[Any] = []
    answer = BundleDecision(stores=[StoreBundle(0, 2)])
    apply_replenishment(warehouse, answer, role=Role.ROA_RPS, max_fetches=0, keep=events.append)
    assert [type(event) for event in events] == [BundleBound, TripDecided]
    assert warehouse.pods[2].bound_for == (0, 1)
    with pytest.raises(ImpossibleError, match=r"sent too many stored pods \(1\); expected at most 0, the robots"):
        apply_replenishment(warehouse, [StoreBundle(1, 0)], role=Role.RPS, max_fetches=0, keep=events.append)


def test_storing_holds_pod_and_worker() -> None:
    """Two bundles for one pod: one visit, 10 s each; then the order that nobody could serve is picked."""
    instance = brought(small_instance({"1": {"a": 3}}, {"p": {"a": 1}}), (0, 0, 1), (0, 0, 2))
    run = prepared(scenario_of(FILE), instance).done()
    stored = run.of(BundleStored)
    assert [event.tick - event.start_tick for event in stored] == [10_000, 10_000]
    assert stored[1].start_tick == stored[0].tick
    assert {(event.visit, event.station) for event in stored} == {(stored[0].visit, 1)}
    ended = next(event for event in run.of(VisitEnded) if event.station == 1)
    assert (ended.tick, ended.picks) == (stored[1].tick, 0)
    assert (len(run.of(ItemPicked)), run.simulation.status) == (3, "complete")


def test_a_pod_picks_and_replenishes() -> None:
    orders, pods = {"1": {"a": 1}, "2": {"b": 1}}, {"p": {"a": 1}}
    instance = brought(small_instance(orders, pods, arrivals_s={"2": 200}), (5, 1, 1))
    run = prepared(scenario_of(FILE, robots=1), instance).done()
    assert [event.station for event in run.of(VisitStarted)[:2]] == [0, 1]
    assert (run.of(VisitEnded)[0].next_station, run.simulation.status) == (1, "complete")
    supply = {"replenishment": {"process": "file", "file": "b"}}
    layout = {"replenishment_west": 1}
    scenario = scenario_of({}, instance=supply, stations={"also_replenish": True, "queue_length": 3}, layout=layout)
    run = prepared(scenario, brought(small_instance({"1": {"a": 1}}, {"p": {"b": 1}}), (0, 1, 1))).done()
    assert [station.id for station in run.simulation.view.replenishment_stations] == [0, 1]
    assert run.of(BundleStored)[0].station == 0
    assert run.of(BundleStored)[0].visit == run.of(ItemPicked)[0].visit
    assert run.simulation.status == "complete"


def test_a_run_waits_for_stock_or_names_what_has_no_room() -> None:
    run = prepared(scenario_of(FILE), brought(small_instance({"1": {"a": 1}}, {"p": {"b": 1}}), (36_000, 1, 1))).done()
    assert (run.of(BundleArrived)[0].tick, len(run.of(OrderCompleted))) == (36_000_000, 1)
    instance = brought(small_instance({"1": {"a": 1}}, {"p": {"b": 3}}), (0, 1, 1))
    run = prepared(scenario_of(FILE, instance={"pod_capacity": 3, "replenishment": FILE}), instance)
    with pytest.raises(StandstillError, match=r"bundles that fit on no pod: B1\."):
        run.simulation.run()


def test_endless_bundles_do_not_hide_a_standstill() -> None:
    """By chance bundles come for ever: where pods have no room for any of them, nothing else will happen."""
    supply = {"process": "poisson", "bundles_per_hour": 60.0, "bundle_items": 1}
    scenario = scenario_of(supply, instance={"pod_capacity": 3, "replenishment": supply})
    run = prepared(scenario, small_instance({"1": {"a": 1}}, {"p": {"b": 3}}))
    with pytest.raises(StandstillError, match="bundles that fit on no pod"):
        run.simulation.run()
    assert len(run.of(BundleArrived)) == 1


@pytest.mark.parametrize("seed", range(6))
def test_endless_bundles_of_which_some_have_room(seed: int) -> None:
    supply = {"process": "poisson", "bundles_per_hour": 60.0, "bundle_items": 1}
    instance = small_instance({"1": {"a": 1}, "2": {"c": 1}}, {"p": {"b": 6}, "q": {"b": 3, "c": 1}})
    instance = evolve(instance, sizes=tuple({"a": 1, "b": 1, "c": 4}[sku] for sku in instance.skus))
    ends = {}
    for places in (1, 100):
        stations = {"bundle_capacity": places, "queue_length": 3}
        scenario = scenario_of(supply, instance={"pod_capacity": 7, "replenishment": supply}, stations=stations)
        run = prepared(scenario.with_seed(seed), instance)
        try:
            run.simulation.run()
        except StandstillError as error:
            assert "bundles that fit on no pod: " in str(error)
        ends[places] = run.simulation.status
        skus = [event.sku for event in run.of(BundleArrived)]
    late = skus.index(instance.skus.index("a")) >= 2
    assert ends == {1: "partial" if late else "complete", 100: "complete"}


def test_a_joint_rule_decides_both() -> None:
    @define
    class Both:
        @hookimpl
        def assign_bundles_and_pods(self, warehouse: WarehouseView, max_fetches: int) -> BundleDecision:
            station = warehouse.replenishment_stations[0]
            new = [bundle.id for bundle in warehouse.bundles]
            left = [bundle.id for bundle in station.bundles if bundle.pod is None]
            stored = [pod.id for pod in warehouse.free_pods][:max_fetches]
            stores = [StoreBundle(bundle, stored[0]) for bundle in (*left, *new)] if stored else []
            return BundleDecision([BundleAssignment(bundle, station.id) for bundle in new], stores)

    instance = {"orders": 6, "skus": 2, "pods": 2, "skus_per_pod": 1, "items_per_sku": 2, "replenishment": REORDER}
    result = rmfs_core.run(scenario_of(REORDER, instance=instance), rules={"roa_rps": Both()})
    assert result.status == "complete"
    assert result.metrics["bundles_stored"]


REORDER = {"process": "reorder-point", "reorder_point": 1, "order_up_to": 4}


def refusal(**instance: Any) -> str:
    keys = {"orders": 5, "skus": 4, "pods": 4, "skus_per_pod": 1} | instance
    return said(InputError, lambda: make_instance(scenario_of({}, instance=keys)))


@cases(
    "instance problem",
    ({"replenishment": {"process": "poisson"}}, "expected `bundles_per_hour` and `bundle_items`"),
    ({"replenishment": {"process": "reorder-point"}}, "expected a number, or one for SKU 1 in the file"),
    ({"replenishment": {"process": "file"}}, 'expected `file` with process "file"'),
    ({"replenishment": REORDER | {"order_up_to": 1}}, "expected order_up_to > reorder_point, found 1 <= 1"),
    ({"replenishment": REORDER | {"unit": "crates"}}, 'found "crates"'),
    ({"replenishment": REORDER, "items_per_sku": 9, "pod_capacity": 8}, "found 8; expected at least 9, what pod 1"),
)
def test_what_cannot_be_replenished_is_refused(instance: dict[str, Any], problem: str) -> None:
    assert problem in refusal(**instance)


def test_a_process_needs_rules_and_a_station() -> None:
    tables = {"rules": {"poa": "pod-match", "pps": "demand"}, "instance": {"replenishment": REORDER}}
    with pytest.raises(InputError, match=r'`rules.roa` and `rules.rps`, or `rules.roa_rps`, .* "reorder-point"'):
        scenario_from_dict(tables)
    tables["rules"]["roa"] = "first-bundle"
    with pytest.raises(InputError, match="expected `roa` and `rps`, or `roa_rps`, found `roa`"):
        scenario_from_dict(tables)
    scenario = scenario_of(REORDER, layout={"replenishment_west": 0}, instance={"pods": 9, "replenishment": REORDER})
    with pytest.raises(InputError, match=r"found no replenishment station; expected `I` in the map"):
        open_warehouse(scenario, make_instance(scenario), make_layout(scenario))


SUPPLIES: tuple[dict[str, Any], ...] = (
    {"process": "reorder-point", "reorder_point": 2, "order_up_to": 6, "bundle_items": 4, "lead_s": 60.0},
    {"process": "reorder-point", "reorder_point": 0, "order_up_to": 3, "lead_s": 600.0},
    {"process": "poisson", "bundles_per_hour": 120.0, "bundle_items": 2},
)


@st.composite
def worlds(draw: st.DrawFn) -> Scenario:
    """Orders that want more than there is, pods with room for what comes, one to six robots, and any supply."""
    supply, both, skus = draw(st.sampled_from(SUPPLIES)), draw(st.booleans()), draw(st.integers(1, 5))
    joint = draw(st.sampled_from([None, None, "split-over-time", "pod-index"]))
    deciders = (
        {"poa_pps": joint} if joint else {"poa": draw(st.sampled_from(["pod-match", "first-come"])), "pps": "demand"}
    )
    return scenario_from_dict(
        {
            "seed": draw(st.integers(0, 1000)),
            "rules": {
                **deciders,
                "roa": "first-bundle",
                "rps": "emptiest-pod",
                "ta": draw(st.sampled_from(["nearest-robot", "balanced"])),
            },
            "instance": {
                "orders": draw(st.integers(1, 25)),
                "skus": skus,
                "pods": draw(st.integers(max(3, skus), 8)),
                "skus_per_pod": 1,
                "items_per_sku": draw(st.integers(1, 4)),
                "replenishment": supply,
                **({} if supply["process"] == "poisson" else {"pod_capacity": draw(st.sampled_from([24, 40]))}),
            },
            "layout": {
                "block_rows": 5,
                "block_columns": draw(st.integers(1, 3)),
                "block_length": 2,
                "hall_width": 1,
                "stations_east": draw(st.integers(1, 2)),
                "replenishment_west": 0 if both else draw(st.integers(1, 2)),
                "pod_fill": draw(st.floats(0.1, 0.9)),
            },
            "robots": {"count": draw(st.integers(1, 6))},
            "stations": {
                "queue_length": draw(st.integers(1, 4)),
                "bundle_capacity": draw(st.integers(1, 4)),
                "also_replenish": both,
                "item_capacity": draw(st.integers(3, 15)),
            },
        }
    )


class Stock:
    """Observer that holds what the pods hold against what was there, stored and picked, at every event."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario

    @hookimpl
    def run_started(self, run: RunInfo) -> None:
        self.view, self.sizes = run.warehouse, run.instance.sizes
        self.held = [Counter(dict(pod.contents)) for pod in run.instance.pods]
        self.sent = self.stored = 0

    @hookimpl
    def on_event(self, event: Event) -> None:
        if isinstance(event, BundleArrived):
            self.sent += 1
        elif isinstance(event, BundleStored):
            self.held[event.pod][event.sku] += event.items
            self.stored += 1
        elif isinstance(event, ItemPicked):
            self.held[event.pod][event.sku] -= 1
        for pod, held in zip(self.view.pods, self.held, strict=True):
            assert +held == +Counter(dict(pod.contents))
            assert pod.free_space >= 0
            assert all(number >= 0 and pod.free_items(sku) >= 0 for sku, number in pod.contents.items())
        stations = self.view.replenishment_stations
        under_way = len(self.view.bundles) + sum(len(station.bundles) for station in stations)
        assert self.sent == self.stored + under_way


def survives(scenario: Scenario, pp: str) -> None:
    """Run to the end; every order is complete, and the validator finds no fault in the trace."""
    scenario = evolve(scenario, rules=evolve(scenario.rules, pp=RuleChoice(pp)), run=RunSection(standstill_s=900.0))
    with tempfile.TemporaryDirectory() as folder:
        try:
            observers = [Stock(scenario)]
            result = rmfs_core.run(scenario, out=folder, record=["trace"], observers=observers)
        except StandstillError as error:
            assert pp == "whca-n"
            assert " waits for row " in str(error)
            return
        assert result.status == "complete"
        assert validate_trace(Path(folder)) == []


@given(scenario=worlds())
@settings(max_examples=15, deadline=None, suppress_health_check=list(HealthCheck))
def test_nothing_is_lost_and_nothing_stands_still(scenario: Scenario) -> None:
    for pp in ("free-flow", "sipp"):
        survives(scenario, pp)


@given(scenario=worlds())
@settings(max_examples=6, deadline=None, suppress_health_check=list(HealthCheck))
def test_the_same_with_windows(scenario: Scenario) -> None:
    """Under `whca-n`, or it says who waits for whom: that one has no proof."""
    survives(scenario, "whca-n")


FROM_TWO_TO_SEVEN = {"process": "reorder-point", "reorder_point": 2, "order_up_to": 7}
LOW = Instance(
    ("a", "b", "c"),
    (OrderData("1", arrival_tick=0, lines=((0, 3), (1, 1))),),
    (PodData("p", ((0, 3), (1, None))), PodData("q", ((0, 1), (2, 2)))),
    levels=((2, 7), (2, 7), (2, 7)),
    restocked=True,
)


def test_what_has_run_low_or_is_waited_for_is_ordered() -> None:
    supply = Supply(scenario_of(FROM_TWO_TO_SEVEN), LOW)
    assert [supply.order(sku) for sku in range(3)] == [[], [], [5]]
    supply.picked(0)
    assert supply.order(0) == []
    supply.picked(0)
    assert [supply.order(0), supply.order(0)] == [[5], []]
    supply, wanted = Supply(scenario_of(FROM_TWO_TO_SEVEN), LOW), [OrderLine(0, 9)]
    supply.waits(wanted)
    assert supply.order(0) == [12]
    supply.waits_no_more(wanted)
    for _ in range(9):
        supply.picked(0)
    assert supply.order(0) == []


@cases(
    "instance largest",
    ({"replenishment": FROM_TWO_TO_SEVEN | {"bundle_items": 2}}, [2, 2, 1]),
    ({"replenishment": FROM_TWO_TO_SEVEN, "pod_capacity": 4}, [4, 1]),
)
def test_large_orders_come_in_several_bundles(instance: dict[str, object], largest: list[int]) -> None:
    assert Supply(scenario_of(FROM_TWO_TO_SEVEN, instance=instance), LOW).order(2) == largest


def test_chance_and_files_bring_bundles() -> None:
    given = {"process": "poisson", "bundles_per_hour": 10.0, "bundle_items": 4}
    drawn = list(islice(Supply(scenario_of(given), LOW).coming(), 400))
    skus = [bundle.sku for bundle in drawn]
    assert 260 < skus.count(0) < 340
    assert skus.count(2) == 0
    assert {bundle.items for bundle in drawn} == {4}
    assert 36 < drawn[-1].arrival_tick / 3_600_000 < 44
    assert drawn == list(islice(Supply(scenario_of(given), LOW).coming(), 400))
    bundles = (BundleData("x", arrival_tick=5, sku=0, items=1), BundleData("y", arrival_tick=9, sku=1, items=2))
    supply = Supply(scenario_of({"process": "file", "file": "b"}), evolve(LOW, bundles=bundles, levels=()))
    assert tuple(supply.coming()) == bundles
    assert supply.order(2) == []
