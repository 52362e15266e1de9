"""What is asked for, in words."""

from __future__ import annotations

from rmfs_sizing.target import Target


def test_a_metric_has_its_label_and_unit() -> None:
    """Those of every run, and those of due times."""
    target = Target("turnover_p95_s", 900)
    assert (target.label, target.with_unit(612.345)) == ("Turn-over time, 95 %", "612.3 s")
    assert Target("late_percent", 2).with_unit(2) == "2.0 %"


def test_somebodys_own_metric_has_its_name() -> None:
    """Nothing more is known of it before a run."""
    target = Target("my_waits", 3)
    assert (target.label, target.with_unit(3)) == ("my_waits", "3.000")
