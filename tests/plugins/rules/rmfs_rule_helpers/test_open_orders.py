"""Orders of the backlog as arrays: as the view has them, whatever joins and leaves."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from rmfs_core.warehouse import WarehouseView
from rmfs_rule_helpers import items_per_order
from rmfs_rule_helpers.open_orders import OpenOrders
from rmfs_testing import small_world


@given(
    st.lists(st.dictionaries(st.sampled_from("abc"), st.integers(1, 4), min_size=1), min_size=1, max_size=9), st.data()
)
def test_they_are_those_of_the_view(orders: list[dict[str, int]], data: st.DataObject) -> None:
    """Lines are assigned one after another, in any order."""
    world = small_world({str(i): order for i, order in enumerate(orders)}, {"p": ["a", "b", "c"]})
    view, kept = WarehouseView(world), OpenOrders()
    while view.backlog:
        if data.draw(st.booleans()):
            kept.update(view)
            assert kept.ids.tolist() == [order.id for order in view.backlog]
            assert kept.items.tolist() == items_per_order(view).tolist()
            assert kept.whole == all(len(order.open_lines) == len(order.lines) for order in view.backlog)
        order = data.draw(st.sampled_from(view.backlog))
        skus = [line.sku for line in order.open_lines]
        world.assign(order, world.stations[0], data.draw(st.lists(st.sampled_from(skus), min_size=1, unique=True)))
    kept.update(view)
    assert not kept.ids.size
    assert kept.whole


def test_many_orders_and_another_warehouse() -> None:
    """The arrays grow; what was known of one warehouse is forgotten in the next."""
    kept = OpenOrders()
    for number in (600, 3):
        kept.update(WarehouseView(small_world({str(i): {"a": 1 + i % 4} for i in range(number)}, {"p": ["a"]})))
        assert kept.ids.tolist() == list(range(number))
        assert kept.items.tolist() == [1 + i % 4 for i in range(number)]
