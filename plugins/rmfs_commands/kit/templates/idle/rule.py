"""idle rule ``the-rule``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

from attrs import define
from rmfs import RobotMove, hookimpl

if TYPE_CHECKING:
    from rmfs.warehouse import WarehouseView


@define
class TheRule:
    """Let robots rest where no pod stands, near the stations.

    A robot that rests under a pod goes to the free storage location from which the drive to a station is shortest.
    Ties go to the lowest cell index.
    """

    needs: ClassVar[tuple[str, ...]] = ("no batteries",)  # it sends none to a charger

    @hookimpl
    def idle_robots(self, warehouse: WarehouseView) -> Sequence[RobotMove]:
        """Send robots there, by id."""
        without_pod = {*warehouse.free_storage_locations}
        tables = [warehouse.travel.times_to(station.cell, True) for station in warehouse.stations]

        def drive(cell: int) -> tuple[int, int]:
            return min(int(table[cell].min()) for table in tables), cell

        free = sorted((cell for cell in warehouse.free_rest_cells if cell in without_pod), key=drive)
        beneath = [robot for robot in warehouse.idle_robots if robot.cell not in without_pod]
        return [RobotMove(robot.id, cell) for robot, cell in zip(beneath, free, strict=False)]
