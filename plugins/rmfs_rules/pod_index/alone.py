"""What is left of an order to an empty station, which takes nothing else."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rmfs_core import JointDecision, OrderAssignment, PodTrip
from rmfs_rules.helpers import ticks_to_station

if TYPE_CHECKING:
    from rmfs_core.warehouse import Pod, WarehouseView
    from rmfs_rules.helpers.oversize import Oversize


def assign_alone(warehouse: WarehouseView, large: Oversize) -> JointDecision:
    """Assign all open lines of an order, and send the pods for them; nothing where free items are not enough.

    Pods that are stored or leaving a station are sent: again and again the one with most of the items that are still
    missing; the nearest of equals, then that of the lowest id.
    """
    order, station = large.order, large.station
    there = warehouse.available()[station.id]
    missing = {line.sku: max(line.quantity - int(there[line.sku]), 0) for line in order.open_lines}
    movable = {
        pod.id: pod for pod in (*warehouse.free_pods, *warehouse.leaving_pods) if station.id not in pod.bound_for
    }
    holding = {pod.id for sku, number in missing.items() if number for pod in warehouse.pods_with(sku)}
    able = [movable[pod] for pod in sorted(movable.keys() & holding)]
    trips = []

    def items(pod: Pod) -> int:
        """How many of the items that are missing a pod has."""
        return sum(min(pod.free_items(sku), number) for sku, number in missing.items() if sku in pod.contents)

    while any(missing.values()):
        best = min(able, key=lambda pod: (-items(pod), ticks_to_station(warehouse, pod, station), pod.id), default=None)
        if best is None or not items(best):
            return JointDecision()
        trips.append(PodTrip(best.id, station.id))
        able.remove(best)
        for sku, number in missing.items():
            if sku in best.contents:
                missing[sku] = max(number - best.free_items(sku), 0)
    return JointDecision([OrderAssignment(order.id, station.id)], trips)
