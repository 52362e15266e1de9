"""Tables, settings and statements as grids of text."""

from __future__ import annotations

import pytest

from rmfs_commands.reproduction.estimates import Estimate
from rmfs_commands.reproduction.grids import number, settings_grid, statements_grid, table_grid
from rmfs_commands.reproduction.paper import Exhibit, Range
from rmfs_commands.reproduction.settings import Setting
from rmfs_commands.reproduction.statements import Comparison, Statement
from rmfs_commands.reproduction.tables import Line, Table, in_range

EXHIBIT = Exhibit("visits", "fig:visits", "Figure 10", "Visits", "They are fewer.")
PRINTED = Exhibit("time", "tab:time", "Table 4", "Time", "It is short.", rounded_to=0.01)


def cells(*lines: Line, exhibit: Exhibit = EXHIBIT, digits: int = 2) -> tuple[tuple[str, ...], ...]:
    """Return the rows of a table's grid."""
    return table_grid(Table(exhibit, lines, "", digits)).rows


def test_a_table_has_the_papers_figure_beside_ours() -> None:
    """Title and sentences of the exhibit, what ours is, the unit in the headings."""
    line = in_range(("50 orders", "integrated"), Range(0.7, 0.8), Estimate(0.75, 0.01, 8, 8))
    grid = table_grid(Table(EXHIBIT, (line,), "s", 2, what="a mean"))
    assert (grid.title, grid.notes) == ("Figure 10: Visits", ("The paper: They are fewer.", "Here: a mean."))
    assert grid.columns == ("", "paper (s)", "ours (s)", "verdict", "runs")
    assert grid.rows == (("50 orders, integrated", "0.70 to 0.80", "0.75 ± 0.01", "in range", "8"),)
    assert table_grid(Table(EXHIBIT, (line,), "", 2)).columns[:3] == ("", "paper", "ours")


def test_figures_have_the_digits_that_make_sense() -> None:
    """Ours those of the table, a printed one of the paper as many as it prints, ranges two at most."""
    ours = Estimate(1234.56789, 0.5, 2, 2)
    assert cells(in_range(("a",), Range(0.7, 0.8), ours), digits=4)[0][1:3] == ("0.70 to 0.80", "1,234.5679 ± 0.5000")
    assert cells(in_range(("a",), Range(1.0, 2.0, 1.5), ours), exhibit=PRINTED, digits=0)[0][1:3] == (
        "1.50",
        "1,235 ± 0",
    )
    assert cells(in_range(("a",), Range(1.5, 1.5, 1.5), ours), digits=1)[0][1] == "1.5"


def test_what_is_missing_is_a_dash() -> None:
    """No figure in the paper, no run, runs that did not count, a single seed."""
    assert cells(in_range(("a",), None, Estimate(2.0, None, 1, 1)))[0][1:] == (
        "-",
        "2.00",
        "no number in the paper",
        "1",
    )
    assert cells(in_range(("a",), Range(1.0, 2.0), None))[0][1:] == ("1.00 to 2.00", "-", "no complete run", "0")
    assert cells(in_range(("a",), Range(1.0, 2.0), Estimate(2.0, None, 1, 3)))[0][-1] == "1 of 3"


def test_settings_have_their_verdict() -> None:
    """The paper's value, ours, and whether they are the same."""
    grid = settings_grid(EXHIBIT, [Setting("Robots", "8", "8"), Setting("PP", "WHCA*n", "sipp")])
    assert grid.rows == (("Robots", "8", "8", "same"), ("PP", "WHCA*n", "sipp", "differs"))


def test_statements_name_where_they_do_not_hold() -> None:
    """With the two figures; nothing is named where all comparisons hold."""
    fine, wrong = Comparison("50 orders", 0.5, 1.0), Comparison("150 orders", 1234.5, 0.0123456)
    grid = statements_grid(
        [Statement("Figure 11", "It is less.", (fine, wrong)), Statement("Figure 12", "It is, too.", (fine,))]
    )
    assert grid.rows == (
        ("Figure 11", "It is less.", "holds in 1 of 2", "150 orders: 1,234 against 0.01235"),
        ("Figure 12", "It is, too.", "holds", ""),
    )


@pytest.mark.parametrize(
    ("value", "text"), [(0.0, "0"), (0.012345, "0.01235"), (1.0034, "1.003"), (12345.0, "12,345"), (-2.5, "-2.500")]
)
def test_four_significant_digits(value: float, text: str) -> None:
    """However small or large."""
    assert number(value) == text
