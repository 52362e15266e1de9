"""From a scenario to its layout, which is fit for use when every storage location and station can be reached."""

from __future__ import annotations

import os
from functools import lru_cache
from pathlib import Path

from rmfs_core import entrypoints
from rmfs_core.entrypoints import Entries
from rmfs_core.errors import InputError
from rmfs_core.scenario.model import MOST_CELLS, LayoutSection, Scenario
from rmfs_core.wording import counted
from rmfs_core.world.grid import Layout, check_size

QUEUE_LENGTH = 12


def make_layout(scenario: Scenario, text: str | None = None) -> Layout:
    """Return the checked layout of a scenario; the same object for the same layout, so that its tables are shared.

    Parameters
    ----------
    scenario
        The scenario. Its layout is made by an entry point of the group ``rmfs.layouts``, a function of the section, the
        text of ``layout.map_file`` (None without one), ``stations.queue_length`` (None: as it likes), what to call the
        map or the section in errors, and ``layout.parameters`` by name; it returns a `Layout`.
    text
        Text of the map file, instead of reading it.

    Raises
    ------
    InputError
        When the map is wrong, or something cannot be reached.
    """
    section, place = scenario.layout, "layout"
    if section.map_file is not None:
        path = Path(scenario.folder) / section.map_file
        place, text = str(path), _text_of(path) if text is None else text
    files = [Path(scenario.folder, one) for one in section.parameters.values() if isinstance(one, str)]  # perhaps
    make = _layout.__wrapped__ if any(map(os.path.exists, files)) else _layout  # one that is there may change
    folder = scenario.folder if files else ""
    return make(layout_maker(section), section, text, scenario.stations.queue_length, place, folder)


def layout_maker(section: LayoutSection) -> Entries:
    """Return the entry points of what makes a layout; one, or they clash."""
    default = "blocks" if section.map_file is None else "text-map"
    return entrypoints.chosen(entrypoints.LAYOUTS, section.generator, default)


def _text_of(path: Path) -> str:
    try:
        with path.open(encoding="utf-8-sig") as stream:
            return stream.read(20 * MOST_CELLS)  # a device may have no end; what is too large is refused
    except UnicodeDecodeError as error:
        raise InputError(str(path), f"cannot read the map: {error}") from error
    except (OSError, ValueError) as error:  # ValueError: of a name that no file can have
        raise InputError("layout.map_file", f"{path} cannot be read: {getattr(error, 'strerror', error)}") from error


@lru_cache(maxsize=16)
def _layout(
    entries: Entries, section: LayoutSection, text: str | None, queue_length: int | None, place: str, folder: str
) -> Layout:
    handed = {"section": section, "text": text, "queue_length": queue_length, "place": place}
    malformed = entrypoints.format_module("reaching").malformed
    layout = entrypoints.generated(entries, Layout, malformed, folder, **handed)
    layout.kind.setflags(write=False)  # runs share it
    layout.moves.setflags(write=False)
    check_size(layout.width, layout.height, place)
    check_layout(layout, place)
    for number, cells in enumerate(layout.stations, 1):
        if queue_length is not None and (has := cells.places) < queue_length:
            found = f"found {queue_length}, but the queue of station {number} in {place} has {counted(has, 'cell')}"
            raise InputError("stations.queue_length", f"{found}; expected at most that many")
    return layout


def queue_length(scenario: Scenario, layout: Layout) -> int:
    """Return how many pods can wait at a station: as the scenario says, or else 12, or fewer where a map has fewer."""
    return scenario.stations.queue_length or min(QUEUE_LENGTH, *(cells.places for cells in layout.stations))


def check_layout(layout: Layout, place: str) -> None:
    """Raise `InputError` naming the cells when something cannot be reached, by a robot with a pod or without."""
    entrypoints.format_module("reaching").check_layout(layout, place)
