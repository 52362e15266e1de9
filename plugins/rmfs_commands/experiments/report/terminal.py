"""A comparison on the terminal."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table
from rich.text import Text

from rmfs_commands.cli.screen import new_table, print_named
from rmfs_commands.experiments.compare import Comparison
from rmfs_commands.experiments.report import numbers
from rmfs_commands.experiments.running import ExperimentResult
from rmfs_core.wording import counted

MOST_SETS = 6
"""With more instance sets than these the terminal has the overall figures alone."""
MOST_ERRORS = 5
OF_BOUND = "x bound: how many times what no rules can beat, mean over the same runs."


def print_comparison(console: Console, result: ExperimentResult, comparison: Comparison) -> None:
    """Print how the runs ended, then one table for each metric."""
    shown = comparison.instance_sets if len(comparison.instance_sets) <= MOST_SETS else comparison.instance_sets[-1:]
    console.print()
    print_named(console, _counts(comparison))
    for row in result.failed[:MOST_ERRORS]:
        text = f"{row['instance']}, {row['rule_set']}, seed {row['seed']}: {row['error']}"
        console.print(Text.assemble(("Failed: ", "red"), text), soft_wrap=True)
    if len(result.failed) > MOST_ERRORS:
        console.print(f"and {counted(len(result.failed) - MOST_ERRORS, 'more failed run')}.", highlight=False)
    if result.failed:
        console.print()
    if len(result.failed) == len(result.rows):
        console.print("All runs failed: there is nothing to compare.", style="yellow", highlight=False)
        return
    for metric in comparison.metrics:
        print_named(console, _metric(comparison, metric, shown))
        for sentence in (told := numbers.other_signs(comparison, metric, shown)):
            console.print(sentence, style="yellow", highlight=False, markup=False)
        if told:
            console.print()
    for first, second in comparison.fronts:
        print_named(console, _front(comparison, first, second, shown))
    for sentence in numbers.left_out(comparison, shown):
        console.print(sentence, style="yellow", highlight=False, markup=False)
    console.print(numbers.caption(comparison), style="dim", highlight=False, markup=False)
    if any(map(comparison.bounded, comparison.metrics)):
        console.print(OF_BOUND, style="dim", highlight=False, markup=False)


def _counts(comparison: Comparison) -> Table:
    table = new_table("Runs")
    table.add_column("Rule set")
    partial = any(one.partial for one in comparison.counted) or not comparison.horizon
    ends = ("Complete", *["Horizon"] * comparison.horizon, *["Partial"] * partial)
    for name in ("Runs", *ends, "Failed", "Stood still", "Stopped early"):
        table.add_column(name, justify="right")
    for one in comparison.counted:
        if one.instances != comparison.instance_sets[-1]:
            continue
        bad = (one.failed, one.stood_still, one.stopped_early)
        table.add_row(
            Text(one.rule_set),
            str(one.runs),
            str(one.complete),
            *([str(one.horizon)] * comparison.horizon),
            *([Text(str(one.partial), "yellow" if one.partial else "")] * partial),
            *(Text(str(count), "bold red" if count else "") for count in bad),
        )
    return table


def _metric(comparison: Comparison, metric: str, shown: tuple[str, ...]) -> Table:
    """Return the table of a metric: differences with interval and p, and what share of the baseline they are."""
    shown_as = comparison.described(metric)
    relative = numbers.has_relative(comparison, metric, shown)
    table = new_table(numbers.heading(comparison, metric))
    table.add_column("Rule set")
    tested = comparison.tested
    columns = [numbers.difference_heading(shown_as), *["p (Holm)"] * tested, *["Relative"] * relative]
    bounded = comparison.bounded(metric)
    for name in ("Seeds", "Mean", *(["x bound"] if bounded else []), *columns):
        table.add_column(name, justify="right")
    for instances in shown:
        if len(shown) > 1:
            table.add_row(Text(instances, "cyan"))
        for one in comparison.of(instances, metric):
            name = f"  {one.rule_set}" if len(shown) > 1 else one.rule_set
            means = [numbers.value(shown_as, one.mean), *([numbers.times(one.times_bound)] if bounded else [])]
            if one.rule_set == comparison.baseline:
                table.add_row(Text(name), numbers.seeds(one), *means, Text("baseline", "dim"))
                continue
            cells = [numbers.difference(shown_as, one.difference, bounds=tested)]
            cells += [numbers.probability(one.difference.p_holm)] * tested
            cells += [numbers.relative(one, bounds=False)] * relative
            table.add_row(Text(name), numbers.seeds(one), *means, *cells)
    return table


def _front(comparison: Comparison, first: str, second: str, shown: tuple[str, ...]) -> Table:
    """Return the table of the rule sets that none beats in two metrics at once."""
    metrics = comparison.described(first), comparison.described(second)
    names = [numbers.heading(comparison, metric) for metric in (first, second)]
    table = new_table("None beats these in both")
    table.add_column("Rule set")
    for name in names:
        table.add_column(name, justify="right")
    for instances in shown:
        if len(shown) > 1:
            table.add_row(Text(instances, "cyan"))
        for pair in comparison.front(instances, first, second):
            means = [numbers.value(metric, one.mean) for metric, one in zip(metrics, pair, strict=True)]
            table.add_row(Text(f"  {pair[0].rule_set}" if len(shown) > 1 else pair[0].rule_set), *means)
    return table
