"""ROA: which station a bundle is assigned to."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from attrs import define

from rmfs_core import BundleAssignment, hookimpl

if TYPE_CHECKING:
    from rmfs_core.warehouse import Station, WarehouseView


@define
class FirstBundle:
    """Assign the oldest bundle to the least loaded replenishment station, until no slot is free.

    The load is the number of bundles that are assigned and not stored; ties go to the lowest id.

    References
    ----------
    M. Merschformann, T. Lamballais, R. de Koster, L. Suhl: Decision rules for robotic mobile fulfillment systems.
    Operations Research Perspectives 6, 100128, 2019. https://doi.org/10.1016/j.orp.2019.100128
    """

    @hookimpl
    def assign_bundles(self, warehouse: WarehouseView) -> Sequence[BundleAssignment]:
        """Assign bundles, oldest first."""
        stations = warehouse.replenishment_stations
        free = {station.id: station.free_bundle_capacity for station in stations}
        load = {station.id: len(station.bundles) for station in stations}
        assignments: list[BundleAssignment] = []
        for bundle in warehouse.bundles:
            able = [station for station in free if free[station] > 0]
            if not able:
                break
            station = min(able, key=lambda station: (load[station], station))
            free[station] -= 1
            load[station] += 1
            assignments.append(BundleAssignment(bundle.id, station))
        return assignments


@define
class SamePod:
    """Assign bundles that one pod can take to the same station.

    Each station remembers the space of one pod: the largest free space on a pod at or bound for it, less the size of
    the bundles there that have no pod. The oldest bundle goes to the station, of those with a free slot, that has the
    least such space of those with enough of it. Where none has enough, the least loaded station begins a new pod: as
    much space as the emptiest stored pod has that is bound nowhere. Ties go to the lowest id; it ends when no slot is
    free.

    References
    ----------
    M. Merschformann, T. Lamballais, R. de Koster, L. Suhl: Decision rules for robotic mobile fulfillment systems.
    Operations Research Perspectives 6, 100128, 2019. https://doi.org/10.1016/j.orp.2019.100128. There, and in RAWSim-O
    (``SamePodBundleManager``), pods are chosen before stations, as ``pod-first`` does.
    """

    @hookimpl
    def assign_bundles(self, warehouse: WarehouseView) -> Sequence[BundleAssignment]:
        """Assign bundles, oldest first."""
        stations = {station.id: station for station in warehouse.replenishment_stations}
        free = {i: station.free_bundle_capacity for i, station in stations.items()}
        new = max((pod.free_space for pod in warehouse.free_pods), default=0)
        room = {i: _room_in_mind(station, new) for i, station in stations.items()}
        assignments: list[BundleAssignment] = []
        for bundle in warehouse.bundles:
            able = [i for i in free if free[i] > 0]
            if not able:
                break
            fitting = [i for i in able if room[i] >= bundle.size]
            if fitting:
                station = min(fitting, key=lambda i: (room[i], i))
            else:
                station = min(able, key=lambda i: (stations[i].bundle_capacity - free[i], i))
                room[station] = new
            free[station] -= 1
            room[station] -= bundle.size
            assignments.append(BundleAssignment(bundle.id, station))
        return assignments


def _room_in_mind(station: Station, new: int) -> int:
    """Return what the bundles at a station without a pod leave of the space in mind; they may have begun new pods."""
    room = max((pod.free_space for pod in station.inbound_pods), default=0)
    for bundle in station.bundles:
        if bundle.pod is None:
            room = (room if room >= bundle.size else new) - bundle.size
    return room
