"""PR rule ``random``."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from attrs import define

from rmfs_core import hookimpl

if TYPE_CHECKING:
    from rmfs_core.warehouse import WarehouseView


@define
class RandomLocation:
    """Store a pod in a random free storage location, each as likely as any other.

    References
    ----------
    M. Merschformann, T. Lamballais, R. de Koster, L. Suhl: Decision rules for robotic mobile fulfillment systems.
    Operations Research Perspectives 6, 100128, 2019. https://doi.org/10.1016/j.orp.2019.100128
    """

    @hookimpl
    def choose_storage_location(self, warehouse: WarehouseView, rng: np.random.Generator) -> int:
        """Draw a free storage location."""
        free = warehouse.free_storage_locations
        return free[int(rng.integers(len(free)))]
