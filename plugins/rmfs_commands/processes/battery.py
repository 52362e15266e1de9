"""The batteries of a run's robots, and what they keep for the longest task and the way to a charger."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial

import numpy as np

from rmfs_core.clock import TICKS_PER_S
from rmfs_core.errors import InputError
from rmfs_core.scenario import Scenario
from rmfs_core.warehouse.battery import Battery
from rmfs_core.world import CellKind
from rmfs_core.world.travel import Travel


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
        needed = f"{joules / 3600:,.1f} Wh, which the longest task and the way to a charger may take"
        found = f"found {battery.capacity_wh:g}; expected more than {needed}"
        raise InputError("robots.battery.capacity_wh", found)
    return partial(Battery, battery, joules, way_j=way_j)
