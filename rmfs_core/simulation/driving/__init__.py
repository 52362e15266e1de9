"""How robots drive in a run; the PP rule's attribute ``reserves`` says which way it plans for."""

from __future__ import annotations

from collections.abc import Callable

from rmfs_core.simulation.context import RunContext
from rmfs_core.simulation.driving.base import Driving
from rmfs_core.simulation.driving.complete import CompleteDriving
from rmfs_core.simulation.driving.fleet import FleetDriving
from rmfs_core.simulation.driving.free import FreeDriving
from rmfs_core.simulation.driving.windowed import WindowedDriving

WAYS: dict[str | None, Callable[[RunContext], Driving]] = {
    None: FreeDriving,
    "full paths": CompleteDriving,
    "windows": WindowedDriving,
    "fleet": FleetDriving,
}
"""Ways to drive by the trait ``reserves`` of a PP rule."""
