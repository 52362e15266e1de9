"""ROA: which station a bundle is assigned to."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from attrs import define

from rmfs_core import BundleAssignment, hookimpl

if TYPE_CHECKING:
    from rmfs_core.warehouse import Bundle, Station, WarehouseView


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
        return _one_by_one(warehouse, lambda _, able: able[0])


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
        new = max((pod.free_space for pod in warehouse.free_pods), default=0)
        room = {station: _room_in_mind(station, new) for station in warehouse.replenishment_stations}

        def station_for(bundle: Bundle, able: Sequence[Station]) -> Station:
            fitting = [station for station in able if room[station] >= bundle.size]
            station = min(fitting, key=lambda station: (room[station], station.id), default=able[0])
            room[station] = (room[station] if fitting else new) - bundle.size
            return station

        return _one_by_one(warehouse, station_for)


def _one_by_one(
    warehouse: WarehouseView, station_for: Callable[[Bundle, Sequence[Station]], Station]
) -> list[BundleAssignment]:
    """Assign bundles, oldest first, until no slot is free: each to one of the stations with a free slot.

    ``station_for`` chooses it; it is given them by their load, then by their ids.
    """
    load = {station: len(station.bundles) for station in warehouse.replenishment_stations}
    assignments: list[BundleAssignment] = []
    for bundle in warehouse.bundles:
        able = [station for station in load if load[station] < station.bundle_capacity]
        if not able:
            break
        able.sort(key=lambda station: (load[station], station.id))
        station = station_for(bundle, able)
        load[station] += 1
        assignments.append(BundleAssignment(bundle.id, station.id))
    return assignments


def _room_in_mind(station: Station, new: int) -> int:
    """Return what the bundles at a station without a pod leave of the space in mind; they may have begun new pods."""
    room = max((pod.free_space for pod in station.inbound_pods), default=0)
    for bundle in station.bundles:
        if bundle.pod is None:
            room = (room if room >= bundle.size else new) - bundle.size
    return room
