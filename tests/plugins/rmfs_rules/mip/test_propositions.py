"""Propositions 1 to 3 in every period of random runs."""

from __future__ import annotations

from pathlib import Path

import pytest

import rmfs_core

RULE = '''
from typing import ClassVar
from attrs import define
from rmfs_core import hookimpl
from rmfs_rules.mip import Integrated, SplitAmongStations, SplitOverTime

@define
class AskAll:
    """Ask all three models in each period; decide as the one that is numbered."""

    number: int = 0
    splits_over_time: ClassVar[bool] = {splits}

    @hookimpl
    def assign_orders_and_pods(self, warehouse, rng):
        rules = (Integrated, SplitAmongStations, SplitOverTime)
        answers = [rule().assign_orders_and_pods(warehouse, rng) for rule in rules]
        whole, among, over = (answer.report for answer in answers)
        assert all(report.status == "optimal" for report in (whole, among, over)), "proposition 1"
        assert among.objective <= whole.objective, "proposition 2"
        assert over.objective <= among.objective, "proposition 3"
        return answers[self.number]
'''

SCENARIO = """
seed = {seed}
instance = {{ orders = {orders}, skus = {skus}, pods = {pods}, skus_per_pod = 2, max_lines = 4 }}
layout = {{ block_rows = 5, block_columns = 2, stations_east = 2, pod_fill = 0.6 }}
robots = {{ count = 3 }}
stations = {{ item_capacity = {capacity}, queue_length = 3 }}
[rules]
pp = "free-flow"
ta = "nearest-robot"
poa_pps = {{ rule = "./ask_all.py:AskAll", number = {number} }}
"""


@pytest.mark.parametrize("number", [0, 1, 2], ids=["integrated", "split-among-stations", "split-over-time"])
@pytest.mark.parametrize(
    ("seed", "orders", "skus", "pods", "capacity"),
    [(1, 20, 8, 8, "6"), (2, 25, 5, 6, "[4, 7]"), (3, 40, 12, 10, "10"), (4, 30, 10, 12, "5")],
)
def test_no_split_is_worse(
    tmp_path: Path, seed: int, orders: int, skus: int, pods: int, capacity: str, number: int
) -> None:
    """Every period has a solution; splitting among stations is never worse, splitting over time never worse still."""
    (tmp_path / "ask_all.py").write_text(RULE.format(splits=number == 2))
    file = tmp_path / "scenario.toml"
    file.write_text(SCENARIO.format(seed=seed, orders=orders, skus=skus, pods=pods, capacity=capacity, number=number))
    result = rmfs_core.run(file)
    assert result.status == "complete"
    assert result.metrics["periods"] > 10
