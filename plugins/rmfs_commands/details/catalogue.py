"""The metrics of `rmfs_commands.details.metrics.Metrics` and of `rmfs_commands.details.observer.Details`.

Medians and 95th percentiles are as numpy has them: between the two nearest values they are interpolated. Orders that
arrive before ``run.warmup_s`` are left out of what is said of orders' times; other events before it are not counted.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from attrs import evolve

from rmfs_commands.results.figures import TIMING
from rmfs_core.results.catalogue import Metric
from rmfs_core.roles import Role

_GROUPS: dict[str, tuple[Metric, ...]] = {
    "Orders": (
        Metric("orders_completed", "Orders completed", "", 0, "Orders whose last item was picked (or handled)."),
        Metric("orders_total", "Orders in all", "", 0, "Orders of the instance."),
        Metric("turnover_s", "Turn-over time", "s", 1, "Arrival to completion, mean over completed orders."),
        Metric(
            "turnover_backlog_s", "  in the backlog", "s", 1, "Mean time from arrival until all parts are assigned."
        ),
        Metric(
            "turnover_station_s",
            "  at stations",
            "s",
            1,
            "Mean rest of the turn-over time.",
        ),
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
        Metric("orders_per_hour", "Orders per hour", "", 1, "Completed orders per hour of the time that counts."),
        Metric("picks_per_hour", "Picks per hour", "", 1, "Picks per hour of the time that counts."),
        Metric(
            "picker_utilisation",
            "Picker utilisation",
            "%",
            1,
            "Share of the time that counts in which pickers handle items.",
            scale=100,
        ),
    ),
    "Decisions": (
        Metric("periods", "Periods", "", 0, "Calls of the POA or joint rule, also those that assign nothing."),
        Metric(
            "solves_stopped_early", "Solves stopped early", "", 0, "Decisions that a limit ended before their proof."
        ),
    ),
}

_OF_COMPLETED = re.compile(
    r"(turnover|tardiness)_.*s|bundle_turnover_s|.*_per_order(_m|_wh)?|items_per_line|orders_per_visit"
    r"|packed_(median_|p95_)?s|consolidation_(p95_)?s|packing_wait_s"
)
"""Means over completed or packed orders, and figures per such order."""


def _grouped(metrics: Iterable[Metric], group: str | None) -> tuple[Metric, ...]:
    return tuple(
        evolve(one, group=group, of_completed=_OF_COMPLETED.fullmatch(one.name) is not None) for one in metrics
    )


METRICS = {heading: _grouped(metrics, heading) for heading, metrics in _GROUPS.items()}
"""Metrics of `rmfs_commands.details.metrics.Metrics`, by heading, in the order of a table."""

DETAILS: tuple[Metric, ...] = (
    Metric("turnover_median_s", "Turn-over time, median", "s", 1, "Median of the turn-over times."),
    Metric("turnover_p95_s", "Turn-over time, p95", "s", 1, "95th percentile of the turn-over times."),
    Metric("turnover_backlog_median_s", "  in the backlog, median", "s", 1, "Median of the times in the backlog."),
    Metric("turnover_backlog_p95_s", "  in the backlog, p95", "s", 1, "95th percentile of the times in the backlog."),
    Metric("turnover_station_median_s", "  at stations, median", "s", 1, "Median of the times at stations."),
    Metric("turnover_station_p95_s", "  at stations, p95", "s", 1, "95th percentile of the times at stations."),
    Metric(
        "orders_cancelled",
        "Orders cancelled",
        "",
        0,
        "Orders that left before anything of them was assigned; where any order may be cancelled.",
    ),
    Metric(
        "open_orders_end",
        "Open orders at the end",
        "",
        0,
        "Orders that have arrived and are neither complete nor cancelled.",
    ),
    Metric("backlog_end", "Backlog at the end", "", 0, "Orders open at the end of which not all is assigned."),
    Metric(
        "open_age_sum_h",
        "Total age of open orders",
        "h",
        2,
        "Time since arrival of the orders open at the end, summed; 0 when none is open.",
    ),
    Metric(
        "open_age_s",
        "Age of open orders",
        "s",
        1,
        "Mean time since arrival of the orders open at the end.",
    ),
    Metric("open_age_max_s", "  of the oldest", "s", 1, "Time since arrival of the oldest open order, at the end."),
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
        "  for a free queue cell",
        "s",
        1,
        "Time in which robots stand under pods until the queue has a free cell, per visit; the rest is traffic.",
    ),
    Metric(
        "picking_distance_per_order_m",
        "Distance for picking per order",
        "m",
        1,
        "Distance per completed order, without that of robots that are sent to rest or carry pods elsewhere.",
    ),
    Metric(
        "energy_wh",
        "Energy",
        "Wh",
        1,
        "What runs, turns and lifts take, by the formulas of `rmfs_commands.details.energy`.",
    ),
    Metric("energy_acceleration_wh", "  acceleration", "Wh", 1, "The part of the energy that acceleration takes."),
    Metric("energy_rolling_wh", "  rolling", "Wh", 1, "The part of the energy against rolling resistance."),
    Metric("energy_turns_wh", "  turns", "Wh", 1, "The part of the energy that turns on the spot take."),
    Metric("energy_lifts_wh", "  lifts", "Wh", 1, "The part of the energy that lifting pods takes."),
    Metric("energy_per_order_wh", "Energy per order", "Wh", 2, "Energy per completed order."),
)
"""Metrics of every run."""

OPENING: tuple[Metric, ...] = (
    Metric(
        "station_open_h",
        "Stations open",
        "h",
        1,
        "Hours in which stations are open or finish what they have, and are not out of service, summed over them.",
    ),
    Metric(
        "open_utilisation_percent",
        "  of it pickers handle items",
        "%",
        1,
        "Share of the time in which stations are open, or finish what they have, in which their pickers handle items.",
    ),
)
"""Metrics of runs in which stations open and close."""

LATENESS: tuple[Metric, ...] = (
    Metric(
        "late_orders",
        "Late orders",
        "",
        0,
        "Orders completed after their due time, or due and not complete at the end.",
    ),
    Metric(
        "late_percent",
        "  of those due",
        "%",
        1,
        "Late orders over those completed or due. Only orders with a due time count; where the run has a horizon, or "
        "ends with orders left, only those that are due by then.",
    ),
    Metric(
        "tardiness_s", "Tardiness", "s", 1, "Completion after the due time, 0 if before, mean over completed orders."
    ),
    Metric("tardiness_p95_s", "  p95", "s", 1, "95th percentile of the tardiness of completed orders."),
    Metric("on_time_percent", "On time", "%", 1, "100 less the late ones."),
)
"""Metrics of runs in which an order has a due time."""


REPLENISHMENT: tuple[Metric, ...] = (
    Metric("bundles_stored", "Bundles stored", "", 0, "Bundles whose items were put on a pod."),
    Metric("items_stored", "Items stored", "", 0, "Items of the bundles stored."),
    Metric("bundle_turnover_s", "Turn-over time of bundles", "s", 1, "Arrival until it is stored, mean over bundles."),
    Metric("replenishment_visits", "Replenishment visits", "", 0, "Visits of pods in which a bundle was stored."),
    Metric("items_per_replenishment_visit", "  items per visit", "", 2, "Items stored per replenishment visit."),
    Metric("stock_outs", "Stock-outs", "", 0, "Times that no pod had any item of a SKU left."),
    Metric(
        "turnover_stock_s",
        "Waiting for stock",
        "s",
        1,
        "The part of the turn-over time until the pods hold enough for an order, mean over completed orders.",
    ),
    Metric(
        "items_in_stock_mean", "Items in stock", "", 1, "Items on all pods of SKUs that can run out, mean over time."
    ),
    Metric("skus_in_stock_mean", "SKUs in stock", "", 1, "SKUs of which a pod has an item, mean over time."),
    Metric(
        "replenishment_robot_percent",
        "Robots replenishing",
        "%",
        1,
        "Robots' time of trips, from task or end of a visit to the end of the next, in which bundles were stored "
        "and nothing was picked, and of carrying pods back from these, as a share of all their time.",
    ),
)
"""Metrics of runs with replenishment."""


UNBUSY: tuple[Metric, ...] = (
    Metric(
        "resting_distance_m",
        "Distance to rest",
        "m",
        0,
        "Part of the distance driven to where robots rest, charge or are repaired.",
    ),
    Metric("pods_moved", "Pods moved", "", 0, "Pods carried elsewhere without a visit."),
    Metric(
        "moving_distance_m",
        "Distance of moving",
        "m",
        0,
        "Part of the distance driven to carry pods elsewhere, with pod and without.",
    ),
    Metric("charges", "Charges", "", 0, "Times a robot came to a charger."),
    Metric("charging_percent", "Charging", "%", 1, "Share of the robots' time that they stand at chargers."),
    Metric("charge_lowest_percent", "Lowest charge", "%", 1, "The least that a battery had in it, of its capacity."),
)
"""Metrics of robots without a task: one with `idle` or maintenance cells, two with `move`, three with batteries."""


OUTAGES: tuple[Metric, ...] = (
    Metric(
        "robot_failures", "Failures of robots", "", 0, "Times that a robot failed; planned maintenance not counted."
    ),
    Metric("robots_down_percent", "Robots out of service", "%", 1, "Share of the robots' time, maintenance included."),
    Metric("station_failures", "Failures of stations", "", 0, "Times that a station failed."),
    Metric("orders_held", "Orders held", "", 0, "Orders with items left to pick at a station when that failed."),
    Metric("stations_down_percent", "Stations out of service", "%", 1, "Share of the stations' time."),
    Metric("charger_failures", "Failures of chargers", "", 0, "Times that a charger failed."),
    Metric("chargers_down_percent", "Chargers out of service", "%", 1, "Share of the chargers' time."),
)
"""Metrics of runs in which robots fail or are maintained, of those in which stations fail, and in which chargers do."""

PACKING: tuple[Metric, ...] = (
    Metric("orders_packed", "Orders packed", "", 0, "Orders that were packed."),
    Metric("packed_s", "Time to packed", "s", 1, "Arrival until the order is packed, mean over packed orders."),
    Metric("packed_median_s", "  median", "s", 1, "Median of the times to packed."),
    Metric("packed_p95_s", "  p95", "s", 1, "95th percentile of the times to packed."),
    Metric("packed_makespan_s", "Makespan to packed", "s", 1, "Time of the last packed order; none when any is left."),
    Metric(
        "consolidation_s",
        "Consolidation",
        "s",
        1,
        "From the first to the last part of a split order at its packing station, mean over packed ones.",
    ),
    Metric("consolidation_p95_s", "  p95", "s", 1, "95th percentile of the times until orders are consolidated."),
    Metric(
        "packing_wait_s",
        "Waiting for a packer",
        "s",
        1,
        "From when an order is complete at its packing station until a packer begins to pack it, mean.",
    ),
    Metric("unpacked_end", "Not packed at the end", "", 0, "Orders that have arrived and are not packed."),
    Metric(
        "unpacked_age_sum_h",
        "Total age of unpacked orders",
        "h",
        2,
        "Time since arrival of the orders not packed at the end, summed; 0 when all are packed.",
    ),
    Metric("boxes_max", "Most boxes reserved", "", 0, "Most boxes that split orders had at the same time."),
    Metric("boxes_mean", "  mean", "", 1, "Boxes that split orders had, mean over time."),
    Metric(
        "packer_utilisation_percent",
        "Packer utilisation",
        "%",
        1,
        "Share of the packers' time in which they work; their time is that in which they are open, or finish a task.",
    ),
    Metric(
        "packer_starved_percent",
        "  without a task",
        "%",
        1,
        "Share of the packers' time in which they have nothing to do though orders that have arrived are not packed.",
    ),
    Metric(
        "splits_refused",
        "Periods without a free box",
        "",
        0,
        "Calls of the POA or joint rule while no box was free, so that no further order could be split.",
    ),
    Metric("totes", "Totes", "", 0, "Totes that left picking stations."),
    Metric("parts_per_order", "Parts per order", "", 2, "Totes of an order, a mean over packed orders."),
    Metric(
        "late_packed", "Packed late", "", 0, "Orders packed after their due time, or due and not packed at the end."
    ),
    Metric(
        "late_packed_percent",
        "  of those due",
        "%",
        1,
        "Orders packed late over those packed, or due and not packed at the end. Only orders with a due time count.",
    ),
)
"""Metrics of runs with packing stations; the last two where an order has a due time."""


DEPARTURES: tuple[Metric, ...] = (
    Metric(
        "departed_share",
        "Orders departed",
        "%",
        1,
        "Share of orders that were done when their truck left: packed, where packing is simulated, else picked. Where "
        "the run has a horizon, or ends with orders left, it is that of orders whose truck has left by then.",
        scale=100,
    ),
    Metric("missed_percent", "Missed their truck", "%", 1, "100 less the orders departed, in percent."),
)
"""Metrics of runs in which trucks leave."""

COSTS: tuple[Metric, ...] = (
    Metric("cost_total", "Cost", "", 2, "What the run costs by the section `costs`, in its currency."),
    Metric(
        "cost_per_order", "Cost per order", "", 4, "Cost per packed order, where packing is simulated, else picked."
    ),
    Metric("cost_pickers_per_order", "  pickers", "", 4, "Cost of pickers per order."),
    Metric("cost_packers_per_order", "  packers", "", 4, "Cost of packers and sorters per order."),
    Metric(
        "cost_replenishers_per_order",
        "  replenishers",
        "",
        4,
        "Cost of replenishers per order.",
    ),
    Metric("cost_robots_per_order", "  robots", "", 4, "Cost of robots per order."),
    Metric("cost_energy_per_order", "  energy", "", 4, "Cost of electricity per order."),
    Metric("cost_lateness_per_order", "  lateness", "", 4, "Cost of late orders per order."),
)
"""Metrics of runs of scenarios with a section `costs`."""


def on_time(priority: int | str) -> Metric:
    """Return the metric of the orders of a priority."""
    meaning = f"On time, of orders of priority {priority}."
    return Metric(f"on_time_percent_priority_{priority}", f"  priority {priority}", "%", 1, meaning)


MEASURES = (
    *_grouped(DETAILS, None),
    *_grouped(OPENING, "Opening hours"),
    *_grouped(REPLENISHMENT, "Replenishment"),
    *_grouped(UNBUSY, "Robots without a task"),
    *_grouped(PACKING, "Packing"),
    *_grouped(OUTAGES, "Outages"),
    *_grouped((*LATENESS, *map(on_time, range(10))), "Due times"),
    *_grouped(DEPARTURES, "Departures"),
    *_grouped(COSTS, "Costs"),
)
"""All of them, with the first ten priorities; the summary of a run shows those of all groups but the first."""

CATALOGUE: dict[str, tuple[Metric, ...]] = {
    **METRICS,
    "Percentiles, waiting and energy": DETAILS,
    "Opening hours": OPENING,
    "Due times": (*LATENESS, evolve(on_time("N"), meaning="The same, of each priority N that an order due has.")),
    "Replenishment": REPLENISHMENT,
    "Robots without a task": UNBUSY,
    "Packing": PACKING,
    "Outages": OUTAGES,
    "Departures": DEPARTURES,
    "Costs": COSTS,
}
"""All of them by heading, for people."""

HOOK_TIMES = tuple(
    Metric(f"hook_s.{role.hook}", f"Time in {role.hook}", "s", 3, f"Wall-clock seconds of all {role.label} decisions.")
    for role in Role
    if role is not Role.OBSERVER
)
"""Wall-clock seconds that a run's rules took in each hook."""

MORE_IS_BETTER = frozenset(
    {
        "orders_completed",
        "pile_on",
        "orders_per_hour",
        "picks_per_hour",
        "picker_utilisation",
        "orders_per_visit",
        "open_utilisation_percent",
        "on_time_percent",
        "departed_share",
        *(on_time(priority).name for priority in range(10)),
        "bundles_stored",
        "items_stored",
        "items_per_replenishment_visit",
        "items_in_stock_mean",
        "skus_in_stock_mean",
        "charge_lowest_percent",
        "orders_packed",
    }
)
"""Metrics that are to be large: a limit of "at most" makes no sense for them."""

FROM_ORDERS = frozenset({"orders_total", "picks", "items_per_line"})
"""Metrics that depend on the orders alone, not on robots, stations or rules."""

_NO_AIM = (
    FROM_ORDERS
    | {"periods", "simulated_s", "pods_moved", "charges", "totes", "station_open_h"}
    | {"packer_utilisation_percent"}  # splitting orders makes packers busy with what nobody else wants
    | {
        "robot_failures",
        "station_failures",
        "robots_down_percent",
        "stations_down_percent",
        "charger_failures",
        "chargers_down_percent",
    }
)
_DESCRIBED = {
    metric.name for metric in (*MEASURES, *TIMING, *HOOK_TIMES, *(one for of in METRICS.values() for one in of))
}


def better(name: str) -> str | None:
    """Return which way a metric is better: ``"more"`` or ``"less"``; None where that is not known, or neither is."""
    if name in MORE_IS_BETTER or name.startswith("on_time_percent_") or name == "simulated_s_per_wall_s":
        return "more"
    return "less" if name in _DESCRIBED - _NO_AIM else None
