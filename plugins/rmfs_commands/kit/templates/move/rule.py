"""repositioning rule ``the-rule``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from attrs import define
from rmfs import PodMove, hookimpl

if TYPE_CHECKING:
    from rmfs.warehouse import Pod, WarehouseView


@define
class TheRule:
    """Carry pods that are wanted to free locations nearer to a station.

    The pod with the most items that are wanted goes first, to the free storage location from which the drive to a
    station is shortest, if that is shorter than from where the pod is. Ties go to the lowest id and cell index.
    """

    @hookimpl
    def move_pods(self, warehouse: WarehouseView, max_moves: int) -> Sequence[PodMove]:
        """Pair wanted pods with the best free locations."""
        demand = warehouse.open_demand()
        tables = [warehouse.travel.times_to(station.cell, True) for station in warehouse.stations]

        def drive(cell: int) -> int:
            return min(int(table[cell].min()) for table in tables)

        def wanted(pod: Pod) -> int:
            return sum(min(int(demand[sku]), pod.free_items(sku)) for sku in pod.contents)

        pods = [pod for pod in warehouse.free_pods if pod.robot is None and wanted(pod)]
        places = sorted(warehouse.free_storage_locations, key=lambda cell: (drive(cell), cell))
        pairs = zip(sorted(pods, key=lambda pod: (-wanted(pod), pod.id)), places, strict=False)
        moves = [PodMove(pod.id, cell) for pod, cell in pairs if drive(cell) < drive(pod.cell)]
        return moves[:max_moves]
