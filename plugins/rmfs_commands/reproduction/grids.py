"""Everything that the report shows in rows, as text: one form for Markdown, HTML, LaTeX and CSV."""

from __future__ import annotations

from collections.abc import Sequence
from math import floor, log10

from rmfs_commands.cli.grids import Grid
from rmfs_commands.reproduction.estimates import Estimate
from rmfs_commands.reproduction.paper import Exhibit, Range
from rmfs_commands.reproduction.settings import Setting
from rmfs_commands.reproduction.statements import Statement
from rmfs_commands.reproduction.tables import Line, Table

DASH = "-"


def table_grid(table: Table) -> Grid:
    """Return a table of figures as text."""
    unit = f" ({table.unit})" if table.unit else ""
    columns = ("", f"paper{unit}", f"ours{unit}", "verdict", "runs")
    rows = tuple(_cells(line, table) for line in table.lines)
    return Grid(_title(table.exhibit), _notes(table.exhibit, table.what), columns, rows, right=(1, 2, 4))


def settings_grid(exhibit: Exhibit, settings: Sequence[Setting]) -> Grid:
    """Return the settings as text."""
    rows = tuple((setting.name, setting.paper, setting.ours, setting.verdict) for setting in settings)
    return Grid(_title(exhibit), _notes(exhibit, ""), ("", "paper", "ours", "verdict"), rows)


def statements_grid(statements: Sequence[Statement]) -> Grid:
    """Return the statements as text; comparisons that do not hold are named with their figures."""
    rows = tuple(
        (statement.item, statement.sentence, statement.verdict, _exceptions(statement)) for statement in statements
    )
    note = "Each sentence is compared with every instance set and method that it names."
    return Grid("What Section 4.2 says in words", (note,), ("", "the paper says", "ours", "where not"), rows)


def _exceptions(statement: Statement) -> str:
    return "; ".join(
        f"{comparison.label}: {number(comparison.smaller)} against {number(comparison.larger)}"
        for comparison in statement.comparisons
        if not comparison.holds
    )


def _title(exhibit: Exhibit) -> str:
    return f"{exhibit.item}: {exhibit.caption}"


def _notes(exhibit: Exhibit, what: str) -> tuple[str, ...]:
    ours = (f"Here: {what}.",) if what else ()
    return (f"The paper: {exhibit.wording}", *ours)


def _cells(line: Line, table: Table) -> tuple[str, ...]:
    ours = _ours(line.ours, table.digits)
    return (", ".join(line.label), _paper(line.paper, table), ours, line.verdict, _runs(line.ours))


def _paper(paper: Range | None, table: Table) -> str:
    if paper is None:
        return DASH
    digits, unit = table.digits, table.exhibit.rounded_to
    if paper.printed is not None:
        return f"{paper.printed:,.{digits if unit is None else round(-log10(unit))}f}"
    return f"{paper.low:,.{min(digits, 2)}f} to {paper.high:,.{min(digits, 2)}f}"


def _ours(ours: Estimate | None, digits: int) -> str:
    if ours is None:
        return DASH
    interval = "" if ours.half_width is None else f" ± {ours.half_width:,.{digits}f}"
    return f"{ours.mean:,.{digits}f}{interval}"


def _runs(ours: Estimate | None) -> str:
    if ours is None:
        return "0"
    return str(ours.runs) if ours.runs == ours.expected else f"{ours.runs} of {ours.expected}"


def number(value: float) -> str:
    """Return a figure with four significant digits."""
    if value == 0:
        return "0"
    digits = max(0, 3 - floor(log10(abs(value))))
    return f"{value:,.{digits}f}"
