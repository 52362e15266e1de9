"""A pick takes no longer when a million items of its line are to come than with ten thousand."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import rmfs_core

SCENARIO = """
[instance]
orders_file = "orders.csv"
pods_file = "pods.csv"
[layout]
block_rows = 3
block_columns = 2
stations_east = 1
[robots]
count = 2
[rules]
poa = "pod-match"
pps = "demand"
pr = "nearest"
ta = "balanced"
pp = "whca-n"
[run]
until_s = 20000
"""
PICKS, RUNS = 1_536, 5


def test_picks_of_a_line_of_a_million_items(benchmark: Any, tmp_path: Path) -> None:
    """Bar: at most twice the CPU time of as many picks of a line of 10,000 items: of each the least of five runs."""
    (tmp_path / "scenario.toml").write_text(SCENARIO)
    (tmp_path / "pods.csv").write_text("pod,sku,quantity\np,1,500\nq,1,\n")

    def least_s(items: int) -> float:
        (tmp_path / "orders.csv").write_text(f"order,arrival_s,sku,quantity\n1,0,1,{items}\n")
        took = []
        for _ in range(RUNS):
            begin = time.process_time()
            result = rmfs_core.run(tmp_path / "scenario.toml")
            took.append(time.process_time() - begin)
            assert abs(result.metrics["picks"] - PICKS) < 10
        return min(took)

    least_s(10_000)  # what is compiled is loaded
    few = least_s(10_000)
    many = benchmark.pedantic(least_s, args=(1_000_000,), rounds=1)
    benchmark.extra_info["quotient"] = many / few
    assert many <= 2 * few, (few, many)
