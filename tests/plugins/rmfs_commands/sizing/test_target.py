"""What is asked for, in words."""

from __future__ import annotations

import pytest

from rmfs_commands.details.catalogue import FROM_ORDERS, MORE_IS_BETTER
from rmfs_commands.sizing.target import KNOWN, Target
from rmfs_core import Scenario
from rmfs_core.errors import InputError
from rmfs_core.scenario import load_scenario
from rmfs_core.world import make_instance


def test_a_metric_has_its_label_and_unit() -> None:
    """Those of every run, and those of due times."""
    target = Target("turnover_p95_s", 900)
    assert (target.label, target.with_unit(612.345)) == ("Turn-over time, 95 %", "612.3 s")
    assert Target("late_percent", 2).with_unit(2) == "2.0 %"


def test_an_indented_label_is_named_with_what_it_is_a_part_of() -> None:
    """All of them have a metric above them; how that one is averaged is left out."""
    assert Target("late_percent", 2).label == "Late orders, of those due"
    assert Target("turnover_backlog_p95_s", 2).label == "Turn-over time, in the backlog, 95 %"
    assert Target("empty_distance_m", 2).label == "Distance, empty"
    assert not [name for name in KNOWN if Target(name, 2).label.startswith(" ")]


def test_somebodys_own_metric_has_its_name() -> None:
    """Nothing more is known of it before a run."""
    target = Target("my_waits", 3)
    assert (target.label, target.with_unit(3)) == ("my_waits", "3.000")


def test_what_cannot_be_too_large_is_refused(poisson: Scenario) -> None:
    """Every metric that is to be large or that robots do not change, and on time of any priority; they exist."""
    orders = [make_instance(poisson)]
    assert KNOWN.keys() >= MORE_IS_BETTER | FROM_ORDERS
    for metric in (*MORE_IS_BETTER, "on_time_percent_priority_12"):
        with pytest.raises(InputError, match=f"--most {metric}=2: more of `{metric}` is better; expected"):
            Target(metric, 2).check(orders)
    for metric in FROM_ORDERS:
        with pytest.raises(InputError, match=f"`{metric}` is the same for every number of robots"):
            Target(metric, 2).check(orders)
    Target("turnover_p95_s", 2).check(orders)
    Target("my_waits", 2).check(orders)


def test_a_limit_that_nothing_can_keep_is_refused(poisson: Scenario) -> None:
    """Metrics of every run are never negative; what somebody's own may be is not known."""
    orders = [make_instance(poisson)]
    for metric in ("turnover_p95_s", "late_percent", "stock_outs"):
        with pytest.raises(InputError, match=f"--most {metric}=-2: `{metric}` is never below 0; expected a number >="):
            Target(metric, -2).check(orders)
    Target("psv_per_order", 0).check(orders)
    Target("my_waits", -2).check(orders)


def test_nothing_is_late_that_is_not_due(poisson: Scenario) -> None:
    """Refused without due times, accepted with them."""
    due = [make_instance(load_scenario("grocery-day", ["instance.orders=20"]))]
    for metric in ("late_percent", "late_orders", "tardiness_s", "tardiness_p95_s"):
        Target(metric, 2).check(due)
        with pytest.raises(InputError, match=f"these runs have no `{metric}`: no order has a due time"):
            Target(metric, 2).check([make_instance(poisson)])
