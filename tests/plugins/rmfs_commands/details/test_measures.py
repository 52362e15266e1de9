"""Percentiles and lateness, from hand-made events."""

from __future__ import annotations

import pytest
from attrs import evolve

from rmfs_commands.details.measures import Measures
from rmfs_commands.details.spans import Number
from rmfs_core.events import OrderAssigned, OrderCompleted, VisitStarted
from rmfs_core.info import RunInfo
from rmfs_core.world import Instance, OrderData

ORDERS = (
    OrderData("a", 0, ((0, 1),), due_tick=15_000),  # complete at 10 s: in time
    OrderData("b", 0, ((0, 3), (1, 1)), due_tick=15_000, priority=2),  # at 20 s: 5 s late
    OrderData("c", 10_000, ((0, 1),), due_tick=5_000),  # due before it arrives; at 40 s: 35 s late
    OrderData("d", 0, ((0, 1),)),  # never due; at 40 s
    OrderData("e", 0, ((0, 1),), due_tick=30_000),  # not complete at 50 s: late
    OrderData("f", 0, ((0, 1),), due_tick=60_000),  # not complete, but there is time
)


def values(run: RunInfo, orders: tuple[OrderData, ...] = ORDERS, begin_s: int = 0) -> dict[str, Number]:
    """Return the metrics of a run of 50 s in which the first four orders are assigned at 5 s or when they arrive."""
    measures = Measures(evolve(run, instance=Instance(("x", "y"), orders, ())), begin_s * 1000)
    for i, tick in enumerate((5_000, 5_000, 10_000, 5_000)):
        measures.handlers[OrderAssigned](OrderAssigned(tick, i, 0, (0,), 1, 1, complete=True))
    for visit, tick in enumerate((3_000, 30_000), 1):
        measures.handlers[VisitStarted](VisitStarted(tick, visit, robot=0, pod=0, station=0))
    for i, tick in enumerate((10_000, 20_000, 40_000, 40_000)):
        measures.handlers[OrderCompleted](OrderCompleted(tick, i))
    return measures.values(50_000)


def test_percentiles(tiny: RunInfo) -> None:
    """Turn-over times of 10, 20, 30 and 40 s; at stations 5, 15, 30 and 35 s of them."""
    found = values(tiny)
    assert (found["turnover_median_s"], found["turnover_p95_s"]) == (25.0, 38.5)
    assert (found["turnover_backlog_median_s"], found["turnover_backlog_p95_s"]) == (5.0, 5.0)
    assert (found["turnover_station_median_s"], found["turnover_station_p95_s"]) == (22.5, 34.25)
    assert found["items_per_line"] == 7 / 5
    assert found["orders_per_visit"] == 2.0


def test_lateness(tiny: RunInfo) -> None:
    """Of four orders that are complete or due, three are late; the completed ones by 0, 5 and 35 s."""
    found = values(tiny)
    assert (found["late_orders"], found["late_percent"], found["on_time_percent"]) == (3, 75.0, 25.0)
    assert found["tardiness_s"] == 40 / 3
    assert found["tardiness_p95_s"] == pytest.approx(32)
    priorities = {name: value for name, value in found.items() if "priority" in name}
    assert priorities == {"on_time_percent_priority_0": 100 / 3, "on_time_percent_priority_2": 0.0}


def test_no_order_is_due(tiny: RunInfo) -> None:
    """Then there is nothing to say about lateness."""
    assert not any(
        "late" in name or "time" in name for name in values(tiny, tuple(evolve(o, due_tick=None) for o in ORDERS))
    )


def test_a_warm_up(tiny: RunInfo) -> None:
    """Times are those of the one order that arrives after it; orders complete after it count per visit."""
    found = values(tiny, begin_s=10)
    assert (found["turnover_median_s"], found["late_orders"], found["tardiness_s"]) == (30.0, 1, 35.0)
    assert found["orders_per_visit"] == 4.0
