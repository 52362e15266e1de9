"""The report in one table."""

from __future__ import annotations

from rmfs_commands.reproduction.estimates import Estimate
from rmfs_commands.reproduction.overview import overview
from rmfs_commands.reproduction.paper import Exhibit, Range
from rmfs_commands.reproduction.settings import Setting
from rmfs_commands.reproduction.statements import Comparison, Statement
from rmfs_commands.reproduction.tables import Line, Table, as_factor, in_range

EXHIBIT = Exhibit("visits", "fig:visits", "Figure 10", "Visits", "They are fewer.")
ONE = Range(0.9, 1.1)


def at(mean: float) -> Estimate:
    """Return an estimate with this mean."""
    return Estimate(mean, None, 1, 1)


def outcome(*lines: Line) -> str:
    """Return what the overview says of a table of these lines."""
    (row,) = overview([Table(EXHIBIT, lines, "", 2)], [], []).rows
    assert row[:3] == ("Figure 10", "Visits", str(len(lines)))
    return row[3]


def test_verdicts_are_counted_the_usual_ones_first() -> None:
    """Agreement, then what lies below or above, then what cannot be compared."""
    lines = [
        in_range(("a",), ONE, at(2.0)),
        in_range(("b",), ONE, None),
        in_range(("c",), None, at(1.0)),
        in_range(("d",), ONE, at(0.1)),
        in_range(("e",), ONE, at(1.0)),
        in_range(("f",), ONE, at(1.1)),
    ]
    assert outcome(*lines) == "2 in range, 1 below, 1 above, 1 no number in the paper, 1 no complete run"


def test_speedups_are_a_span() -> None:
    """From the slowest to the fastest; lines without one are counted before."""
    fast, slow = as_factor(("a",), ONE, at(0.01)), as_factor(("b",), ONE, at(2.0))
    assert outcome(fast, slow) == "from 2.0 times slower to 100 times faster"
    assert outcome(fast, as_factor(("c",), None, at(1.0))) == (
        "1 no number in the paper; from 100 times faster to 100 times faster"
    )


def test_settings_come_first_and_statements_last() -> None:
    """Each in a row; neither where there is none."""
    table = Table(EXHIBIT, (in_range(("a",), ONE, at(1.0)),), "", 2)
    settings = [Setting("Robots", "8", "8"), Setting("PP", "WHCA*n", "sipp"), Setting("PR", "nearest", "nearest")]
    held = Statement("Figure 11", "It is less.", (Comparison("50 orders", 0.5, 1.0),))
    grid = overview([table], settings, [held, Statement("Figure 12", "So.", ())])
    assert grid.rows == (
        ("Section 4.1", "Settings", "3", "2 same, 1 differs"),
        ("Figure 10", "Visits", "1", "1 in range"),
        ("Section 4.2", "What it says in words", "2", "1 holds, 1 no complete run"),
    )
