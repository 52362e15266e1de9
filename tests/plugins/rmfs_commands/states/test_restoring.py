"""The warehouse as plain data, and back."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from attrs import evolve

import rmfs_core
from rmfs_commands.states.plain import Memento, PartMemento, RequestMemento
from rmfs_commands.states.restoring import ContradictionError, restore
from rmfs_commands.testing import small_world
from rmfs_core import hookimpl
from rmfs_core.info import Question, RunInfo
from rmfs_core.roles import Role
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_core.warehouse.promises import next_request
from rmfs_core.world import OrderData, PodData

SKUS = ("a", "b")


class GoesBack:
    """Observer that makes the warehouse anew at each decision, and looks whether it is the same."""

    def __init__(self) -> None:
        self.compared = 0

    @hookimpl
    def run_started(self, run: RunInfo) -> None:
        """Keep the view of the whole warehouse."""
        self.run = run

    @hookimpl
    def rule_asked(self, question: Question) -> None:
        """Compare."""
        view, skus = self.run.warehouse, self.run.instance.skus
        if question.decides is Role.PP:
            return
        memento = Memento.of(view, skus)
        again = WarehouseView(restore(memento, view.travel))
        assert Memento.of(again, skus) == memento
        assert (again.available() == view.available()).all()
        assert (again.open_demand() == view.open_demand()).all()
        assert again.free_storage_locations == view.free_storage_locations
        assert again.split_orders_open == view.split_orders_open
        assert [s.load for s in again.stations] == [s.load for s in view.stations]
        assert [order.unpicked_items for order in again.orders] == [order.unpicked_items for order in view.orders]
        assert [robot.pod for robot in again.robots] == [robot.pod for robot in view.robots]
        self.compared += 1


@pytest.mark.parametrize(
    "settings",
    [
        ("instance.items_per_sku=20", "stations.order_capacity=2"),
        ("rules.poa=", "rules.pps=", "rules.poa_pps=split-over-time", "stations.item_capacity=6"),
        ("stations.release=handled", "stations.order_capacity=2"),
        (
            "stations.release=handled",
            "rules.poa=",
            "rules.pps=",
            "rules.poa_pps=split-over-time",
            "stations.item_capacity=6",
        ),
        ('instance.arrivals={process="refill", backlog=4}', "stations.release=handled"),
        (
            'stations.open={1 = [["00:00", "00:02"]], 2 = [["00:01", "24:00"]]}',
            'robots.available=[["00:00", "00:03"], ["00:03", "24:00", 1]]',
            "rules.activate={rule='backlog-threshold', open_above=2, timeout_s=60}",
        ),
    ],
)
def test_a_run_can_be_taken_down_and_restored_at_every_decision(settings: tuple[str, ...]) -> None:
    """What a memento tells of the warehouse is all there is to it: restored, it shows what it showed."""
    observer = GoesBack()
    overrides = ["instance.orders=14", "instance.max_lines=5", "rules.pp=free-flow", *settings]
    rmfs_core.run("examples/small", overrides=overrides, observers=[observer])
    assert observer.compared > 20


def at_work() -> Warehouse:
    """Return a world in which pod 0 stands at the station, pod 1 waits, and order 0 wants an item of each."""
    world = small_world({"1": {"a": 2, "b": 1}}, {"p": ["a"], "q": {"b": 4}})
    world.assign(world.orders[0], world.stations[0], [0, 1])
    world.place_at_station(world.robots[0], world.pods[0], world.stations[0])
    world.bind(world.pods[1], world.stations[0])
    request = next_request(world.stations[0], world.pods[0])
    assert request is not None
    world.fulfil(request, world.pods[0])
    return world


def test_a_restored_warehouse_is_another_one() -> None:
    """What is done to it leaves the first one alone, and goes on as there."""
    world = at_work()
    before = Memento.of(WarehouseView(world), SKUS)
    again = restore(before, world.travel)
    for warehouse in (again, world):
        station, pod = warehouse.stations[0], warehouse.pods[0]
        request = next_request(station, pod)
        assert request is not None
        assert (request.id, request.pod) == (1, pod)
        warehouse.fulfil(request, pod)
        assert next_request(station, pod) is None
        if warehouse is again:
            assert Memento.of(WarehouseView(world), SKUS) == before
    assert Memento.of(WarehouseView(again), SKUS) == Memento.of(WarehouseView(world), SKUS)


def test_what_is_in_hand_keeps_its_place() -> None:
    """An item that is picked and not yet handled; another one that was not picked here cannot be in hand."""
    world = small_world({"1": {"a": 1}, "2": {"b": 1}}, {"p": ["a"]}, capacities=[2])
    station = world.stations[0]
    world.assign(world.orders[0], station, [0])
    world.place_at_station(world.robots[0], world.pods[0], station)
    world.fulfil(station.open_requests[0], world.pods[0], handled=False)
    told = Memento.of(WarehouseView(world), SKUS)
    assert told.stations[0].in_hand == (0, 0)
    again = restore(told, world.travel)
    assert (again.stations[0].load, again.orders[0].unpicked_items, again.orders[0].complete) == (1, 0, False)
    wrong = evolve(told, stations=(evolve(told.stations[0], in_hand=(1, 1)),))
    with pytest.raises(ContradictionError, match=r"stations\.0\.in_hand: names no item picked here"):
        restore(wrong, world.travel)


def test_the_last_item_of_a_too_large_order_in_hand() -> None:
    """The order keeps more places than its station has until the item is handled; two orders never do."""
    world = small_world({"1": {"a": 1, "b": 1}, "2": {"b": 1}}, {"p": ["a", "b"]}, capacities=[1])
    station, pod = world.stations[0], world.pods[0]
    world.assign(world.orders[0], station, [0, 1])
    world.place_at_station(world.robots[0], pod, station)
    for request in station.open_requests:
        world.fulfil(request, pod, handled=request.sku == 0)
    told = Memento.of(WarehouseView(world), SKUS)
    assert restore(told, world.travel).stations[0].load == 2
    world.assign(world.orders[1], station, [1])
    with pytest.raises(ContradictionError, match=r"stations\.0\.capacity: found 1; expected at least 3"):
        restore(Memento.of(WarehouseView(world), SKUS), world.travel)


def test_promises_that_are_not_told_are_made() -> None:
    """A request without a pod is covered by the first inbound one that has an item to spare."""
    world = at_work()
    told = Memento.of(WarehouseView(world), SKUS)
    (station,) = told.stations
    untold = tuple(request._replace(pod=None) for request in station.requests)
    again = restore(evolve(told, stations=(evolve(station, requests=untold),)), world.travel)
    assert Memento.of(WarehouseView(again), SKUS) == told


@pytest.mark.parametrize(
    ("part", "change", "path", "problem"),
    [  # what a state with names cannot get wrong; the rest is tried there
        ("orders", {"parts": (PartMemento(1, (0,), 1),)}, ("orders", 0, "parts", 0, "station"), "expected 0 to 0"),
        ("orders", {"parts": (PartMemento(0, (-1,), 1),)}, ("orders", 0, "parts", 0), "found the id -1"),
        ("stations", {"requests": (RequestMemento(0, 9, 0, None),)}, ("stations", 0, "requests", 0), "the id 9"),
        ("stations", {"inbound": (0, 2)}, ("stations", 0, "inbound", 1), "found the id 2; expected 0 to 1"),
        ("stations", {"line": (0, -1)}, ("stations", 0, "line", 1), "found the id -1"),
        ("stations", {"line": (0, 1)}, ("stations", 0, "line", 1), 'names pod "q", which no robot carries'),
        ("robots", {"task": 2}, ("robots", 0, "task"), "found the id 2"),
        ("robots", {"cell": 10_000}, ("robots", 0, "cell"), "expected a cell of the layout"),
        ("robots", {"cell": 11}, ("robots", 0, "cell"), "expected a cell of the layout, 0 to 119, no wall"),
        ("orders", {"data": OrderData("1", 0, ((0, 2), (9, 1)))}, ("orders", 0, "lines"), "the id 9"),
        ("orders", {"data": OrderData("1", 0, ((0, -2),))}, ("orders", 0, "lines"), "found -2 items"),
        ("pods", {"data": PodData("p", ((-1, 3),))}, ("pods", 0, "contents"), "the id -1"),
        (
            "pods",
            {"data": PodData("p", ((0, 3),)), "capacity": 2},
            ("pods", 0, "capacity"),
            "expected at least 3, what",
        ),
        ("pods", {"home": 0}, ("pods", 0, "home"), "found 0; expected a storage location"),
        ("stations", {"queue_room": -1}, ("stations", 0, "queue_room"), "found -1; expected 0 to "),
        ("stations", {"queue_room": 99}, ("stations", 0, "queue_room"), "found 99; expected 0 to "),
    ],
)
def test_contradictions(part: str, change: dict[str, object], path: tuple[str | int, ...], problem: str) -> None:
    """What no warehouse can be is refused with the path of the value."""
    world = at_work()
    memento = Memento.of(WarehouseView(world), SKUS)
    first, *others = getattr(memento, part)
    assert restore(memento, world.travel).now == memento.now
    with pytest.raises(ContradictionError) as caught:
        restore(evolve(memento, **{part: (evolve(first, **change), *others)}), world.travel)
    assert caught.value.path == path
    assert problem in caught.value.problem
    assert str(caught.value) == f"{'.'.join(map(str, path))}: {caught.value.problem}"


@pytest.mark.parametrize(
    ("changed", "key"),
    [
        (lambda memento: {"stations": memento.stations * 2}, "stations"),
        (lambda memento: {"blocked": (0,)}, "blocked"),
        (lambda memento: {"reserved": (10_000,)}, "reserved"),
        (lambda memento: {"blocked": (memento.pods[1].home,), "reserved": (memento.pods[1].home,)}, "reserved"),
    ],
)
def test_contradictions_of_the_whole(changed: Callable[[Memento], dict[str, Any]], key: str) -> None:
    """More stations than the layout has, cells that are no storage locations, or twice one."""
    world = at_work()
    memento = Memento.of(WarehouseView(world), SKUS)
    with pytest.raises(ContradictionError) as caught:
        restore(evolve(memento, **changed(memento)), world.travel)
    assert caught.value.path == (key,)
