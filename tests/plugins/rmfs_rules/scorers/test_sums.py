"""Sums over what pods hold and what the backlog wants, against loops in plain Python."""

from __future__ import annotations

import numpy as np
import pytest

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import WarehouseView
from rmfs_rules.scorers.sums import completed, served


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
    view = WarehouseView(world)
    for order in world.orders[::3]:  # of which the last lines are left
        world.assign(order, world.stations[0], [order.open_lines[0].sku])
    wanted = rng.integers(0, 3, len(skus))
    orders_completed, value, served_items = np.zeros((3, 4))
    for rank, pod in enumerate(view.pods[::2]):
        left = {sku: max(pod.free_items(sku) - int(wanted[sku]), 0) for sku in pod.contents}
        at_work = dict(left)
        for order in view.backlog:
            if all(line.quantity <= left.get(line.sku, 0) for line in order.open_lines):
                orders_completed[rank] += 1
                for line in order.open_lines:
                    left[line.sku] -= line.quantity
            for line in order.open_lines:
                items = min(at_work.get(line.sku, 0), line.quantity)
                at_work[line.sku] = at_work.get(line.sku, 0) - items
                value[rank] += items * order.id / order.unpicked_items
                served_items[rank] += items
    half = np.arange(0, len(view.pods), 2)
    ones = np.ones(len(view.lines.items))
    assert completed(view.lines, view.stock, half, wanted, ones).tolist() == orders_completed.tolist()
    share = view.lines.order_id / [view.order(order).unpicked_items for order in view.lines.order_id.tolist()]
    assert served(view.lines, view.stock, half, wanted, share) == pytest.approx(value)
    assert served(view.lines, view.stock, half, wanted, ones).tolist() == served_items.tolist()
