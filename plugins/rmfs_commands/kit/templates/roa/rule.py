"""ROA rule ``the-rule``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from attrs import define, field, validators
from rmfs import BundleAssignment, hookimpl

if TYPE_CHECKING:
    from rmfs.warehouse import Bundle, WarehouseView


@define
class TheRule:
    """Assign the bundle first whose SKU is wanted most, to the station with the most free capacity.

    How much a SKU is wanted is its open demand per item in the bundle. So that nothing waits forever, bundles that
    have waited longer than ``patience_s`` go first, the oldest of them before the others.

    Parameters
    ----------
    patience_s
        How long a bundle may wait before it goes first (s).
    """

    patience_s: float = field(default=1800.0, validator=validators.ge(0))

    @hookimpl
    def assign_bundles(self, warehouse: WarehouseView) -> Sequence[BundleAssignment]:
        """Assign bundles until no capacity is free."""
        wanted = warehouse.open_demand()

        def rank(bundle: Bundle) -> tuple[bool, float, int]:
            patient = warehouse.now_s - bundle.arrival_s <= self.patience_s
            return patient, -wanted[bundle.sku] / bundle.items if patient else bundle.arrival_s, bundle.id

        free = {station.id: station.free_bundle_capacity for station in warehouse.replenishment_stations}
        chosen = []
        for bundle in sorted(warehouse.bundles, key=rank)[: sum(free.values())]:
            station = max(free, key=lambda station: (free[station], -station))
            free[station] -= 1
            chosen.append(BundleAssignment(bundle.id, station))
        return chosen
