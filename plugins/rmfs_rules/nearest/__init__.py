"""Rule ``nearest``, for PR and for the packing stations of orders."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from attrs import define

from rmfs_core import hookimpl
from rmfs_rules.helpers import nearest_free_location
from rmfs_rules.helpers.packing import bound_for

if TYPE_CHECKING:
    from rmfs_core.warehouse import Order, Pod, WarehouseView


@define
class Nearest:
    """Store a pod in the nearest free storage location; send an order to the nearest packing station.

    The storage location is the one with the shortest loaded driving time from where the pod is, turns included; ties
    go to the lowest cell index. The packing station is the one to which conveyors take the parts that are assigned so
    far in the least time, summed over these, if it has a free box for a split order; ties go as in `least-reserved`.

    References
    ----------
    L. Xie, N. Thieme, R. Krenzler, H. Li: Efficient order picking methods in robotic mobile fulfillment systems.
    arXiv:1902.03092, 2019. https://arxiv.org/abs/1902.03092

    M. Merschformann, T. Lamballais, R. de Koster, L. Suhl: Decision rules for robotic mobile fulfillment systems.
    Operations Research Perspectives 6, 100128, 2019. https://doi.org/10.1016/j.orp.2019.100128
    """

    @hookimpl
    def choose_storage_location(self, warehouse: WarehouseView, pod: Pod) -> int:
        """Choose the nearest free storage location."""
        return nearest_free_location(warehouse, pod)

    @hookimpl
    def assign_packing(self, warehouse: WarehouseView, orders: Sequence[Order]) -> Sequence[int]:
        """Choose by the time on conveyors."""
        return bound_for(warehouse, orders, lambda order, to: sum(to.conveyor_s[part.station] for part in order.parts))
