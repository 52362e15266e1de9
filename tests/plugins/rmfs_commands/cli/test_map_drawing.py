"""Layouts as text maps."""

from __future__ import annotations

import pytest

from rmfs_commands.cli.map_drawing import draw_map
from rmfs_core.scenario import load_scenario
from rmfs_core.world import make_layout, parse_map


@pytest.mark.parametrize("name", ["examples/small", "examples/text-map"])
def test_what_is_drawn_is_read_back(name: str) -> None:
    """The same cells, the same moves, the same stations."""
    layout = make_layout(load_scenario(name))
    again = parse_map(draw_map(layout), "again")
    assert (again.kind == layout.kind).all()
    assert (again.moves == layout.moves).all()
    assert again.stations == layout.stations
