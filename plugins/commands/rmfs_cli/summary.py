"""The table of metrics at the end of a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Console, Group, RenderableType
from rich.rule import Rule
from rich.table import Table
from rich.text import Text

from rmfs_core.results import Result
from rmfs_core.results.catalogue import METRICS, TIMING, Metric, show
from rmfs_details.catalogue import DETAILS, KNOWN

LEFT = ("Orders", "Robots", "Decisions")
RIGHT = ("Pods", "Throughput")
LATE = KNOWN.keys() - {metric.name for metric in DETAILS}
NARROW = 76
STATUS_STYLE = {"complete": "bold green", "partial": "bold yellow", "failed": "bold red"}


def print_summary(console: Console, name: str, result: Result) -> None:
    """Print every metric with its unit: in two columns, or in one where the console is narrow."""
    title = Text.assemble((name, "bold"), f", seed {result.seed}: ", (result.status, STATUS_STYLE[result.status]))
    # One of the two: a run with orders left has no makespan, and one without was simulated for that long.
    unsaid = "makespan_s" if result.metrics["makespan_s"] is None else "simulated_s"
    metrics = {name: tuple(one for one in group if one.name != unsaid) for name, group in METRICS.items()}
    left = [_group(group, metrics[group], result.metrics) for group in LEFT]
    right = [_group(group, metrics[group], result.metrics) for group in RIGHT]
    catalogue = {metric.name for group in METRICS.values() for metric in group}
    if late := [KNOWN[name] for name in result.metrics if name in LATE]:
        right.append(_group("Due times", late, result.metrics))
    catalogue |= KNOWN.keys()
    others = [result.described.get(name) or Metric(name) for name in result.metrics if name not in catalogue]
    if others:
        right.append(_group("Observers", others, result.metrics))
    right.append(_group("Wall clock", TIMING, result.timing))
    console.print()
    console.print(Rule(title, align="left", style="dim"))
    if console.width < NARROW:
        console.print(_stack([*left, *right]))
        return
    columns = Table.grid(padding=(0, 4), expand=console.width < 2 * NARROW)
    columns.add_column(ratio=1)
    columns.add_column(ratio=1)
    columns.add_row(_stack(left), _stack(right))
    console.print(columns, width=min(console.width, NARROW + 24))


PROFILE = {
    "tables": "Tables of travel times",
    "queries": "Path queries",
    "rules": "Other decision rules",
    "observers": "Observers (metrics, display, trace)",
    "events": "Events: robots, stations, reservations",
}


def print_profile(console: Console, result: Result) -> None:
    """Print what the wall-clock time of a run went to, and the time in each hook."""
    seconds, hooks = result.timing["profile_s"], result.timing["hook_s"]
    total = sum(seconds.values())
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column("Where the time went", header_style="bold cyan")
    table.add_column("s", justify="right", header_style="bold cyan")
    table.add_column("%", justify="right", header_style="bold cyan")
    for key, label in PROFILE.items():
        table.add_row(label, f"{seconds[key]:.3f}", f"{100 * seconds[key] / total:.1f}" if total else "")
    table.add_section()
    for hook, spent in sorted(hooks.items(), key=lambda entry: -entry[1]):
        table.add_row(Text(f"  in {hook}", style="dim"), Text(f"{spent:.3f}", style="dim"), "")
    console.print()
    console.print(table)


def _stack(groups: list[Table]) -> RenderableType:
    spaced: list[RenderableType] = []
    for group in groups:
        spaced += [Text(), group]
    return Group(*spaced[1:])


def _group(name: str, metrics: Sequence[Metric], values: Mapping[str, Any]) -> Table:
    table = Table(box=None, expand=True, show_header=True, padding=(0, 1, 0, 0), pad_edge=False)
    table.add_column(name, header_style="bold cyan", overflow="fold", ratio=1)
    table.add_column(justify="right", no_wrap=True)
    table.add_column(style="dim", no_wrap=True, min_width=1)
    for metric in metrics:
        value = values.get(metric.name)
        table.add_row(metric.label, show(metric, value), metric.unit if value is not None else "")
    return table
