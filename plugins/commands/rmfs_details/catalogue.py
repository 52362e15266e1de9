"""The metrics that `rmfs_details.observer.Details` adds: names, units, meanings.

Medians and 95th percentiles are as numpy has them: between the two nearest values they are interpolated. Orders that
arrive before ``run.warmup_s`` are left out of what is said of orders' times; other events before it are not counted.
"""

from __future__ import annotations

from attrs import evolve

from rmfs_core.results.catalogue import Metric

DETAILS: tuple[Metric, ...] = (
    Metric("turnover_median_s", "Turn-over time, median", "s", 1, "Median of the turn-over times."),
    Metric("turnover_p95_s", "Turn-over time, 95 %", "s", 1, "95th percentile of the turn-over times."),
    Metric("turnover_backlog_median_s", "  in the backlog, median", "s", 1, "Median of the times in the backlog."),
    Metric("turnover_backlog_p95_s", "  in the backlog, 95 %", "s", 1, "95th percentile of the times in the backlog."),
    Metric("turnover_station_median_s", "  at stations, median", "s", 1, "Median of the times at stations."),
    Metric("turnover_station_p95_s", "  at stations, 95 %", "s", 1, "95th percentile of the times at stations."),
    Metric("items_per_line", "Items per order line", "", 2, "Items over order lines of the completed orders."),
    Metric("orders_per_visit", "Orders per visit", "", 3, "Orders whose last item was picked, per pod-station visit."),
    Metric(
        "waiting_per_visit_s",
        "Waiting for others per visit",
        "s",
        1,
        "Time in which robots with a task, not in a queue, neither drive nor turn nor lift, per pod-station visit.",
    ),
    Metric(
        "waiting_for_room_per_visit_s",
        "  for room at the station",
        "s",
        1,
        "The part of it that robots spend beneath their pods until the station's queue has room; the rest is traffic.",
    ),
)
"""Metrics of every run."""

LATENESS: tuple[Metric, ...] = (
    Metric(
        "late_orders",
        "Late orders",
        "",
        0,
        "Orders completed after their due time, or due and not complete at the end.",
    ),
    Metric(
        "late_percent", "  of those due", "%", 1, "Late orders over orders completed or due, of those with a due time."
    ),
    Metric(
        "tardiness_s", "Tardiness", "s", 1, "Completion after the due time, 0 if before, mean over completed orders."
    ),
    Metric("tardiness_p95_s", "  95 %", "s", 1, "95th percentile of the tardiness of completed orders."),
    Metric("on_time_percent", "On time", "%", 1, "100 less the late ones."),
)
"""Metrics of runs in which an order has a due time."""


def on_time(priority: int | str) -> Metric:
    """Return the metric of the orders of a priority."""
    meaning = "The same among orders of this priority; there is one for each priority that an order due has."
    return Metric(f"on_time_percent_priority_{priority}", f"  priority {priority}", "%", 1, meaning)


MEASURES = (
    *(evolve(metric, group=None) for metric in DETAILS),
    *(evolve(metric, group="Due times") for metric in (*LATENESS, *map(on_time, range(10)))),
)
"""All of them, with the first ten priorities; the summary of a run shows those of due times."""
