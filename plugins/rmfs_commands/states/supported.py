"""Things that a run that begins in a state, or leaves one, cannot have yet."""

from __future__ import annotations

from rmfs_core.errors import InputError
from rmfs_core.scenario import Scenario


def check_supported(scenario: Scenario) -> None:
    """Raise InputError for the first thing in a scenario of which no state tells how far it is."""
    robots, stations = scenario.robots, scenario.stations
    for place, given, what in (
        ("robots.failures", robots.failures, "failures"),
        ("robots.maintenance", robots.maintenance, "maintenance"),
        ("stations.outages", stations.outages, "outages"),
        ("robots.battery.charger_outages", robots.battery and robots.battery.charger_outages, "outages of chargers"),
    ):
        if given:
            problem = f"a run cannot begin in a state, or save one, with {what} yet"
            raise InputError(place, f"{problem}; expected a scenario without {what}")
