"""PPS rule ``the-rule``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from attrs import define, field, validators
from rmfs import PodTrip, hookimpl, to_seconds
from rmfs.helpers import send_pods, ticks_to_station

if TYPE_CHECKING:
    from rmfs.warehouse import Pod, Station, WarehouseView


@define
class TheRule:
    """Send the pod that serves many requests after a short drive.

    The pod with the lowest ``drive_s - seconds_per_item * items`` is sent: its driving time to the station, less what
    the uncovered requests are worth that it can serve there. Ties go to the lowest id.

    Parameters
    ----------
    seconds_per_item
        How much longer a drive may be for one more request served (s).
    """

    seconds_per_item: float = field(default=20.0, validator=validators.ge(0))

    @hookimpl
    def select_pods(self, warehouse: WarehouseView, max_fetches: int) -> Sequence[PodTrip]:
        """Send pods one after another, the one with the lowest cost each time."""

        def cost(station: Station, pod: Pod, wanted: Mapping[int, int]) -> tuple[float, int]:
            items = sum(min(number, pod.free_items(sku)) for sku, number in wanted.items())
            drive_s = to_seconds(ticks_to_station(warehouse, pod, station))
            return drive_s - self.seconds_per_item * items, pod.id

        def choose(station: Station, pods: Sequence[Pod], wanted: Mapping[int, int]) -> Pod:
            return min(pods, key=lambda pod: cost(station, pod, wanted))

        return send_pods(warehouse, max_fetches, choose)  # wanted: items that no pod serves yet, by SKU
