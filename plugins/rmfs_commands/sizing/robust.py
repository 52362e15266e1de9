"""A scenario in which times spread, and robots and stations fail."""

from __future__ import annotations

from typing import Any

from attrs import evolve

from rmfs_core.scenario import Scenario
from rmfs_core.scenario.model import FailuresSection
from rmfs_core.scenario.service import ServiceTime, Spread

CV = 0.5
FAILURES = FailuresSection(mtbf_h=8.25, mttr_s=300.0)
"""A robot or station is out of service for 1 % of the time."""
UNDER = (
    f"Under spread and failures (times of picks with a cv of {CV:g}, robots and stations out of service for 1 % of the "
    "time)"
)


def under_spread_and_failures(scenario: Scenario) -> Scenario:
    """Return the scenario with spread and failures where it has none of its own."""
    stations, robots = scenario.stations, scenario.robots
    times: dict[str, Any] = {
        name: seconds if hasattr(seconds, "spread") else ServiceTime(Spread(mean=float(seconds), cv=CV))
        for name in ("pick_s", "handle_s")
        for seconds in [getattr(stations, name)]
    }
    return evolve(
        scenario,
        stations=evolve(stations, outages=stations.outages or FAILURES, **times),
        robots=evolve(robots, failures=robots.failures or FAILURES),
    )
