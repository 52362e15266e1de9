"""Layouts as text maps."""

from __future__ import annotations

from rmfs_core.world import CellKind, Layout
from rmfs_core.world.textmap import FLOOR_SIGN, QUEUE_SIGN


def draw_map(layout: Layout) -> str:
    """Return the text map of a layout; `parse_map` reads it back to the same layout."""
    signs = [_sign(layout, cell) for cell in range(layout.width * layout.height)]
    rows = ("".join(signs[i : i + layout.width]).rstrip() for i in range(0, len(signs), layout.width))
    return "\n".join(rows) + "\n"


def _sign(layout: Layout, cell: int) -> str:
    match layout.kind[cell]:
        case CellKind.STORAGE:
            return "#"
        case CellKind.STATION:
            return "O"
        case CellKind.QUEUE:
            return QUEUE_SIGN[int(layout.moves[cell])]
        case CellKind.FLOOR:
            moves = 0
            for heading in range(4):
                beside = layout.neighbour(cell, heading)
                if layout.may_step(cell, heading) and beside is not None and layout.kind[beside] != CellKind.STORAGE:
                    moves |= 1 << heading
            return FLOOR_SIGN.get(moves, ".")
        case _:
            return "@"
