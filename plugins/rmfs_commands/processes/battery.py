"""The batteries of a run's robots, and what they keep for the longest task and the way to a charger.

Why no robot strands is argued in the documentation, docs/explanation/batteries.md.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from math import ceil

import numpy as np

from rmfs_core.clock import TICKS_PER_S, to_seconds, to_ticks
from rmfs_core.errors import InputError
from rmfs_core.scenario import Scenario
from rmfs_core.scenario.model import BatterySection
from rmfs_core.world import CellKind
from rmfs_core.world.travel import Travel


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

    Attributes
    ----------
    charging
        Whether a charger charges it.
    """

    def __init__(
        self, section: BatterySection, low_j: float, clock: Callable[[], int], charge: float = 1.0, way_j: float = 0
    ) -> None:
        self.section, self.low_j, self.clock, self.way_j = section, low_j, clock, way_j
        self.capacity_j = section.capacity_wh * 3600
        self.joules, self.since, self.charging = charge * self.capacity_j, clock(), False

    def left_j(self, tick: int, charging: bool) -> float:
        """Return what is in it at a tick if the robot has stood since the last change."""
        seconds = to_seconds(tick - self.since)
        if charging:
            return min(self.joules + self.section.charging_w * seconds, self.capacity_j)
        return max(min(self.joules, self.low_j), self.joules - self.section.idle_w * seconds)

    def work(self, ticks: int, watts: float, charging: bool) -> None:
        """Note work that ends now, and standing before it; a floor may tell of less than that takes."""
        now = self.clock()
        self.joules, self.since = max(self.left_j(now - ticks, charging) - watts * to_seconds(ticks), 0.0), now

    @property
    def left_now_j(self) -> float:
        """Joules in it now."""
        return self.left_j(self.clock(), self.charging)

    @property
    def share(self) -> float:
        """Its charge now as a share of the capacity."""
        return self.left_now_j / self.capacity_j

    @property
    def low(self) -> bool:
        """Whether its charge is too low for a task. Standing does not make it so, only a charger ends it."""
        return self.joules < self.low_j and (not self.charging or self.left_now_j < self.low_j)

    @property
    def may_go_on(self) -> bool:
        """Whether there is enough in it to drive from a charger that fails to another one."""
        return self.left_now_j >= self.way_j

    def lift(self, ticks: int) -> None:
        """Note that lifting a pod, or setting it down, ends now."""
        self.work(ticks, self.section.lifting_w, charging=False)

    def drive(self, ticks: int, *, loaded: bool) -> None:
        """Note that driving and turning, with a pod or without, ends now."""
        self.work(ticks, self.section.loaded_w if loaded else self.section.empty_w, self.charging)

    def stand(self) -> None:
        """Note that standing ends now."""
        self.work(0, 0.0, self.charging)

    def ticks_to(self, share: float) -> int:
        """Ticks until it is so full, and full enough for a task; 0 where no charger charges it."""
        missing = max(share * self.capacity_j, self.low_j) - self.left_j(self.clock(), True)
        return to_ticks(max(missing, 0.0) / self.section.charging_w) + 1 if self.charging else 0


def battery_for_a_moment(share: float, *, low: bool) -> Battery:
    """Return a battery with this share of its capacity in it, for a moment in which no time passes."""
    battery = Battery(BatterySection(), 0.0, lambda: 0, share)
    battery.low_j = battery.joules + low
    return battery


def battery_of(scenario: Scenario, travel: Travel) -> Callable[[Callable[[], int]], Battery] | None:
    """Return what makes the robots' batteries; they keep what the longest task and the way to a charger take."""
    battery, layout = scenario.robots.battery, travel.layout
    if battery is None:
        return None
    lacking = [] if layout.chargers else ["a charger (`layout.chargers`, or `C` in a map)"]
    lacking += [] if scenario.rules.idle else ['a rule that sends robots there (rules.idle = "charge-when-low")']
    lacking += ["a number of seconds as `robots.lift_s`"] if hasattr(scenario.robots.lift_s, "spread") else []
    if lacking:
        raise InputError("robots.battery", f"expected {' and '.join(lacking)}")
    hub = layout.nearest({*np.flatnonzero(layout.kind == CellKind.FLOOR).tolist()}, layout.storage_locations)[0]

    def ticks(cells: Iterable[int], loaded: bool) -> int:
        """Longest drive to the hub."""
        return int(travel.times_to(hub, loaded)[list(cells)].max())

    def on(cell: int, loaded: bool) -> int:
        """Drive on from the hub."""
        return int(travel.times_to(cell, loaded)[hub].max())

    stored, chargers, stations = layout.storage_locations, layout.chargers, [cells.station for cells in layout.stations]
    aside = (*stored, *layout.maintenance)
    queues = max(len(cells.queue) for cells in layout.stations) * travel.motion.run_ticks(1)  # moving up, cell by cell
    farthest = [
        max(int(travel.times_from(hub, h, loaded)[list(cells)].max()) for h in range(4))
        for loaded, cells in ((False, aside), (True, stored))
    ]
    empty = ticks((*aside, *chargers), False) + farthest[0]
    empty += ticks(aside, False) + min(on(cell, False) for cell in chargers)
    between = ticks(chargers, False) + max(on(cell, False) for cell in chargers) if battery.charger_outages else 0
    way_j = battery.detour * battery.empty_w * between / TICKS_PER_S
    loaded = ticks(stored, True) + max(on(cell, True) for cell in stations) + ticks(stations, True) + farthest[1]
    watts = battery.empty_w * empty + battery.loaded_w * (loaded + queues)
    joules = battery.detour * watts / TICKS_PER_S + 2 * battery.lifting_w * scenario.robots.lift_s + way_j
    if joules >= 3600 * battery.capacity_wh:
        needed = f"{ceil(joules / 360) / 10:,.1f} Wh, which the longest task and the way to a charger may take"
        found = f"found {battery.capacity_wh:g}; expected more than {needed}"
        raise InputError("robots.battery.capacity_wh", found)
    return partial(Battery, battery, joules, way_j=way_j)
