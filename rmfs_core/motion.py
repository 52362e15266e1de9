"""How a robot moves: closed formulas, in ticks."""

from __future__ import annotations

import math

from attrs import frozen

from rmfs_core.clock import to_ticks


@frozen
class Motion:
    """Kinematics of a robot: constant acceleration and deceleration, a top speed, turns on the spot.

    Parameters
    ----------
    acceleration_m_per_s2
        Acceleration and deceleration.
    top_speed_m_per_s
        Top speed.
    full_turn_s
        Seconds of a turn by 360 degrees.
    lift_s
        Seconds to lift a pod, and to set it down.
    """

    acceleration_m_per_s2: float = 1.0
    top_speed_m_per_s: float = 1.5
    full_turn_s: float = 2.5
    lift_s: float = 2.2

    def run_s(self, metres: float) -> float:
        """Seconds of a straight run from rest to rest: trapezoidal speed profile, triangular when it is short.

        With ``a`` the acceleration and ``v`` the top speed: D/v + v/a for D >= v^2/a, else 2 sqrt(D/a).
        """
        a, v = self.acceleration_m_per_s2, self.top_speed_m_per_s
        if metres >= v * v / a:
            return metres / v + v / a
        return 2 * math.sqrt(metres / a)

    def run_ticks(self, metres: int) -> int:
        """Ticks of a straight run over ``metres`` cells."""
        return to_ticks(self.run_s(metres))

    def turn_ticks(self, heading: int, to: int) -> int:
        """Ticks to turn on the spot from one heading to another, the shorter way."""
        quarters = (to - heading) % 4
        return to_ticks(min(quarters, 4 - quarters) * self.full_turn_s / 4)

    @property
    def lift_ticks(self) -> int:
        """Ticks to lift a pod, and to set it down."""
        return to_ticks(self.lift_s)

    def position_m(self, metres: float, seconds: float) -> float:
        """Metres from the start, ``seconds`` after the start of a run over ``metres``."""
        a, v = self.acceleration_m_per_s2, self.top_speed_m_per_s
        total = self.run_s(metres)
        ramp = min(v / a, total / 2)
        if seconds <= ramp:
            return a * seconds**2 / 2
        if seconds >= total - ramp:
            return metres - a * max(total - seconds, 0.0) ** 2 / 2
        return a * ramp**2 / 2 + v * (seconds - ramp)
