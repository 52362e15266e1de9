"""A comparison on the terminal."""

from __future__ import annotations

from rich.console import Console
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from rmfs_cli.screen import new_table, print_named
from rmfs_experiments.compare import Comparison
from rmfs_experiments.report import numbers
from rmfs_experiments.running import ExperimentResult

MOST_SETS = 6
"""With more instance sets than these the terminal has the overall figures alone."""
MOST_ERRORS = 5
WIDE = 100
"""Columns from which on absolute differences are shown beside the relative ones."""


def print_comparison(console: Console, result: ExperimentResult, comparison: Comparison) -> None:
    """Print how the runs ended, then one table for each metric."""
    shown = comparison.instance_sets if len(comparison.instance_sets) <= MOST_SETS else comparison.instance_sets[-1:]
    console.print()
    print_named(console, _counts(comparison))
    for row in result.failed[:MOST_ERRORS]:
        text = f"{row['instance']}, {row['rule_set']}, seed {row['seed']}: {row['error']}"
        console.print(Text.assemble(("Failed: ", "red"), text), soft_wrap=True)
    if len(result.failed) > MOST_ERRORS:
        console.print(f"and {len(result.failed) - MOST_ERRORS} more failed runs.", highlight=False)
    if result.failed:
        console.print()
    for metric in comparison.metrics:
        print_named(console, _metric(comparison, metric, shown, console.width >= WIDE))
    console.print(
        f'Differences from "{comparison.baseline}", means of pairs of runs of the same instance and seed, with 95 % '
        "Student t intervals; p of the paired t test, corrected for the number of rule sets after Holm.",
        style="dim",
        highlight=False,
    )


def _counts(comparison: Comparison) -> Table:
    table = new_table("Runs")
    table.add_column("Rule set")
    for name in ("Runs", "Complete", "Partial", "Failed", "Stood still", "Stopped early"):
        table.add_column(name, justify="right")
    for one in comparison.counted:
        if one.instances != comparison.instance_sets[-1]:
            continue
        bad = (one.failed, one.stood_still, one.stopped_early)
        table.add_row(
            Text(one.rule_set),
            str(one.runs),
            str(one.complete),
            Text(str(one.partial), "yellow" if one.partial else ""),
            *(Text(str(count), "bold red" if count else "") for count in bad),
        )
    return table


def _metric(comparison: Comparison, metric: str, shown: tuple[str, ...], wide: bool) -> Table:
    shown_as = comparison.described(metric)
    table = new_table(escape(numbers.title(shown_as)))
    table.add_column("Rule set")
    for name in ("Pairs", "Mean", *(["Difference"] if wide else []), "Relative", "p (Holm)"):
        table.add_column(name, justify="right")
    for instances in shown:
        if len(shown) > 1:
            table.add_row(Text(instances, "cyan"))
        for one in comparison.of(instances, metric):
            name = f"  {one.rule_set}" if len(shown) > 1 else one.rule_set
            mean = numbers.value(shown_as, one.mean)
            if one.rule_set == comparison.baseline:
                table.add_row(Text(name), "", mean, Text("baseline", "dim"))
                continue
            differences = [numbers.difference(shown_as, one.difference)] if wide else []
            table.add_row(
                Text(name),
                numbers.pairs(one),
                mean,
                *differences,
                numbers.relative(one.relative),
                numbers.probability(one.p_holm),
            )
    return table
