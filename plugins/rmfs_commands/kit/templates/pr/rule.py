"""PR rule ``the-rule``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from attrs import define, field, validators

from rmfs import hookimpl

if TYPE_CHECKING:
    import numpy as np

    from rmfs.warehouse import Pod, WarehouseView


@define
class TheRule:
    """Store a pod in one of the nearest free storage locations, drawn at random.

    Pods that leave a station at about the same time do not all head for the same corner.

    Parameters
    ----------
    choices
        How many of the nearest locations are drawn from, each as likely as any other.
    """

    choices: int = field(default=5, validator=validators.ge(1))

    @hookimpl
    def choose_storage_location(self, warehouse: WarehouseView, pod: Pod, rng: np.random.Generator) -> int:
        """Draw one of the nearest free storage locations."""
        assert pod.robot is not None, "a robot carries the pod"
        heading = warehouse.robots[pod.robot].heading
        ticks = warehouse.travel.times_from(pod.cell, heading, loaded=True)
        nearest = sorted(warehouse.free_storage_locations, key=lambda cell: (ticks[cell], cell))[: self.choices]
        return nearest[int(rng.integers(len(nearest)))]
