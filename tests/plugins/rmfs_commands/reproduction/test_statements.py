"""What the paper says in words, held against rows with known answers."""

from rmfs_commands.reproduction.instance_sets import METHODS
from rmfs_commands.reproduction.statements import Comparison, Statement, statements


def verdict_on(rows, start: str) -> str:
    """Return the verdict on the sentence that starts so."""
    (found,) = (statement for statement in statements(rows) if statement.sentence.startswith(start))
    return found.verdict


def test_verdicts() -> None:
    """All, some, none, and nothing to compare."""
    good, bad = Comparison("a", 1.0, 2.0), Comparison("b", 2.0, 2.0)
    assert Statement("", "", (good, good)).verdict == "holds"
    assert Statement("", "", (good, bad)).verdict == "holds in 1 of 2"
    assert Statement("", "", (bad,)).verdict == "does not hold"
    assert Statement("", "", ()).verdict == "no complete run"


def test_integrated_saves_less_distance_than_visits(row) -> None:
    """0.7 of the visits but 0.8 of the distance."""
    rows = [row(), row("integrated", psv_per_order=0.7, distance_per_order_m=80.0)]
    assert verdict_on(rows, "Robot distances") == "holds"


def test_turnover(row) -> None:
    """Shorter in the backlog but not at the stations is half of the sentence for one of two models."""
    rows = [row(), row("integrated", turnover_backlog_s=300.0, turnover_station_s=210.0)]
    rows.append(row("split-over-time", turnover_s=700.0))
    assert verdict_on(rows, "With the integrated") == "holds in 1 of 2"
    assert verdict_on(rows, "The turn-over time of split-over-time") == "holds"


def test_computing_times(row) -> None:
    """Totals are compared with sequential, first periods with split-over-time, the rest with the paper's limits."""
    first = {"sequential": 0.01, "integrated": 2.0, "split-among-stations": 0.3, "split-over-time": 0.5}
    rows = [row(method, decision_s_first=first[method], decision_percent_of_simulated=14.9) for method in METHODS]
    assert verdict_on(rows, "Computing times") == "holds"
    assert verdict_on(rows, "At t = 1") == "holds in 1 of 2"
    assert verdict_on(rows, "Computing the decisions") == "holds"
    assert verdict_on([row(decision_s_per_order=1.6)], "It takes") == "does not hold"
