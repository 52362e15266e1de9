"""rmfs: interchangeable decision rules for robotic mobile fulfillment systems.

What is named here is the public surface. It is imported on first use: ``import rmfs_core`` costs next to nothing.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rmfs_core.decisions import (
        JointDecision,
        Leg,
        OrderAssignment,
        Path,
        PodTrip,
        SolveReport,
        TaskAssignment,
    )
    from rmfs_core.errors import InputError, RmfsError, RuleError, RunError, StandstillError
    from rmfs_core.hookspecs import hookimpl
    from rmfs_core.results import Result
    from rmfs_core.running import run
    from rmfs_core.scenario import Scenario, load_scenario

__all__ = [
    "InputError",
    "JointDecision",
    "Leg",
    "OrderAssignment",
    "Path",
    "PodTrip",
    "Result",
    "RmfsError",
    "RuleError",
    "RunError",
    "Scenario",
    "SolveReport",
    "StandstillError",
    "TaskAssignment",
    "hookimpl",
    "load_scenario",
    "run",
]

_HOME = {
    "decisions": (
        "JointDecision",
        "Leg",
        "OrderAssignment",
        "Path",
        "PodTrip",
        "SolveReport",
        "TaskAssignment",
    ),
    "errors": ("InputError", "RmfsError", "RuleError", "RunError", "StandstillError"),
    "hookspecs": ("hookimpl",),
    "results": ("Result",),
    "running": ("run",),
    "scenario": ("Scenario", "load_scenario"),
}
_MODULE_OF = {name: module for module, names in _HOME.items() for name in names}


def __getattr__(name: str) -> object:
    if name not in _MODULE_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value: object = getattr(importlib.import_module(f"{__name__}.{_MODULE_OF[name]}"), name)
    globals()[name] = value
    return value
