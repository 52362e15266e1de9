"""The tables of the 24 instances, from rows with known answers."""

import pytest

from rmfs_commands.reproduction.instance_sets import METHODS, implied_makespan, instance_set_tables
from rmfs_commands.reproduction.paper import Range, load_paper
from rmfs_commands.reproduction.tables import Table


def tables_of(rows) -> dict[str, Table]:
    """Return the tables by the name of their exhibit."""
    return {table.exhibit.name: table for table in instance_set_tables(rows, load_paper())}


def verdict(table: Table, *label: str) -> str:
    """Return the verdict of a line."""
    (line,) = (line for line in table.lines if line.label == label)
    return line.verdict


def test_visits_relative_to_sequential(row) -> None:
    """0.75 of the sequential visits lie in the paper's range of 20 % to 30 % fewer; half of them in "about 50 %"."""
    rows = [
        row("sequential", psv_per_order=2.0),
        row("integrated", psv_per_order=1.5),
        row("split-among-stations", psv_per_order=1.0),
        row("split-over-time", psv_per_order=1.0),
    ]
    table = tables_of(rows)["pod-station-visits"]
    assert [line.label for line in table.lines] == [("50 orders", method) for method in METHODS[1:]]
    assert [line.ours.mean for line in table.lines if line.ours] == [0.75, 0.5, 0.5]
    assert [line.verdict for line in table.lines] == ["in range", "in range", "above"]


def test_the_second_baseline_is_sequential_with_six_orders(row) -> None:
    """Item capacity costs the sequential rules a quarter more visits; a model that saves 40 % of these saves 25 %."""
    rows = [
        row("sequential", psv_per_order=2.5),
        row("sequential, 6 orders", psv_per_order=2.0),
        row("split-among-stations", psv_per_order=1.5),
    ]
    table = tables_of(rows)["second-baseline"]
    six = table.ours("50 orders", "visits", "sequential, 6 orders to sequential")
    model = table.ours("50 orders", "visits", "split-among-stations to sequential, 6 orders")
    assert six is not None and model is not None
    assert (six.mean, model.mean) == (0.8, 0.75)


def test_the_highest_pile_on_is_held_against_up_to_5_5_times(row) -> None:
    """The paper has a number for the best instance set alone."""
    rows = [row(orders=orders, pile_on=1.0) for orders in (50, 250)]
    rows += [row("split-over-time", orders=50, pile_on=3.0), row("split-over-time", orders=250, pile_on=5.5)]
    table = tables_of(rows)["pile-on"]
    assert verdict(table, "50 orders", "split-over-time") == "no number in the paper"
    assert verdict(table, "highest of the sets", "split-over-time") == "in range"


def test_turnover_has_two_parts(row) -> None:
    """Backlog and station for every method; methods without runs say so."""
    table = tables_of([row(turnover_backlog_s=300.0, turnover_station_s=60.0)])["turnover"]
    backlog, station = (
        table.ours("50 orders", "sequential", "backlog"),
        table.ours("50 orders", "sequential", "station"),
    )
    assert backlog is not None and station is not None
    assert (backlog.mean, station.mean) == (300.0, 60.0)
    assert verdict(table, "50 orders", "integrated", "backlog") == "no complete run"


def test_computing_times_are_factors(row) -> None:
    """0.067 % of simulated time where the paper has 3.35 would be 50 times faster."""
    tables = tables_of(
        [row("integrated", orders=250, decision_percent_of_simulated=0.0339, decision_s_per_order=0.048)]
    )
    assert verdict(tables["share-of-simulated-time"], "250 orders", "integrated") == "100 times faster"
    assert verdict(tables["time-per-order"], "250 orders", "integrated") == "10 times faster"


def test_implied_makespan() -> None:
    """0.48 s an order x 250 orders / 3.39 % = 3540 s; the rounding of both leaves 3498 to 3582."""
    found = implied_makespan(Range(0.475, 0.485, 0.48), Range(3.385, 3.395, 3.39), 250)
    assert found is not None
    assert found.low == pytest.approx(0.475 * 250 / 0.03395)
    assert found.high == pytest.approx(0.485 * 250 / 0.03385)
    assert found.low < 3540 < found.high
    assert implied_makespan(None, Range(1, 2), 50) is None


def test_makespan_beside_the_implied_one(row) -> None:
    """Every method and set has one, since both of the paper's tables have all of them."""
    rows = [row(method, orders=250, makespan_s=3540.0) for method in METHODS]
    table = tables_of(rows)["makespan"]
    assert [line.verdict for line in table.lines] == ["in range", "in range", "above", "above"]


def test_only_sets_that_were_run_have_lines(row) -> None:
    """A quick reproduction says nothing on 150 and 250 orders."""
    for table in instance_set_tables([row(method) for method in METHODS], load_paper()):
        assert all("150" not in line.label[0] and "250" not in line.label[0] for line in table.lines)
