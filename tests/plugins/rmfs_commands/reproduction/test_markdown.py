"""The report as Markdown."""

from __future__ import annotations

import re

from rmfs_commands.cli.grids import Grid
from rmfs_commands.experiments.report.plots import Plot
from rmfs_commands.reproduction.markdown import to_markdown
from rmfs_commands.reproduction.report import Report


def test_markdown_tables_are_well_formed(report: Report) -> None:
    """Every row of a table has as many cells as its head; a bar within a cell is escaped."""
    text = to_markdown(report)
    assert "- Command: `rmfs reproduce`" in text
    assert r"robot 3 \| waits for 4" in text
    for block in re.findall(r"(?:^\|.*\n)+", text, re.MULTILINE):
        cells = [len(re.split(r"(?<!\\)\|", line)) for line in block.splitlines()]
        assert len(set(cells)) == 1, block
    for plot in report.plots:
        assert f"({plot.name}.png)" in text


def test_a_small_report() -> None:
    """Facts as a list, the command as code; a heading for each grid, figures on the right; pictures in their place."""
    grid = Grid("Figure 1: Visits", ("A note.", "Another."), ("what", "ours"), (("two\nlines", "1.5"),), right=(1,))
    report = Report({"Command": "rmfs reproduce", "Time": "3 s"}, [grid, Plot("visits", "Visits drawn", b"", b"", b"")])
    assert (
        to_markdown(report)
        == """\
# The paper's evaluation, and ours

- Command: `rmfs reproduce`
- Time: 3 s

## Figure 1: Visits

A note.

Another.

| what | ours |
|---|---:|
| two lines | 1.5 |

![Visits drawn](visits.png)
"""
    )
