"""Layouts of scenarios, and what makes one unfit for use."""

from __future__ import annotations

import pytest

from rmfs_core.errors import InputError
from rmfs_core.world import check_layout, parse_map


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("..#\n.qO\n..@\n@@.", "map: 1 cell(s) cannot be reached over the floor from row 1, column 2: row 4, column 3"),
        (".#.\n###\n.qO\n...", "map: 1 cell(s) have no floor beside them, so no pod gets in or out: row 2, column 2"),
        ("#.\n..", "map: the layout has no picking station"),
        (".qO\n...", "map: the layout has no storage location"),
        ("#@@@\n.@qO\n.<┘<", "map, row 2, column 3: no aisle leads into the end of this queue"),
        ("..#\n.qO", "map, row 2, column 3: no floor beside the picking station to leave it"),
    ],
)
def test_what_cannot_be_reached_is_named(text: str, message: str) -> None:
    """A map that can be read but not driven on is refused with the cells."""
    layout = parse_map(text, "map")
    with pytest.raises(InputError) as caught:
        check_layout(layout, "map")
    assert message in str(caught.value)
