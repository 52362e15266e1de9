"""What requests want of pods."""

from __future__ import annotations

from rmfs_commands.testing import small_world
from rmfs_rules.scorers.wanted import Requests


def test_requests_are_counted_by_order_and_sku() -> None:
    """The order that was assigned first is in the first row, though it is the younger one."""
    world = small_world({"old": {"b": 2, "c": 1}, "new": {"a": 1, "c": 1}}, {"p": ["a", "b", "c"]})
    for order in reversed(world.orders):
        world.assign(order, world.stations[0], [line.sku for line in order.open_lines])
    uncovered = world.stations[0].uncovered_requests
    wanted = Requests.of(uncovered, [request.items for request in uncovered])
    assert wanted.skus.tolist() == [0, 1, 2]
    assert wanted.needs.tolist() == [[1, 0, 1], [0, 2, 1]]
    assert wanted.row.tolist() == [0, 0, 1, 1]
    assert wanted.items.tolist() == [1, 1, 2, 1]
    assert wanted.skus[wanted.column].tolist() == [request.sku for request in wanted.requests]
    assert wanted.worth(lambda order: order.items).tolist() == [2, 2, 3, 3]


def test_no_requests() -> None:
    """Nothing is wanted."""
    assert Requests.of([], []).needs.shape == (0, 0)
