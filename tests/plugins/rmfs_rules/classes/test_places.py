"""How good storage locations are."""

from __future__ import annotations

from rmfs_commands.testing import small_instance, small_layout, small_world
from rmfs_core.motion import Motion
from rmfs_core.warehouse import Station, Warehouse, WarehouseView
from rmfs_core.world.travel import travel_on
from rmfs_rules.classes.places import Places


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


def test_places_with_the_same_drive_have_the_same_rank() -> None:
    """0 is the best."""
    found, _ = places()
    drives = sorted(set(found.nearest_ticks.tolist()))
    assert found.ranks().tolist() == [drives.index(drive) for drive in found.nearest_ticks.tolist()]
    assert len(drives) < len(found.cells)
