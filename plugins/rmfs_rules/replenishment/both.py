"""ROA and RPS together."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from attrs import define, field, validators

from rmfs_core import BundleAssignment, BundleDecision, StoreBundle, hookimpl
from rmfs_rules.helpers import StoragePods, cheapest, ticks_to_station
from rmfs_rules.helpers.parameters import parameter
from rmfs_rules.replenishment.pods import POD_RULES

if TYPE_CHECKING:
    from rmfs_core.warehouse import Station, WarehouseView
    from rmfs_core.world.travel import Travel


@define
class PodFirst:
    """Choose the pod of a bundle first, then a station for it: what one pod takes comes to one station.

    The oldest bundle chooses its pod as the rule ``pod`` does, driving times being those to the nearest station with a
    free slot. It goes to a station that this pod is at or bound for, else to the one with the shortest loaded driving
    time from where the pod is, of those with a free slot; ties go to the lowest id. A bundle that no pod can take goes
    to no station, so that it takes no slot there. Bundles that are at a station without a pod choose before.

    References
    ----------
    M. Merschformann, T. Lamballais, R. de Koster, L. Suhl: Decision rules for robotic mobile fulfillment systems.
    Operations Research Perspectives 6, 100128, 2019. https://doi.org/10.1016/j.orp.2019.100128

    RAWSim-O, https://github.com/merschformann/RAWSim-O: ``SamePodBundleManager``.
    """

    pod: str = parameter(
        "emptiest-pod",
        validators.in_(tuple(POD_RULES)),
        f"RPS rule whose choice of pods is taken, with its defaults: {', '.join(POD_RULES)}",
    )
    _rule: Any = field(init=False, repr=False, eq=False)

    def __attrs_post_init__(self) -> None:
        self._rule = POD_RULES[self.pod]()

    def prepare(self, travel: Travel) -> None:
        """Load what is compiled, or compile it."""
        self._rule.prepare(travel)

    @hookimpl
    def assign_bundles_and_pods(self, warehouse: WarehouseView, max_fetches: int) -> BundleDecision:
        """Choose pods, and then stations, until no slot is free."""
        stations, cost = warehouse.replenishment_stations, self._rule.cost
        pods = StoragePods(warehouse, max_fetches)
        free = {station.id: station.free_bundle_capacity for station in stations}
        going: dict[int, set[int]] = {}  # pods of this decision -> stations
        assignments, stores = [], []
        for station in stations:
            for bundle in station.bundles:
                if bundle.pod is None and (pod := cheapest(pods, bundle, cost, (station,))) is not None:
                    going.setdefault(pod, set()).add(station.id)
                    stores.append(StoreBundle(bundle.id, pod))
        for bundle in warehouse.bundles:
            able = [station for station in stations if free[station.id] > 0]
            if not able:
                break
            if (pod := cheapest(pods, bundle, cost, able)) is None:
                continue
            at = going.setdefault(pod, set())
            to = _station(warehouse, pod, able, at)
            at.add(to)
            free[to] -= 1
            assignments.append(BundleAssignment(bundle.id, to))
            stores.append(StoreBundle(bundle.id, pod))
        return BundleDecision(assignments, stores)


def _station(warehouse: WarehouseView, number: int, able: list[Station], going: set[int]) -> int:
    """Return the nearest station of those that a pod visits anyway, or that it is ``going`` to by now, or of all."""
    pod = warehouse.pods[number]
    there = [station for station in able if station.id in going or station.id in pod.bound_for] or able
    if len(there) == 1:
        return there[0].id
    return min(there, key=lambda station: (ticks_to_station(warehouse, pod, station), station.id)).id
