"""Statements of the paper on the sequential rules, compared with runs (Xie, Thieme, Krenzler, Li, arXiv:1902.03092)."""

from itertools import product
from statistics import mean

import pytest

import rmfs_core

IMPLIED_MAKESPAN_S = 3571
"""Computing time per order x 250 orders / share of simulated time (the paper's tables): the makespan they imply."""


def test_example_2_sequential() -> None:
    result = rmfs_core.run("examples/example-2-sequential")
    assert result.status == "complete"
    assert {row["order"]: row["stations"] for row in result.orders} == {"1": "2", "2": "1", "3": "1", "4": "2"}
    assert result.metrics["pod_station_visits"] == 6
    assert result.metrics["pile_on"] == 2.0
    first = [(row["pod"], row["station"]) for row in result.visits[:2]]
    assert first == [("1", "1"), ("2", "2")]
    rest = sorted((row["pod"], row["station"]) for row in result.visits[2:])
    assert rest == [("3", "1"), ("3", "2"), ("4", "1"), ("4", "2")]


@pytest.mark.slow
def test_makespan_of_the_250_order_instances(capsys: pytest.CaptureFixture[str]) -> None:
    makespans = {}
    for skus, pods, alpha in product((20, 100), (50, 100), (2, 3)):
        overrides = [f"instance.skus={skus}", f"instance.pods={pods}", f"instance.skus_per_pod={alpha}"]
        result = rmfs_core.run("paper-250", overrides=overrides)
        assert result.status == "complete"
        makespans[skus, pods, alpha] = result.metrics["makespan_s"]
    with capsys.disabled():
        print(f"\nmean makespan {mean(makespans.values()):.0f} s; implied by the paper {IMPLIED_MAKESPAN_S} s")
        for (skus, pods, alpha), makespan in makespans.items():
            print(f"  |I| {skus:3}, |P| {pods:3}, alpha {alpha}: {makespan:.0f} s")
    assert mean(makespans.values()) == pytest.approx(IMPLIED_MAKESPAN_S, rel=0.25)
