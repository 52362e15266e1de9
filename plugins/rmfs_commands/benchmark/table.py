"""The table of best known values, with what no rules can beat next to them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from attrs import frozen

from rmfs_commands.benchmark.claims import Claim, best_of, read_claims
from rmfs_commands.benchmark.sets import Frozen, known_bounds
from rmfs_commands.cli.grids import Grid, grid_csv, grid_markdown
from rmfs_commands.cli.latex import to_latex
from rmfs_commands.results.files import write_text

NOT_IN_LATEX = ("Rules", "rmfs", "Seed")
"""Columns that LaTeX tables do not have, so that they fit into a text column; the caption names the versions."""
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
    verified
        Whether it comes with the package, whose claims are made again before they are added.
    """

    instance: Frozen
    objective: str
    claim: Claim
    bound: float | None
    verified: bool = True

    @property
    def value(self) -> float:
        """The value."""
        return self.claim.metrics[self.objective]

    @property
    def gap(self) -> float | None:
        """How far the value is above the bound, as a share of the bound; None where there is none, or it is 0."""
        return (self.value - self.bound) / self.bound if self.bound else None

    @property
    def made_by(self) -> str:
        """Its rules in short, and whether it was made offline, or nobody has made it again."""
        marks = ["offline"] * self.claim.offline + ["unverified"] * (not self.verified)
        return f"{self.claim.made_by} ({', '.join(marks)})" if marks else self.claim.made_by


def best_known(instances: Sequence[Frozen], claims: Sequence[Claim], objectives: Sequence[str] = ()) -> Iterator[Best]:
    """Yield the best known value of each objective of each instance; of those objectives, or of all."""
    known = read_claims()
    for one in instances:
        bounds = known_bounds().get(one.name, {})
        for objective, claim in best_of(claims, one).items():
            if not objectives or objective in objectives:
                yield Best(one, objective, claim, bounds.get(objective), claim in known)


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
            one.made_by,
            one.claim.digest,
            one.claim.versions.get("rmfs", "-"),
            str(one.instance.scenario.seed),
        )
        for one in found
    ]
    columns = ("Instance", "Objective", "Best known", "At least", "Gap", "Made by", *NOT_IN_LATEX)
    notes = ("Rules: first digits of the SHA-256 of all rules as written, with their parameters.",)
    made_with = " and ".join(sorted({f"rmfs {one.claim.versions.get('rmfs', '-')}" for one in found}))
    title = f"Best known values of benchmark set {version}, made with {made_with}"
    return Grid(title, notes, columns, rows, (2, 3, 4, 8))


def own_grid(instances: Sequence[Frozen], rows: Mapping[str, Mapping[str, Any]], version: str) -> Grid:
    """Return what rules have reached, a row for each objective, next to the best known values of the package.

    Parameters
    ----------
    instances
        The instances that were run.
    rows
        The row of each run, by name of the instance.
    version
        Of the set.
    """
    cells, known = [], read_claims()
    for one in instances:
        best = best_of(known, one)
        for objective, value in one.reached(rows[one.name]).items():
            least = best[objective].metrics[objective] if objective in best else None
            off = None if value is None or not least else value / least - 1
            bound = known_bounds().get(one.name, {}).get(objective)
            figures = (told(objective, value), told(objective, least), percent(off), told(objective, bound))
            cells.append((one.name, LABELS[objective], *figures))
    columns = ("Instance", "Objective", "Reached", "Best known", "Off by", "At least")
    return Grid(f"Values reached on benchmark set {version}", (), columns, cells, (2, 3, 4, 5))


def write_table(grid: Grid, file: Path) -> None:
    """Write a grid with a row for each instance and objective, as CSV, Markdown, or a LaTeX table of each objective."""
    if file.suffix == ".csv":
        write_text(file, grid_csv(grid))
    elif file.suffix == ".md":
        write_text(file, grid_markdown(grid))
    else:
        kept = [at for at, name in enumerate(grid.columns) if name not in ("Objective", *NOT_IN_LATEX)]
        right = [number for number, at in enumerate(kept) if at in grid.right]
        tables = []
        for key, label in LABELS.items():
            rows = [tuple(row[at] for at in kept) for row in grid.rows if row[1] == label]
            columns = tuple(grid.columns[at] for at in kept)
            part = Grid(f"{label}. {grid.title}.", (), columns, rows, right)
            tables += [to_latex(part, f"{file.stem}-{key.replace('_', '-')}")] if rows else []
        write_text(file, "\n".join(tables))


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
            "verified": one.verified,
            "rules": one.claim.digest,
            "trace": one.claim.trace,
            "versions": dict(one.claim.versions),
            "seed": one.instance.scenario.seed,
            "checksum": one.instance.checksum,
        }
        for one in found
    ]
