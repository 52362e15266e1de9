"""Active repositioning by cache and utility."""

from __future__ import annotations

import numpy as np
import pytest

from rmfs_commands.testing import small_layout, small_world
from rmfs_core import PodMove
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.classes import Cache, Utility
from rmfs_rules.classes.moving import Pause, nearest_to
from rmfs_rules.classes.places import NO_STATION, Places
from rmfs_rules.classes.worth import movable


def world(wanted: int, pods: int = 20) -> Warehouse:
    """Return a warehouse in which the last pods, far from the station, are wanted: the last one most."""
    contents = {str(i): [f"s{i}"] for i in range(pods)}
    orders = {f"{i}-{n}": [f"s{pods - 1 - i}"] for i in range(wanted) for n in range(wanted - i)}
    return small_world(orders, contents, layout=small_layout(1, block_columns=3))


def after(warehouse: Warehouse, moves: list[PodMove]) -> None:
    """Let robots carry out moves."""
    for move in moves:
        pod, robot = warehouse.pods[move.pod], warehouse.robots[0]
        warehouse.waiting[pod.id] = pod
        warehouse.take_task(robot, pod)
        warehouse.reserve(move.cell)
        warehouse.lift(robot, pod)
        warehouse.move(robot, move.cell, robot.heading)
        warehouse.store(robot, pod)


def test_utility_moves_the_worst_misplaced_first() -> None:
    """No more than may be; each comes nearer to its rank, and in the end there is nothing to move."""
    warehouse = world(4)
    view, rule = WarehouseView(warehouse), Utility(retry_s=10)
    places = Places.of(view)
    rank = dict(zip(places.cells.tolist(), places.ranks().tolist(), strict=True))
    (first,) = rule.move_pods(view, 1)
    assert rank[first.cell] != rank[warehouse.pods[first.pod].cell]
    moved = 0
    while moves := rule.move_pods(view, 1):
        after(warehouse, moves)
        moved += 1
        assert moved < 100
    assert moved > 1


def test_cache_fills_and_clears() -> None:
    """Useful pods come in until only so many places are free; those that nobody wants go out."""
    warehouse = world(3)
    view, rule = WarehouseView(warehouse), Cache(free_places=2)
    places = Places.of(view)
    owner = dict(zip(places.cells.tolist(), places.caches(rule.share).tolist(), strict=True))
    for _ in range(50):
        moves = rule.move_pods(view, 2)
        assert len(moves) <= 2
        for move in moves:
            useful = bool(view.open_demand()[min(warehouse.pods[move.pod].contents)])
            assert (owner[move.cell] != NO_STATION) == useful
        after(warehouse, moves)
        if not moves:
            break
    assert not moves
    free = sum(owner[cell] != NO_STATION for cell in view.free_storage_locations)
    inside = [pod for pod in view.pods if owner[pod.cell] != NO_STATION]
    assert free >= 2 or not any(not view.open_demand()[min(pod.contents)] for pod in inside)


@pytest.mark.parametrize("rule", [Utility(retry_s=60), Cache(retry_s=60)])
def test_it_looks_again_after_a_pause(rule: Utility | Cache) -> None:
    """Nothing is wanted, so there is nothing to move for sixty seconds; before that it has not paused."""
    warehouse = small_world({}, {str(i): ["a"] for i in range(len(small_layout().storage_locations))})
    view = WarehouseView(warehouse)
    assert rule.wake_at(view) is None
    assert rule.move_pods(view, 2) == []
    assert rule.wake_at(view) == 60
    warehouse.advance(60_000)
    assert rule.wake_at(view) is None
    assert WarehouseView(small_world({}, {"p": ["a"]})) is not view
    assert rule.wake_at(WarehouseView(small_world({}, {"p": ["a"]}))) is None, "another run"


def test_pauses_begin_where_nothing_is_moved() -> None:
    """Not where something is."""
    view = WarehouseView(small_world({}, {"p": ["a"]}))
    pause, move = Pause(), PodMove(0, 1)
    assert pause.after(view, 5, lambda: [move]) == [move]
    assert pause.until_s(view) is None
    assert pause.after(view, 5, list) == []
    assert pause.until_s(view) == 5
    assert pause.after(view, 5, lambda: [move]) == []


def test_pods_that_are_bound_or_fetched_stay() -> None:
    """Others may be moved."""
    warehouse = small_world({"1": ["a"]}, {"p": ["a"], "q": ["a"], "r": ["a"]})
    view = WarehouseView(warehouse)
    warehouse.bind(warehouse.pods[0], warehouse.stations[0])
    warehouse.waiting[1] = warehouse.pods[1]
    warehouse.take_task(warehouse.robots[0], warehouse.pods[1])
    assert movable(view).tolist() == [False, False, True]


def test_the_nearest_place_is_that_of_the_pod() -> None:
    """By the loaded drive, however the robot faces."""
    warehouse = small_world({}, {"p": ["a"]})
    view, pod = WarehouseView(warehouse), warehouse.pods[0]
    cells = list(view.free_storage_locations)
    ticks = {c: min(warehouse.travel.ticks(pod.cell, h, c, True) for h in range(4)) for c in cells}
    assert nearest_to(view, pod.cell, np.array(cells)) == min(cells, key=lambda cell: (ticks[cell], cell))
