"""Layout ``the-rule``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rmfs import InputError
from rmfs.layouts import parse_map

if TYPE_CHECKING:
    from rmfs import LayoutSection
    from rmfs.world import Layout


def the_rule(section: LayoutSection, text: str | None, queue_length: int | None, place: str) -> Layout:
    """Make pairs of rows of storage locations beside aisles, with a picking station at the end of each aisle.

    Parameters
    ----------
    section
        The section ``layout``: ``block_rows`` pairs of rows of ``block_columns`` times ``block_length`` locations.
    text
        The text of ``layout.map_file``, None without one.
    queue_length
        ``stations.queue_length``: as many cells the queues have, 4 where it is None.
    place
        What errors call the layout.
    """
    if text is not None:
        raise InputError(place, "expected no map file beside this generator")
    queue = queue_length or 4
    length = section.block_columns * section.block_length
    storage, aisle = "#" * length, "." * length
    walls, waiting, lane = "@" * queue, "q" * queue, "." * queue
    rows = []
    for _ in range(section.block_rows):
        rows += [f".{storage}.{walls}@", f".{aisle}.{waiting}O", f".{storage}.{lane}."]
    return parse_map("\n".join([f".{aisle}.{walls}@", *rows]), place)
