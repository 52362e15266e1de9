"""Active repositioning besides locations and worth: targets, and a pause when all is done."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from attrs import define, field

from rmfs_core import PodMove

if TYPE_CHECKING:
    from rmfs_core.warehouse import Robot, WarehouseView
    from rmfs_rules.classes.locations import Ids


@define(eq=False)
class Pause:
    """Lets some time pass when there was nothing to move."""

    _until_s: float | None = field(init=False, default=None)
    _robots: tuple[Robot, ...] = field(init=False, default=())  # whose run it is

    def after(self, warehouse: WarehouseView, retry_s: float, moves: Callable[[], list[PodMove]]) -> list[PodMove]:
        """Return the moves there are; none during a pause, which begins when there are none."""
        if self.until_s(warehouse) is not None:
            return []
        found = moves()
        self.begin(warehouse, None if found else warehouse.now_s + retry_s)
        return found

    def begin(self, warehouse: WarehouseView, until_s: float | None) -> None:
        """Pause until a time; None: no longer."""
        self._robots, self._until_s = warehouse.robots, until_s

    @property
    def told(self) -> float | None:
        """When it is over, or was."""
        return self._until_s

    def until_s(self, warehouse: WarehouseView) -> float | None:
        """Return when the pause is over; None when there is none."""
        pausing = self._robots is warehouse.robots and self._until_s is not None and self._until_s > warehouse.now_s
        return self._until_s if pausing else None


def nearest_to(warehouse: WarehouseView, cell: int, cells: Ids) -> int:
    """Return the cell with the shortest loaded drive from another, the robot facing as it likes; ties: the first."""
    times = [warehouse.travel.times_from(cell, heading, True)[cells] for heading in range(4)]
    return int(cells[np.min(times, axis=0).argmin()])
