"""The view that rules get."""

from __future__ import annotations

import pytest

from rmfs_core.warehouse import WarehouseView
from rmfs_testing import small_world


def test_the_view_is_for_looking_only() -> None:
    """What a rule sees cannot be set or filled by accident."""
    world = small_world({"1": ["a"]}, {"p": ["a"]})
    view = WarehouseView(world)
    with pytest.raises(AttributeError):
        view.stations[0].load = 3  # type: ignore[misc]
    with pytest.raises(AttributeError):
        view.pods[0].location = 3  # type: ignore[misc]
    with pytest.raises(AttributeError, match=r"Station\.capacity is read-only"):
        view.stations[0].capacity = 1000
    with pytest.raises(AttributeError):
        view.travel.motion = None  # type: ignore[misc,assignment]
    with pytest.raises(TypeError):
        view.pods[0].contents[0] = 3  # type: ignore[index]
    for array in (view.backlog_lines.sku, view.travel.layout.lane, view.travel.layout.kind):
        with pytest.raises(ValueError, match="read-only"):
            array[:] = 0
    assert isinstance(view.free_storage_locations, tuple)
    view.open_demand()[0] = 99
    assert view.open_demand()[0] == 1
