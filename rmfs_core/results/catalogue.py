"""What each metric is called for people, its unit and its meaning; every table of metrics is made from this list."""

from __future__ import annotations

from collections.abc import Iterable

from attrs import Factory, frozen

from rmfs_core.errors import InputError
from rmfs_core.wording import shown_short


@frozen
class Metric:
    """A metric.

    Parameters
    ----------
    name
        Its key in ``metrics`` or ``timing`` of result.json.
    label, unit, digits
        How a table shows it: the name where there is no label; no unit for a plain number; integers without digits.
    meaning
        One sentence.
    group
        Under which heading the summary of a run shows an observer's metric; None: not there.
    """

    name: str
    label: str = Factory(lambda self: self.name, takes_self=True)
    unit: str = ""
    digits: int = 2
    meaning: str = ""
    group: str | None = "Observers"

    def __attrs_post_init__(self) -> None:
        texts = (self.name, self.label, self.unit, self.meaning, self.group or "")
        if not all(isinstance(text, str) and text.isprintable() for text in texts) or self.digits not in range(16):
            raise ValueError(f"expected texts of one line and 0 to 15 digits, found {shown_short(self)}")


METRICS: dict[str, tuple[Metric, ...]] = {
    "Orders": (
        Metric("orders_completed", "Orders completed", "", 0, "Orders whose last item was picked (or handled)."),
        Metric("orders_total", "Orders in all", "", 0, "Orders of the instance."),
        Metric("turnover_s", "Turn-over time", "s", 1, "Arrival to completion, mean over completed orders."),
        Metric(
            "turnover_backlog_s", "  in the backlog", "s", 1, "Arrival until all parts are assigned, mean of those."
        ),
        Metric("turnover_station_s", "  at stations", "s", 1, "The rest of the turn-over time, mean of those."),
        Metric("split_orders_open_max", "Most split orders open", "", 0, "Most split orders open at the same time."),
    ),
    "Pods": (
        Metric("picks", "Picks", "", 0, "Items picked."),
        Metric("pod_station_visits", "Pod-station visits", "", 0, "Times a pod came to stand at a picking station."),
        Metric("psv_per_order", "Visits per order", "", 2, "Pod-station visits per completed order."),
        Metric("pile_on", "Pile-on", "", 2, "Picks per pod-station visit."),
    ),
    "Robots": (
        Metric("distance_m", "Distance", "m", 0, "Distance driven by all robots."),
        Metric("loaded_distance_m", "  with a pod", "m", 0, "Part of the distance driven with a pod."),
        Metric("empty_distance_m", "  empty", "m", 0, "Part of the distance driven without a pod."),
        Metric("distance_per_order_m", "Distance per order", "m", 1, "Distance per completed order."),
    ),
    "Throughput": (
        Metric("makespan_s", "Makespan", "s", 1, "Time of the last completed order; none when orders are left."),
        Metric("simulated_s", "Simulated time", "s", 1, "The makespan; the end of the run when orders are left."),
        Metric("orders_per_hour", "Orders per hour", "", 1, "Completed orders per hour of simulated time."),
        Metric("picks_per_hour", "Picks per hour", "", 1, "Picks per hour of simulated time."),
        Metric("picker_utilisation", "Picker utilisation", "%", 1, "Share of it in which pickers handle items."),
    ),
    "Decisions": (
        Metric("periods", "Periods", "", 0, "Times pick orders were assigned (POA or joint decisions)."),
        Metric(
            "solves_stopped_early", "Solves stopped early", "", 0, "Decisions that a limit ended before their proof."
        ),
    ),
}
"""Metrics by group, in the order of a table; the same on every run of the same scenario and seed."""

TIMING: tuple[Metric, ...] = (
    Metric("wall_s", "Simulation", "s", 2, "Wall-clock seconds of the simulation."),
    Metric("simulated_s_per_wall_s", "Simulated seconds per second", "", 0, "Simulated time over wall-clock time."),
    Metric("decision_s_first", "Decisions, t = 1", "s", 3, "POA and PPS decisions of the first period."),
    Metric("decision_s_later", "Decisions, t > 1", "s", 3, "POA and PPS decisions of all later periods."),
    Metric("decision_s_per_order", "  per order", "s", 4, "The same per completed order."),
    Metric("decision_percent_of_simulated", "  of simulated time", "%", 3, "The same as a share of simulated time."),
)
"""Wall-clock figures; they differ from run to run."""


def show(metric: Metric, value: float | None) -> str:
    """Value of a metric for people: rounded, thousands separated, a dash where there is none."""
    if value is None:
        return "-"
    if metric.name == "picker_utilisation":
        value *= 100
    return f"{value:,}" if isinstance(value, int) else f"{value:,.{metric.digits}f}"


def described_by(observers: Iterable[object]) -> dict[str, Metric]:
    """Return the metrics that observers describe in their attribute ``measures``, by name."""
    found: dict[str, Metric] = {}
    for observer in observers:
        try:
            measures = getattr(observer, "measures", ())
        except Exception as error:
            measures = error
        if not isinstance(measures, tuple | list) or not all(isinstance(one, Metric) for one in measures):
            place, expected = f"class {type(observer).__name__}", "a tuple of rmfs_core.results.catalogue.Metric"
            raise InputError(place, f"expected `measures` to be {expected}, found {shown_short(measures)}")
        found |= {metric.name: metric for metric in measures}
    return found
