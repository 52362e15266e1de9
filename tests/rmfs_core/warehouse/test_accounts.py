"""Accounts of the backlog and of free items."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import rmfs_core
from rmfs_commands.testing import small_world
from rmfs_core import hookimpl
from rmfs_core.info import Question
from rmfs_core.warehouse import Station, WarehouseView, lines_of
from rmfs_core.warehouse.backlog import Backlog
from rmfs_core.warehouse.parts import UNLIMITED
from standing import put_at_station


def test_the_backlog_as_arrays_follows_what_joins_and_leaves() -> None:
    """Lines as the orders have them, oldest first; sizes and log follow, and an order leaves with its last line."""
    world = small_world({"1": {"a": 2, "b": 1}, "2": {"b": 3}}, {"p": ["a", "b"]}, capacities=[9])
    backlog, station = world.backlog, world.stations[0]
    assert (len(backlog), dict(backlog.sizes), dict(backlog.line_sizes)) == (2, {3: 2}, {2: 1, 1: 1, 3: 1})
    assert backlog.log.joined().tolist() == [[0, 0, 1], [0, 1, 1], [2, 1, 3]]
    world.assign(world.orders[0], station, [0])
    assert (backlog.lines.order_id.tolist(), backlog.lines.sku.tolist()) == ([0, 1], [1, 1])
    assert backlog.lines is backlog.lines
    world.assign(world.orders[0], station, [1])
    assert [order.id for order in backlog.orders] == [1]
    assert world.orders[0] not in backlog
    assert (dict(backlog.sizes), dict(backlog.line_sizes), backlog.log.left()) == ({3: 1}, {3: 1}, [0, 1])


def test_a_new_log_begins_when_an_order_joins_late() -> None:
    """All that are there join anew, by age, and lines that are assigned leave at once; younger ones join the log."""
    world = small_world({"1": ["a"], "2": {"a": 1, "b": 2}, "3": ["b"], "4": ["a"]}, {"p": ["a", "b"]}, capacities=[9])
    first, second, third, fourth = world.orders
    backlog, station = Backlog(world.n_skus), world.stations[0]
    for order in (second, third):
        backlog.add(order)
    backlog.close(second, [0])
    log = backlog.log
    backlog.add_late([fourth])
    assert backlog.log is log
    backlog.add_late([first])
    assert backlog.log is not log
    assert backlog.orders == (first, second, third, fourth)
    assert backlog.log.joined().T.tolist() == [[0, 0, 1], [1, 0, 1], [1, 1, 2], [2, 1, 1], [3, 0, 1]]
    assert backlog.log.left() == [1]
    assert backlog.lines.order_id.tolist() == [0, 1, 2, 3]
    assert (dict(backlog.sizes), dict(backlog.line_sizes)) == ({2: 1, 1: 3}, {2: 1, 1: 3})
    backlog.close(second, [1])
    assert backlog.log.left() == [1, 2]
    assert station.load == 0


def test_open_lines_of_any_orders_as_arrays() -> None:
    """The position is that in the sequence, not the order's id; closed lines are left out, and nobody changes them."""
    world = small_world({"1": {"a": 2, "b": 1}, "2": {"b": 2}}, {"p": ["a", "b"]})
    first, second = world.orders
    world.assign(first, world.stations[0], [1])
    lines = lines_of((second, first))
    assert [lines.order.tolist(), lines.sku.tolist(), lines.quantity.tolist()] == [[0, 1], [1, 0], [2, 2]]
    assert [len(array) for array in (lines_of(()).order, lines_of(()).sku, lines_of(()).quantity)] == [0, 0, 0]
    with pytest.raises(ValueError, match="read-only"):
        lines.quantity[0] = 1


def test_free_items_are_told_as_arrays() -> None:
    """Every SKU of every pod, by pod and SKU; the same object until a promise or a pick changes them."""
    world = small_world({"1": ["a", "b"], "2": ["a"]}, {"p": {"a": 2, "b": 1}, "q": ["a"]}, capacities=[5])
    view, station = WarehouseView(world), world.stations[0]
    before = view.free_items
    assert (before.pod.tolist(), before.sku.tolist()) == ([0, 0, 1], [0, 1, 0])
    assert before.number.tolist() == [2, 1, UNLIMITED]
    assert view.free_items is before
    put_at_station(world, 0)
    assert view.free_items is before
    world.assign(world.orders[0], station, [0, 1])
    assert view.free_items.number.tolist() == [1, 0, UNLIMITED]
    assert before.number.tolist() == [2, 1, UNLIMITED]
    world.fulfil(station.open_requests[0], world.pods[0])
    assert view.free_items.number.tolist() == [1, 0, UNLIMITED]
    with pytest.raises(ValueError, match="read-only"):
        view.free_items.number[0] = 9


def test_what_changed_of_free_items_is_told_once() -> None:
    """At first all; then what a promise takes, and not what a pick does; arrays change in place, for looking only."""
    world = small_world({"1": ["a", "b"], "2": ["a"]}, {"p": {"a": 2, "b": 1}, "q": ["a"]}, capacities=[5])
    log, station = WarehouseView(world).free_items_log(), world.stations[0]
    number = log.items.number
    assert (number.tolist(), log.changed().tolist(), log.changed(3).tolist()) == ([2, 1, UNLIMITED], [0, 1, 2], [])
    put_at_station(world, 0)
    world.assign(world.orders[0], station, [0, 1])
    assert (log.changed(3).tolist(), number.tolist()) == ([0, 1], [1, 0, UNLIMITED])
    world.fulfil(station.open_requests[0], world.pods[0])
    world.assign(world.orders[1], station, [0])
    assert (log.changed(5).tolist(), log.items.number.tolist()) == ([0], [0, 0, UNLIMITED])
    with pytest.raises(ValueError, match="read-only"):
        log.items.number[0] = 9


def test_a_sku_that_a_pod_never_held_is_one_entry_more() -> None:
    """At the end of the log, where all others stay, and in its place among the free items that are told sorted."""
    world = small_world({}, {"p": ["a"], "q": {"b": 2}, "r": {"a": 1, "b": 1}}, bundle_capacity=9)
    view, station = WarehouseView(world), world.stations[0]
    log = view.free_items_log()
    assert (log.items.pod.tolist(), log.items.sku.tolist()) == ([0, 1, 2, 2], [0, 1, 0, 1])
    seen = len(log.changed())
    for pod, sku in ((1, 0), (1, 1)):
        bundle = world.bundle_arrives(sku, 3)
        world.assign_bundle(bundle, station)
        world.bind_bundle(bundle, world.pods[pod])
        world.store_bundle(bundle, world.pods[pod])
    assert view.free_items_log() is log
    assert log.changed(seen).tolist() == [1, 4]
    assert (log.items.pod.tolist(), log.items.sku.tolist()) == ([0, 1, 2, 2, 1], [0, 1, 0, 1, 0])
    assert log.ordered == 4
    assert log.items.number.tolist()[1:] == [5, 1, 1, 3]
    told = view.free_items
    assert (told.pod.tolist(), told.sku.tolist()) == ([0, 1, 1, 2, 2], [0, 0, 1, 0, 1])
    assert told.number.tolist()[1:] == [3, 5, 1, 1]


class Keeper:
    """Observer that keeps account of free items and stations by what it is told has changed."""

    def __init__(self) -> None:
        self.log: object = None
        self.logs = self.checked = 0
        self.stations: dict[int, tuple[int, Any]] = {}

    @hookimpl
    def rule_asked(self, question: Question) -> None:
        """Compare with what is read anew."""
        view = question.warehouse
        log = view.free_items_log()
        if log is not self.log:
            self.log, self.seen, self.logs = log, 0, self.logs + 1
            self.kept = np.zeros(0, np.int64)
        self.kept = np.append(self.kept, np.zeros(len(log.items.number) - len(self.kept), np.int64))
        changed = log.changed(self.seen)
        self.kept[changed] = log.items.number[changed]
        self.seen += len(changed)
        items = zip(log.items.pod.tolist(), log.items.sku.tolist(), strict=True)
        assert self.kept.tolist() == [view.pods[pod].free_items(sku) for pod, sku in items]
        order = np.lexsort((log.items.sku, log.items.pod))
        assert self.kept[order].tolist() == view.free_items.number.tolist()
        self.given = len(order) - log.ordered
        for station in (*view.stations, *view.replenishment_stations):
            now, (changes, before) = seen_of(station), self.stations.get(station.id, (-1, None))
            assert changes < station.changes() or before == now
            self.stations[station.id] = station.changes(), now
        self.checked += 1


def seen_of(station: Station) -> Any:
    """Return what `Station.changes` counts changes of."""
    hours = station.open, station.staffed, station.active, station.opens_s, station.closes_s
    requests = [(request, request.pod) for request in station.open_requests]
    return station.load, station.free_capacity, requests, station.inbound_pods, station.bundles, hours


@pytest.mark.parametrize(
    ("scenario", "overrides", "given"),
    [
        ("examples/small", [], False),
        (
            "examples/small",
            ["instance.items_per_sku=3", "stations.open={1 = [['00:00', '00:10']], 2 = [['00:02', '24:00']]}"],
            False,
        ),
        ("examples/replenished", ["run.until_s=3600", "rules.activate=backlog-threshold"], True),
    ],
)
def test_whoever_keeps_account_knows_what_is_read_anew(scenario: str, overrides: list[str], given: bool) -> None:
    """In whole runs: unlimited and finite stock, stations that close, and pods that are given SKUs anew."""
    keeper = Keeper()
    rmfs_core.run(scenario, overrides=overrides, observers=[keeper])
    assert keeper.checked > 50
    assert keeper.logs == 1
    assert (keeper.given > 0) == given
