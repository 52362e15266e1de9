"""Energy of the robots' driving: mechanical energy of runs, turns and lifts, over the efficiency of the drives.

With m the mass that moves (robot, and pod if it carries one), g = 9.81 m/s^2, and a, v the robot's acceleration and top
speed, a run over D metres reaches u = min(v, sqrt(a D)) after s = u^2 / (2 a) metres, and takes

    acceleration   m a s
    rolling        c m g (D - s) + max(c g - a, 0) m s

c being the coefficient of rolling resistance: braking wins nothing back, but the resistance helps. A turn by an angle b
(radians) at the speed w of the full turn takes

    turns          J w^2 / 2 + c m g r b        J = m l^2 / 6

l being the side of the square that turns, and r half the track of the wheels. Lifting a pod of mass p by h metres takes

    lifts          p g h

and setting it down nothing. All of it is divided by the efficiency. Standing, computing and charging are not counted.

Sources: the terms for acceleration, resistance and lifts are those of energy models of shuttles, as in Energy
evaluation of deep-lane autonomous vehicle storage and retrieval system, Sustainability 11(14) 3817, 2019,
https://doi.org/10.3390/su11143817; that of a turn is the kinetic energy of a rotating plate. The masses are round
numbers for a drive unit under a loaded pod.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable

from rmfs_commands.details.spans import TICKS_PER_HOUR, Handlers, Number, ratio
from rmfs_core.clock import TICKS_PER_S, to_seconds
from rmfs_core.events import PodLifted, RobotMoved
from rmfs_core.info import RunInfo
from rmfs_core.scenario.model import BatterySection

ROBOT_KG, POD_KG = 150.0, 450.0
ROLLING, EFFICIENCY = 0.015, 0.8
SIDE_M, HALF_TRACK_M, LIFT_M = 0.9, 0.3, 0.05
GRAVITY_M_PER_S2 = 9.81
J_PER_WH = 3600
AT_ONCE = 512
"""How many runs are counted at once."""

PARTS = ("acceleration", "rolling", "turns", "lifts")


class Energy:
    """Follows runs, turns and lifts: how many of each kind there were is counted, and divided at the end.

    Parameters
    ----------
    run
        The run.
    begin
        The time from which on is counted.
    """

    def __init__(self, run: RunInfo, begin: int) -> None:
        self._motion = run.motion
        self._begin = begin
        self._told: list[RobotMoved] = []  # not counted yet: to count many at once is quicker
        self._runs: Counter[tuple[int, bool, int, int, bool]] = Counter()
        self._lifts = 0
        self.handlers: Handlers = {RobotMoved: self._told.append, PodLifted: self._lifted}

    def _lifted(self, event: PodLifted) -> None:
        self._lifts += event.tick >= self._begin
        if len(self._told) >= AT_ONCE:
            self._take_in()

    def _take_in(self) -> None:
        """Count runs: by hour, whether they count, metres, ticks of the turn, and whether the robot is loaded."""
        begin = self._begin
        self._runs.update(
            (one.tick // TICKS_PER_HOUR, one.tick >= begin, one.distance_m, one.turn_ticks, one.pod is not None)
            for one in self._told
        )
        self._told.clear()

    @property
    def _legs(self) -> Counter[tuple[int, int, bool]]:
        """How many runs count, by metres, ticks of the turn, and whether the robot is loaded."""
        self._take_in()
        legs: Counter[tuple[int, int, bool]] = Counter()
        for (_, counts, metres, ticks, loaded), number in self._runs.items():
            if counts:
                legs[metres, ticks, loaded] += number
        return legs

    def metres(self) -> Counter[int]:
        """Return the metres that robots drove, those before the time from which on is counted, too, by hour."""
        self._take_in()
        metres: Counter[int] = Counter()
        for (hour, _, each, *_), number in self._runs.items():
            metres[hour] += number * each
        return metres

    def values(self, completed: int) -> dict[str, Number]:
        """Return the metrics by name, for so many orders completed."""
        joules = dict.fromkeys(PARTS, 0.0)
        motion = self._motion
        runs: Counter[tuple[int, bool]] = Counter()
        turns: Counter[tuple[int, bool]] = Counter()
        for (metres, ticks, loaded), number in self._legs.items():
            runs[metres, loaded] += number
            turns[ticks, loaded] += number
        for (metres, loaded), number in sorted(runs.items()):
            accelerating, rolling = run_j(metres, loaded, motion.acceleration_m_per_s2, motion.top_speed_m_per_s)
            joules["acceleration"] += number * accelerating
            joules["rolling"] += number * rolling
        for (ticks, loaded), number in sorted(turns.items()):
            quarters = round(4 * to_seconds(ticks) / motion.full_turn_s)
            joules["turns"] += number * turn_j(quarters, loaded, motion.full_turn_s)
        joules["lifts"] = self._lifts * POD_KG * GRAVITY_M_PER_S2 * LIFT_M / EFFICIENCY
        hours = {part: amount / J_PER_WH for part, amount in joules.items()}
        total = sum(hours.values())
        return {
            "energy_wh": total,
            **{f"energy_{part}_wh": amount for part, amount in hours.items()},
            "energy_per_order_wh": ratio(total, completed),
        }

    def drawn_wh(self, battery: BatterySection, standing_ticks: Callable[[int], int]) -> float:
        """Return what batteries gave since the time from which on is counted: work and standing, by their draws.

        Robots that sleep with low batteries count as standing.

        Parameters
        ----------
        battery
            The draws.
        standing_ticks
            Returns how long robots stood, not at chargers, given for how long they drove, turned and lifted.
        """
        watts = (battery.empty_w, battery.loaded_w)
        moving = [0, 0]
        for (metres, ticks, loaded), number in self._legs.items():
            moving[loaded] += number * (ticks + self._motion.run_ticks(metres))
        lifting = 2 * self._lifts * self._motion.lift_ticks  # what is lifted is set down
        drawn = sum(power * ticks for power, ticks in zip(watts, moving, strict=True)) + battery.lifting_w * lifting
        drawn += battery.idle_w * standing_ticks(sum(moving) + lifting)
        return drawn / (TICKS_PER_S * J_PER_WH)


def run_j(metres: int, loaded: bool, acceleration: float, top_speed: float) -> tuple[float, float]:
    """Return what a run takes to accelerate, and against rolling resistance, in joules."""
    mass = ROBOT_KG + POD_KG * loaded
    speeding_m = min(top_speed * top_speed, acceleration * metres) / (2 * acceleration)
    resistance = ROLLING * GRAVITY_M_PER_S2
    rolling = mass * (resistance * (metres - speeding_m) + max(resistance - acceleration, 0.0) * speeding_m)
    return mass * acceleration * speeding_m / EFFICIENCY, rolling / EFFICIENCY


def turn_j(quarters: int, loaded: bool, full_turn_s: float) -> float:
    """Return what a turn by so many right angles takes, in joules."""
    if not quarters:
        return 0.0
    mass, speed, angle = ROBOT_KG + POD_KG * loaded, 2 * math.pi / full_turn_s, quarters * math.pi / 2
    kinetic = mass * SIDE_M**2 / 6 * speed**2 / 2
    return (kinetic + ROLLING * mass * GRAVITY_M_PER_S2 * HALF_TRACK_M * angle) / EFFICIENCY
