"""Two snapshots of a view differ where anything was changed in between, and nowhere else."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from reserving import hold_until
from rmfs_commands.testing import small_world
from rmfs_commands.testing.snapshot import Snapshot
from rmfs_core.traffic import Query, Reservations, Roads, Traffic
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_core.warehouse.promises import next_request


def world() -> Warehouse:
    """Return a world with an order assigned and a pod bound for it."""
    built = small_world({"1": ["a"], "2": ["b"]}, {"p": {"a": 2}, "q": {"b": 3}}, capacities=(4, 4))
    built.assign(built.orders[0], built.stations[0], [0])
    return built


def tick(built: Warehouse) -> None:
    """Let time pass."""
    built.advance(built.now + 1)


def bind(built: Warehouse) -> None:
    """Send a pod to a station."""
    built.bind(built.pods[0], built.stations[0])


def assign(built: Warehouse) -> None:
    """Assign the other order."""
    built.assign(built.orders[1], built.stations[1], [1])


def task(built: Warehouse) -> None:
    """Let a robot fetch a pod."""
    built.bind(built.pods[0], built.stations[0])
    built.take_task(built.robots[0], built.pods[0])


def rename(built: Warehouse) -> None:
    """Give a pod another name, which no rule may."""
    object.__setattr__(built.pods[1], "name", "r")


@pytest.mark.parametrize(
    ("change", "named"),
    [
        (tick, "of the warehouse"),
        (bind, "of the warehouse"),
        (assign, "backlog of the warehouse"),
        (task, "of the warehouse"),
        (rename, "name of pod r"),
    ],
    ids=lambda value: getattr(value, "__name__", ""),
)
def test_whatever_changes_is_named(change: Callable[[Warehouse], None], named: str) -> None:
    """The first value that is another one, and whose it is."""
    built = world()
    view = WarehouseView(built)
    before = Snapshot.of(view)
    change(built)
    changed = before.first_change(Snapshot.of(view))
    assert changed is not None
    assert named in changed


def test_looking_changes_nothing() -> None:
    """A view may be asked for anything: caches that it fills are no change."""
    built = world()
    view = WarehouseView(built)
    before = Snapshot.of(view)
    assert view.backlog_lines.quantity.tolist() == [1]
    assert view.pods_with(0)
    assert view.travel.times_to(view.stations[0].cell, True).min() == 0
    assert before.first_change(Snapshot.of(view)) is None


def test_items_are_told_apart_from_those_that_are_free() -> None:
    """A promise takes a free item, a pick takes the item itself: both change the pod."""
    built = world()
    view = WarehouseView(built)
    (pod, _), station = built.pods, built.stations[0]
    before = Snapshot.of(view)
    built.place_at_station(built.robots[0], pod, station)
    promised = Snapshot.of(view)
    request = next_request(station, pod)
    assert request is not None
    built.promises.secure(request, pod)
    built.fulfil(request, pod)
    picked = Snapshot.of(view)
    assert [note.stock[pod] for note in (before, promised, picked)] == [((0, 2, 2),), ((0, 2, 1),), ((0, 1, 1),)]
    assert before.first_change(promised) is not None
    assert promised.first_change(picked) is not None


def test_reservations_are_seen_where_a_rule_is_asked_with_them() -> None:
    """A reservation more is a change; the same table is none."""
    built = world()
    view = WarehouseView(built)
    roads = Roads(built.travel)
    traffic = Traffic(roads, Reservations(roads.cells), Query(0, 0, 0, 0, 5))
    before = Snapshot.of(view, traffic)
    assert before.first_change(Snapshot.of(view, traffic)) is None
    hold_until(traffic.table, 1, 3, 0, 500)
    assert before.first_change(Snapshot.of(view, traffic)) == "the reservations"
