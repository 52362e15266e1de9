"""The rows of orders.csv, visits.csv and periods.csv."""

import math

from rmfs_commands.details.tables import ORDER_COLUMNS, PERIOD_COLUMNS, VISIT_COLUMNS, Tables
from rmfs_core.events import (
    DecisionMade,
    ItemPicked,
    OrderAssigned,
    OrderCompleted,
    VisitEnded,
    VisitStarted,
)
from rmfs_core.info import RunInfo
from rmfs_core.roles import Role


def test_an_order_that_was_split_and_one_that_never_left_the_backlog(tiny: RunInfo) -> None:
    """Each order has a row with its parts and times; what has not happened is None."""
    tables = Tables()
    tables.run_started(tiny)
    tables.on_event(OrderAssigned(1000, 0, 1, skus=(0,), items=1, period=1, complete=False))
    tables.on_event(OrderAssigned(2000, 0, 0, skus=(1,), items=1, period=2, complete=True))
    tables.on_event(OrderCompleted(9000, 0))
    first, second = tables.orders
    assert first == {
        "order": "first",
        "arrival_s": 0.0,
        "items": 2,
        "lines": 2,
        "parts": 2,
        "stations": "2 1",
        "assigned_s": 2.0,
        "completed_s": 9.0,
        "turnover_s": 9.0,
        "turnover_backlog_s": 2.0,
        "turnover_station_s": 7.0,
    }
    assert (second["order"], second["arrival_s"], second["items"], second["lines"]) == ("second", 5.0, 2, 1)
    assert (second["parts"], second["stations"], second["completed_s"], second["turnover_s"]) == (0, "", None, None)
    assert list(first) == list(ORDER_COLUMNS)


def test_visits_count_their_picks_and_may_be_open_at_the_end(tiny: RunInfo) -> None:
    """A visit's row has names, times and picks; one that the run's end cut off has no end."""
    tables = Tables()
    tables.run_started(tiny)
    tables.on_event(VisitStarted(1000, 1, robot=1, pod=1, station=0))
    tables.on_event(VisitStarted(2000, 2, robot=0, pod=0, station=1))
    tables.on_event(ItemPicked(8000, 1000, 14_000, visit=1, station=0, pod=1, order=0, sku=1))
    tables.on_event(VisitEnded(8000, 1, pod=1, station=0, picks=1, next_station=None))
    first, second = tables.visits
    assert list(first.values()) == [1, "q", "1", "2", 1.0, 8.0, 1]
    assert (second["pod"], second["station"], second["robot"], second["end_s"], second["picks"]) == (
        "p",
        "2",
        "1",
        None,
        0,
    )
    assert list(first) == list(VISIT_COLUMNS)


def test_decisions_keep_what_the_rule_reported(tiny: RunInfo) -> None:
    """A decision's row has its report; a bound of infinity is left empty; the wall-clock time is the last column."""
    tables = Tables()
    tables.run_started(tiny)
    tables.on_event(DecisionMade(3000, 4, Role.POA_PPS, "model", 2, 1, 1, "stopped", 3, -math.inf, True, 0.25))
    (row,) = tables.periods
    assert (row["period"], row["time_s"], row["objective"], row["bound"]) == (4, 3.0, 3.0, None)
    assert (row["status"], row["stopped_early"]) == ("stopped", True)
    assert list(row) == list(PERIOD_COLUMNS)
    assert list(row)[-1] == "seconds"
