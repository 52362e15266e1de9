"""Layout ``the-rule``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rmfs import InputError
from rmfs.layouts import parse_map

if TYPE_CHECKING:
    from rmfs import LayoutSection
    from rmfs.world import Layout


def the_rule(
    section: LayoutSection, text: str | None, queue_length: int | None, place: str, *, lane_width: int = 1
) -> Layout:
    """Make pairs of rows of storage locations next to aisles, with a picking station at the end of each aisle.

    Parameters
    ----------
    section
        The section ``layout``: ``block_rows`` pairs of rows of ``block_columns`` times ``block_length`` locations.
    text
        The text of ``layout.map_file``, None without one.
    queue_length
        ``stations.queue_length``: as many cells the queues have, 4 where it is None.
    place
        Name of the layout in errors.
    lane_width
        Width of the lanes at both ends of the aisles (cells); ``layout.parameters`` of a scenario sets it.
    """
    if text is not None:
        raise InputError(place, "expected no map file with this generator")
    if lane_width < 1:
        raise InputError("layout.parameters", f"expected `lane_width` of at least 1, found {lane_width}")
    queue = queue_length or 4
    length = section.block_columns * section.block_length
    storage, aisle = "#" * length, "." * length
    walls, waiting, lane, side = "@" * queue, "q" * queue, "." * queue, "." * lane_width
    rows = []
    for _ in range(section.block_rows):
        rows += [
            f"{side}{storage}{side}{walls}@",
            f"{side}{aisle}{side}{waiting}O",
            f"{side}{storage}{side}{lane}.",
        ]
    return parse_map("\n".join([f"{side}{aisle}{side}{walls}@", *rows]), place)
