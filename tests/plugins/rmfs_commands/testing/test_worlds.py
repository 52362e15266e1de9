"""Tiny warehouses: what is written down is what is there."""

from __future__ import annotations

import pytest

from rmfs_commands.testing import small_instance, small_layout, small_world
from rmfs_core.world import NORTH, CellKind


def test_an_instance_is_written_down_by_names() -> None:
    """SKUs are numbered as they appear, first on pods; one of each and endless stock unless numbers are given."""
    given = small_instance({"1": ["b", "c"], "2": {"a": 3}}, {"p": ["a", "b"], "q": {"a": 2}}, arrivals_s={"2": 1.5})
    assert given.skus == ("a", "b", "c")
    assert [(order.name, order.arrival_tick, order.lines) for order in given.orders] == [
        ("1", 0, ((1, 1), (2, 1))),
        ("2", 1500, ((0, 3),)),
    ]
    assert [(pod.name, pod.contents) for pod in given.pods] == [("p", ((0, None), (1, None))), ("q", ((0, 2),))]
    assert not given.unlimited_stock


def test_orders_may_be_due() -> None:
    """At a time in seconds, in an instance as in a world; the others never are."""
    due = {"2": 1.5}
    assert [order.due_tick for order in small_instance({"1": ["a"], "2": ["a"]}, {"p": ["a"]}, due_s=due).orders] == [
        None,
        1500,
    ]
    assert [order.due_s for order in small_world({"1": ["a"], "2": ["a"]}, {"p": ["a"]}, due_s=due).orders] == [
        None,
        1.5,
    ]


@pytest.mark.parametrize("stations", [1, 2, 4])
@pytest.mark.parametrize(("queue_length", "drawn"), [(1, 3), (3, 3), (4, 6)])
def test_a_layout_has_the_stations_asked_for(stations: int, queue_length: int, drawn: int) -> None:
    """On its east side, each with a queue as long as asked for, or longer: queues go up and down rows of blocks."""
    layout = small_layout(stations, queue_length=queue_length)
    assert [len(cells.queue) for cells in layout.stations] == [drawn] * stations
    middle = layout.width // 2
    assert all(cells.station % layout.width > middle for cells in layout.stations)
    assert len(layout.storage_locations) >= 8
    assert layout is small_layout(stations, queue_length=queue_length)


def test_a_wider_layout_has_more_storage_locations() -> None:
    """Block columns are what it is made of."""
    assert len(small_layout(block_columns=4).storage_locations) == 2 * len(
        small_layout(block_columns=2).storage_locations
    )


def test_a_world_begins_with_everything_waiting() -> None:
    """Orders in the backlog, pods in the first storage locations, robots without one under the last, facing north."""
    world = small_world({"1": ["a"], "2": ["b"]}, {"p": ["a"], "q": ["b"]}, capacities=(4, 9), robots=3)
    locations = world.travel.layout.storage_locations
    assert world.now == 0
    assert [order.name for order in world.backlog.orders] == ["1", "2"]
    assert [pod.location for pod in world.pods] == list(locations[:2])
    assert [(robot.cell, robot.heading, robot.idle) for robot in world.robots] == [
        (locations[-1 - i], NORTH, True) for i in range(3)
    ]
    assert [(station.capacity, station.counts_orders) for station in world.stations] == [(4, False), (9, False)]
    assert [station.queue_room for station in world.stations] == [3 + 1, 3 + 1]


def test_stations_may_count_orders_on_a_layout_of_ones_own() -> None:
    """Both are as given."""
    layout = small_layout(2, block_columns=3)
    world = small_world({"1": {"a": 9}}, {"p": ["a"]}, capacities=(1, 1), counts_orders=True, layout=layout)
    assert world.travel.layout is layout
    assert all(station.counts_orders for station in world.stations)
    assert world.size_at(world.orders[0], world.stations[0]) == 1
    assert {int(layout.kind[pod.cell]) for pod in world.pods} == {CellKind.STORAGE}
