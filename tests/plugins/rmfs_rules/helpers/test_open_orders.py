"""Orders of the backlog by size: as the view has them, whatever joins and leaves."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import WarehouseView
from rmfs_rules.helpers.open_orders import OpenOrders


def hold_to_view(kept: OpenOrders, view: WarehouseView) -> None:
    """Compare what is kept with what the warehouse shows."""
    assert list(kept.items.items()) == [(order.id, order.open_items) for order in view.backlog]
    assert kept.of_size == {
        size: [order.id for order in view.backlog if order.open_items == size]
        for size in {order.open_items for order in view.backlog}
    }


@given(
    st.lists(st.dictionaries(st.sampled_from("abc"), st.integers(1, 4), min_size=1), min_size=1, max_size=9), st.data()
)
def test_they_are_those_of_the_view(orders: list[dict[str, int]], data: st.DataObject) -> None:
    """Lines are assigned one after another, in any order; made anew, the account is the same."""
    world = small_world({str(i): order for i, order in enumerate(orders)}, {"p": ["a", "b", "c"]})
    view, kept = WarehouseView(world), OpenOrders()
    while view.backlog:
        if data.draw(st.booleans()):
            kept.update(view)
            hold_to_view(kept, view)
            hold_to_view(OpenOrders(view.backlog), view)
        order = data.draw(st.sampled_from(view.backlog))
        skus = [line.sku for line in order.open_lines]
        world.assign(order, world.stations[0], data.draw(st.lists(st.sampled_from(skus), min_size=1, unique=True)))
    kept.update(view)
    hold_to_view(kept, view)


def test_another_warehouse() -> None:
    """What was known of one warehouse is forgotten in the next."""
    kept = OpenOrders()
    for number in (600, 3):
        view = WarehouseView(small_world({str(i): {"a": 1 + i % 4} for i in range(number)}, {"p": ["a"]}))
        kept.update(view)
        hold_to_view(kept, view)
