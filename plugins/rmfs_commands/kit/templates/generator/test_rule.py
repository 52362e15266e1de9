"""Tests of the generator."""

import rmfs
from rmfs.world import make_instance

NAMED = ["instance.generator=the-rule", "instance.orders=20"]


def test_a_run_with_it_is_complete() -> None:
    """It is found by its name. (Its distribution has to be installed.) The last order comes after 19 minutes."""
    result = rmfs.run("examples/small", overrides=NAMED)
    assert (result.status, result.metrics["orders_completed"]) == ("complete", 20)
    assert result.orders[-1]["arrival_s"] == 19 * 60


def test_the_pace_is_a_parameter() -> None:
    """A scenario sets it by name."""
    scenario = rmfs.load_scenario("examples/small", [*NAMED, "instance.parameters={pace_s=5}"])
    assert [order.arrival_tick for order in make_instance(scenario).orders][:3] == [0, 5_000, 10_000]


def test_the_same_seed_makes_the_same_instance() -> None:
    """And another seed another one."""
    one, same, other = (
        make_instance(rmfs.load_scenario("examples/small", [*NAMED, f"seed={seed}"])) for seed in (1, 1, 2)
    )
    assert one == same != other
