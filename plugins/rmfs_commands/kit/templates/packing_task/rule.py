"""Packing-task rule ``the-rule``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from attrs import define, field, validators
from rmfs import hookimpl

if TYPE_CHECKING:
    from rmfs.warehouse import PackingTask, WarehouseView


@define
class TheRule:
    """Do what is quickest, a task that has waited long before all others.

    What has waited for ``patience_s`` comes first, the longest waiting of these; else what takes the least time. Ties
    go to the one that waits longer.

    Parameters
    ----------
    patience_s
        Seconds that a task waits at most before it is next.
    """

    patience_s: float = field(default=300.0, validator=validators.ge(0))

    @hookimpl
    def choose_packing_task(self, warehouse: WarehouseView, tasks: Sequence[PackingTask]) -> int:
        """Choose the longest waiting task, or the shortest."""
        if warehouse.now_s - tasks[0].since_s >= self.patience_s:
            return 0
        return min(range(len(tasks)), key=lambda at: tasks[at].duration_s)
