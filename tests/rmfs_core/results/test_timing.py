"""Wall-clock figures, worked out by hand from rows."""

from __future__ import annotations

from typing import Any

import pytest

from rmfs_core.results.catalogue import TIMING
from rmfs_core.results.timing import timing

ORDERS = [{"completed_s": 40.0}, {"completed_s": 70.0}]


def decided(period: int, seconds: float, time_s: float = 0.0) -> dict[str, Any]:
    """Return the row of a decision."""
    return {"period": period, "time_s": time_s, "seconds": seconds}


PERIODS = [decided(1, 2.0), decided(1, 1.0), decided(2, 0.5, time_s=45.0)]


def test_the_first_period_is_apart() -> None:
    """All its decisions are; the later ones are divided by the orders, and by the time to the last of them."""
    found = timing(10.0, 70.0, 0, ORDERS, PERIODS)
    assert (found["decision_s_first"], found["decision_s_later"]) == (3.0, 0.5)
    assert found["decision_s_per_order"] == 0.25
    assert found["decision_percent_of_simulated"] == pytest.approx(100 * 0.5 / 70)
    assert (found["wall_s"], found["simulated_s_per_wall_s"]) == (10.0, 7.0)


def test_what_comes_before_the_end_of_the_warm_up_does_not_count() -> None:
    """Neither decisions nor orders nor time."""
    found = timing(10.0, 70.0, 50, ORDERS, [*PERIODS, decided(3, 0.25, time_s=60.0)])
    assert (found["decision_s_first"], found["decision_s_later"]) == (3.0, 0.25)
    assert found["decision_s_per_order"] == 0.25
    assert found["decision_percent_of_simulated"] == 100 * 0.25 / 20


def test_with_orders_left_the_run_was_simulated_to_its_end() -> None:
    """Not to the last completed order."""
    found = timing(10.0, 100.0, 0, [*ORDERS, {"completed_s": None}], PERIODS)
    assert found["decision_percent_of_simulated"] == 0.5
    assert found["decision_s_per_order"] == 0.25


def test_a_ratio_to_nothing_is_none() -> None:
    """No orders, no simulated time and a clock that stood."""
    found = timing(0.0, 0.0, 0, [], [])
    assert {name for name, value in found.items() if value is None} == {
        "simulated_s_per_wall_s",
        "decision_s_per_order",
        "decision_percent_of_simulated",
    }


def test_every_figure_is_in_the_catalogue() -> None:
    """The table at the end of a run shows each."""
    assert {metric.name for metric in TIMING} == timing(1.0, 0.0, 0, [], []).keys()
