"""What the metrics of every run are called."""

from __future__ import annotations

from rmfs_commands.details.catalogue import DETAILS, LATENESS, MEASURES, METRICS, on_time
from rmfs_commands.details.metrics import Metrics


def test_no_two_metrics_have_a_name() -> None:
    """Neither among them nor with those that every table begins with."""
    names = [metric.name for metric in (*DETAILS, *LATENESS)]
    assert len(set(names)) == len(names)
    assert not {metric.name for group in METRICS.values() for metric in group} & {metric.name for metric in MEASURES}


def test_each_says_what_it_means() -> None:
    """With a sentence, and a unit where it is a time."""
    for name, metric in ((metric.name, metric) for metric in (*MEASURES, *Metrics.measures)):
        assert metric.meaning.endswith("."), name
        assert (metric.unit == "s") == name.endswith("_s"), name


def test_orders_on_time_are_told_by_priority() -> None:
    """Also those of a priority that is not among the first."""
    assert on_time(12).name == "on_time_percent_priority_12"
    groups = {metric.name: metric.group for metric in MEASURES}
    assert groups[on_time(0).name] == "Due times"
    assert groups["turnover_p95_s"] is None
