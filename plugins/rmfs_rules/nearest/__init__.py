"""PR rule ``nearest``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from attrs import define

from rmfs_core import hookimpl
from rmfs_rules.helpers import nearest_free_location

if TYPE_CHECKING:
    from rmfs_core.warehouse import Pod, WarehouseView


@define
class Nearest:
    """Store a pod in the nearest free storage location.

    That is the one with the shortest loaded driving time from where the pod is, turns included; ties go to the lowest
    cell index.

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
