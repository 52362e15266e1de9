"""What requests and the backlog want of pods."""

from __future__ import annotations

import numpy as np
import pytest

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import WarehouseView
from rmfs_rules.helpers.pod_completing import KeptCompleted
from rmfs_rules.helpers.pod_sending import KeptPods
from rmfs_rules.scorers.wanted import Backlog, Held, Requests


def test_requests_are_counted_by_order_and_sku() -> None:
    """The order that was assigned first is in the first row, though it is the younger one."""
    world = small_world({"old": {"b": 2, "c": 1}, "new": {"a": 1, "c": 1}}, {"p": ["a", "b", "c"]})
    for order in reversed(world.orders):
        world.assign(order, world.stations[0], [line.sku for line in order.open_lines])
    wanted = Requests.of(world.stations[0].uncovered_requests)
    assert wanted.skus.tolist() == [0, 1, 2]
    assert wanted.needs.tolist() == [[1, 0, 1], [0, 2, 1]]
    assert wanted.row.tolist() == [0, 0, 1, 1, 1]
    assert wanted.skus[wanted.column].tolist() == [request.sku for request in wanted.requests]
    assert wanted.worth(lambda order: order.items).tolist() == [2, 2, 3, 3, 3]


def test_no_requests() -> None:
    """Nothing is wanted."""
    assert Requests.of([]).needs.shape == (0, 0)


@pytest.mark.parametrize("seed", range(30))
@pytest.mark.parametrize("finite", [True, False])
def test_the_backlog_is_served_as_one_by_one(seed: int, finite: bool) -> None:
    """Orders and items of the oldest first, against a loop in plain Python, for half of the pods."""
    rng = np.random.default_rng(seed)
    skus = "abcdef"

    def some(most: int, number: int) -> dict[str, int]:
        chosen = rng.choice(list(skus), rng.integers(1, number), replace=False)
        return {str(sku): int(rng.integers(1, most)) for sku in chosen}

    orders = {str(i): some(4, 4) for i in range(int(rng.integers(0, 12)))}
    held = {str(i): some(7, 5) for i in range(6)} | {"all": dict.fromkeys(skus, 99)}
    pods = held if finite else {name: list(items) for name, items in held.items()}
    world = small_world(orders, pods)  # type: ignore[arg-type]
    view, account, pods_now = WarehouseView(world), KeptCompleted(), KeptPods()
    pods_now.update(view)
    account.alone(view, pods_now)
    kept, read = Backlog(lambda order: -order.id), Backlog(lambda order: -order.id)
    kept.update(view)
    for order in world.orders[::3]:  # of which the last lines are left
        world.assign(order, world.stations[0], [order.open_lines[0].sku])
    free = view.free_items
    some_pods = free.pod % 2 == 0
    items = Held(4, free.pod[some_pods] // 2, free.sku[some_pods], free.number[some_pods])
    completed, work = np.zeros(4), np.zeros(4)
    for rank, pod in enumerate(view.pods[::2]):
        left, at_work = dict(pod.contents), dict(pod.contents)
        for order in view.backlog:
            if all(line.quantity <= left.get(line.sku, 0) for line in order.open_lines):
                completed[rank] += 1
                for line in order.open_lines:
                    left[line.sku] -= line.quantity
            for line in order.open_lines:
                served = min(at_work.get(line.sku, 0), line.quantity)
                at_work[line.sku] = at_work.get(line.sku, 0) - served
                work[rank] += served * (1 + order.id / order.unpicked_items)
    pods_now.update(view)
    account.alone(view, pods_now)
    assert account.one_after_another(4, items.pod, items.sku, items.items).tolist() == completed.tolist()
    shown = {order.id for order in view.backlog}
    assert account.one_after_another(4, items.pod, items.sku, items.items, shown).tolist() == completed.tolist()
    assert not account.one_after_another(4, items.pod, items.sku, items.items, set()).any()
    kept.update(view)
    read.read(view)
    assert kept.work(items, 0.0, 1.0) == pytest.approx(work)
    assert read.work(items, 0.0, 1.0) == pytest.approx(work)
    in_part = [order for order in view.backlog if len(order.open_lines) < len(order.lines)]
    assert kept.whole == (not in_part)
