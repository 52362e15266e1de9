"""Packing stations: boxes of split orders, conveyors, packers, and the end of a run when all is packed."""

from collections.abc import Callable
from typing import Any

import pytest
from attrs import define, evolve

from cases import cases
from rmfs_commands.layouts import parse_map
from rmfs_commands.processes.events import (
    OrderConsolidated,
    OrderPacked,
    PackingAssigned,
    PackingStarted,
    PartArrived,
    PartPut,
    PartSent,
)
from rmfs_commands.testing import small_instance, small_layout
from rmfs_core import JointDecision, OrderAssignment, PodTrip, hookimpl
from rmfs_core.errors import InputError, RuleError, StandstillError
from rmfs_core.events import Event, ItemPicked, OrderCompleted
from rmfs_core.rules import RuleSet, with_objects
from rmfs_core.scenario import load_scenario, scenario_to_dict
from rmfs_core.scenario.model import PackingSection, RuleChoice, Scenario
from rmfs_core.simulation.engine import Simulation
from told import Prepare, ToldRun

ORDERS = {str(i): "abcdef"[i % 4 : i % 4 + 1 + i % 3] for i in range(12)}
PODS = {"p": "ab", "q": "cd", "r": "ef"}
INSTANCE = small_instance(
    {name: [*skus] for name, skus in ORDERS.items()}, {name: [*skus] for name, skus in PODS.items()}
)
SINGLES = small_instance({str(i): ["a"] for i in range(12)}, {"p": ["a"]})
NO_TIME = {"conveyor_s": 0.0, "tote_s": 0.0, "put_s": 0.0, "pack_s": 0.0, "pack_item_s": 0.0}
SPLITTING = ("pod-index", "split-among-stations", "split-over-time")


def packing(**keys: Any) -> Callable[[Scenario], Scenario]:
    return lambda scenario: evolve(scenario, packing=PackingSection(**keys))


@define
class Scripted:
    """Splits orders over two stations, or leaves lines in the backlog; unless it is careless while boxes are free."""

    splits_over_time = True
    over_time: bool = False
    often: int = 1
    careless: bool = False

    @hookimpl
    def assign_orders_and_pods(self, warehouse: Any) -> JointDecision:
        assignments, trips = [], []
        free = warehouse.free_boxes
        for order in warehouse.backlog[: self.often]:
            if len(order.open_lines) < 2 or order.parts or not (free or self.careless):
                parts = [(order.open_lines, warehouse.stations[0])]
            elif self.over_time:
                parts = [(order.open_lines[:1], warehouse.stations[0])]
            else:
                parts = [(order.open_lines[:1], warehouse.stations[0]), (order.open_lines[1:], warehouse.stations[1])]
            free -= len(parts) > 1
            for lines, station in parts:
                if sum(line.quantity for line in lines) > station.free_capacity:
                    return JointDecision()
                assignments.append(OrderAssignment(order.id, station.id, tuple(line.sku for line in lines)))
                for line in lines:
                    for pod in warehouse.pods_with(line.sku):
                        trip = PodTrip(pod.id, station.id)
                        if station.id not in pod.bound_for and trip not in trips:
                            trips.append(trip)
        return JointDecision(assignments, trips)


def scripted(tiny_run: Prepare, rules: dict[str, Any], change: Callable[[Scenario], Scenario]) -> ToldRun:
    run = tiny_run(INSTANCE, capacity=(9, 9), robots=3, change=change)
    scenario = evolve(run.simulation.scenario, rules=with_objects(run.simulation.scenario.rules, rules))
    keys = {"poa", "pps", "poa_pps", "packing", "packing_task"} & rules.keys()
    loaded = RuleSet.load(scenario.rules, scenario.folder, objects={key: rules[key] for key in keys})
    found = ToldRun(Simulation(scenario, INSTANCE, small_layout(2), loaded))
    loaded.register_observer(found)
    return found


@pytest.mark.parametrize("rule", ["pod-match", *SPLITTING])
def test_where_packing_takes_no_time_packed_is_picked(tiny_run: Prepare, rule: str) -> None:
    """With as many packers as there are orders, all is as without packing stations, until the last order is packed."""
    rules = {"poa": rule} if rule == "pod-match" else {"poa_pps": rule}
    plain = tiny_run(INSTANCE, capacity=(9, 9), robots=3, **rules).done()
    packed = tiny_run(INSTANCE, capacity=(9, 9), robots=3, change=packing(packers=99, **NO_TIME), **rules).done()
    for kind in (ItemPicked, OrderCompleted):
        assert plain.of(kind) == packed.of(kind)
    assert {e.order: e.tick for e in packed.of(OrderPacked)} == {e.order: e.tick for e in packed.of(OrderCompleted)}
    assert not any("packing" in vars(type(event)).get("__slots__", ()) for event in plain.events)


@pytest.mark.parametrize("rule", SPLITTING)
@pytest.mark.parametrize("counts", ["packed", "picked"])
@pytest.mark.parametrize("tote", ["part", "visit"])
def test_a_split_order_has_a_box_of_its_own_until_it_is_packed(tiny_run, rule, counts, tote) -> None:
    change = packing(stations=2, boxes=1, packers=1, packing_from=counts, tote=tote)
    run = tiny_run(INSTANCE, capacity=(3, 3), robots=3, change=change, poa_pps=rule).done()
    boxes: dict[int, tuple[int, int]] = {}
    picked: set[int] = set()
    items: dict[int, list[int]] = {}
    split = set()
    for event in run.events:
        match event:
            case PackingAssigned(order=order, packing=at, box=box) if box is not None:
                assert (at, box) not in boxes.values()
                boxes[order] = (at, box)
                split.add(order)
                assert len(boxes.keys() - (picked if counts == "picked" else set())) <= 2
                assert box == 0 or counts == "picked"
            case OrderCompleted(order=order):
                picked.add(order)
            case PartSent(order=order, items=number):
                items.setdefault(order, []).append(number)
            case OrderPacked(order=order):
                boxes.pop(order, None)
    orders = run.warehouse.orders
    assert run.simulation.status == "complete"
    assert {order.id: sum(items[order.id]) for order in orders} == {order.id: order.items for order in orders}
    assert {order.id for order in orders if order.split} == split
    assert all(len(totes) == 1 for order, totes in items.items() if order not in split)
    assert {event.order for event in run.of(OrderConsolidated)} == split == {event.order for event in run.of(PartPut)}
    assert boxes == {}


@cases(
    "rules keys told",
    ({"poa_pps": Scripted(often=3, careless=True)}, {}, "split 2 orders; free boxes at the packing stations: 1"),
    ({"poa_pps": Scripted(often=9, over_time=True, careless=True)}, {"stations": 2}, "split 6 orders; .*: 2"),
)
def test_a_decision_that_splits_without_a_box_is_refused(tiny_run: Prepare, rules: Any, keys: Any, told: str) -> None:
    with pytest.raises(RuleError, match=told):
        scripted(tiny_run, rules, packing(boxes=1, **keys)).done()


@define
class Answers:
    answer: Any = ()

    @hookimpl
    def assign_packing(self, orders: Any) -> Any:
        return self.answer if isinstance(self.answer, str) else self.answer[: len(orders)]

    @hookimpl
    def choose_packing_task(self) -> Any:
        return self.answer


@cases(
    "rules told",
    ({"packing": Answers([])}, "assign_packing, at 0.000 s: named packing stations: 0; expected 1, one for each"),
    ({"packing": Answers([2])}, "named packing station 2, which does not exist; ids are 0 to 1"),
    ({"packing": Answers("ab")}, "returned str 'ab'; expected a sequence of ids"),
    (
        {"packing": Answers([0]), "poa_pps": Scripted()},
        r"sent split order 2 \(id 2\) to packing station 1, where no box is free",
    ),
    ({"packing_task": Answers(9)}, r"choose_packing_task, at [0-9.]+ s: named task 9, which does not exist"),
    ({"packing_task": Answers(None)}, "named task None; expected a whole number"),
)
def test_an_impossible_decision_of_packing_is_refused(tiny_run: Prepare, rules: Any, told: str) -> None:
    with pytest.raises(RuleError, match=told):
        scripted(tiny_run, {"poa_pps": Scripted()} | rules, packing(stations=2, boxes=1, packers=1)).done()


@pytest.mark.parametrize(("packers", "sorters"), [(1, 0), (2, 0), (5, 0), (1, 1)])
def test_single_items_are_packed_as_a_queue_says(tiny_run: Prepare, packers: int, sorters: int) -> None:
    """By hand: the n-th one begins when it comes, or when one of so many packers is done; each takes 30 + 5 s."""
    run = tiny_run(SINGLES, change=packing(packers=packers, sorters=sorters)).done()
    sent = {event.tote: event for event in run.of(PartSent)}
    arrived, free = run.of(PartArrived), [0] * packers
    assert [event.tick - sent[event.tote].tick for event in arrived] == [60_000] * 12
    assert sorted(event.tick for event in run.of(OrderCompleted)) == [event.tick for event in sent.values()]
    expected = {}
    for event in arrived:
        free.sort()
        begin = max(event.tick, free[0])
        free[0] = begin + 35_000
        expected[event.order] = (begin, begin + 35_000)
    begun = {event.order: event.tick for event in run.of(PackingStarted)}
    assert {event.order: (begun[event.order], event.tick) for event in run.of(OrderPacked)} == expected
    assert run.simulation.now == max(end for _, end in expected.values())


def test_parts_are_put_and_then_packed(tiny_run: Prepare) -> None:
    """By hand: 3 s a tote and 4 s an item to put, 30 s and 5 s an item to pack; a sorter leaves the packer free."""
    run = scripted(tiny_run, {"poa_pps": Scripted()}, packing(packers=1, sorters=1)).done()
    for put in run.of(PartPut):
        assert put.tick - put.start_tick == 3000 + 4000 * put.items
    together = {event.order: event.tick for event in run.of(OrderConsolidated)}
    assert together == {event.order: event.tick for event in run.of(PartPut)} != {}
    for event in run.of(OrderPacked):
        assert event.tick - event.start_tick == 30_000 + 5_000 * run.warehouse.orders[event.order].items
        assert event.start_tick >= together.get(event.order, 0)


def test_packers_begin_nothing_while_they_are_closed(tiny_run: Prepare) -> None:
    run = tiny_run(SINGLES, change=packing(packers=1, open=(("00:05", "00:06"), ("00:10", "24:00")))).done()
    starts = [event.tick for event in run.of(PackingStarted)]
    assert starts[0] == 300_000
    assert not [tick for tick in starts if tick < 300_000 or 360_000 <= tick < 600_000]
    assert run.simulation.status == "complete"


MAP = """
#....O
#....q
#....q
P....P
"""


def test_conveyors_take_their_way(tiny_run: Prepare) -> None:
    """Along rows and columns, 0.5 m/s; `nearest` sends all to the packing station below the picking station."""
    layout = parse_map(MAP, "map")
    assert layout.packing == (18, 23)
    section = packing(conveyor_speed_m_per_s=0.5)

    def change(scenario: Scenario) -> Scenario:
        changed = section(scenario)
        return evolve(changed, rules=evolve(changed.rules, packing=RuleChoice("nearest")))

    run = tiny_run(SINGLES, layout=layout, queue_length=2, change=change)
    assert [station.conveyor_s for station in run.done().warehouse.packing] == [(16.0,), (6.0,)]
    assert {event.packing for event in run.of(PackingAssigned)} == {1}
    sent = {event.tote: event.tick for event in run.of(PartSent)}
    assert {event.tick - sent[event.tote] for event in run.of(PartArrived)} == {6000}


def test_the_view_says_how_far_an_order_is(tiny_run: Prepare) -> None:
    run = scripted(tiny_run, {"poa_pps": Scripted()}, packing(boxes=3, packers=1))
    seen: list[tuple[Event, Any]] = []

    @define
    class Looks:
        @hookimpl
        def on_event(self, event: Event) -> None:
            if isinstance(event, PartSent | PartArrived | PackingStarted | OrderPacked):
                seen.append((event, run.warehouse.orders[event.order].packing))

    run.simulation.rules.register_observer(Looks())
    assert run.simulation.view.free_boxes == 3
    run.done()
    packed = {event.order: event.tick / 1000 for event in run.of(OrderPacked)}
    first = {}
    for event, packing_of in seen:
        first.setdefault(event.order, event.tick / 1000) if isinstance(event, PartArrived) else None
        assert packing_of.first_part_s == first.get(event.order)
        assert packing_of.packed == isinstance(event, OrderPacked)
        assert packing_of.expected_s <= packed[event.order]
        if isinstance(event, PackingStarted):
            assert packing_of.expected_s == packed[event.order]
            assert packing_of.items_in_box in (0, run.warehouse.orders[event.order].items)
    assert run.simulation.view.free_boxes == 3


@cases(
    "keys told",
    ({"stations": 2, "open": {"2": ()}}, "packing.open: found no span for station 2; expected one that opens it"),
    ({"open": {"2": ()}}, "packing.open.2: no station 2; expected 1 to 1"),
    ({"conveyor_speed_m_per_s": 1.0}, "packing.conveyor_speed_m_per_s: expected a map that says where"),
)
def test_a_section_that_makes_no_sense_is_refused(tiny_run: Prepare, keys: Any, told: str) -> None:
    with pytest.raises(InputError, match=told):
        tiny_run(SINGLES, change=packing(**keys))


def test_packing_stations_that_the_map_cannot_hold_are_refused(tiny_run: Prepare) -> None:
    told = r"packing.stations: found 3, but the map has 2 packing stations \(`P`\); expected as many, or no number"
    with pytest.raises(InputError, match=told):
        tiny_run(SINGLES, layout=parse_map(MAP, "map"), queue_length=2, change=packing(stations=3))
    with pytest.raises(InputError, match="row 1, column 1: the packing station has no floor next to it; expected some"):
        parse_map("P\n#....O\n#....q\n", "map")


def test_rules_of_packing_stations_need_some(tiny_run: Prepare) -> None:
    with pytest.raises(ValueError, match='expected a section `packing` with the rule "nearest" of packing stations'):
        tiny_run(SINGLES, packing="nearest")
    scenario = tiny_run(SINGLES, change=packing()).simulation.scenario
    assert scenario.rules.packing_task == RuleChoice("first-come")
    assert "pack" not in repr(scenario_to_dict(evolve(scenario, packing=None, folder=".")))
    with pytest.raises(InputError, match=r"--set rules\.packing=least-reserved: has no effect without"):
        load_scenario("examples/small", ["rules.packing=least-reserved"])


def test_a_rule_that_waits_for_ever_is_told_of(tiny_run: Prepare) -> None:
    @define
    class Idle:
        @hookimpl
        def assign_orders(self, warehouse: Any) -> list[OrderAssignment]:
            first = warehouse.backlog[0]
            return [OrderAssignment(first.id, 0)] if not first.id else []

    run = scripted(tiny_run, {"poa": Idle()}, packing(boxes=1))
    with pytest.raises(StandstillError, match="11 orders are not complete"):
        run.done()
    assert len(run.of(OrderPacked)) == 1


@pytest.mark.parametrize("rule", ["pod-match", *SPLITTING])
def test_orders_larger_than_any_station_are_packed_with_one_box(tiny_run: Prepare, rule: str) -> None:
    """Many small lines, more than any station takes: it goes to an empty station alone."""
    large = {str(i): dict.fromkeys("abcdef", 2) for i in range(2)}
    orders = small_instance(large | {"2": {"a": 1, "c": 1}}, {name: [*skus] for name, skus in PODS.items()})
    rules = {"poa": rule} if rule == "pod-match" else {"poa_pps": rule}
    run = tiny_run(orders, capacity=(5, 5), robots=3, change=packing(boxes=1, packers=1), **rules).done()
    assert (run.simulation.status, len(run.of(OrderPacked))) == ("complete", 3)
    assert None in [event.box for event in run.of(PackingAssigned) if event.order < 2]
