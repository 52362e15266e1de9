"""The report: one HTML file with everything in it, which needs neither network nor other files."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from rmfs_commands.cli.not_simulated import NOT_SIMULATED
from rmfs_commands.experiments.compare import Comparison
from rmfs_commands.experiments.report import numbers
from rmfs_commands.experiments.report.plots import Plot, front_name, plot_name
from rmfs_commands.experiments.running import ExperimentResult

TEMPLATE = "report.html.j2"
MOST_OF_A_VERSION = 19  # of a digest: "sha256:" and twelve digits


def report_html(result: ExperimentResult, comparison: Comparison, plots: Sequence[Plot]) -> str:
    """Return the report as one HTML document.

    Parameters
    ----------
    result, comparison
        What to report.
    plots
        Plots to embed; those named like a metric go beside its table.
    """
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(TEMPLATE).render(
        experiment=result.experiment,
        facts=_facts(result),
        comparison=comparison,
        failed=result.failed,
        numbers=numbers,
        plots={plot.name: _embedded(plot) for plot in plots},
        plot_name=plot_name,
        front_name=front_name,
        not_simulated=NOT_SIMULATED,
        has_bounds=any(map(comparison.bounded, comparison.metrics)),
    )


def _embedded(plot: Plot) -> str:
    """Return a plot as an address that holds it; an image of its own, so that ids of several SVGs do not clash."""
    return f"data:image/svg+xml;base64,{base64.b64encode(plot.svg).decode('ascii')}"


def _facts(result: ExperimentResult) -> list[tuple[str, str]]:
    experiment = result.experiment
    return [
        ("Runs", f"{len(result.rows):,}"),
        ("Scenarios", ", ".join(base.name for base in experiment.bases)),
        *((axis.name, ", ".join(str(point.value) for point in axis.points)) for axis in experiment.axes),
        ("Seeds", _span(experiment.seeds)),
        ("Rule sets", ", ".join(rule_set.name for rule_set in experiment.rule_sets)),
        ("Baseline", experiment.baseline),
        ("Versions", ", ".join(f"{name} {version[:MOST_OF_A_VERSION]}" for name, version in result.versions.items())),
    ]


def _span(seeds: Sequence[int]) -> str:
    if len(seeds) > 2 and all(later == one + 1 for one, later in pairwise(seeds)):
        return f"{seeds[0]} to {seeds[-1]}"
    return ", ".join(map(str, seeds))
