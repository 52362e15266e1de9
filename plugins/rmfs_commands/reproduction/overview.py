"""The report in one table: how many of the paper's figures each exhibit of ours meets."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from rmfs_commands.cli.grids import Grid
from rmfs_commands.reproduction.settings import Setting
from rmfs_commands.reproduction.statements import Statement
from rmfs_commands.reproduction.tables import ABOVE, BELOW, IN_RANGE, NO_NUMBER, NO_RUN, Line, Table, speed


def overview(tables: Sequence[Table], settings: Sequence[Setting], statements: Sequence[Statement]) -> Grid:
    """Return a row for each exhibit: the number of figures, and what became of them."""
    rows = [
        (table.exhibit.item, table.exhibit.caption, str(len(table.lines)), _outcome(table.lines)) for table in tables
    ]
    if settings:
        rows.insert(0, ("Section 4.1", "Settings", str(len(settings)), _counted([entry.verdict for entry in settings])))
    if statements:
        verdicts = [statement.verdict for statement in statements]
        rows.append(("Section 4.2", "What it says in words", str(len(statements)), _counted(verdicts)))
    notes = (
        "A verdict compares our mean with the paper's figure or range: a single percentage of its text is taken as "
        "itself plus or minus 5 percentage points, a figure of a table as right to half of its last digit.",
        "± is half of the 95 % confidence interval over seeds (Student t). Figures relative to other rules are ratios "
        "of means over the same instances on the same seed, averaged over seeds.",
    )
    return Grid("Overview", notes, ("exhibit", "what", "figures", "ours"), tuple(rows), right=(2,))


def _outcome(lines: Sequence[Line]) -> str:
    speedups = [line.speedup for line in lines if line.speedup is not None]
    rest = [line.verdict for line in lines if line.speedup is None]
    parts = [_counted(rest)] if rest else []
    if speedups:
        parts.append(f"from {speed(min(speedups))} to {speed(max(speedups))}")
    return "; ".join(parts)


def _counted(verdicts: Sequence[str]) -> str:
    """Return how often each verdict occurs, the usual ones first."""
    counts = Counter(verdicts)
    usual = [verdict for verdict in ("same", "holds", IN_RANGE, BELOW, ABOVE, NO_NUMBER, NO_RUN) if verdict in counts]
    return ", ".join(f"{counts[verdict]} {verdict}" for verdict in dict.fromkeys([*usual, *counts]))
