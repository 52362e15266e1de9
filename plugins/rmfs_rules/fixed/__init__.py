"""PR rule ``fixed``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from attrs import define

from rmfs_core import hookimpl
from rmfs_rules.helpers import nearest_free_location

if TYPE_CHECKING:
    from rmfs_core.warehouse import Pod, WarehouseView


@define
class Fixed:
    """Store a pod where it stood when the run started.

    Should another pod stand there or be on its way there, the pod goes to the nearest free storage location.

    References
    ----------
    M. Merschformann, T. Lamballais, R. de Koster, L. Suhl: Decision rules for robotic mobile fulfillment systems.
    Operations Research Perspectives 6, 100128, 2019. https://doi.org/10.1016/j.orp.2019.100128
    """

    @hookimpl
    def choose_storage_location(self, warehouse: WarehouseView, pod: Pod) -> int:
        """Choose the pod's home location."""
        home = warehouse.home(pod)
        return home if home in warehouse.free_storage_locations else nearest_free_location(warehouse, pod)
