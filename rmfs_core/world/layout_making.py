"""From a scenario to its layout."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

from rmfs_core.errors import InputError
from rmfs_core.scenario.model import LayoutSection, Scenario
from rmfs_core.world.block import block_map
from rmfs_core.world.grid import Layout
from rmfs_core.world.layout_checks import check_layout
from rmfs_core.world.textmap import parse_map


def make_layout(scenario: Scenario) -> Layout:
    """Return the checked layout of a scenario; the same object for the same layout, so that its tables are shared.

    Raises
    ------
    InputError
        When the map is wrong, or something cannot be reached.
    """
    section = scenario.layout
    if section.map_file is None:
        return _block_layout(section, scenario.stations.queue_length)
    path = Path(scenario.folder) / section.map_file
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(str(path), f"cannot read the map: {error}") from error
    return _map_layout(text, str(path), scenario.stations.queue_length)


@lru_cache(maxsize=16)
def _block_layout(section: LayoutSection, queue_length: int) -> Layout:
    layout = parse_map(block_map(section, queue_length), "layout")
    check_layout(layout, "layout")
    return layout


@lru_cache(maxsize=16)
def _map_layout(text: str, place: str, queue_length: int) -> Layout:
    layout = parse_map(text, place)
    check_layout(layout, place)
    for number, cells in enumerate(layout.stations, 1):
        if len(cells.queue) < queue_length:
            raise InputError(
                "stations.queue_length",
                f"found {queue_length}, but the queue of station {number} in {place} has {len(cells.queue)} cell(s); "
                "expected at most that many",
            )
    return layout
