"""POA rules ``earliest-due`` and ``least-slack``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from attrs import define

from rmfs_core import OrderAssignment, hookimpl
from rmfs_rules.helpers.pairs import LaneOptions
from rmfs_rules.helpers.parameters import NOT_NEGATIVE, parameter

if TYPE_CHECKING:
    from rmfs_core.warehouse import WarehouseView


@define
class EarliestDue(LaneOptions):
    """Assign the order that is due first.

    Of the orders that fit anywhere, the one with the earliest due time goes to the station with the lowest load where
    it fits (ties: lowest id). Orders without a due time come last; ties go to the oldest. This is repeated until
    nothing fits.

    References
    ----------
    J. R. Jackson: Scheduling a production line to minimize maximum tardiness. Management Sciences Research Project,
    Research Report 43, University of California, Los Angeles, 1955.

    M. Merschformann, T. Lamballais, R. de Koster, L. Suhl: Decision rules for robotic mobile fulfillment systems.
    Operations Research Perspectives 6, 100128, 2019. https://doi.org/10.1016/j.orp.2019.100128
    """

    @hookimpl
    def assign_orders(self, warehouse: WarehouseView) -> Sequence[OrderAssignment]:
        """Assign orders by due time."""
        return self.assign_by(warehouse.lines.due_s, warehouse)


@define
class LeastSlack(LaneOptions):
    """Assign the order that has least time to spare.

    Of the orders that fit anywhere, the one with the lowest slack

        due time - now - item_s * (items that are open)

    goes to the station with the lowest load where it fits (ties: lowest id). Orders without a due time come last; ties
    go to the oldest. This is repeated until nothing fits. So of two orders that are due at the same time the larger
    goes first.

    References
    ----------
    S. S. Panwalkar, W. Iskander: A survey of scheduling rules. Operations Research 25(1), 45-61, 1977.
    https://doi.org/10.1287/opre.25.1.45 (slack as a priority)
    """

    item_s: float = parameter(
        13.0, NOT_NEGATIVE, "How long an item takes: by default, how long a picker is busy with one", "s"
    )

    @hookimpl
    def assign_orders(self, warehouse: WarehouseView) -> Sequence[OrderAssignment]:
        """Assign orders by slack; what time it is makes no difference between them."""
        lines = warehouse.lines
        return self.assign_by(lines.due_s - self.item_s * lines.items, warehouse)
