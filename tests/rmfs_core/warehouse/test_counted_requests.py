"""Items of a line are counted, not kept one by one: with the same promises, and no more work for long lines."""

import random
import sys
from itertools import pairwise
from types import FrameType
from typing import Any

import pytest
from attrs import define

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import Warehouse
from rmfs_core.warehouse.promises import next_request
from standing import put_at_station


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
        for pod in (first, second):
            while number_left(station.open_items, quantity, pod is first) and (request := next_request(station, pod)):
                world.fulfil(request, pod)
    finally:
        sys.setprofile(None)
    assert station.open_items == quantity - 50
    return number


def number_left(left: int, quantity: int, first: bool) -> int:
    return left - (quantity - 30 if first else quantity - 50)


def test_a_pick_of_a_long_line_is_no_more_work() -> None:
    """As many calls with 1,000,000 items to come as with 100."""
    assert calls(1_000_000) == calls(100)
