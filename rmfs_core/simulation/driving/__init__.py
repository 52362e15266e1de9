"""How robots get from place to place in a run; the PP rule's attribute ``reserves`` says which way it plans for."""

from __future__ import annotations

from collections.abc import Callable

from rmfs_core.errors import InputError
from rmfs_core.simulation.driving.base import Driving, Process, Surroundings
from rmfs_core.simulation.driving.complete import CompleteDriving
from rmfs_core.simulation.driving.free import FreeDriving
from rmfs_core.simulation.driving.windowed import WindowedDriving

__all__ = ["WAYS", "Driving", "Process", "Surroundings", "driving_for"]

WAYS: dict[str | None, Callable[[Surroundings], Driving]] = {
    None: FreeDriving,
    "full paths": CompleteDriving,
    "windows": WindowedDriving,
}
"""Ways to drive by the attribute ``reserves`` of a PP rule's class."""


def driving_for(run: Surroundings) -> Driving:
    """Return the way of driving that the PP rule plans for.

    Raises
    ------
    InputError
        When the rule asks for one that does not exist, or there are too many robots for it.
    """
    reserves = getattr(type(run.rule.instance), "reserves", None)
    if reserves not in WAYS:
        known = ", ".join(repr(way) for way in WAYS)
        raise InputError("rules.pp", f"{run.rule.describe()} has reserves = {reserves!r}; expected one of {known}")
    return WAYS[reserves](run)
