"""Charge of a robot's battery. Why no robot strands is argued in the documentation, docs/explanation/batteries.md."""

from __future__ import annotations

from collections.abc import Callable

from rmfs_core.clock import to_seconds
from rmfs_core.scenario.model import BatterySection


class Battery:
    """Counts joules, from when to when the robot worked; all other time it has stood.

    Parameters
    ----------
    section
        Capacity and draws.
    low_j
        Energy for the longest task and the way to a charger: standing draws nothing of that.
    clock
        Simulated time in ticks.
    charge
        Charge at first, as a share of the capacity.
    way_j
        Energy for the way from one charger to another (J), where chargers fail.
    """

    def __init__(
        self, section: BatterySection, low_j: float, clock: Callable[[], int], charge: float = 1.0, way_j: float = 0
    ) -> None:
        self.section, self.low_j, self.clock, self.way_j = section, low_j, clock, way_j
        self.capacity_j = section.capacity_wh * 3600
        self.joules, self.since = charge * self.capacity_j, clock()

    def left_j(self, tick: int, charging: bool) -> float:
        """Return what is in it at a tick if the robot has stood since the last change."""
        seconds = to_seconds(tick - self.since)
        if charging:
            return min(self.joules + self.section.charging_w * seconds, self.capacity_j)
        return max(min(self.joules, self.low_j), self.joules - self.section.idle_w * seconds)

    def work(self, ticks: int, watts: float, charging: bool) -> None:
        """Note work that ends now, and standing before it."""
        now = self.clock()
        self.joules, self.since = self.left_j(now - ticks, charging) - watts * to_seconds(ticks), now
