"""The report: one HTML file with everything in it, which needs neither network nor other files."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

from rmfs_commands.cli.not_simulated import NOT_SIMULATED
from rmfs_commands.cli.pages import render
from rmfs_commands.experiments.compare import Comparison
from rmfs_commands.experiments.report import numbers
from rmfs_commands.experiments.report.plots import Plot, front_name, plot_name
from rmfs_commands.experiments.report.repeating import rules_digests
from rmfs_commands.experiments.running import ExperimentResult

TEMPLATE = Path(__file__).parent / "report.html.j2"
MOST_OF_A_VERSION = 19  # of a digest: "sha256:" and twelve digits
MOST_ROWS = 2_000
"""Of all tables together; beyond that they have the overall figures alone, and summary.csv has the others."""
MOST_ERRORS = 200


def report_html(result: ExperimentResult, comparison: Comparison, plots: Sequence[Plot]) -> str:
    """Return the report as one HTML document.

    Parameters
    ----------
    result, comparison
        The experiment's result to report.
    plots
        Plots to embed; those named like a metric go next to its table.
    """
    sets = comparison.instance_sets
    if len(sets) * len(comparison.rule_sets) * (1 + len(comparison.metrics)) > MOST_ROWS:
        sets = sets[-1:]
    return render(
        TEMPLATE,
        experiment=result.experiment,
        facts=_facts(result),
        comparison=comparison,
        answers=list(filter(None, (numbers.answer(comparison, metric) for metric in comparison.metrics))),
        sets=sets,
        runs=len(result.rows),
        failed=result.failed,
        most_errors=MOST_ERRORS,
        numbers=numbers,
        plots={plot.name: plot.svg for plot in plots},
        plot_name=plot_name,
        front_name=front_name,
        not_simulated=NOT_SIMULATED,
        has_bounds=any(map(comparison.bounded, comparison.metrics)),
    )


def _facts(result: ExperimentResult) -> list[tuple[str, str]]:
    experiment = result.experiment
    rules = ", ".join(f"{name} {' or '.join(digests)}" for name, digests in rules_digests(result).items())
    return [
        ("Runs", f"{len(result.rows):,}"),
        ("Scenarios", ", ".join(base.name for base in experiment.bases)),
        *((axis.name, ", ".join(str(point.value) for point in axis.points)) for axis in experiment.axes),
        ("Seeds", _span(experiment.seeds)),
        ("Rule sets", ", ".join(rule_set.name for rule_set in experiment.rule_sets)),
        ("Baseline", experiment.baseline),
        *([("SHA-256 of the rules", rules)] if rules else []),
        ("Versions", ", ".join(f"{name} {version[:MOST_OF_A_VERSION]}" for name, version in result.versions.items())),
    ]


def _span(seeds: Sequence[int]) -> str:
    if len(seeds) > 2 and all(later == one + 1 for one, later in pairwise(seeds)):
        return f"{seeds[0]} to {seeds[-1]}"
    return ", ".join(map(str, seeds))
