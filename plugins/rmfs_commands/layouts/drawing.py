"""A layout drawn for a notebook: the entry point ``drawing`` of the group ``rmfs.formats``."""

from __future__ import annotations

from itertools import groupby

from rmfs_core.world.grid import CellKind, Layout

DRAWN = {
    CellKind.FLOOR: ("#d5dae1", "floor"),
    CellKind.STORAGE: ("#b9935a", "storage locations"),
    CellKind.QUEUE: ("#7ba3d4", "queue cells"),
    CellKind.CHARGER: ("#5f9e6e", "chargers"),
    CellKind.MAINTENANCE: ("#c28a3d", "maintenance cells"),
    CellKind.STATION: ("#c0453a", "picking stations"),
}
"""Colour and legend of the cells in a picture."""
MOST_DRAWN = 250_000
"""Cells of the largest layout that is drawn."""


def html(layout: Layout) -> str | None:
    """Return the layout drawn to scale for a notebook; None for one that is too large."""
    if layout.width * layout.height > MOST_DRAWN:
        return None
    drawn: dict[int, str] = dict.fromkeys(DRAWN, "")
    for row, kinds in enumerate(layout.kind.reshape(layout.height, layout.width).tolist()):
        for kind, cells in groupby(range(layout.width), kinds.__getitem__):
            column, *more = cells
            if kind in drawn:
                drawn[kind] += f"M{column} {row}h{1 + len(more)}v1h-{1 + len(more)}z"
    legend = ", ".join(
        f'<span style="color:{colour}">■</span> {number:,} {name}'
        for kind, (colour, name) in DRAWN.items()
        if (number := int((layout.kind == kind).sum())) or kind not in (CellKind.CHARGER, CellKind.MAINTENANCE)
    )
    size = f'viewBox="0 0 {layout.width} {layout.height}" style="width:{8 * layout.width}px;max-width:100%"'
    paths = "".join(f'<path fill="{colour}" d="{drawn[kind]}"/>' for kind, (colour, _) in DRAWN.items())
    named = f'role="img" aria-label="Layout of {layout.width} x {layout.height} cells, north at the top"'
    return f"<div><svg {size} {named}>{paths}</svg><div>{layout.width} x {layout.height} cells: {legend}</div></div>"
