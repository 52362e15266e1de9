"""Rule ``first-come``, for POA and for the tasks of packers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from attrs import define

from rmfs_core import OrderAssignment, hookimpl
from rmfs_rules.helpers.pairs import PairOptions

if TYPE_CHECKING:
    import numpy as np

    from rmfs_core.warehouse import WarehouseView


@define
class FirstCome(PairOptions):
    """Assign the oldest order first; let packers do first what waits longest.

    As POA: the oldest order that fits anywhere goes to the station with the lowest load where it fits (ties: lowest
    id). When the oldest order fits nowhere, the next oldest that does is assigned. This is repeated until nothing fits.

    References
    ----------
    M. Merschformann, T. Lamballais, R. de Koster, L. Suhl: Decision rules for robotic mobile fulfillment systems.
    Operations Research Perspectives 6, 100128, 2019. https://doi.org/10.1016/j.orp.2019.100128
    """

    @hookimpl
    def assign_orders(self, warehouse: WarehouseView, rng: np.random.Generator) -> Sequence[OrderAssignment]:
        """Assign orders by age: all pairs score the same, and ties go to the oldest order."""
        return self.assign(warehouse, rng)

    @hookimpl
    def choose_packing_task(self) -> int:
        """Choose the task that waits longest."""
        return 0
