"""Layouts as text maps."""

from __future__ import annotations

from rmfs_commands.layouts.textmap import CLEAR_SIGN, FLOOR_SIGN, QUEUE_SIGN
from rmfs_core.world import CellKind, Layout
from rmfs_core.world.grid import RESTING

REST_SIGN = {CellKind.STORAGE: "#", CellKind.CHARGER: "C", CellKind.MAINTENANCE: "M"}


def draw_map(layout: Layout) -> str:
    """Return the text map of a layout; `parse_map` reads it back to the same layout."""
    signs = [_sign(layout, cell) for cell in range(layout.width * layout.height)]
    rows = ("".join(signs[i : i + layout.width]).rstrip() for i in range(0, len(signs), layout.width))
    return "\n".join(rows) + "\n"


def _sign(layout: Layout, cell: int) -> str:
    match layout.kind[cell]:
        case CellKind.STORAGE | CellKind.CHARGER | CellKind.MAINTENANCE as kind:
            return REST_SIGN[kind]
        case CellKind.STATION:
            return "I" if layout.lane[cell] >= len(layout.stations) - layout.replenishing else "O"
        case CellKind.QUEUE:
            station = layout.stations[int(layout.lane[cell])]
            signs = CLEAR_SIGN if cell in station.queue[: station.clear] else QUEUE_SIGN
            return signs[int(layout.moves[cell])]
        case CellKind.FLOOR:
            moves = 0
            for heading in range(4):
                beside = layout.neighbour(cell, heading)
                if layout.may_step(cell, heading) and beside is not None and layout.kind[beside] not in RESTING:
                    moves |= 1 << heading
            return FLOOR_SIGN.get(moves, ".")
        case _:
            return "P" if cell in layout.packing else "@"
