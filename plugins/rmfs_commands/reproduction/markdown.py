"""The report as Markdown."""

from __future__ import annotations

from rmfs_commands.cli.grids import Grid
from rmfs_commands.experiments.report.plots import Plot
from rmfs_commands.reproduction.report import TITLE, Report


def to_markdown(report: Report) -> str:
    """Return the report; its pictures are files next to it, ``<name>.png``."""
    parts = [f"# {TITLE}\n", *(_fact(name, value) for name, value in report.facts.items()), ""]
    parts += [_plot(entry) if isinstance(entry, Plot) else _grid(entry) for entry in report.content]
    return "\n".join(parts)


def _fact(name: str, value: str) -> str:
    return f"- {name}: `{value}`" if name == "Command" else f"- {name}: {value}"


def _plot(plot: Plot) -> str:
    return f"![{plot.title}]({plot.name}.png)\n"


def _grid(grid: Grid) -> str:
    lines = [f"## {grid.title}", "", *(f"{note}\n" for note in grid.notes)]
    rule = "|".join("---:" if number in grid.right else "---" for number in range(len(grid.columns)))
    lines += [_row(grid.columns), f"|{rule}|", *map(_row, grid.rows)]
    return "\n".join(lines) + "\n"


def _row(cells: tuple[str, ...]) -> str:
    return "| " + " | ".join(" ".join(cell.split()).replace("|", r"\|") for cell in cells) + " |"
