"""Decisions of pod-index, ms an order: a day of groceries, and 10,000 orders waiting. `make bench` measures.

The aim is 1 ms an order on a machine that does nothing else. No run fails for it.
"""

from __future__ import annotations

from typing import Any

import pytest

from rmfs_core import run

WORLDS = {
    "grocery-day": ("grocery-day", ["rules.ta=nearest-robot"], 25_200),
    "10,000 orders": ("paper-250", ["instance.orders=10000"], 300),
}
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
