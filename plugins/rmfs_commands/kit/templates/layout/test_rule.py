"""Tests of the layout."""

import pytest
import rmfs
from rmfs.world import make_layout

NAMED = ["layout.generator=the-rule", "layout.block_rows=2", "layout.block_columns=3", "instance.orders=20"]


def test_it_has_what_the_section_says() -> None:
    """Two pairs of rows of three times four storage locations, and a station for each."""
    layout = make_layout(rmfs.load_scenario("examples/small", [*NAMED, "layout.block_length=4"]))
    assert len(layout.storage_locations) == 2 * 2 * 3 * 4
    assert len(layout.stations) == 2


def test_the_width_of_the_lanes_is_a_parameter() -> None:
    """A scenario sets it by name; what makes no sense is one sentence."""
    narrow, wide = (
        make_layout(rmfs.load_scenario("examples/small", [*NAMED, f"layout.parameters={{lane_width={width}}}"]))
        for width in (1, 3)
    )
    assert wide.width == narrow.width + 4
    with pytest.raises(rmfs.InputError, match="expected `lane_width` of at least 1, found 0"):
        make_layout(rmfs.load_scenario("examples/small", [*NAMED, "layout.parameters={lane_width=0}"]))


def test_a_run_with_it_is_complete() -> None:
    """Robots get everywhere, with pods and without. (Its distribution has to be installed.)"""
    assert rmfs.run("examples/small", overrides=NAMED).status == "complete"
