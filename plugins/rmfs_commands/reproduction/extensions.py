"""The rest of Section 4 from the rows of runs: prefilter, 2000 orders, packing capacity, and the examples."""

from __future__ import annotations

from collections.abc import Mapping

from rmfs_commands.reproduction.estimates import Rows, mean_of, metric, relative, select
from rmfs_commands.reproduction.instance_sets import METHODS, MODELS, RELATIVE, SEQUENTIAL
from rmfs_commands.reproduction.paper import Exhibit
from rmfs_commands.reproduction.tables import Table, as_factor, in_range

UNFILTERED = "split-among-stations"
PREFILTER = (10, 20, 30, 40, 50, 75, 100, 150, 250)
"""Values of n of the prefilter study."""


def prefiltered(n: int) -> str:
    """Return the name of the rule set with a prefilter of n orders."""
    return f"most-covered-{n}"


def prefilter_tables(rows: Rows, paper: Mapping[str, Exhibit]) -> list[Table]:
    """Return the tables of the prefilter study; rule sets as `prefiltered` names them, and those to compare with."""
    exhibit, share = paper["prefilter"], paper["prefilter-share"]
    unfiltered, sequential = select(rows, rule_set=UNFILTERED), select(rows, rule_set=SEQUENTIAL)
    comparisons = (
        ("pod-station visits, to no prefilter", "visits_to_unfiltered", "psv_per_order", unfiltered),
        ("pod-station visits, to sequential", "visits_to_sequential", "psv_per_order", sequential),
        ("computing time t > 1, to no prefilter", "time_to_unfiltered", "decision_s_later", unfiltered),
    )
    lines = [
        in_range(
            (f"n = {n}", label),
            exhibit.range(key) if n == min(PREFILTER) else None,
            relative(select(rows, rule_set=prefiltered(n)), baseline, metric(name)),
        )
        for label, key, name, baseline in comparisons
        for n in PREFILTER
    ]
    shares = [
        as_factor(
            (f"n = {n}",),
            share.range(str(n)),
            mean_of(select(rows, rule_set=prefiltered(n)), metric("decision_percent_of_simulated")),
        )
        for n in PREFILTER
    ]
    return [
        Table(exhibit, tuple(lines), "", 3, "means over the instances, relative to each other on the same seed"),
        Table(share, tuple(shares), "%", 4),
    ]


def large_tables(rows: Rows, paper: Mapping[str, Exhibit]) -> list[Table]:
    """Return the tables of the 2000-order instances."""
    exhibit, share = paper["large"], paper["large-share"]
    sequential = select(rows, rule_set=SEQUENTIAL)
    measures = {"pod-station visits": "psv_per_order", "robot distance": "distance_per_order_m"}
    lines = [
        in_range(
            (model, label),
            exhibit.range(model),
            relative(select(rows, rule_set=model), sequential, metric(name)),
        )
        for label, name in measures.items()
        for model in MODELS
    ]
    shares = [
        as_factor(
            (method,),
            share.range(method),
            mean_of(select(rows, rule_set=method), metric("decision_percent_of_simulated")),
        )
        for method in METHODS
    ]
    return [Table(exhibit, tuple(lines), "", 3, RELATIVE), Table(share, tuple(shares), "%", 4)]


def packing_tables(rows: Rows, paper: Mapping[str, Exhibit]) -> list[Table]:
    """Return the table of the packing capacity; rule sets ``packing-10``, and those to compare with."""
    exhibit = paper["packing"]
    sequential = select(rows, rule_set=SEQUENTIAL)
    lines = [
        in_range(
            (label, "pod-station visits"),
            exhibit.range(key),
            relative(select(rows, rule_set=rule_set), sequential, metric("psv_per_order")),
        )
        for label, key, rule_set in (
            ("packing capacity 10", "limited", "packing-10"),
            ("no limit", "unlimited", UNFILTERED),
        )
    ]
    return [Table(exhibit, tuple(lines), "", 3, RELATIVE)]


def example_tables(rows: Rows, paper: Mapping[str, Exhibit]) -> list[Table]:
    """Return the table of the paper's examples; their names are the rows' ``instance``."""
    exhibit = paper["examples"]
    names = {"visits": "pod_station_visits", "pile_on": "pile_on"}
    lines = [
        in_range(
            (example.removeprefix("examples/"), figure.replace("_", "-")),
            exhibit.range(example, figure),
            mean_of(select(rows, instance=example), metric(names[figure])),
        )
        for example, figures in exhibit.values.items()
        for figure in figures
    ]
    return [Table(exhibit, tuple(lines), "", 1)]
