"""Filter waves."""

from __future__ import annotations

import numpy as np
import pytest

import rmfs_core
from rmfs_commands.testing import small_world
from rmfs_core import hookimpl
from rmfs_core.events import Event, OrderArrived, OrderAssigned
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.waves import Waves

ARRIVALS_S = (0, 10, 100, 130, 150, 200)


def world(now_s: float, arrivals_s: tuple[float, ...] = ARRIVALS_S) -> Warehouse:
    """Return a world in which orders have arrived by a time."""
    warehouse = small_world({}, {"p": ["a"]})
    known = small_world({str(i): ["a"] for i in range(len(arrivals_s))}, {"p": ["a"]})
    warehouse.orders = known.orders
    for order, arrival_s in zip(known.orders, arrivals_s, strict=True):
        if arrival_s <= now_s:
            warehouse.order_arrives(order, round(1000 * arrival_s))
    warehouse.advance(round(1000 * now_s))
    return warehouse


def released(rule: Waves, now_s: float) -> tuple[list[str], float | None]:
    """Return the names of the orders that are released at a time, and when the rule wants to wake up."""
    view = WarehouseView(world(now_s))
    return [order.name for order in rule.filter_backlog(view, view.orders)], rule.wake_at(view)


@pytest.mark.parametrize(
    ("now_s", "names", "wakes_s"),
    [
        (0, ["0"], None),
        (10, ["0"], 100),
        (99, ["0"], 100),
        (100, ["0", "1", "2"], None),  # what arrives with a wave belongs to it
        (150, ["0", "1", "2"], 200),
        (200, ["0", "1", "2", "3", "4", "5"], None),
        (230, ["0", "1", "2", "3", "4", "5"], None),
    ],
)
def test_waves_by_the_clock(now_s: float, names: list[str], wakes_s: float | None) -> None:
    """Every 100 s, and a round then if an order waits for it."""
    assert released(Waves(every_s=100), now_s) == (names, wakes_s)


@pytest.mark.parametrize(
    ("now_s", "names", "wakes_s"),
    [
        (10, ["0"], 1000),
        (100, ["0", "1", "2"], None),
        (130, ["0", "1", "2"], 1000),
        (150, ["0", "1", "2", "3", "4"], None),
    ],
)
def test_waves_by_number(now_s: float, names: list[str], wakes_s: float | None) -> None:
    """Two orders make a wave before its time."""
    assert released(Waves(every_s=1000, orders=2), now_s) == (names, wakes_s)


def test_behind_another_filter() -> None:
    """Only what that left is looked at."""
    view = WarehouseView(world(120))
    assert [order.name for order in Waves(every_s=100).filter_backlog(view, view.orders[1:2])] == ["1"]


class Waits:
    """Observer of when orders arrive and are assigned."""

    def __init__(self) -> None:
        self.arrived: dict[int, int] = {}
        self.assigned: dict[int, int] = {}

    @hookimpl
    def on_event(self, event: Event) -> None:
        """Note both."""
        if isinstance(event, OrderArrived):
            self.arrived[event.order] = event.tick
        if isinstance(event, OrderAssigned):
            self.assigned[event.order] = event.tick


def test_a_run_in_waves_is_complete() -> None:
    """No order is assigned before its wave, and the last wave is waited for."""
    overrides = ["instance.orders=30", "instance.arrivals={process='poisson', orders_per_hour=200}"]
    seen = Waits()
    result = rmfs_core.run(
        "examples/small", overrides=[*overrides, "rules.filters=[{rule='waves', every_s=120}]"], observers=[seen]
    )
    assert result.status == "complete"
    waves = {order: -(-tick // 120_000) * 120_000 for order, tick in seen.arrived.items()}
    assert all(seen.assigned[order] >= wave for order, wave in waves.items())
    assert np.mean([seen.assigned[order] == wave for order, wave in waves.items()]) > 0.3
