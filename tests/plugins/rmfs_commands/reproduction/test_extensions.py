"""The tables of prefilter, 2000 orders, packing capacity and examples, from rows with known answers."""

from rmfs_commands.reproduction.extensions import example_tables, large_tables, packing_tables, prefilter_tables
from rmfs_commands.reproduction.paper import load_paper


def test_prefilter(row) -> None:
    """17 % more visits than without, 40 % fewer than sequential and a tenth of the time are the paper's figures."""
    rows = [
        row("sequential", psv_per_order=1.95),
        row("split-among-stations", psv_per_order=1.0, decision_s_later=10.0),
        row("most-covered-10", psv_per_order=1.17, decision_s_later=1.0, decision_percent_of_simulated=1.03),
    ]
    curve, share = prefilter_tables(rows, load_paper())
    of_ten = {line.label[1]: (line.ours.mean, line.verdict) for line in curve.lines if line.ours}
    assert of_ten == {
        "pod-station visits, to no prefilter": (1.17, "in range"),
        "pod-station visits, to sequential": (0.6, "in range"),
        "computing time t > 1, to no prefilter": (0.1, "in range"),
    }
    assert share.lines[0].verdict == "1.0 times faster"
    assert [line.verdict for line in share.lines[1:]] == ["no complete run"] * 8


def test_2000_orders(row) -> None:
    """Distances are held against the same reductions as visits."""
    rows = [
        row("sequential", psv_per_order=1.0, distance_per_order_m=100.0),
        row("integrated", psv_per_order=1.05, distance_per_order_m=99.0),
    ]
    table, _ = large_tables(rows, load_paper())
    verdicts = {line.label: line.verdict for line in table.lines}
    assert verdicts["integrated", "pod-station visits"] == "in range"
    assert verdicts["integrated", "robot distance"] == "below"
    assert verdicts["split-over-time", "robot distance"] == "no complete run"


def test_packing_capacity(row) -> None:
    """35 % fewer visits with room for ten split orders, nearly 50 % without a limit."""
    rows = [
        row("sequential", psv_per_order=1.0),
        row("packing-10", psv_per_order=0.65),
        row("split-among-stations", psv_per_order=0.3),
    ]
    (table,) = packing_tables(rows, load_paper())
    assert [line.verdict for line in table.lines] == ["in range", "below"]


def test_examples(row) -> None:
    """Visits and pile-on are exact."""
    rows = [
        row(instance="examples/example-2-sequential", pod_station_visits=6, pile_on=2.0),
        row(instance="examples/example-2-integrated", pod_station_visits=5, pile_on=2.4),
    ]
    (table,) = example_tables(rows, load_paper())
    verdicts = {line.label: line.verdict for line in table.lines}
    assert verdicts["example-2-sequential", "visits"] == "in range"
    assert verdicts["example-2-sequential", "pile-on"] == "in range"
    assert verdicts["example-2-integrated", "visits"] == "above"
    assert verdicts["example-2-integrated", "pile-on"] == "below"
    assert verdicts["example-1-integrated", "visits"] == "no complete run"
