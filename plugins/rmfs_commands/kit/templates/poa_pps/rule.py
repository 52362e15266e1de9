"""Rule ``the-rule`` for POA and PPS together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

from attrs import define

from rmfs import JointDecision, OrderAssignment, PodTrip, hookimpl
from rmfs.helpers import ticks_to_station

if TYPE_CHECKING:
    from rmfs.warehouse import Order, Station, WarehouseView


@define
class TheRule:
    """Assign the oldest order that fits to the station where it needs the fewest new pods.

    For each SKU that no pod at or bound for the station holds, the nearest pod that does is sent. Each decision assigns
    one order; the rule is asked again as long as one more fits. Ties go to the station with the lowest id.
    """

    needs: ClassVar[tuple[str, ...]] = ("unlimited stock",)  # a pod that holds a SKU is taken to have enough of it

    @hookimpl
    def assign_orders_and_pods(self, warehouse: WarehouseView) -> JointDecision:
        """Assign one order, and send the pods it needs."""
        for order in warehouse.backlog:
            trips = {
                station.id: self._trips(warehouse, order, station)
                for station in warehouse.stations
                if warehouse.fits(order, station)
            }
            if trips:
                best = min(trips, key=lambda station: (len(trips[station]), station))
                return JointDecision([OrderAssignment(order.id, best)], trips[best])
        return JointDecision()

    def _trips(self, warehouse: WarehouseView, order: Order, station: Station) -> Sequence[PodTrip]:
        """Return the trips to a station that an order would need there."""
        there = {sku for pod in station.inbound_pods for sku in pod.contents}
        trips = []
        for line in order.open_lines:
            if line.sku not in there:
                pods = warehouse.pods_with(line.sku)
                nearest = min(pods, key=lambda pod: (ticks_to_station(warehouse, pod, station), pod.id))
                trips.append(PodTrip(nearest.id, station.id))
                there |= nearest.contents.keys()
        return trips
