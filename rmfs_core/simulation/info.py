"""What an observer learns at the start of a run."""

from __future__ import annotations

from attrs import frozen

from rmfs_core.instance import Instance
from rmfs_core.layout import Layout
from rmfs_core.motion import Motion
from rmfs_core.scenario.model import Scenario
from rmfs_core.warehouse import WarehouseView


@frozen(eq=False)
class RunInfo:
    """A run before its first event."""

    scenario: Scenario
    instance: Instance
    layout: Layout
    motion: Motion
    warehouse: WarehouseView
