"""orders.csv, visits.csv and periods.csv worked out anew, of a day of one order, written by hand."""

from __future__ import annotations

from attrs import evolve

from damage import without
from rmfs_commands.trace.reader import Trace
from rmfs_commands.validation.results import orders_of, periods_of, visits_of


def test_the_days_order(day: Trace) -> None:
    """It arrives and is assigned at the start, and is complete with its last pick; nothing is due."""
    (row,) = orders_of(day)
    assert list(row.values()) == ["A", 0.0, 3, 2, 1, "1", 0.0, 48.028, 48.028, 0.0, 48.028]


def test_an_order_that_is_due(day: Trace) -> None:
    """Three columns more, for all orders; what has not come about is left out."""
    order = evolve(day.instance.orders[0], due_tick=48_000, priority=1)
    dated = evolve(day, instance=evolve(day.instance, orders=(order,)))
    assert orders_of(dated)[0]["lateness_s"] == 0.028
    (row,) = orders_of(evolve(dated, events=()))
    assert (row["due_s"], row["priority"], row["lateness_s"], row["stations"]) == (48.0, 1, None, "")


def test_the_days_visit(day: Trace) -> None:
    """With names for people; one that has not ended has no end."""
    assert list(visits_of(day)[0].values()) == [1, "P0", "1", "1", 15.028, 48.028, 3]
    assert visits_of(without(17)(day))[0]["end_s"] is None


def test_the_days_decisions(day: Trace) -> None:
    """In the order in which they were made."""
    rows = periods_of(day)
    assert [(row["decides"], row["assignments"], row["trips"]) for row in rows] == [("POA", 1, 0), ("PPS", 0, 1)]
    assert {row["stopped_early"] for row in rows} == {"false"}
