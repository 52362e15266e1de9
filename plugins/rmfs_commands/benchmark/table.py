"""The table of best known values, with what no rules can beat next to them."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from attrs import frozen

from rmfs_commands.benchmark.claims import Claim, best_of
from rmfs_commands.benchmark.sets import Frozen
from rmfs_commands.cli.grids import Grid

BOUNDS_FILE = "bounds.json"
LABELS = {
    "pod_station_visits": "Visits",
    "makespan_s": "Makespan (s)",
    "turnover_s": "Turn-over (s)",
    "packed_s": "To packed (s)",
    "late_orders": "Late orders",
    "distance_m": "Distance (m)",
}


@frozen
class Best:
    """A best known value.

    Parameters
    ----------
    instance, objective
        Instance and objective of the value.
    claim
        Claim that reached it.
    bound
        Bound that no rules can beat; None where nothing is proven.
    """

    instance: Frozen
    objective: str
    claim: Claim
    bound: float | None

    @property
    def value(self) -> float:
        """The value."""
        return self.claim.metrics[self.objective]

    @property
    def gap(self) -> float | None:
        """How far the value is above the bound, as a share of the bound; None where there is none, or it is 0."""
        return (self.value - self.bound) / self.bound if self.bound else None


@cache
def known_bounds() -> dict[str, dict[str, float]]:
    """Return the bounds that were proven for the set, by instance and metric."""
    found: dict[str, dict[str, float]] = json.loads(Path(__file__).with_name(BOUNDS_FILE).read_text("utf-8"))
    return found


def best_known(instances: Sequence[Frozen], claims: Sequence[Claim], objectives: Sequence[str] = ()) -> Iterator[Best]:
    """Yield the best known value of each objective of each instance; of those objectives, or of all."""
    for one in instances:
        bounds = known_bounds().get(one.name, {})
        for objective, claim in best_of(claims, one).items():
            if not objectives or objective in objectives:
                yield Best(one, objective, claim, bounds.get(objective))


def told(objective: str, value: float | None) -> str:
    """Return a value for people: seconds with a digit."""
    if value is None:
        return "-"
    return f"{value:,.1f}" if objective.endswith("_s") else f"{value:,.0f}"


def percent(share: float | None) -> str:
    """Return a gap for people; a dash where there is none."""
    return "-" if share is None else f"{100 * share:,.1f} %"


def grid_of(found: Sequence[Best], version: str) -> Grid:
    """Return best known values as a grid, a row each."""
    rows = [
        (
            one.instance.name,
            LABELS[one.objective],
            told(one.objective, one.value),
            told(one.objective, one.bound),
            percent(one.gap),
            one.claim.made_by + (" (offline)" if one.claim.offline else ""),
            one.claim.digest,
            one.claim.versions.get("rmfs", "-"),
            str(one.instance.scenario.seed),
        )
        for one in found
    ]
    columns = ("Instance", "Objective", "Best known", "At least", "Gap", "Made by", "Rules", "rmfs", "Seed")
    notes = ("Rules: first digits of the SHA-256 of all rules with their parameters.",)
    return Grid(f"Best known values, benchmark set {version}", notes, columns, rows, (2, 3, 4, 8))


def plain(found: Sequence[Best]) -> list[dict[str, Any]]:
    """Return best known values for machines."""
    return [
        {
            "instance": one.instance.name,
            "objective": one.objective,
            "value": one.value,
            "bound": one.bound,
            "gap": one.gap,
            "made_by": one.claim.made_by,
            "offline": one.claim.offline,
            "rules": one.claim.digest,
            "trace": one.claim.trace,
            "versions": dict(one.claim.versions),
            "seed": one.instance.scenario.seed,
            "checksum": one.instance.checksum,
        }
        for one in found
    ]


def page_table(instances: Sequence[Frozen], found: Sequence[Best]) -> str:
    """Return best known values as a table in Markdown, a row for each instance, with gaps and letters of the rules."""
    makers = {one.claim.made_by: "" for one in found}
    letters: Mapping[str, str] = {name: chr(97 + i) for i, name in enumerate(sorted(makers))}
    by = {(one.instance.name, one.objective): one for one in found}

    def cell(name: str, objective: str) -> str:
        one = by.get((name, objective))
        if one is None:
            return ""
        gap = "" if one.gap is None else f" (+{100 * one.gap:,.0f} %)"
        return f"{told(objective, one.value)}{gap} {letters[one.claim.made_by]}{'*' * one.claim.offline}"

    lines = ["| instance | " + " | ".join(label.lower() for label in LABELS.values()) + " |"]
    lines.append("|---|" + "---:|" * len(LABELS))
    lines += [f"| {one.name} | " + " | ".join(cell(one.name, key) for key in LABELS) + " |" for one in instances]
    legend = ", ".join(f"{letter} {'a plan' if name == 'plan' else f'`{name}`'}" for name, letter in letters.items())
    return "\n".join([*lines, "", f"Made by: {legend}; * offline.", ""])
