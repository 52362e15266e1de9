"""Rules that keep scores follow the parameters that they share."""

from __future__ import annotations

import numpy as np
import pytest

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import Order, WarehouseView
from rmfs_rules.helpers.kept_options import KeptLanes, KeptPairs

ALIKE = {"old": ["a"], "due": ["a"], "other": ["b"]}


@pytest.mark.parametrize(
    ("parameters", "first"),
    [({}, "old"), ({"tie_break": "due"}, "due"), ({"late_first": True}, "other")],
    ids=["oldest", "due first", "late first"],
)
def test_which_of_the_orders_goes_first(parameters: dict[str, object], first: str) -> None:
    """The one that matches; of those alike the oldest, or the one that is due first; a late one before all of them."""
    world = small_world(ALIKE, {"p": ["a", "b"]}, capacities=[1], due_s={"old": 90.0, "due": 60.0, "other": 10.0})
    world.advance(20_000)
    view, rule = WarehouseView(world), KeptPairs(**parameters)  # type: ignore[arg-type]
    assert rule.keeps(view, np.array([[1, 0]]))
    (chosen,) = rule.assign_kept(view, np.random.default_rng(0))
    assert world.orders[chosen.order].name == first


def test_orders_that_are_ranked_alike_everywhere() -> None:
    """Those with the lowest number go first."""

    class Smallest(KeptLanes):
        def rank(self, order: Order) -> float:
            return order.open_items

    world = small_world({"two": {"a": 2}, "one": ["a"]}, {"p": ["a"]}, capacities=[2])
    view, rule = WarehouseView(world), Smallest()
    assert rule.keeps(view)
    (chosen,) = rule.assign_kept(view)
    assert world.orders[chosen.order].name == "one"


def test_nothing_is_decided_where_a_filter_chooses_what_is_shown() -> None:
    """Then the rule makes its scores anew."""
    view = WarehouseView(small_world({"1": ["a"], "2": ["a"]}, {"p": ["a"]}))
    assert not KeptPairs().keeps(view.showing(view.backlog[:1]), np.array([[1]]))
