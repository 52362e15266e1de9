"""The whole report, put together from rows: tables and pictures in the order of the paper."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from attrs import frozen

from rmfs_commands.cli.grids import Grid
from rmfs_commands.experiments.report.plots import Plot
from rmfs_commands.reproduction.counts import count, distinct, unfinished
from rmfs_commands.reproduction.distributions import distribution_tables
from rmfs_commands.reproduction.estimates import Rows
from rmfs_commands.reproduction.grids import settings_grid, statements_grid, table_grid
from rmfs_commands.reproduction.overview import overview
from rmfs_commands.reproduction.paper import Exhibit, load_paper
from rmfs_commands.reproduction.parts import PARTS
from rmfs_commands.reproduction.plots import DRAWINGS, draw
from rmfs_commands.reproduction.settings import settings
from rmfs_commands.reproduction.statements import statements
from rmfs_commands.reproduction.tables import Table
from rmfs_core.scenario import Scenario

TITLE = "The paper's evaluation, and ours"
DRAWN_SEEDS = range(1, 11)
"""Seeds of the instances whose order lengths and SKUs are counted."""


@frozen(eq=False)
class Report:
    """Findings of a reproduction.

    Parameters
    ----------
    facts
        How it was made, by name: command, time, machine, versions.
    content
        Grids and plots in order.
    """

    facts: Mapping[str, str]
    content: Sequence[Grid | Plot]

    @property
    def grids(self) -> list[Grid]:
        """The grids alone: first the overview, then how the runs ended."""
        return [entry for entry in self.content if isinstance(entry, Grid)]

    @property
    def plots(self) -> list[Plot]:
        """The plots alone."""
        return [entry for entry in self.content if isinstance(entry, Plot)]


def make_report(parts: Mapping[str, Rows], scenarios: Sequence[Scenario], facts: Mapping[str, str]) -> Report:
    """Return the report on the runs of some parts.

    Parameters
    ----------
    parts
        Rows by the name of the part (`PARTS`).
    scenarios
        Those of the 24 instances, for the settings; none when that part was not run.
    facts
        How the runs were made.
    """
    paper = load_paper()
    tables = distribution_tables(DRAWN_SEEDS, paper)
    for part in PARTS:
        if part.name in parts:
            tables += part.tables(parts[part.name], paper)
    tables.sort(key=lambda table: list(paper).index(table.exhibit.name))
    compared = settings(paper["settings"], scenarios) if scenarios else []
    said = statements(parts["instances"]) if "instances" in parts else []
    plots = draw({table.exhibit.name: table for table in tables})
    content: list[Grid | Plot] = [overview(tables, compared, said), *_runs(parts)]
    if compared:
        content.append(settings_grid(paper["settings"], compared))
    content += _with_plots(tables, plots)
    if said:
        content.append(statements_grid(said))
    content.append(_left_out(parts, paper))
    return Report(facts, content)


def _runs(parts: Mapping[str, Rows]) -> list[Grid]:
    """Return the grid of how the runs ended, and one of incomplete runs, if any."""
    counts = count(parts)
    runs = distinct(parts)
    stopped = sum(row.get("solves_stopped_early") or 0 for row in runs)
    failed = sum(row["status"] == "failed" for row in runs)
    notes = (
        f"{len(runs):,} different runs, of which {failed:,} failed; solves that a time limit stopped: {stopped:,}.",
        "Parts share runs. Only complete runs count in the figures.",
    )
    columns = ("part", "rule set", "runs", "complete", "partial", "failed", "stood still", "solves stopped", "seconds")
    rows = [
        (
            entry.part,
            entry.rule_set,
            *(f"{number:,}" for number in (entry.runs, entry.complete, entry.partial, entry.failed)),
            *(f"{number:,}" for number in (entry.stood_still, entry.stopped_early)),
            f"{entry.seconds:,.1f}",
        )
        for entry in counts
    ]
    grids = [Grid("Runs", notes, columns, tuple(rows), right=range(2, len(columns)))]
    ended_early = tuple(
        (part, f"{row['instance']}, {row['rule_set']}, seed {row['seed']}", row["status"], row["error"] or "")
        for part, row in unfinished(parts)
    )
    if ended_early:
        note = "None of them counts in a figure."
        grids.append(Grid("Runs that did not complete", (note,), ("part", "run", "status", "error"), ended_early))
    return grids


def _with_plots(tables: Sequence[Table], plots: Mapping[str, Plot]) -> list[Grid | Plot]:
    """Return the tables as grids, each plot after the last of the tables that it is drawn from."""
    content: list[Grid | Plot] = []
    for table in tables:
        content.append(table_grid(table))
        content += [plot for name, plot in plots.items() if DRAWINGS[name].exhibits[-1] == table.exhibit.name]
    return content


def _left_out(parts: Mapping[str, Rows], paper: Mapping[str, Exhibit]) -> Grid:
    """Return what of Section 4 has no figures, and what was not run."""
    exhibit = paper["without-figures"]
    rows = [(f"{exhibit.item}: {exhibit.caption}", exhibit.wording)]
    rows += [(f"Part {part.name}", "Not run here.") for part in PARTS if part.name not in parts]
    return Grid("Not in this report", (), ("what", "why"), tuple(rows))
