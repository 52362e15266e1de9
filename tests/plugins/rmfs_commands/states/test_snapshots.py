"""The state of a running warehouse, step by step: what is written, and what the patches tell."""

from __future__ import annotations

from copy import deepcopy
from typing import Any

import pytest

from rmfs_commands.states.patches import patched
from rmfs_commands.states.rebuilding import open_state
from rmfs_commands.states.snapshots import Snapshots
from rmfs_commands.states.state_json import state_from_dict
from rmfs_commands.testing import small_instance, small_layout, small_world
from rmfs_core.events import ItemPicked, OrderArrived, OrderAssigned, PodLifted, PodStored, TripDecided
from rmfs_core.info import RunInfo
from rmfs_core.motion import Motion
from rmfs_core.scenario.model import RuleChoice, RulesSection, Scenario
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_core.world import NORTH, parse_map

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
        """Look again; return the patch, with which the state before is the state now."""
        patch = deepcopy(self.snapshots.look(call))
        self.known = patched(self.known, patch)
        assert self.known == self.snapshots.state
        return patch

    def orders_arrive(self) -> None:
        """Tell of the two orders."""
        for order in self.world.orders:
            self.snapshots.told(OrderArrived(0, order.id))

    def assign(self, order: int, station: int, *skus: int) -> None:
        """Assign lines, and tell of it."""
        items = self.world.assign(self.world.orders[order], self.world.stations[station], list(skus))
        self.snapshots.told(OrderAssigned(0, order, station, skus, items, 1, complete=False))

    def bind(self, pod: int, station: int) -> None:
        """Decide a trip, and tell of it."""
        self.world.bind(self.world.pods[pod], self.world.stations[station])
        self.snapshots.told(TripDecided(0, pod, station))


@pytest.fixture
def run() -> Run:
    """Return a run with item capacity."""
    return Run()


def test_the_first_state_is_complete(run: Run) -> None:
    """All that does not come with events; stock without limit is null."""
    state, world = run.snapshots.state, run.world
    first, second = (pod.cell for pod in world.pods)
    assert (state["time_s"], state["skus"], state["seed"]) == (0, ["milk", "tea", "jam"], 7)
    assert state["pods"] == {
        "P1": {"contents": {"milk": 3, "tea": 1}, "home": first, "cell": first},
        "P2": {"contents": {"jam": None}, "home": second, "cell": second},
    }
    empty = {"item_capacity": 4, "queue_length": 3, "requests": [], "inbound": [], "line": [], "queue_room": 4}
    assert state["stations"] == {"1": empty, "2": empty}
    assert state["robots"] == {robot.name: {"cell": robot.cell, "heading": NORTH} for robot in world.robots}
    assert [state[key] for key in ("orders", "waiting", "empty_pods", "reserved")] == [{}, [], [], []]
    drawn, layout = parse_map("\n".join(state["layout"]["map"]), "map"), small_layout(2)
    assert (drawn.storage_locations, drawn.stations) == (layout.storage_locations, layout.stations)


def test_stations_say_what_they_count() -> None:
    """Orders here."""
    station = Run(counts_orders=True).snapshots.state["stations"]["1"]
    assert station["order_capacity"] == 4
    assert "item_capacity" not in station


def test_orders_come_with_the_events_that_tell_of_them(run: Run) -> None:
    """With their lines and arrival, and later with what was assigned of them."""
    assert "orders" not in run.look(POA)
    run.orders_arrive()
    milk_and_tea = {"lines": {"milk": 1, "tea": 1}, "arrival_s": 0, "parts": []}
    assert run.look(POA)["orders"] == {"A": milk_and_tea, "B": {"lines": {"jam": 2}, "arrival_s": 0, "parts": []}}
    run.assign(0, 1, 1)
    assert run.look(POA)["orders"] == {"A": {"parts": [{"station": "2", "skus": ["tea"], "period": 1}]}}
    assert "orders" not in run.look(POA)


def test_requests_have_names_and_the_pod_that_they_are_promised_from(run: Run) -> None:
    """The pod once one is on its way; stations where nothing changed are left out."""
    run.orders_arrive()
    run.assign(0, 1, 0, 1)
    request = {"order": "A", "sku": "milk", "id": 0}, {"order": "A", "sku": "tea", "id": 1}
    assert run.look(POA)["stations"] == {"2": {"requests": list(request)}}
    run.bind(0, 1)
    patch = run.look(PPS)
    promised = [one | {"pod": "P1"} for one in request]
    assert patch["stations"] == {"2": {"requests": promised, "inbound": ["P1"]}}
    assert patch["waiting"] == ["P1"]
    assert "pods" not in patch  # bound for one station, which says so


def test_a_pod_that_is_fetched_and_stored_elsewhere(run: Run) -> None:
    """It has a cell while it is stored, its robot a task until then; a place is reserved while it is on its way."""
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


def test_a_pick_takes_an_item_from_pod_and_station(run: Run) -> None:
    """The line at the station and its room are told, too; the order keeps its part."""
    run.orders_arrive()
    run.assign(0, 0, 0)
    world = run.world
    world.place_at_station(world.robots[0], world.pods[0], world.stations[0])
    run.snapshots.told(PodLifted(0, 0, 0, 0, 0))
    assert {"line": ["P1"], "queue_room": 3}.items() <= run.look(PPS)["stations"]["1"].items()
    (request,) = world.stations[0].open_requests
    world.fulfil(request, world.pods[0])
    run.snapshots.told(ItemPicked(0, 0, 0, 1, 0, 0, 0, 0))
    patch = run.look(PPS)
    assert patch == {"pods": {"P1": {"contents": {"milk": 2}}}, "stations": {"1": {"requests": []}}}


def test_time_goes_on(run: Run) -> None:
    """In seconds; where nothing else changed, nothing else is told."""
    run.look(POA)
    run.world.advance(1_500)
    assert run.look(POA) == {"time_s": 1.5}
    assert run.look(POA) == {}


def test_what_belongs_to_one_call_is_gone_at_the_next(run: Run) -> None:
    """A prefilter's backlog and a generator's state; what is asked is told where it is another question."""
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


def test_the_state_describes_the_warehouse(run: Run) -> None:
    """Opened again, it has the same orders, requests, pods and robots."""
    run.orders_arrive()
    run.assign(1, 1, 2)
    run.bind(1, 1)
    run.look(POA)
    opened = open_state(state_from_dict(run.known, "state")).warehouse
    for found, expected in zip(opened.stations, run.world.stations, strict=True):
        assert found.free_capacity == expected.free_capacity
        assert [request.sku for request in found.open_requests] == [request.sku for request in expected.open_requests]
        assert [pod.name for pod in found.inbound_pods] == [pod.name for pod in expected.inbound_pods]
    assert [order.name for order in opened.backlog.orders] == ["A"]
    assert [pod.contents for pod in opened.pods] == [pod.contents for pod in run.world.pods]
    assert [robot.cell for robot in opened.robots] == [robot.cell for robot in run.world.robots]
