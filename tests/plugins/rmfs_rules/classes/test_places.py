"""How good storage locations are."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from rmfs_commands.testing import small_instance, small_layout, small_world
from rmfs_core.motion import Motion
from rmfs_core.warehouse import Station, Warehouse, WarehouseView
from rmfs_core.world.travel import travel_on
from rmfs_rules.classes.places import Places, by_share, class_at, nearest_of


def places(stations: int = 2) -> tuple[Places, WarehouseView]:
    """Return the places of a world with so many stations."""
    view = WarehouseView(small_world({}, {"p": ["a"]}, capacities=[9] * stations))
    return Places.of(view), view


def test_places_are_all_storage_locations_with_their_drives() -> None:
    """By cell; loaded, with the best heading at the start."""
    found, view = places()
    assert found.cells.tolist() == sorted(view.travel.layout.storage_locations)
    for station in view.stations:
        drives = [view.travel.times_to(station.cell, True)[cell].min() for cell in found.cells.tolist()]
        assert found.ticks[station.id].tolist() == drives
    assert found.nearest_ticks.tolist() == [min(pair) for pair in zip(*found.ticks.tolist(), strict=True)]


def test_places_with_empty_pods_are_none() -> None:
    """They never become free."""
    layout = small_layout(1)
    locations = layout.storage_locations
    station = Station(0, layout.stations[0], 9, False, 3)
    instance = small_instance({}, {"p": ["a"]})
    world = Warehouse(instance, travel_on(layout, Motion()), [station], [], locations[:1], blocked=locations[1:5])
    assert not {*Places.of(WarehouseView(world)).cells.tolist()} & {*locations[1:5]}


@pytest.mark.parametrize("borders", [(0.1, 0.3, 1.0), (0.5, 1.0), (1.0,), (0.01, 1.0)])
def test_classes_are_shares_of_the_places(borders: tuple[float, ...]) -> None:
    """Nobody in a class has a longer drive than somebody in the next one."""
    found, _ = places()
    classes, drives = found.classes(borders), found.nearest_ticks
    ends = np.cumsum(np.bincount(classes, minlength=len(borders))).tolist()
    assert ends == [math.floor(border * len(drives)) for border in borders[:-1]] + [len(drives)]
    for one in range(len(borders) - 1):
        assert drives[classes <= one].max(initial=0) <= drives[classes > one].min()


def test_shares_are_cut_in_the_given_order() -> None:
    """Of five the best two, the next one and the last two."""
    assert by_share(np.array([3, 0, 4, 1, 2]), (0.4, 0.6, 1.0)).tolist() == [0, 2, 2, 0, 1]
    assert [class_at(rank, 5, (0.4, 0.6, 1.0)) for rank in range(5)] == [0, 0, 1, 2, 2]


def test_places_with_the_same_drive_have_the_same_rank() -> None:
    """0 is the best."""
    found, _ = places()
    drives = sorted(set(found.nearest_ticks.tolist()))
    assert found.ranks().tolist() == [drives.index(drive) for drive in found.nearest_ticks.tolist()]
    assert len(drives) < len(found.cells)


def test_the_nearest_of_some_cells_is_the_robots(put_at_station: Callable[[Warehouse, int, int], None]) -> None:
    """By driving time with the pod from where its robot stands, turns included; ties go to the lowest cell."""
    world = small_world({}, {"p": ["a"]})
    put_at_station(world, 0, 0)
    view, pod, robot = WarehouseView(world), world.pods[0], world.robots[0]
    cells = np.array(world.free_locations)[5:30]
    drives = {cell: world.travel.ticks(pod.cell, robot.heading, cell, True) for cell in cells.tolist()}
    assert nearest_of(view, pod, cells) == min(drives, key=lambda cell: (drives[cell], cell))
