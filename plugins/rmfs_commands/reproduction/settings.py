"""Section 4.1 and Appendix D: the parameters of the simulation, the paper's next to ours."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Any

from attrs import frozen

from rmfs_commands.reproduction.paper import Exhibit
from rmfs_core.scenario import RuleChoice, Scenario

Reading = Callable[[Scenario], object]


@frozen
class Setting:
    """A parameter of the simulation, in the paper and in ours."""

    name: str
    paper: str
    ours: str

    @property
    def verdict(self) -> str:
        """Whether the two are the same, or ours are some of the paper's values."""
        if self.paper == self.ours:
            return "same"
        return "some of them" if {*self.ours.split(", ")} < {*self.paper.split(", ")} else "differs"


def settings(exhibit: Exhibit, scenarios: Sequence[Scenario]) -> list[Setting]:
    """Return the paper's parameters next to those of the scenarios.

    Parameters
    ----------
    exhibit
        The paper's, by name.
    scenarios
        Resolved scenarios.
    """
    return [Setting(name, value, _all(READINGS[name], scenarios)) for name, value in exhibit.values.items()]


def _all(reading: Reading, scenarios: Sequence[Scenario]) -> str:
    """Return the different values over the scenarios, as the paper lists them."""
    values = {reading(scenario) for scenario in scenarios} - {None}
    return ", ".join(_text(value) for value in sorted(values, key=_rank))


def _rank(value: object) -> tuple[float, str]:
    return (value, "") if isinstance(value, int | float) else (0.0, str(value))


def _text(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _storage_locations(scenario: Scenario) -> int:
    from rmfs_core.world import make_layout

    return len(make_layout(scenario).storage_locations)


def _pods(scenario: Scenario) -> int:
    return max(int(scenario.layout.pod_fill * _storage_locations(scenario)), scenario.instance.pods)


def _rule(choice: RuleChoice | None) -> str | None:
    return None if choice is None else choice.rule


def _unused_capacity_weight(scenario: Scenario) -> float | None:
    name, choice = "unused_capacity_weight", scenario.rules.poa_pps
    if choice is None:
        return None
    return float(choice.parameters[name] if name in choice.parameters else _defaults(choice.rule)[name])


@cache
def _defaults(rule: str) -> dict[str, Any]:
    """Return the default of every parameter of an installed rule."""
    from rmfs_commands.cli.description import installed_rules

    return {p.name: p.default for found in installed_rules() if found.name == rule for p in found.parameters}


READINGS: Mapping[str, Reading] = {
    "Number of orders |O|": lambda s: s.instance.orders,
    "Number of SKUs |I|": lambda s: s.instance.skus,
    "Number of pods |P|": lambda s: s.instance.pods,
    "SKUs per pod, alpha": lambda s: s.instance.skus_per_pod,
    "Storage locations": _storage_locations,
    "Pods in the layout": _pods,
    "Picking stations": lambda s: s.layout.stations_east + s.layout.stations_west,
    "Robots": lambda s: s.robots.count,
    "Length of a station's queue": lambda s: s.stations.queue_length,
    "Item capacity of a station": lambda s: s.stations.item_capacity,
    "Acceleration and deceleration": lambda s: f"{s.robots.acceleration_m_per_s2:g} m/s^2",
    "Top speed": lambda s: f"{s.robots.top_speed_m_per_s:g} m/s",
    "Full turn": lambda s: f"{s.robots.full_turn_s:g} s",
    "Lifting or storing a pod": lambda s: f"{s.robots.lift_s:g} s",
    "Picking a unit": lambda s: f"{s.stations.pick_s:g} s",
    "Handling a unit": lambda s: f"{s.stations.handle_s:g} s",
    "W_u": _unused_capacity_weight,
    "POA, sequential": lambda s: _rule(s.rules.poa),
    "PPS, sequential": lambda s: _rule(s.rules.pps),
    "PR": lambda s: s.rules.pr.rule,
    "PP": lambda s: s.rules.pp.rule,
}
"""How a scenario says each of the paper's parameters."""
