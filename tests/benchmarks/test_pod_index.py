"""Decisions of pod-index: ms an order, and ms a call with up to 50,000 orders waiting, also by `most-covered`.

The aim is 1 ms an order on a machine that does nothing else; no run fails for that.
"""

from __future__ import annotations

from typing import Any

import pytest

from rmfs_core import run

WORLDS = {
    "grocery-day": ("grocery-day", ["rules.ta=nearest-robot"], 25_200),
    "10,000 orders": ("paper-250", ["instance.orders=10000"], 300),
}
WITH_4000_MS = 2.5
RULES = ["rules.poa=", "rules.pps=", "rules.poa_pps=pod-index"]


@pytest.mark.parametrize("world", WORLDS)
def test_decisions_an_order(benchmark: Any, world: str) -> None:
    """Seconds that the assigning rule took, to the orders that were completed; unless timed, the beginning will do."""
    name, more, short_s = WORLDS[world]
    end_s = 8000 if world == "10,000 orders" else 10**6
    overrides = [*RULES, *more, f"run.until_s={end_s if benchmark.enabled else short_s}"]
    result = benchmark.pedantic(lambda: run(name, overrides=overrides), rounds=1)
    orders = result.metrics["orders_completed"]
    assert orders > 0
    benchmark.extra_info["decisions_ms_an_order"] = 1000 * sum(one["seconds"] for one in result.periods) / orders


RULES_OF = {"pod-index": RULES, "most-covered": ["rules.filters=[{rule='most-covered',n=20}]"]}


def ms_a_call(rule: str, backlog: int) -> float:
    """Return the mean time of a decision where stations count orders, but for the first ones: they fill stations."""
    world = [
        "instance.skus=1000",
        "instance.pods=428",
        "instance.skus_per_pod=12",
        "robots.count=16",
        "run.until_s=600",
        "rules.pp=free-flow",
        "stations.order_capacity=6",
        f"instance.orders={backlog + 2000}",
        f"instance.arrivals={{process='refill',backlog={backlog}}}",
    ]
    seconds = [one["seconds"] for one in run("paper-250", overrides=[*RULES_OF[rule], *world]).periods]
    return 1000 * sum(seconds[5:]) / len(seconds[5:])


@pytest.mark.parametrize("rule", RULES_OF)
def test_a_call_of_a_large_backlog(benchmark: Any, rule: str) -> None:
    """Bar: it grows no faster than the backlog, from 1,000 orders on; where nothing is timed, 250 orders do.

    With 4,000 orders a call takes at most `WITH_4000_MS`.
    """
    sizes = (1000, 4000, 10_000, 50_000) if benchmark.enabled else (250,)
    took = benchmark.pedantic(lambda: {size: ms_a_call(rule, size) for size in sizes}, rounds=1)
    if benchmark.enabled:
        benchmark.extra_info["ms_a_call"] = took
        assert all(took[size] <= size / 1000 * took[1000] for size in sizes), took
        assert took[4000] <= WITH_4000_MS, took
