"""PPS rule ``nearest-pod``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from attrs import define

from rmfs_core import PodTrip, hookimpl
from rmfs_rules.helpers.sending import ByStock, nearest, send

if TYPE_CHECKING:
    from rmfs_core.warehouse import WarehouseView


@define
class NearestPod(ByStock):
    """Send the nearest pod that can serve something.

    Among the pods not in use (or leaving a station with no next one) that can serve at least one uncovered request of
    the station, the one with the shortest loaded driving time to the station is sent; ties go to the lowest id. The
    station with the fewest inbound pods chooses first.

    References
    ----------
    M. Merschformann, T. Lamballais, R. de Koster, L. Suhl: Decision rules for robotic mobile fulfillment systems.
    Operations Research Perspectives 6, 100128, 2019. https://doi.org/10.1016/j.orp.2019.100128
    """

    @hookimpl
    def select_pods(self, warehouse: WarehouseView, max_fetches: int) -> Sequence[PodTrip]:
        """Send the nearest pods to the stations that lack one."""
        return send(warehouse, max_fetches, lambda stock, at, pods: nearest(warehouse, stock, pods, at))
