"""The table of metrics at the end of a run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import zip_longest
from textwrap import wrap
from typing import Any

from rich.console import Console, Group, RenderableType
from rich.measure import Measurement
from rich.rule import Rule
from rich.table import Table
from rich.text import Text

from rmfs_commands.cli.screen import new_table
from rmfs_commands.results.figures import TIMING, by_heading, show
from rmfs_core.results import Result
from rmfs_core.results.catalogue import Metric
from rmfs_core.wording import counted

LEFT = ("Orders", "Robots", "Decisions")
CANCELLED = "orders_cancelled"
NARROW = 76
STATUS_STYLE = {"complete": "bold green", "horizon": "bold green", "partial": "bold yellow", "failed": "bold red"}

GAPS = (
    Metric("ended_at_effort", "  at their effort", "", 0, "Of these, decisions whose effort was used up."),
    Metric("largest_gap", "  largest gap", "%", 1, "Largest distance of an objective to its bound, as its share."),
)


def gap_of(objective: float | None, bound: float | None) -> float | None:
    """Return how far a bound lies below an objective, as a share of this; None where one is missing."""
    return None if not objective or bound is None else (objective - bound) / abs(objective)


def gaps_of(periods: Sequence[Mapping[str, Any]]) -> dict[str, float]:
    """Return how many decisions ended at their effort, and the largest gap in percent, where solves stopped early.

    Parameters
    ----------
    periods
        Rows of periods.csv.
    """
    early = [row for row in periods if row["stopped_early"]]
    if not early:
        return {}
    found: dict[str, float] = {"ended_at_effort": sum(row["status"] == "effort" for row in early)}
    gaps = [gap for row in early if (gap := gap_of(row["objective"], row["bound"])) is not None]
    return {**found, "largest_gap": 100 * max(gaps)} if gaps else found


def print_summary(console: Console, name: str, result: Result) -> None:
    """Print every metric with its unit: in two columns, or in one where the console is narrow."""
    title = Text.assemble((name, "bold"), f", seed {result.seed}: ", (result.status, STATUS_STYLE[result.status]))
    # One of the two: a run with orders left has no makespan, and one without was simulated for that long.
    unsaid = "makespan_s" if result.metrics.get("makespan_s") is None else "simulated_s"
    gaps = gaps_of(result.periods)
    groups = by_heading([name for name in result.metrics if name != unsaid], result.described)
    groups.setdefault("Decisions", []).extend(one for one in GAPS if one.name in gaps)
    if CANCELLED in result.metrics and CANCELLED in result.described:  # or some in all would be missing
        at = [one.name for one in groups["Orders"]].index("orders_total") + 1
        groups["Orders"].insert(at, result.described[CANCELLED])
    left = [_group(heading, groups.pop(heading, []), {**result.metrics, **gaps}) for heading in LEFT]
    right = [_group(heading, metrics, result.metrics) for heading, metrics in groups.items()]
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


PARTS = {
    "before": "before the run",
    "stock": "waiting for stock",
    "room": "waiting for station capacity",
    "robot": "waiting for a robot",
    "pod": "waiting for the pod",
    "driving": "driving",
    "queueing": "queueing",
    "picking": "picking",
    "hands": "the picker's hands",
}
"""Parts of the turn-over time: what was before a run that begins in a state, four times of waiting, and four with the
pod under way."""


def print_bottleneck(console: Console, result: Result) -> None:
    """Print where the turn-over time went, what pickers and robots did, and what limits the run, as far as known."""
    if (found := result.summary.get("bottleneck")) is None:
        return
    parts = found.get("turnover_parts_s", {})
    console.print()
    if whole := sum(seconds or 0.0 for seconds in parts.values()):
        told = f"of {whole:,.1f} s went"
        if result.status != "complete":
            told = f"of the {counted(found['completed'], 'completed order')} went: {whole:,.1f} s"
        if "packing" in found:
            told += ", picking only"
        console.print(Text(f"Where the turn-over time {told}", style="bold cyan"))
        cells = [
            (PARTS[part], f"{seconds:,.{seconds < 10_000:d}f} s", f"{100 * seconds / whole:.0f} %")
            for part, seconds in parts.items()
        ]
        grid = Table.grid(padding=(0, 2, 0, 0))
        half, blank = -(-len(cells) // 2), ("", "", "")
        pairs = zip_longest(cells[:half], cells[half:], fillvalue=blank)
        rows = [(one,) for one in cells] if console.width < NARROW else pairs
        for row in rows:
            grid.add_row(*(cell for one in row for cell in one))
        for column in grid.columns:
            column.justify = "right"
        for column in grid.columns[::3]:
            column.justify = "left"
        if Measurement.get(console, console.options.update(max_width=200), grid).maximum > console.width:
            grid.padding = (0, 1, 0, 0)
        console.print(grid)
    lines = Table.grid(padding=(0, 1, 0, 0))
    lines.add_column(style="bold cyan", no_wrap=True)
    lines.add_column()
    outages = result.summary.get("outages")
    for label, text in (*bottleneck_lines(found), *([("Outages", outages)] if outages else [])):
        # Rich breaks lines at no-break spaces too, textwrap does not
        wrapped = wrap(text.replace(" %", "\N{NO-BREAK SPACE}%"), max(console.width - 8, 20), break_long_words=False)
        lines.add_row(label, Text("\n".join(wrapped).replace("\N{NO-BREAK SPACE}", " ")))
    if lines.row_count:
        console.print(lines)


def bottleneck_lines(found: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield what pickers and robots did, and what limits the run, each with its label."""
    ends = [found[name] for name in ("busiest_station", "idlest_station") if found.get(name)]
    named = ", ".join(f"station {one['station']} {one['handling_percent']:.0f} %" for one in ends)
    for label, does in (("Pickers", PICKERS), ("Robots", ROBOTS)):
        shares = found.get(f"{label.lower()}_percent", {})
        shown = {what: share for what, share in shares.items() if share and round(share)}
        if shown:
            several = label == "Pickers" and "handling" in shown and len({*map(str, ends)}) > 1
            yield label, _shares(shown, does, named if several else "")
    says, packing = [*found.get("says", ())], "packing" in found
    yield from zip(("Limit", "Gain"), says[: -1 if packing else None], strict=False)
    if packing:
        yield "Packing", says[-1]


def _shares(shown: Mapping[str, float], does: Mapping[str, str], named: str) -> str:
    """Return some shares in words, after the first of them the stations with the most and the least."""
    first, *rest = (f"{share:.0f} % {does[what]}" for what, share in shown.items())
    return ", ".join([f"{first} ({named})" if named else first, *rest])


PICKERS = {"handling": "handling", "waiting": "waiting", "idle": "idle", "down": "out of service"}
ROBOTS = {
    "idle": "idle",
    "driving": "driving",
    "traffic": "in traffic",
    "queueing": "queueing",
    "at_station": "at stations",
    "charging": "charging",
    "low": "battery low",
    "off": "off duty",
    "down": "out of service",
}
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
    table = new_table()
    table.add_column("Where the time went")
    table.add_column("s", justify="right")
    table.add_column("%", justify="right")
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
        unit = metric.unit if value is not None else ""
        table.add_row(Text(metric.label), show(metric, value), Text(unit))  # an observer's are no markup
    return table
