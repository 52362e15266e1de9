"""Section 4.2 on the 24 instances: Figures 10 to 14, Tables 3 and 4, from the rows of all runs."""

from __future__ import annotations

from collections.abc import Mapping

from rmfs_commands.reproduction.estimates import Estimate, Measure, Row, Rows, mean_of, metric, relative, select
from rmfs_commands.reproduction.paper import Exhibit, Range
from rmfs_commands.reproduction.tables import Line, Table, as_factor, in_range

ORDERS = "instance.orders"
"""Column with the size of the instance set."""

SEQUENTIAL = "sequential"
SIX_ORDERS = "sequential, 6 orders"
"""The sequential rules with stations that count orders."""

MODELS = ("integrated", "split-among-stations", "split-over-time")
METHODS = (SEQUENTIAL, *MODELS)
RELATIVE = "mean over the instances, relative to that of sequential on the same seed"


def instance_set_tables(rows: Rows, paper: Mapping[str, Exhibit]) -> list[Table]:
    """Return the tables of the 24 instances.

    Parameters
    ----------
    rows
        One a run, with the columns ``instance.orders``, ``instance``, ``rule_set`` (one of METHODS, or
        SIX_ORDERS), ``seed``, ``status``, and its metrics.
    paper
        The paper's exhibits.
    """
    return [
        normalized(paper["pod-station-visits"], rows, metric("psv_per_order")),
        normalized(paper["distances"], rows, metric("distance_per_order_m")),
        pile_on(paper["pile-on"], rows),
        turnover(paper["turnover"], rows),
        picks_per_time(paper["picks-per-time"], rows),
        computing_time(paper["computing-time"], rows),
        timing(paper["share-of-simulated-time"], rows, "decision_percent_of_simulated", "%"),
        timing(paper["time-per-order"], rows, "decision_s_per_order", "s"),
        makespans(paper["makespan"], paper["time-per-order"], paper["share-of-simulated-time"], rows),
        second_baseline(paper["second-baseline"], rows),
    ]


def sizes(rows: Rows) -> list[int]:
    """Return the numbers of orders that there are runs of, ascending."""
    return sorted({row[ORDERS] for row in rows})


def of(orders: int) -> str:
    """Return what lines of an instance set are labelled with."""
    return f"{orders:,} orders"


def runs_of(rows: Rows, orders: int, rule_set: str) -> list[Row]:
    """Return the runs of an instance set with a rule set."""
    return select(rows, **{ORDERS: orders, "rule_set": rule_set})


def to_sequential(rows: Rows, orders: int, rule_set: str, measure: Measure) -> Estimate | None:
    """Return a measure of a rule set relative to the sequential rules, averaged over an instance set."""
    return relative(runs_of(rows, orders, rule_set), runs_of(rows, orders, SEQUENTIAL), measure)


def normalized(exhibit: Exhibit, rows: Rows, measure: Measure) -> Table:
    """Return the table of a measure relative to sequential."""
    lines = [
        in_range((of(orders), model), exhibit.range(model), to_sequential(rows, orders, model, measure))
        for orders in sizes(rows)
        for model in MODELS
    ]
    return Table(exhibit, tuple(lines), "", 3, RELATIVE)


def pile_on(exhibit: Exhibit, rows: Rows) -> Table:
    """Return the table of pile-on relative to sequential, and the highest of the sets for split-over-time."""
    table = normalized(exhibit, rows, metric("pile_on"))
    model = "split-over-time"
    of_sets = [line.ours for line in table.lines if line.label[-1] == model and line.ours is not None]
    highest = max(of_sets, key=lambda estimate: estimate.mean, default=None)
    line = in_range(("highest of the sets", model), exhibit.range("highest", model), highest)
    return Table(exhibit, (*table.lines, line), "", 3, RELATIVE)


def turnover(exhibit: Exhibit, rows: Rows) -> Table:
    """Return the table of the two parts of the turn-over time."""
    parts = {"backlog": "turnover_backlog_s", "station": "turnover_station_s"}
    lines = _of_all_methods(exhibit, rows, parts)
    what = "mean over orders; backlog: until all parts of an order are assigned, station: from then to its last pick"
    return Table(exhibit, lines, "s", 0, what)


def computing_time(exhibit: Exhibit, rows: Rows) -> Table:
    """Return the table of computing time of the first period and of the others."""
    parts = {"t = 1": "decision_s_first", "t > 1": "decision_s_later"}
    return Table(exhibit, _of_all_methods(exhibit, rows, parts), "s", 3, "sum over a run's decisions, mean over runs")


def _of_all_methods(exhibit: Exhibit, rows: Rows, parts: Mapping[str, str]) -> tuple[Line, ...]:
    return tuple(
        in_range(
            (of(orders), method, part),
            exhibit.range(str(orders), method, part),
            mean_of(runs_of(rows, orders, method), metric(name)),
        )
        for orders in sizes(rows)
        for method in METHODS
        for part, name in parts.items()
    )


def picks_per_time(exhibit: Exhibit, rows: Rows) -> Table:
    """Return the table of picks per time of split-over-time relative to sequential."""
    model, measure = "split-over-time", metric("picks_per_hour")
    lines = [
        in_range((of(orders), model), exhibit.range(model), to_sequential(rows, orders, model, measure))
        for orders in sizes(rows)
    ]
    return Table(exhibit, tuple(lines), "", 3, RELATIVE + '; "equal" is taken as within 5 %')


def timing(exhibit: Exhibit, rows: Rows, name: str, unit: str) -> Table:
    """Return the table of a figure of computing time."""
    lines = [
        as_factor(
            (of(orders), method),
            exhibit.range(str(orders), method),
            mean_of(runs_of(rows, orders, method), metric(name)),
        )
        for orders in sizes(rows)
        for method in METHODS
    ]
    return Table(exhibit, tuple(lines), unit, 4)


def makespans(exhibit: Exhibit, per_order: Exhibit, share: Exhibit, rows: Rows) -> Table:
    """Return the table of makespans next to the makespans that the two tables of computing time imply."""
    lines = [
        in_range(
            (of(orders), method),
            implied_makespan(per_order.range(str(orders), method), share.range(str(orders), method), orders),
            mean_of(runs_of(rows, orders, method), metric("makespan_s")),
        )
        for orders in sizes(rows)
        for method in METHODS
    ]
    return Table(exhibit, tuple(lines), "s", 0)


def second_baseline(exhibit: Exhibit, rows: Rows) -> Table:
    """Return the table of the sequential rules with six orders per station, and of the models next to them."""
    measures = {"visits": "psv_per_order", "distance": "distance_per_order_m", "makespan": "makespan_s"}
    pairs = ((SIX_ORDERS, SEQUENTIAL), *((model, SIX_ORDERS) for model in MODELS))
    lines = [
        in_range(
            (of(orders), what, f"{rule_set} to {baseline}"),
            None,
            relative(runs_of(rows, orders, rule_set), runs_of(rows, orders, baseline), metric(name)),
        )
        for orders in sizes(rows)
        for what, name in measures.items()
        for rule_set, baseline in pairs
    ]
    return Table(exhibit, tuple(lines), "", 3, "mean over the instances, relative to each other on the same seed")


def implied_makespan(s_per_order: Range | None, percent: Range | None, orders: int) -> Range | None:
    """Return the simulated time, in s, that follows from rounded computing times.

    Parameters
    ----------
    s_per_order
        Computing time per order, s.
    percent
        The same as a share of simulated time, %.
    orders
        Number of orders.
    """
    if s_per_order is None or percent is None:
        return None
    return Range(s_per_order.low * orders / (percent.high / 100), s_per_order.high * orders / (percent.low / 100))
