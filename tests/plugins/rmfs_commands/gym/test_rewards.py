"""Rewards by hand: what happened in a step of one minute."""

from __future__ import annotations

from typing import Any

import pytest

from rmfs_commands.gym import REWARDS, Step
from rmfs_core.events import OrderArrived, OrderCompleted, RobotMoved, VisitStarted
from rmfs_core.info import RunInfo

MINUTE = 60_000


@pytest.fixture
def step(tiny: RunInfo, monkeypatch: pytest.MonkeyPatch) -> Step:
    """From 60 s to 120 s: two visits, an order that comes at 90 s, one that is done at 100 s; 12 m, 8 m with a pod."""
    monkeypatch.setattr(type(tiny.warehouse), "now_tick", 2 * MINUTE)
    events: tuple[Any, ...] = (
        VisitStarted(70_000, 1, 0, 0, 0),
        OrderArrived(90_000, 3),
        RobotMoved(95_000, 90_000, 0, 1, 13, 0, 0, 0, 12, None),
        OrderCompleted(100_000, 1),
        VisitStarted(110_000, 2, 1, 1, 0),
        RobotMoved(115_000, 110_000, 0, 13, 21, 0, 0, 0, 8, 0),
    )
    return Step(events, tiny.warehouse, MINUTE, orders_open=2)


@pytest.mark.parametrize(
    ("name", "cost"),
    [
        ("visits", 2),
        ("turnover", (60 + 30 + 40) / 3600),  # one open all the time, one since 90 s, one until 100 s
        ("distance", 0.02),
    ],
)
def test_what_a_step_costs(step: Step, name: str, cost: float) -> None:
    """Visits that began, hours of open orders, kilometres with and without a pod."""
    assert REWARDS[name](step) == pytest.approx(-cost)
