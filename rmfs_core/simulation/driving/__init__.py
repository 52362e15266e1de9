"""How robots get from place to place in a run; the PP rule's attribute ``reserves`` says which way it plans for."""

from __future__ import annotations

from collections.abc import Callable

from rmfs_core.errors import InputError
from rmfs_core.simulation.driving.base import Driving, Process, Surroundings
from rmfs_core.simulation.driving.complete import CompleteDriving
from rmfs_core.simulation.driving.free import FreeDriving
from rmfs_core.simulation.driving.windowed import WindowedDriving

__all__ = ["WAYS", "Driving", "Process", "Surroundings", "driving_for", "reserves_of"]

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
    return WAYS[reserves_of(type(run.rule.instance), "rules.pp", run.rule.describe())](run)


def reserves_of(rule: type, place: str, name: str) -> str | None:
    """Return the attribute ``reserves`` of a PP rule's class.

    Raises
    ------
    InputError
        When there is no such way to drive; ``place`` and ``name`` are where the rule was named, and what to call it.
    """
    reserves = getattr(rule, "reserves", None)
    if isinstance(reserves, str | None) and reserves in WAYS:
        return reserves
    known = ", ".join(repr(way) for way in WAYS)
    found = repr(reserves) if isinstance(reserves, str) else "no class attribute (annotate it as ClassVar)"
    raise InputError(place, f"{name} has reserves = {found}; expected one of {known}")
