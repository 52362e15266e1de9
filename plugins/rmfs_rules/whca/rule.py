"""Windowed hierarchical cooperative A*, non-volatile, with exact kinematics."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, ClassVar

from attrs import define, validators

from rmfs_core import Path, hookimpl
from rmfs_core.clock import to_ticks
from rmfs_rules.helpers.parameters import AT_LEAST_1, POSITIVE, finite, parameter
from rmfs_rules.whca import compiled
from rmfs_traffic import FOREVER, timed_path
from rmfs_traffic.searching import Asked, search_once

if TYPE_CHECKING:
    from rmfs_traffic import Query, Reservations, Roads, TimedPath, Traffic


@define
class WhcaN:
    """Drive a fast path among the reservations of the other robots, planned for a window of time.

    A* over (cell, heading, time) at rest, times less than a wait apart counting as one. A robot waits ``wait_s``, or
    turns and drives a straight run of any length that ends at rest; going straight on is a longer run from the last
    stop. Within the window reservations are kept clear of; the rest of the way is estimated by its exact time without
    traffic. The path ends where the window does, or at the goal, and always in a cell that nobody else has reserved
    from then on, so that it can be held.

    References
    ----------
    M. Merschformann, L. Xie, D. Erdmann: Multi-agent path finding with kinematic constraints for robotic mobile
    fulfillment systems. arXiv:1706.09347, 2017. https://arxiv.org/abs/1706.09347
    """

    reserves: ClassVar[str] = "windows"

    window_s: float = parameter(
        20.0, POSITIVE, "Simulated time that a path is planned ahead; inf plans to the goal", "s", infinite=True
    )
    wait_s: float = parameter(2.0, [validators.ge(0.001), finite], "Simulated time of a wait", "s")
    max_nodes: int = parameter(100_000, AT_LEAST_1, "Nodes after which a search gives up, as if there were no path")

    def prepare(self, roads: Roads) -> None:
        """Load the compiled search, or compile it."""
        search_once(self.search, roads)

    @hookimpl
    def plan_path(self, traffic: Traffic) -> Path | None:
        """Return a path to the goal or to the end of the window; None where none leads anywhere."""
        ends = self._ends(traffic.roads, traffic.table, traffic.query)
        return None if ends is None or not len(ends) else Path(ends)

    def search(self, roads: Roads, table: Reservations, query: Query) -> TimedPath | None:
        """Return a path to the goal or to the end of the window, where the robot may stay; None when there is none."""
        ends = self._ends(roads, table, query)
        return None if ends is None else timed_path(roads, query, Path(ends).legs)

    def _ends(self, roads: Roads, table: Reservations, query: Query) -> Any:
        """End and wait of each leg, as an array; None when there is no path."""
        end = FOREVER if self.window_s == math.inf else query.start_tick + to_ticks(self.window_s)
        tracks, intervals = tuple(roads.tracks(query.goal, query.loaded)), tuple(table.arrays)
        return compiled.search(Asked.by(query), end, to_ticks(self.wait_s), self.max_nodes, tracks, intervals)
