"""Figures of a run as people are shown them: rounded, under headings; and those by the clock on the wall."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from rmfs_core.results.catalogue import Metric

TIMING: tuple[Metric, ...] = (
    Metric("wall_s", "Simulation", "s", 2, "Wall-clock seconds of the simulation."),
    Metric("simulated_s_per_wall_s", "Simulated seconds per second", "", 0, "Simulated time over wall-clock time."),
    Metric("decision_s_first", "Decisions, t = 1", "s", 3, "POA and PPS decisions of the first period."),
    Metric("decision_s_later", "Decisions, t > 1", "s", 3, "POA and PPS decisions of all later periods."),
    Metric(
        "decision_s_per_order", "  per order", "s", 4, "POA and PPS decisions per completed order.", of_completed=True
    ),
    Metric(
        "decision_percent_of_simulated",
        "  of simulated time",
        "%",
        3,
        "POA and PPS decisions, as a share of simulated time.",
    ),
)
"""Wall-clock figures; they differ from run to run."""


def show(metric: Metric, value: float | None) -> str:
    """Value of a metric for people: rounded, thousands separated, a dash where there is none."""
    if value is None:
        return "-"
    value *= metric.scale
    return f"{value:,}" if isinstance(value, int) else f"{value:,.{metric.digits}f}"


def by_heading(names: Collection[str], described: Mapping[str, Metric]) -> dict[str, list[Metric]]:
    """Return the metrics of a run by heading, in the order of description; what nobody describes goes by its name."""
    known = {**described, **{name: Metric(name) for name in names if name not in described}}
    groups: dict[str | None, list[Metric]] = {known[name].group: [] for name in names}
    for metric in known.values():
        if metric.name in names:
            groups[metric.group].append(metric)
    return {heading: metrics for heading, metrics in groups.items() if heading}
