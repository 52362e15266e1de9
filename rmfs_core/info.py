"""Facts of a run that observers are told besides its events."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from attrs import field, frozen

from rmfs_core.clock import to_ticks
from rmfs_core.motion import Motion
from rmfs_core.roles import Role
from rmfs_core.scenario.model import Scenario
from rmfs_core.warehouse import WarehouseView
from rmfs_core.world.grid import Layout
from rmfs_core.world.instance import Instance


@frozen(eq=False)
class RunInfo:
    """A run before its first event.

    Parameters
    ----------
    scenario, instance, layout, motion
        Inputs of the run.
    warehouse
        The warehouse now, live: kept, the same object shows it as it is at any later time.
    out
        A folder whose files will be next to the results, where an observer may write some; None where none are kept.
    apart
        Whether the PP rule keeps robots apart (it ``reserves``); else they pass through each other.
    summary
        Plain values by name that observers put here until the run is over: `Result.summary`.
    """

    scenario: Scenario
    instance: Instance
    layout: Layout
    motion: Motion
    warehouse: WarehouseView
    out: Path | None = None
    apart: bool = True
    summary: dict[str, Any] = field(factory=dict)

    @property
    def began(self) -> int | None:
        """Tick of the state in which a run begins, told before its first event; None where it begins afresh."""
        return None if self.scenario.instance.state_file is None else self.warehouse.now_tick

    @property
    def since(self) -> int:
        """First tick of which events are of this run, not of the state in which it begins: 0 without one."""
        began = self.began
        return 0 if began is None else min(to_ticks(self.scenario.run.warmup_s or 0), began + 1)


@frozen(eq=False)
class Question:
    """A rule that is asked for a decision.

    Parameters
    ----------
    decides
        Role or kind of the question.
    rule
        The rule's name, as in the scenario.
    hook
        The hook that is called.
    warehouse
        The view that the rule is shown.
    rng
        The rule's random generator, before it draws. An observer must not draw from it.
    period
        Number of the period; 0 before the first.
    arguments
        Other arguments of the hook, by name.
    """

    decides: Role
    rule: str
    hook: str
    warehouse: WarehouseView
    rng: np.random.Generator
    period: int
    arguments: Mapping[str, Any]
