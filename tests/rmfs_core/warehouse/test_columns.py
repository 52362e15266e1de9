"""Columns against the objects that they follow; items of a line are counted, not kept one by one."""

import math
import random
import sys
from collections import Counter
from collections.abc import Sequence
from itertools import pairwise
from types import FrameType
from typing import Any

import numpy as np
import pytest
from attrs import define
from hypothesis import Phase, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, precondition, rule, run_state_machine_as_test

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import BUSY, STORED, Lines, Order, Pod, Stock, Warehouse, WarehouseView, column_keeping
from rmfs_core.warehouse.backlog import Backlog
from rmfs_core.warehouse.claims import Claims
from rmfs_core.warehouse.parts import UNLIMITED, put
from rmfs_core.warehouse.promises import next_request
from standing import put_at_station

SKUS = "abcd"


def tell(lines: Lines) -> list[tuple[int, float, float, list[tuple[int, int]]]]:
    return [
        (lines.order_id.item(at), lines.arrival_s.item(at), lines.due_s.item(at), lines.of_order(at))
        for at in np.flatnonzero(lines.open_lines).tolist()
    ]


def hold_lines(lines: Lines, orders: Sequence[Order]) -> None:
    due_s = [math.inf if order.due_s is None else order.due_s for order in orders]
    told = [(order.id, order.arrival_s, due, [*order.open_lines]) for order, due in zip(orders, due_s, strict=True)]
    assert tell(lines) == told
    rows = [int(lines.row[order.id]) for order in orders]
    assert rows == np.flatnonzero(lines.open_lines).tolist()
    assert lines.priority[rows].tolist() == [order.priority for order in orders]
    assert lines.items[rows].tolist() == [order.open_items for order in orders]
    assert lines.open_lines[rows].tolist() == [len(order.open_lines) for order in orders]
    assert lines.items.sum() == lines.quantity.sum()
    assert lines.begun.tolist() == [rows[i] for i, one in enumerate(orders) if len(one.open_lines) < len(one.lines)]
    for sku in range(len(lines.first)):
        there = slice(lines.first[sku], lines.first[sku] + lines.number[sku])
        listed = [*zip(lines.listed_order[there].tolist(), lines.listed_items[there].tolist(), strict=True)]
        assert listed == [
            (row, line.quantity)
            for row, order in zip(rows, orders, strict=True)
            for line in order.open_lines
            if line.sku == sku
        ]


def hold_stock(stock: Stock, world: Warehouse) -> None:
    free = [(pod.id, sku, pod.free_items(sku)) for pod in world.pods for sku in sorted(pod.contents)]
    assert [*zip(stock.pod.tolist(), stock.sku.tolist(), stock.items.tolist(), strict=True)] == free
    assert [int(end - begin) for begin, end in zip(stock.of_pod, stock.of_pod[1:], strict=False)] == [
        len(pod.contents) for pod in world.pods
    ]
    by_sku = sorted((sku, pod, items) for pod, sku, items in free)
    there = stock.by_sku
    assert [
        *zip(stock.sku[there].tolist(), stock.pod[there].tolist(), stock.items[there].tolist(), strict=True)
    ] == by_sku
    assert np.diff(stock.of_sku).tolist() == [sum(sku == i for sku, *_ in by_sku) for i in range(world.n_skus)]
    leaving = world.leaving_pods()

    def at(pod: Pod) -> int:
        if pod in leaving:
            return pod.bound_for[0]
        return STORED if pod.location is not None and not pod.bound_for else BUSY

    assert stock.at.tolist() == [at(pod) for pod in world.pods]
    assert stock.bound.tolist() == [
        ([-1] + [i for i in pod.bound_for if i < len(world.picking)])[-1] for pod in world.pods
    ]
    assert stock.location.tolist() == [-1 if pod.location is None else pod.location for pod in world.pods]
    assert stock.space.tolist() == [pod.free_space for pod in world.pods]
    sent = [pod.id for pod in world.pods if at(pod) != BUSY]
    assert stock.cell[sent].tolist() == [world.pods[pod].cell for pod in sent]


def hold_books(world: Warehouse) -> None:
    """Compare loads, demand and sizes with what orders and requests amount to."""
    orders, backlog = world.arrived.values(), world.backlog
    parts = [part for order in orders for part in order.parts]
    assert len(parts) == len({(part.order.id, part.station, part.period) for part in parts})
    for station in world.stations:
        load = sum(part.items for part in parts if part.station == station.id and part.unpicked_items)
        assert (station.load, station.free_capacity) == (load, max(station.capacity - load, 0))
    assert world.split_orders_open == sum(order.split and not order.complete for order in orders)
    wanted, ordered = Counter[int](), Counter[int]()
    for order in orders:
        assert sorted(order.stations) == sorted({part.station for part in order.parts})
        ordered.update(dict(order.lines))
        wanted.update(dict(order.open_lines))
    promised = Counter[tuple[int, int]]()
    for request in (request for station in world.stations for request in station.open_requests):
        wanted[request.sku] += request.items
        if request.pod is not None:
            promised[request.pod.id, request.sku] += request.items
    for pod in world.pods:
        for sku, items in pod.contents.items():
            free = UNLIMITED if items == UNLIMITED else items - promised[pod.id, sku]
            assert pod.free_items(sku) == free >= 0
    assert world.open_demand.tolist() == [wanted[sku] for sku in range(world.n_skus)]
    assert world.ordered.tolist() == [ordered[sku] for sku in range(world.n_skus)]
    assert [order.id for order in backlog.orders] == [
        order.id
        for order in world.orders
        if order.id in world.arrived and order.open_lines and not order.waits_for_stock
    ]
    assert backlog.sizes == Counter(order.open_items for order in backlog)
    assert backlog.line_sizes == Counter(line.quantity for order in backlog for line in order.open_lines)


class Run(RuleBasedStateMachine):
    @initialize(
        orders=st.lists(
            st.dictionaries(st.sampled_from(SKUS), st.integers(1, 3), min_size=1, max_size=3), min_size=9, max_size=40
        ),
        pods=st.lists(st.dictionaries(st.sampled_from(SKUS[:3]), st.integers(1, 3)), min_size=2, max_size=5),
        finite=st.sampled_from([True, True, False]),
        due=st.booleans(),
    )
    def begin(self, orders: list[dict[str, int]], pods: list[dict[str, int]], finite: bool, due: bool) -> None:
        named = {str(i): lines for i, lines in enumerate([*orders, dict.fromkeys(SKUS, 1)])}
        held = {str(i): pod if finite else [*pod] for i, pod in enumerate(pods)}
        self.world = small_world(
            named, held, capacities=[40, 40], bundle_capacity=9, pod_capacity=40, due_s={"0": 7.5} if due else None
        )
        self.world.backlog = Backlog(self.world.n_skus)
        self.world.arrived.clear()
        self.world.open_demand[:] = self.world.ordered[:] = 0
        if finite:
            self.world.claims = Claims(self.world.pods)
        self.coming = [*self.world.orders]
        for order in self.world.orders[::3]:
            put(order, "priority", 1)
        self.seen: dict[object, object] = {}
        self.period = 1

    @rule(number=st.integers(1, 20), tick=st.integers(0, 3))
    @precondition(lambda self: self.coming)
    def arrive(self, number: int, tick: int) -> None:
        self.world.advance(self.world.now + tick)
        for order in self.coming[:number]:
            self.world.order_arrives(order, self.world.now)
        del self.coming[:number]

    @rule(which=st.integers(0, 99), lines=st.integers(1, 3), at=st.integers(0, 1), later=st.booleans())
    @precondition(lambda self: len(self.world.backlog))
    def assign(self, which: int, lines: int, at: int, later: bool) -> None:
        self.period += later
        order = self.world.backlog.orders[which % len(self.world.backlog)]
        skus = [line.sku for line in order.open_lines[:lines]]
        self.world.assign(order, self.world.stations[at], skus, self.period)

    @rule(number=st.integers(5, 30))
    @precondition(lambda self: len(self.world.backlog))
    def assign_all(self, number: int) -> None:
        for order in self.world.backlog.orders[:number]:
            self.world.assign(order, self.world.stations[0], [line.sku for line in order.open_lines], self.period)

    @rule(which=st.integers(0, 99))
    def cancel(self, which: int) -> None:
        able = [order for order in self.world.arrived.values() if order.open_lines and not order.parts]
        if able:
            order = able[which % len(able)]
            freed = [] if order.waits_for_stock else order.open_lines
            waiting, claims = WarehouseView(self.world).orders_waiting_for_stock, self.world.claims
            before, wanted = Counter(claims.unclaimed if claims else ()), self.world.open_demand.copy()
            served = self.world.cancel(order)
            assert [one for one in waiting if one in served] == [*served]
            assert order not in self.world.backlog
            wanted[[sku for sku, _ in order.lines]] -= [items for _, items in order.lines]
            assert self.world.open_demand.tolist() == wanted.tolist()
            if claims is not None:
                before.update(dict(freed))
                for one in served:
                    before.subtract(dict(one.lines))
                assert Counter(claims.unclaimed) == before
                assert all(claims.lacking(one) is not None for one in claims.waiting.values())

    @rule(which=st.integers(0, 9), at=st.integers(0, 1))
    def bind(self, which: int, at: int) -> None:
        pod, station = self.world.pods[which % len(self.world.pods)], self.world.stations[at]
        if station.id not in pod.bound_for:
            self.world.bind(pod, station)

    @rule(which=st.integers(0, 9))
    @precondition(lambda self: self.world.robots[0].task is None)
    def stand(self, which: int) -> None:
        pod = self.world.pods[which % len(self.world.pods)]
        if not pod.bound_for:
            put_at_station(self.world, pod.id)

    @rule(number=st.integers(1, 4))
    @precondition(lambda self: self.world.stations[0].line)
    def pick(self, number: int) -> None:
        robot, station = self.world.stations[0].line[0], self.world.stations[0]
        pod = self.world.pods[robot.task or 0]
        self.period += 1
        for _ in range(number):
            if (request := next_request(station, pod)) is None:
                self.world.leave(robot, pod, station)
                break
            self.world.fulfil(request, pod)
            hold_books(self.world)

    @rule(which=st.integers(0, 99))
    @precondition(lambda self: self.world.stations[0].line)
    def secure(self, which: int) -> None:
        station, pod = self.world.stations[0], self.world.pods[self.world.robots[0].task or 0]
        able = [request for request in station.open_requests if request.pod and request.sku in pod.contents]
        if able and pod.contents[able[which % len(able)].sku]:
            self.world.promises.secure(able[which % len(able)], pod)

    @rule()
    @precondition(lambda self: self.world.robots[0].task is not None and not self.world.stations[0].line)
    def put_down(self) -> None:
        robot, cell = self.world.robots[0], self.world.free_locations[0]
        self.world.reserve(cell)
        self.world.move(robot, cell, 0)
        self.world.store(robot, self.world.pods[robot.task or 0])

    @rule(which=st.integers(0, 9), sku=st.integers(0, 3), lacking=st.booleans(), items=st.integers(1, 5))
    @precondition(lambda self: not self.world.unlimited_stock)
    def store(self, which: int, sku: int, lacking: bool, items: int) -> None:
        pod = self.world.pods[which % len(self.world.pods)]
        missing = self.world.claims.missing if lacking and self.world.claims is not None else []
        bundle = self.world.bundle_arrives((missing or [sku % self.world.n_skus])[0], items)
        self.world.assign_bundle(bundle, self.world.stations[1])
        self.world.bind_bundle(bundle, pod)
        self.world.store_bundle(bundle, pod)

    @rule()
    def look(self) -> None:
        view = WarehouseView(self.world)
        hold_books(self.world)
        hold_lines(view.lines, view.backlog)
        flat = view.backlog_lines
        lines = view.lines
        open_lines = lines.quantity > 0
        assert lines.order_id[lines.order[open_lines]].tolist() == flat.order_id.tolist()
        assert (lines.sku[open_lines].tolist(), lines.quantity[open_lines].tolist()) == (
            flat.sku.tolist(),
            flat.quantity.tolist(),
        )
        some = view.showing(view.backlog[::2])
        hold_lines(some.lines, some.backlog)

        hold_stock(view.stock, self.world)
        for sku in range(view.n_skus):
            assert [*view.pods_with(sku)] == [pod for pod in self.world.pods if sku in pod.contents]
        free, stock = view.free_items, view.stock
        assert (free.pod.tolist(), free.sku.tolist()) == (stock.pod.tolist(), stock.sku.tolist())
        assert free.number.tolist() == stock.items.tolist()
        assert view.capacities.tolist() == [
            (one.free_capacity, one.load, one.capacity, one.counts_orders, len(one.inbound_pods))
            for one in view.stations
        ]
        assert view.available().tolist() == [
            [sum(pod.free_items(sku) for pod in station.inbound_pods) for sku in range(view.n_skus)]
            for station in view.stations
        ]
        at = [pod for pod in stock.at.tolist() if pod < 0]
        what = (
            tell(lines),
            view.capacities.tolist(),
            view.available().tolist(),
            stock.items.tolist(),
            at,
            stock.bound.tolist(),
        )
        assert self.seen.setdefault((view.version, view.leaving_pods), what) == what


def test_columns_are_the_objects(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(column_keeping, "SPARE", 0)
    run_state_machine_as_test(
        Run, settings=settings(max_examples=150, stateful_step_count=40, deadline=None, phases=[Phase.generate])
    )


@define(eq=False)
class Item:
    """An item that is still to be picked, and the pod that it is promised from."""

    number: int
    order: int
    sku: int
    period: int
    pod: int | None = None


class ItemByItem:
    """Promises as they are defined: for one item after another. Stations and pods by id, items oldest first."""

    def __init__(self, stock: list[dict[int, int]], stations: int) -> None:
        self.stock = [dict(held) for held in stock]
        self.bound: list[list[int]] = [[] for _ in stock]
        self.inbound: list[list[int]] = [[] for _ in range(stations)]
        self.items: list[list[Item]] = [[] for _ in range(stations)]
        self.made = 0

    def free(self, pod: int, sku: int) -> int:
        return self.stock[pod].get(sku, 0) - sum(i.pod == pod and i.sku == sku for items in self.items for i in items)

    def assign(self, order: int, lines: list[tuple[int, int]], station: int, period: int) -> None:
        for sku, quantity in lines:
            for _ in range(quantity):
                item = Item(self.made, order, sku, period)
                self.made += 1
                self.items[station].append(item)
                self.cover(item, station, set())

    def bind(self, pod: int, station: int) -> None:
        self.bound[pod].append(station)
        self.inbound[station].append(pod)
        self.promise(pod, station)

    def promise(self, pod: int, station: int) -> None:
        for item in self.items[station]:
            if item.pod is None and self.free(pod, item.sku) > 0:
                item.pod = pod

    def cover(self, item: Item, station: int, tried: set[int]) -> bool:
        """Promise an item a free one, or one promised elsewhere that another pod can serve."""
        pods = [pod for pod in self.inbound[station] if item.sku in self.stock[pod] and pod not in tried]
        for pod in pods:
            if self.free(pod, item.sku) > 0:
                item.pod = pod
                return True
        for pod in pods:
            tried.add(pod)
            for other in self.bound[pod]:
                same = (i for i in self.items[other] if i.pod == pod and (i.sku, i.period) == (item.sku, item.period))
                if other != station and (moved := next(same, None)) is not None:
                    moved.pod = None
                    if self.cover(moved, other, tried):
                        item.pod = pod
                        return True
                    moved.pod = pod
        return False

    def pick(self, pod: int, station: int) -> None:
        """Pick the oldest item that a pod can serve, not with what it promised elsewhere."""
        for item in self.items[station]:
            here = sum(i.pod == pod and i.sku == item.sku for i in self.items[station])
            if self.free(pod, item.sku) + here > 0:
                break
        else:
            return
        had = item.pod
        if had != pod:
            younger = next((i for i in self.items[station] if i.sku == item.sku and i.pod == pod), None)
            item.pod = pod
            if younger is not None:
                younger.pod = had
            elif had is not None:
                for at in self.bound[had]:
                    self.promise(had, at)
        self.items[station].remove(item)
        self.stock[pod][item.sku] -= 1

    def told(self) -> list[tuple[int, int, int, int, int | None]]:
        return [(at, i.number, i.order, i.sku, i.pod) for at, items in enumerate(self.items) for i in items]


def told(world: Warehouse) -> list[tuple[int, int, int, int, int | None]]:
    return [
        (station.id, request.id + i, request.order.id, request.sku, None if request.pod is None else request.pod.id)
        for station in world.stations
        for request in station.open_requests
        for i in range(request.items)
    ]


@pytest.mark.parametrize("seed", range(40))
def test_promises_are_those_of_items_one_by_one(seed: int) -> None:
    rng = random.Random(seed)
    stock = [
        {sku: rng.randint(1, 9) for sku in "abc" if rng.random() < 0.6} or {"a": 3} for _ in range(rng.randint(1, 5))
    ]
    there = sorted({sku for held in stock for sku in held})
    orders = [{sku: rng.randint(1, 8) for sku in there if rng.random() < 0.6} or {there[0]: 2} for _ in range(6)]
    stations = rng.randint(1, 3)
    world = small_world(
        {str(i): wanted for i, wanted in enumerate(orders)},
        {str(i): held for i, held in enumerate(stock)},
        capacities=[200] * stations,
    )
    literal, period = ItemByItem([dict(pod.contents) for pod in world.pods], stations), 1
    for _ in range(40):
        step, station = rng.choice(["assign", "bind", "pick", "pick", "pick", "period"]), rng.choice(world.stations)
        pod = rng.choice(station.inbound_pods if step == "pick" and station.inbound_pods else world.pods)
        if step == "assign" and world.backlog:
            order = rng.choice(world.backlog.orders)
            lines = [*order.open_lines][: rng.randint(1, 3)]
            part = order.part_of(station.id, period)
            period += part is not None and not part.unpicked_items  # what is picked is of an earlier period
            world.assign(order, station, [sku for sku, _ in lines], period)
            literal.assign(order.id, [*map(tuple, lines)], station.id, period)  # type: ignore[arg-type]
        elif step == "bind" and station.id not in pod.bound_for:
            world.bind(pod, station)
            literal.bind(pod.id, station.id)
        elif step == "pick" and pod in station.inbound_pods:
            for _ in range(rng.randint(1, 4)):
                if (request := next_request(station, pod)) is not None:
                    world.fulfil(request, pod)
                literal.pick(pod.id, station.id)
        period += step == "period"
        hold_books(world)
        assert told(world) == literal.told()
        for at in world.stations:
            for one, other in pairwise(at.open_requests):
                alike = (one.part, one.sku, one.pod) == (other.part, other.sku, other.pod)
                assert not (alike and one.id + one.items == other.id)
            pods = [item[-1] for item in literal.told() if item[0] == at.id]
            assert (at.open_items, at.uncovered_items) == (len(pods), pods.count(None))


def calls(quantity: int) -> int:
    """Return how many functions are called until 50 items of a line of so many are picked."""
    world = small_world({"1": {"a": quantity}}, {"p": {"a": 30}, "q": {"a": quantity}}, capacities=[quantity])
    station, (first, second) = world.stations[0], world.pods
    number = 0

    def count(_frame: FrameType, event: str, _argument: Any) -> None:
        nonlocal number
        number += event in ("call", "c_call")

    put_at_station(world, first.id)
    sys.setprofile(count)
    try:
        world.assign(world.orders[0], station, [0])
        world.bind(second, station)
        for pod, picks in ((first, 30), (second, 20)):
            for _ in range(picks):
                world.fulfil(next_request(station, pod), pod)
    finally:
        sys.setprofile(None)
    assert station.open_items == quantity - 50
    return number


def test_a_pick_of_a_long_line_is_no_more_work() -> None:
    assert calls(1_000_000) == calls(100)
