"""Tables for papers: LaTeX and CSV."""

from __future__ import annotations

import csv
import io
import re
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from rmfs_commands.cli.grids import Grid, file_name, grid_csv, latex_text, to_latex, write_grid

GRID = Grid(
    "Visits & more",
    ("50 % of them.",),
    ("Rule set", "Mean"),
    [("pod-match_2", "0.90 ± 0.1"), ("[x]", "−1")],  # noqa: RUF001
    right=(1,),
)
COMMANDS = re.compile(r"\\text\w+\{\}|\{\\char34\}|\\[&%$#_]|\$(?:\\pm|\\times|-)\$")
"""What a text may have of LaTeX: signs by name, signs that are written with a backslash, and three in formulas."""


def test_latex() -> None:
    """Figures are aligned on the right, no sign is a command, and a bracket is no argument of the row's end above."""
    assert to_latex(GRID) == "\n".join(
        [
            r"\begin{table}",
            r"  \centering",
            r"  \caption{Visits \& more}",
            r"  \begin{tabular}{@{}lr@{}}",
            r"    \toprule",
            r"    Rule set & Mean \\",
            r"    \midrule",
            r"    pod-match\_2 & 0.90 $\pm$ 0.1 \\",
            r"    {[x]} & $-$1 \\",
            r"    \bottomrule",
            r"  \end{tabular}",
            r"  % 50 % of them.",
            r"\end{table}",
            "",
        ]
    )


@given(st.text())
def test_no_text_is_a_command(text: str) -> None:
    """Whatever a rule set is called, LaTeX prints it."""
    assert not set(COMMANDS.sub("", latex_text(text))) & set("\\{}&%$#_^\n")


def test_csv_has_the_cells_and_no_formula() -> None:
    """A name that a spreadsheet would compute is a text; a figure with a sign is left as it is."""
    grid = Grid("", (), ("Rule\nset", "p", "p"), [("=1+1", "+3 %", "-")], right=(1, 2))
    assert list(csv.reader(io.StringIO(grid_csv(grid)))) == [["Rule set", "p", "p"], ["'=1+1", "+3 %", "-"]]


def test_the_ending_says_what_is_written(tmp_path: Path) -> None:
    """LaTeX or CSV."""
    for name, content in (("a.tex", to_latex(GRID)), ("a.csv", grid_csv(GRID))):
        write_grid(GRID, tmp_path / name)
        assert (tmp_path / name).read_text(encoding="utf-8") == content


def test_files_are_named_after_what_comes_first() -> None:
    """What follows a comma, a colon or a bracket would make names long."""
    assert file_name("Tables 1 and 2, Figure 9: instances (all)") == "tables-1-and-2"
    assert file_name("Section 4.2: picks") == "section-4-2"
