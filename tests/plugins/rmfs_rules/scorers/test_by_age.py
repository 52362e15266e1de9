"""Lines of SKUs by age, in runs: what is kept leads where it leads when all is read anew."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import rmfs_core
from rmfs_core import hookimpl
from rmfs_core.info import Question
from rmfs_core.roles import Role
from rmfs_rules.scorers import WorkAmount
from rmfs_rules.scorers.by_age import LENGTH, LINE, QUANTITY, START, WANTED, join, leave


def test_lines_join_at_the_end_and_leave_anywhere() -> None:
    """Four lines of a SKU: the first, one in the middle, the last and the only one leave."""
    lines, skus, pool = np.zeros((3, 4), np.int64), np.zeros((4, 1), np.int64), np.zeros((4, 1))
    lines[QUANTITY], orders = [1, 2, 3, 4], np.ones((2, 1))
    pool, used = join(0, 3, 0, lines, skus, orders, pool)
    pool, used = join(3, 4, used, lines, skus, orders, pool)
    number = np.array([[4], [4]])

    def left() -> list[int]:
        found: list[int] = pool[LINE, skus[START, 0] : skus[START, 0] + skus[LENGTH, 0]].tolist()
        return found

    assert left() == [0, 1, 2, 3]
    assert leave(np.array([1]), lines, skus, number, pool) == 1
    assert left() == [0, 2, 3]
    assert skus[WANTED, 0] == 8
    assert leave(np.array([0, 3]), lines, skus, number, pool) == 0
    assert left() == [2]
    assert leave(np.array([2]), lines, skus, number, pool) == -1
    assert left() == []
    assert skus[WANTED, 0] == 0


class Doubter:
    """Observer that has each decision made once more, by a rule that remembers nothing."""

    def __init__(self, value: str) -> None:
        self.value, self.pods = value, 0

    @hookimpl
    def rule_answered(self, question: Question, answer: Any) -> None:
        """Compare."""
        if question.decides is Role.PPS:
            view = question.warehouse
            assert list(answer) == list(WorkAmount(self.value).select_pods(view, **question.arguments, rng=None))
            shown = view.showing(view.backlog)
            assert list(answer) == list(WorkAmount(self.value).select_pods(shown, **question.arguments, rng=None))
            self.pods += len(answer)


@pytest.mark.parametrize("value", ["age", "lateness"])
@pytest.mark.parametrize("stock", [[], ["instance.items_per_sku=3"]], ids=["unlimited", "limited"])
def test_every_decision_of_a_run(value: str, stock: list[str]) -> None:
    """As if each call were the first, and as if all orders were shown by a filter."""
    doubter = Doubter(value)
    orders = ["instance.orders=120", "instance.due={allowance_s=200,spread_s=190}"]
    rules = ["rules.pps=work-amount", f"rules.pps.value={value}", "rules.pp=free-flow", "run.until_s=900"]
    rmfs_core.run("paper-250", overrides=[*orders, *stock, *rules], observers=[doubter])
    assert doubter.pods > 5
