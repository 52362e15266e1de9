"""What is in a robot's battery."""

from __future__ import annotations

import pytest

from rmfs_core.scenario.model import BatterySection
from rmfs_core.warehouse.battery import Battery

SECTION = BatterySection(capacity_wh=10, empty_w=100, idle_w=20, charging_w=500)
FULL_J = 36_000.0


class Clock:
    """Ticks that a test sets."""

    tick = 0


def battery(low_j: float = 0.0, charge: float = 1.0) -> tuple[Battery, Clock]:
    """Return a battery and its clock."""
    clock = Clock()
    return Battery(SECTION, low_j, lambda: clock.tick, charge), clock


def test_standing_takes_the_idle_draw() -> None:
    """20 W for 100 s."""
    one, _ = battery()
    assert one.left_j(100_000, charging=False) == FULL_J - 2000


def test_a_robot_that_stands_sleeps_where_it_has_no_more_than_it_keeps() -> None:
    """For the longest task: it comes down to that, and stays there; below it nothing is taken."""
    one, _ = battery(low_j=35_000)
    assert one.left_j(40_000, charging=False) == FULL_J - 800
    assert one.left_j(10_000_000, charging=False) == 35_000
    less, _ = battery(low_j=35_000, charge=0.5)
    assert less.left_j(10_000_000, charging=False) == FULL_J / 2


def test_work_is_counted_after_standing() -> None:
    """5 s of driving end at 25 s: 20 s of standing were before."""
    one, clock = battery()
    clock.tick = 25_000
    one.work(5_000, SECTION.empty_w, charging=False)
    assert one.left_j(25_000, charging=False) == FULL_J - 20 * 20 - 5 * 100


def test_a_charger_fills_it_and_no_more() -> None:
    """500 W; a full battery stays full."""
    one, clock = battery(charge=0.5)
    assert one.left_j(10_000, charging=True) == FULL_J / 2 + 5000
    assert one.left_j(10_000_000, charging=True) == FULL_J
    clock.tick = 12_000
    one.work(2_000, SECTION.empty_w, charging=True)
    assert one.left_j(12_000, charging=False) == pytest.approx(FULL_J / 2 + 5000 - 200)
