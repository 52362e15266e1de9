"""What lines are worth."""

from __future__ import annotations

import numpy as np

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import WarehouseView
from rmfs_rules.pod_index import PodIndex
from rmfs_rules.pod_index.deciding import weights_of
from rmfs_rules.pod_index.period import POWER, SECONDS, WORTH
from rmfs_rules.pod_index.worth import bound_orders, line_of, share_visits


def test_a_line_whose_sku_is_at_no_station_bears_its_share_of_a_visit() -> None:
    """SKU b shares a visit with SKU a, three lines in all on p; a is at a station, and no pod has c."""
    orders = {"1": ["a"], "2": ["b"], "3": ["b"], "4": ["c"]}
    view = WarehouseView(small_world(orders, {"p": ["a", "b"], "q": ["a"], "r": {"c": 0}}))
    available = np.array([[5, 0], [0, 0], [0, 0]])
    share = share_visits(np.array([0, 1, 2]), view.stock, available, np.array([3, 1, 0]), 300.0)
    assert share.tolist() == [0.0, 100.0, 0.0]


def test_orders_are_bounded_by_priority_and_due_time() -> None:
    """The second order is due: three times the worth at most."""
    view = WarehouseView(small_world({"1": {"a": 2}, "2": {"a": 1, "b": 3}}, {"p": ["a", "b"]}, due_s={"2": 9.0}))
    orders = bound_orders(view.lines, weights_of(PodIndex(handle_s=10, due_factor=3)))
    assert orders[:, POWER].tolist() == [0.0, 0.0]
    assert orders[:, WORTH].tolist() == [1.0, 3.0]
    assert orders[:, SECONDS].tolist() == [20.0, 40.0]


def test_lines_are_found_from_the_lists_by_sku() -> None:
    """The list of b has the lines 1 and 2, the first of the second order."""
    lines = WarehouseView(small_world({"1": ["a", "b"], "2": ["b", "a"]}, {"p": ["a", "b"]})).lines
    assert [line_of(lines, int(lines.first[1]) + i) for i in range(2)] == [1, 2]
