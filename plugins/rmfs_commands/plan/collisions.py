"""Whether paths keep clear of each other, found out without a reservation table or passing times.

Positions come from `Motion.position_m` alone: a robot has a cell while its position is less than a metre from the
cell's centre. When it comes so near and when it is so far again is found by bisection.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

from attrs import frozen

from rmfs_core.clock import TICKS_PER_S
from rmfs_core.motion import Motion
from rmfs_traffic import Roads, TimedPath

TOLERANCE_S = 1e-3
"""Two robots that touch a cell one after another within a tick do not collide: runs are rounded to ticks."""


@frozen
class Collision:
    """Two robots (numbers of their paths) have a cell at once, from ``since_s`` to ``until_s``."""

    cell: int
    first: int
    second: int
    since_s: float
    until_s: float


def collisions(roads: Roads, paths: Sequence[TimedPath]) -> tuple[Collision, ...]:
    """Return every overlap of two paths in a cell, the earliest first. A robot stays forever where its path ends."""
    at: dict[int, list[tuple[float, float, int]]] = {}
    for robot, path in enumerate(paths):
        for cell, since, until in _stays(roads, path):
            at.setdefault(cell, []).append((since, until, robot))
    found = []
    for cell, stays in at.items():
        stays.sort()
        for i, (_, until, robot) in enumerate(stays):
            for begin, end, other in stays[i + 1 :]:
                if begin >= until - TOLERANCE_S:
                    break
                if other != robot:
                    found.append(Collision(cell, min(robot, other), max(robot, other), begin, min(until, end)))
    return tuple(sorted(found, key=lambda c: (c.since_s, c.cell, c.first, c.second)))


def _stays(roads: Roads, path: TimedPath) -> list[tuple[int, float, float]]:
    """Cells with the seconds since and until which the robot has them."""
    layout, motion = roads.layout, roads.travel.motion
    stays = []
    cell, heading, now, came = path.cell, path.heading, path.start_tick / TICKS_PER_S, path.start_tick / TICKS_PER_S
    for leg in path.legs:
        now += leg.wait_ticks / TICKS_PER_S
        if leg.to == cell:
            continue
        towards = roads.travel.heading(cell, leg.to)
        assert towards is not None
        now += motion.turn_ticks(heading, towards) / TICKS_PER_S
        length = layout.distance(cell, leg.to)
        passed = [now + _passed_s(motion, length, i) for i in range(length + 1)]
        step = (leg.to - cell) // length
        begins = [came, *passed]
        stays += [(cell + i * step, begins[i], passed[i + 1]) for i in range(length)]
        came = passed[length - 1]
        now += motion.run_ticks(length) / TICKS_PER_S
        cell, heading = leg.to, towards
    return [*stays, (cell, came, math.inf)]


@lru_cache(maxsize=100_000)
def _passed_s(motion: Motion, length: int, metres: int) -> float:
    """Seconds after which a robot is ``metres`` from the start of a run."""
    low, high = 0.0, motion.run_s(length)
    if metres == length:
        return high
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if motion.position_m(length, middle) < metres else (low, middle)
    return high
