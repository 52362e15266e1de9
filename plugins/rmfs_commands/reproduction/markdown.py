"""The report as Markdown."""

from __future__ import annotations

from rmfs_commands.cli.grids import grid_markdown
from rmfs_commands.experiments.report.plots import Plot
from rmfs_commands.reproduction.report import TITLE, Report


def to_markdown(report: Report) -> str:
    """Return the report; its pictures are files next to it, ``<name>.png``."""
    parts = [f"# {TITLE}\n", *(_fact(name, value) for name, value in report.facts.items()), ""]
    parts += [_plot(entry) if isinstance(entry, Plot) else grid_markdown(entry) for entry in report.content]
    return "\n".join(parts)


def _fact(name: str, value: str) -> str:
    return f"- {name}: `{value}`" if name == "Command" else f"- {name}: {value}"


def _plot(plot: Plot) -> str:
    return f"![{plot.title}]({plot.name}.png)\n"
