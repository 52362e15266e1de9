"""POA rule ``first-come``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from attrs import define

from rmfs_core import OrderAssignment, hookimpl
from rmfs_rules.helpers.kept_options import KeptPairs

if TYPE_CHECKING:
    from rmfs_core.warehouse import WarehouseView


@define
class FirstCome(KeptPairs):
    """Assign the oldest order first.

    The oldest order that fits anywhere goes to the station with the lowest load where it fits (ties: lowest id). When
    the oldest order fits nowhere, the next oldest that does is assigned. This is repeated until nothing fits.

    References
    ----------
    M. Merschformann, T. Lamballais, R. de Koster, L. Suhl: Decision rules for robotic mobile fulfillment systems.
    Operations Research Perspectives 6, 100128, 2019. https://doi.org/10.1016/j.orp.2019.100128
    """

    @hookimpl
    def assign_orders(self, warehouse: WarehouseView, rng: np.random.Generator) -> Sequence[OrderAssignment]:
        """Assign orders by age: all pairs score the same, and ties go to the oldest order."""
        if self.keeps(warehouse):
            return self.assign_kept(warehouse, rng)
        same = np.zeros(len(warehouse.backlog), dtype=np.int64)
        return self.assign(warehouse, rng, lambda _: same)
