"""Which cells each robot holds when, and whether two hold one at once.

Cell i of a run is held from leaving cell i - 1 until reaching cell i + 1: at any time a robot on its way holds the two
cells between whose centres it is. The first cell is held from the arrival there on, wait and turn included, the last
one until the next run has reached its second cell. Where a leg that the end of the run cut off was to end is not known:
of its cells is held what it holds in any case. A complete run does not tell such legs: where a robot with a task rests
is known until the last thing it did.
"""

from __future__ import annotations

import math
from collections import defaultdict
from functools import cache

from attrs import define

from rmfs_commands.validation.case import Case, seconds
from rmfs_commands.validation.state import State
from rmfs_core.clock import TICKS_PER_S
from rmfs_core.events import RobotMoved
from rmfs_core.motion import Motion

PARKING_TICKS = 120 * TICKS_PER_S
"""A robot without a task may be on its way to rest, which the trace does not tell, for so long."""

LONGEST_M = 100_000
"""A run so long that a robot does not brake before the cells in question."""

TOLERANCE_TICKS = 2
"""Overlap that is no fault: a planner that counts in whole ticks rounds both intervals."""


@define
class Hold:
    """A robot holds a cell from ``start`` to ``end`` (ticks), and goes to the cell next to it next."""

    robot: int
    cell: int
    start: float
    end: float = 0.0
    goes_to: int | None = None


def find_collisions(case: Case, state: State) -> None:
    """Add a fault for each time that two robots hold one cell at once, or drive through each other.

    Parameters
    ----------
    case
        The trace.
    state
        Everything at the end of it.
    """
    by_cell: dict[int, list[Hold]] = defaultdict(list)
    for hold in _holds(case, _known_until(case, state)):
        by_cell[hold.cell].append(hold)
    meetings: dict[tuple[int, int], list[tuple[Hold, Hold]]] = defaultdict(list)
    for holds in by_cell.values():
        _overlaps(holds, meetings)
    for pair in sorted(meetings):
        _report(case, sorted(meetings[pair], key=_begin))


def reached_s(motion: Motion, metres: int, at: int) -> float:
    """Seconds after the start of a run over ``metres`` at which the point ``at`` metres from its start is reached."""
    a, v = motion.acceleration_m_per_s2, motion.top_speed_m_per_s
    total = motion.run_s(metres)
    ramp_s = min(v / a, total / 2)
    ramp_m = a * ramp_s**2 / 2
    if at <= ramp_m:
        return math.sqrt(2 * at / a)
    if at >= metres - ramp_m:
        return total - math.sqrt(2 * (metres - at) / a)
    return ramp_s + (at - ramp_m) / v


def _known_until(case: Case, state: State) -> list[int]:
    """Tick until which the cell of each robot is known where it rests last."""
    end = case.trace.tick
    serving = {station.visit.robot for station in state.stations if station.visit is not None}
    return [
        end
        if i in serving
        else robot.free_tick
        if robot.task is not None
        else max(robot.free_tick, end - PARKING_TICKS)
        for i, robot in enumerate(state.robots)
    ]


def _holds(case: Case, known_until: list[int]) -> list[Hold]:
    """Every hold of every robot."""
    began = float(case.trace.began)
    holds = [Hold(i, robot["cell"], began) for i, robot in enumerate(case.trace.robots)]
    resting = list(holds)

    @cache
    def offsets(metres: int, total: int) -> list[float]:
        return [reached_s(case.motion, total, at) * TICKS_PER_S for at in range(1, metres + 1)]

    for event in case.trace.events:
        if not isinstance(event, RobotMoved) or event.origin == event.to:
            continue
        heading = case.heading(event.origin, event.to)
        metres = 1 if heading is None else case.layout.distance(event.origin, event.to)
        step = event.to - event.origin if heading is None else case.step(heading)
        begin = event.start_tick + event.wait_ticks + event.turn_ticks
        # The soonest and the latest that it can have reached each cell: the same, unless it was to drive farther.
        soonest, latest = (LONGEST_M, metres + 1) if case.is_cut_off(event) else (metres, metres)
        reached = [min(begin + offset, event.tick) for offset in offsets(metres, soonest)]
        entered = [min(begin + offset, event.tick) for offset in offsets(metres, latest)]
        last = resting[event.robot]
        left = float(begin)
        for i in range(metres):
            hold = Hold(event.robot, event.origin + (i + 1) * step, left)
            last.end, last.goes_to = reached[i], hold.cell
            holds.append(hold)
            last, left = hold, entered[i]
        resting[event.robot] = last
    for hold, tick in zip(resting, known_until, strict=True):
        hold.end = tick
    for hold in holds if began else ():  # a leg under way holds what it has left no more
        hold.start = max(hold.start, began)
    return holds


def _overlaps(holds: list[Hold], meetings: dict[tuple[int, int], list[tuple[Hold, Hold]]]) -> None:
    """Add the pairs of holds of one cell that overlap in time."""
    holds.sort(key=lambda hold: (hold.start, hold.robot))
    active: list[Hold] = []
    for hold in holds:
        active = [other for other in active if other.end > hold.start + TOLERANCE_TICKS]
        for other in active:
            if other.robot != hold.robot and hold.end > hold.start + TOLERANCE_TICKS:
                first, second = (other, hold) if other.robot < hold.robot else (hold, other)
                meetings[first.robot, second.robot].append((first, second))
        active.append(hold)


def _begin(pair: tuple[Hold, Hold]) -> float:
    return max(pair[0].start, pair[1].start)


def _report(case: Case, pairs: list[tuple[Hold, Hold]]) -> None:
    """Report the meetings of two robots; overlaps in several cells without a break are one meeting."""
    episode: list[tuple[Hold, Hold]] = []
    until = -math.inf
    for pair in pairs:
        if _begin(pair) >= until and episode:
            _report_one(case, episode)
            episode = []
        episode.append(pair)
        until = max(until, min(pair[0].end, pair[1].end))
    _report_one(case, episode)


def _report_one(case: Case, episode: list[tuple[Hold, Hold]]) -> None:
    first, second = episode[0]
    tick = math.ceil(_begin(episode[0]))
    until = max(min(a.end, b.end) for a, b in episode)
    robots = f"{case.robot(first.robot)} and {case.robot(second.robot)}"
    steps = [(a.cell, a.goes_to) for a, _ in episode if a.goes_to is not None]
    opposite = {(b.goes_to, b.cell) for _, b in episode}
    passed = next((step for step in steps if step in opposite), None)
    if passed is not None:
        between = f"between {case.where(passed[0])} and {case.where(passed[1])}"
        case.add("swap", tick, f"{robots} drive through each other {between}, from {seconds(tick)} to {seconds(until)}")
    else:
        case.add(
            "collision", tick, f"{robots} both hold {case.where(first.cell)} from {seconds(tick)} to {seconds(until)}"
        )
