"""The page on a run: figures of its files as its template shows them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from statistics import fmean
from typing import Any
from urllib.parse import quote

from markupsafe import Markup

from rmfs_commands.cli.display import duration
from rmfs_commands.cli.not_simulated import NOT_SIMULATED
from rmfs_commands.cli.pages import render
from rmfs_commands.cli.summary import PARTS, bottleneck_lines
from rmfs_commands.details.bottleneck import PARTS as COLUMNS
from rmfs_commands.layouts.hall import HALL_STYLE, hall_legend
from rmfs_commands.report.drawing import Series, chart, nice, stacked
from rmfs_commands.report.hall import heat_maps
from rmfs_commands.report.reading import Row, Run
from rmfs_commands.results.figures import by_heading, show
from rmfs_commands.states.stories import Episode, order_stories
from rmfs_core.scenario.rulenames import rule_choices
from rmfs_core.wording import counted

TEMPLATE = Path(__file__).parent / "report.html.j2"
PICKERS = {
    "busy": ("handling items", 3),
    "waiting": ("waiting for pods", 2),
    "idle": ("idle", 8),
    "down": ("out of service", 12),
}
ROBOTS = {
    "to_pod": ("to a pod", 6),
    "to_station": ("to a station", 1),
    "station": ("at the station", 3),
    "storing": ("storing", 9),
    "queue": ("in the queue", 5),
    "waiting": ("waiting for robots or a queue cell", 2),
    "to_rest": ("to rest", 10),
    "charging": ("charging", 4),
    "low": ("battery low", 13),
    "moving_pods": ("moving pods", 7),
    "idle": ("idle", 8),
    "off": ("off duty", 11),
    "down": ("out of service", 12),
}
"""Activities of pickers and robots, with the number of their colour, by the columns of stations.csv and robots.csv."""
SLOWEST_PERCENT = 5
WORTH_SAYING = 0.05
"""Share of an order's turn-over time from which on a part of it is a cause."""
MOST_CAUSES = 3
BARS = 24
"""About so many has the distribution."""


def run_page(run: Run, limit: int, replay: str | None) -> str:
    """Return the page.

    Parameters
    ----------
    run
        The run to report.
    limit
        How many orders of each kind are listed.
    replay
        Address of the page of `rmfs replay`; None where there is none.
    """
    listed = _listed(run, limit)
    names = dict.fromkeys(row["order"] for _, rows in listed for row in rows)
    told = {} if run.recording is None else order_stories(run.recording, names)
    delays = {row["order"]: row for row in run.delays}
    said = run.result.summary.get("outages")
    outages = {} if said is None else {"Outages": said}
    return render(
        TEMPLATE,
        run=run,
        result=run.result,
        lead=_lead(run),
        limits=dict(bottleneck_lines(run.result.summary.get("bottleneck", {}))) | outages,
        went=_went(run),
        figures=_hours(run),
        peak=_peak(run),
        stations=[_station(row) for row in run.stations],
        down=any("down_s" in row for row in run.stations),
        work=_work(run),
        turnover=_turnover(run),
        listed=[(title, [_order(row, delays[row["order"]], told) for row in rows]) for title, rows in listed],
        packing=list(_packing(run)),
        packed_late=run.result.metrics.get("late_packed"),
        departures=list(_departures(run)),
        costs=list(_costs(run)),
        heats=[] if run.replay is None or run.floor is None else heat_maps(run.replay.start, run.floor),
        legend="" if run.replay is None else Markup(hall_legend(run.replay.start.layout)),
        hall_style=Markup(HALL_STYLE),
        metrics=_metrics(run),
        rules=", ".join(
            f"{'.'.join(map(str, key))} {choice.rule}" for key, choice in rule_choices(run.result.scenario.rules)
        ),
        link=lambda **asked: _link(replay, **asked),
        duration=duration,
        not_simulated=NOT_SIMULATED,
    )


def _link(replay: str | None, **asked: object) -> str | None:
    """Return an address in the replay that begins with what is asked for; None without a replay."""
    return replay and f"{replay}#{'&'.join(f'{key}={quote(str(value))}' for key, value in asked.items())}"


def _lead(run: Run) -> str:
    result = run.result
    done = sum(row["completed_s"] is not None for row in result.orders)
    left = sum(row.get("cancelled_s") is not None for row in result.orders)
    gone = f", {left:,} cancelled" if left else ""
    size = f"{counted(len(run.stations), 'station')}, {counted(len(run.robots), 'robot')}, seed {result.seed}"
    end = duration(result.metrics.get("simulated_s") or 0)
    if result.status == "complete":
        others = "all others" if left else "all"
        return f"{counted(len(result.orders), 'order')}{gone}, {others} complete at {end}. {size}."
    how = {"horizon": "ended at its horizon", "partial": "was interrupted"}.get(result.status, "failed")
    return f"The run {how} at {end}: {done:,} of {counted(len(result.orders), 'order')} complete{gone}. {size}."


def _part_times(row: Row) -> dict[str, float]:
    """Return what an order's turn-over time went to; empty of one that is not complete."""
    if row["turnover_s"] is None:
        return {}
    return {part: sum(row.get(column) or 0.0 for column in columns) for part, columns in COLUMNS.items()}


def _timed(run: Run) -> list[Mapping[str, Any]]:
    """Return the orders whose times count, as in the metrics: orders that arrived in the run, after its warm-up.

    Of a run that goes on from a state, also those that were open in it.
    """
    begin = run.result.scenario.run.warmup_s or 0
    begun = bool(run.result.summary.get("bottleneck", {}).get("turnover_parts_s", {}).get("before"))
    orders = [row for row in _arrived(run) if row.get("cancelled_s") is None]
    return [
        row
        for row in orders
        if row["arrival_s"] >= begin or (begun and (row["completed_s"] is None or row["completed_s"] >= begin))
    ]


def _arrived(run: Run) -> list[Mapping[str, Any]]:
    """Return the orders that arrived before the run ended; of some runs orders.csv has later ones, too."""
    end = run.result.metrics.get("simulated_s") or 0
    return [row for row in run.result.orders if row["arrival_s"] is not None and row["arrival_s"] <= end]


def _went(run: Run) -> tuple[list[str], list[tuple[str, list[tuple[str, str]]]]]:
    """Return whose time is told, and for each part its seconds and its share, means over all, the slowest and late."""
    counts = {row["order"] for row in _timed(run)}
    done = [row for row in run.delays if row["turnover_s"] is not None and row["order"] in counts]
    done.sort(key=lambda row: -row["turnover_s"])
    late = {row["order"] for row in _late(run)}
    groups = {
        f"All {len(done):,} completed": done,
        f"Slowest {SLOWEST_PERCENT} %": done[: max(len(done) * SLOWEST_PERCENT // 100, 1)],
        "Late": [row for row in done if row["order"] in late],
    }
    means = {}
    for name, rows in groups.items():
        if rows:
            times = [_part_times(row) for row in rows]
            means[name] = {part: fmean(of[part] for of in times) for part in COLUMNS}
    table = [
        (
            PARTS[part],
            [(f"{of[part]:,.1f} s", f"{100 * of[part] / (sum(of.values()) or 1):.0f} %") for of in means.values()],
        )
        for part in COLUMNS
        if any(of[part] for of in means.values())
    ]
    return list(means), table


def _hours(run: Run) -> list[Markup]:
    def of(column: str) -> list[float]:
        return [row[column] for row in run.hours]

    charts = {
        "Orders": [Series("arrived", of("orders_in")), Series("complete", of("orders_out"), 2, line=True)],
        "Items picked": [Series("picks", of("picks"), 3)],
        "Backlog at the end of the hour": [Series("orders", of("backlog"), 4)],
    }
    late, first = [0.0] * len(run.hours), int(run.hours[0]["hour"]) if run.hours else 0
    for row in _late(run):
        if (hour := int(row["due_s"] // 3600) - first) >= 0:
            late[min(hour, len(late) - 1)] += 1
    charts["Late orders, by the hour in which they were due"] = [Series("late", late, 2)]
    seen = [(title, series) for title, series in charts.items() if any(any(s.values) for s in series)]
    return [chart(title, series, 1, "hour", shown=lambda hour: f"{first + hour:,g}") for title, series in seen]


def _peak(run: Run) -> tuple[str, float] | None:
    """Return the largest backlog at the end of an hour, and when that was: the last hour ends with the run."""
    peak = max(run.hours, key=lambda row: row["backlog"], default=None)
    if peak is None or not peak["backlog"]:
        return None
    end = run.result.metrics.get("simulated_s") or 0
    return counted(int(peak["backlog"]), "order"), min(3600 * (peak["hour"] + 1), end)


def _late(run: Run) -> list[Mapping[str, Any]]:
    """Return the orders that were completed late, or were due and not complete at the end, the latest first."""
    end = run.result.metrics.get("simulated_s") or 0
    late = [
        {**row, "late_s": row["lateness_s"] if row["completed_s"] is not None else end - row["due_s"]}
        for row in _timed(run)
        if row.get("due_s") is not None
    ]
    return sorted((row for row in late if (row["late_s"] or 0) > 0), key=lambda row: -row["late_s"])


def _station(row: Row) -> tuple[str, ...]:
    shown = {does: row[f"{does}_s"] for does in PICKERS if f"{does}_s" in row}
    out = shown.pop("down", None) if "open_s" in row else None
    whole = sum(shown.values())
    shares = [f"{100 * time / whole:.0f} %" if whole else "-" for time in shown.values()]
    times = shares if out is None else [*shares, f"{out / 3600:.1f} h"]  # outages go on while it is closed
    name = row["station"] if row.get("open_s") != 0 else f"{row['station']} (never open)"
    counts = (f"{row['picks']:,.0f}", f"{row['visits']:,.0f}")
    return (name, *counts, *times, f"{row['queue_mean']:.1f}", f"{row['queue_max']:.0f}")


def _work(run: Run) -> list[Markup]:
    def parts(rows: Sequence[Row], does: Mapping[str, tuple[str, int]]) -> list[Series]:
        return [
            Series(name, [row.get(f"{state}_s") or 0.0 for row in rows], colour)
            for state, (name, colour) in does.items()
        ]

    stations = [{**row, "down_s": 0.0} if "open_s" in row else row for row in run.stations]
    return [
        stacked("What pickers did", [row["station"] for row in stations], parts(stations, PICKERS), "station"),
        stacked("What robots did", [row["robot"] for row in run.robots], parts(run.robots, ROBOTS), "robot"),
    ]


def _turnover(run: Run) -> Markup | None:
    metrics = run.result.metrics
    times = [row["turnover_s"] for row in _timed(run) if row["turnover_s"] is not None]
    if not times:
        return None
    unit, name = (3600, "hours") if max(times) > 4 * 3600 else (60, "minutes")
    step = nice(max(times) / BARS / unit)
    bars = [0.0] * (int(max(times) / unit / step) + 1)
    for seconds in times:
        bars[int(seconds / unit / step)] += 1
    marks = {"mean": "turnover_s", "95th percentile": "turnover_p95_s"}
    shown = {
        f"{label}, {metrics[name]:,.0f} s": metrics[name] / unit for label, name in marks.items() if metrics.get(name)
    }
    return chart("Turn-over times", [Series("orders", bars)], step, f"turn-over time, {name}", marks=shown)


def _listed(run: Run, limit: int) -> list[tuple[str, Sequence[Mapping[str, Any]]]]:
    """Return the orders that are listed: the latest, the slowest, and the oldest that are not complete."""
    late = _late(run)
    slowest = sorted((row for row in _timed(run) if row["turnover_s"] is not None), key=lambda row: -row["turnover_s"])
    left = [row for row in _arrived(run) if row["completed_s"] is None and row.get("cancelled_s") is None]
    left.sort(key=lambda row: row["arrival_s"])
    kinds: list[tuple[str, Sequence[Mapping[str, Any]]]] = [
        (counted(len(late), "late order") if not run.packing else f"{counted(len(late), 'order')} picked late", late),
        ("Slowest orders", slowest),
        (f"{counted(len(left), 'open order')} at the end", left),
    ]
    return [(title, rows[:limit]) for title, rows in kinds if rows]


def _order(row: Mapping[str, Any], delay: Row, told: Mapping[str, Sequence[Episode]]) -> dict[str, Any]:
    """Return an order as the table shows it: when, how long, why, and what was decided for it."""
    times, whole = _part_times(delay), row["turnover_s"] or 1.0
    ranked = sorted(times, key=lambda part: -times[part])[:MOST_CAUSES]
    causes = [
        f"{PARTS[p]} {times[p]:,.0f} s ({100 * times[p] / whole:.0f} %)"
        for p in ranked
        if times[p] / whole >= WORTH_SAYING
    ]
    if not times:
        given = row["assigned_s"] is not None
        causes = [f"assigned at {duration(row['assigned_s'])}, not complete" if given else "not all assigned"]
    return {**row, "causes": "; ".join(causes), "told": told.get(row["order"], ())}


def _packing(run: Run) -> Iterator[tuple[str, ...]]:
    """Yield for each packing station its orders and parts, and means of consolidating, waiting and packing."""
    for station in dict.fromkeys(row["packing_station"] for row in run.packing or ()):
        rows = [row for row in run.packing or () if row["packing_station"] == station]
        done = [row for row in rows if row["packed_s"] is not None]
        spans = (("first_part_s", "last_part_s"), ("last_part_s", "packing_s"), ("packing_s", "packed_s"))
        means = [f"{fmean(row[end] - row[begin] for row in done):,.1f} s" if done else "-" for begin, end in spans]
        yield station, f"{len(rows):,}", f"{len(done):,}", f"{sum(row['parts'] or 0 for row in rows):,.0f}", *means


def in_days(seconds: float) -> str:
    """Return a time since time 0 with its whole days apart: ``14:00:00 +1 day``."""
    days, rest = divmod(round(seconds), 86_400)
    return f"{duration(rest)} +{counted(days, 'day')}" if days else duration(rest)


def _departures(run: Run) -> Iterator[tuple[str, ...]]:
    """Yield for each truck its route, when it leaves, what it took and left behind, and how late that is."""
    for row in run.departures or ():
        counts = (f"{row[name]:,.0f}" for name in ("orders", "departed", "missed", "open"))
        share, late = row["departed_share"], row["late_mean_s"]
        shares = "-" if share is None else f"{100 * share:.1f} %", "-" if late is None else f"{late:,.0f} s"
        yield row["route"] or "-", in_days(row["leaves_s"]), *counts, *shares


def _costs(run: Run) -> Iterator[tuple[str, str, str]]:
    """Yield the parts of what an order costs, each with its share; none where the scenario names no costs."""
    values, described = run.result.metrics, run.result.described
    whole = values.get("cost_per_order")
    for name in [one for one in values if one.startswith("cost_") and one.endswith("_per_order")]:
        if whole is not None and (part := values[name]) is not None and name in described:
            share = f"{100 * part / whole:.0f} %" if whole else "-"
            yield described[name].label.strip().capitalize(), show(described[name], part), share


def _metrics(run: Run) -> dict[str, list[tuple[str, str, str]]]:
    """Return label, value and meaning of each metric by heading."""
    values = run.result.metrics
    return {
        heading: [
            (
                one.label,
                f"{show(one, values[one.name])} {one.unit if values[one.name] is not None else ''}".strip(),
                one.meaning,
            )
            for one in metrics
        ]
        for heading, metrics in by_heading(values, run.result.described).items()
    }
