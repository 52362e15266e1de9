"""Statements of Section 4.2 about figures that it gives no numbers for, compared with the runs."""

from __future__ import annotations

from collections.abc import Iterator

from attrs import frozen

from rmfs_commands.reproduction.estimates import Estimate, Rows, mean_of, metric
from rmfs_commands.reproduction.instance_sets import METHODS, MODELS, SEQUENTIAL, runs_of, sizes, to_sequential
from rmfs_commands.reproduction.tables import NO_RUN


@frozen
class Comparison:
    """Two figures, of which the first should be the smaller one."""

    label: str
    smaller: float
    larger: float

    @property
    def holds(self) -> bool:
        """Whether it is."""
        return self.smaller < self.larger


@frozen
class Statement:
    """A sentence of the paper, and the comparisons it comes down to."""

    item: str
    sentence: str
    comparisons: tuple[Comparison, ...]

    @property
    def verdict(self) -> str:
        """Whether all comparisons hold, or how many."""
        if not self.comparisons:
            return NO_RUN
        held = sum(comparison.holds for comparison in self.comparisons)
        if held == len(self.comparisons):
            return "holds"
        return f"holds in {held} of {len(self.comparisons)}" if held else "does not hold"


def statements(rows: Rows) -> list[Statement]:
    """Return the paper's statements about the instance sets that there are runs of."""
    listed = (
        (
            "Figure 11",
            "Robot distances of the integrated model improve less than its pod-station visits.",
            _distances(rows),
        ),
        (
            "Figure 13",
            "With the integrated and the split-among-stations model orders spend less time in both the backlog and "
            "the stations, compared to sequential.",
            _shorter_turnover(rows),
        ),
        ("Figure 13", "The turn-over time of split-over-time is higher than sequential.", _longer_turnover(rows)),
        (
            "Figure 14",
            "Computing times of the three models are larger than those of the sequential rules.",
            _computing_times(rows),
        ),
        (
            "Figure 14",
            "At t = 1 split-over-time decides faster than integrated and split-among-stations.",
            _first_period(rows),
        ),
        (
            "Table 3",
            "Computing the decisions takes at most around 15 % of the simulation time.",
            _at_most(rows, "decision_percent_of_simulated", 15.0),
        ),
        ("Table 4", "It takes at most 1.5 s per order.", _at_most(rows, "decision_s_per_order", 1.5)),
    )
    return [Statement(item, sentence, tuple(comparisons)) for item, sentence, comparisons in listed]


def _compare(label: str, smaller: Estimate | float | None, larger: Estimate | float | None) -> Iterator[Comparison]:
    """Yield the comparison when there are runs for both figures."""
    if smaller is not None and larger is not None:
        yield Comparison(label, _figure(smaller), _figure(larger))


def _figure(value: Estimate | float) -> float:
    return value.mean if isinstance(value, Estimate) else value


def _distances(rows: Rows) -> Iterator[Comparison]:
    for orders in sizes(rows):
        visits = to_sequential(rows, orders, "integrated", metric("psv_per_order"))
        distance = to_sequential(rows, orders, "integrated", metric("distance_per_order_m"))
        yield from _compare(f"{orders} orders, visits < distance", visits, distance)


def _shorter_turnover(rows: Rows) -> Iterator[Comparison]:
    for orders in sizes(rows):
        for model in ("integrated", "split-among-stations"):
            for part in ("backlog", "station"):
                ratio = to_sequential(rows, orders, model, metric(f"turnover_{part}_s"))
                yield from _compare(f"{orders} orders, {model}, {part}", ratio, 1.0)


def _longer_turnover(rows: Rows) -> Iterator[Comparison]:
    for orders in sizes(rows):
        ratio = to_sequential(rows, orders, "split-over-time", metric("turnover_s"))
        yield from _compare(f"{orders} orders, sequential < split-over-time", 1.0, ratio)


def _computing_times(rows: Rows) -> Iterator[Comparison]:
    def total(rule_set: str, orders: int) -> Estimate | None:
        first, later = metric("decision_s_first"), metric("decision_s_later")
        return mean_of(runs_of(rows, orders, rule_set), lambda row: (first(row) or 0.0) + (later(row) or 0.0))

    for orders in sizes(rows):
        for model in MODELS:
            yield from _compare(
                f"{orders} orders, sequential < {model}", total(SEQUENTIAL, orders), total(model, orders)
            )


def _first_period(rows: Rows) -> Iterator[Comparison]:
    for orders in sizes(rows):
        fast = mean_of(runs_of(rows, orders, "split-over-time"), metric("decision_s_first"))
        for model in ("integrated", "split-among-stations"):
            slow = mean_of(runs_of(rows, orders, model), metric("decision_s_first"))
            yield from _compare(f"{orders} orders, split-over-time < {model}", fast, slow)


def _at_most(rows: Rows, name: str, limit: float) -> Iterator[Comparison]:
    for orders in sizes(rows):
        for method in METHODS:
            ours = mean_of(runs_of(rows, orders, method), metric(name))
            yield from _compare(f"{orders} orders, {method}", ours, limit)
