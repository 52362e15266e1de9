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
            moves = _ways(layout, cell)
            return FLOOR_SIGN.get(moves | _idle_arm(layout, cell, moves), ".")
        case _:
            return "P" if cell in layout.packing else "@"


def _ways(layout: Layout, cell: int) -> int:
    """Return the bits of the headings in which a floor cell may be left to floor and queues."""
    moves = 0
    for heading in range(4):
        beside = layout.neighbour(cell, heading)
        if layout.may_step(cell, heading) and beside is not None and layout.kind[beside] not in RESTING:
            moves |= 1 << heading
    return moves


def _idle_arm(layout: Layout, cell: int, moves: int) -> int:
    """Return the bit of an arm that leads nowhere where the only way out of a cell is the way in, too; else 0.

    Nobody may come against the sign of a one-way cell; one more arm keeps the way in open.
    """
    way = moves.bit_length() - 1
    beside = layout.neighbour(cell, way) if moves in (1, 2, 4, 8) else None
    if beside is None or not layout.may_step(beside, (way + 2) % 4):
        return 0
    return next((1 << heading for heading in range(4) if heading != way and _closed(layout, cell, heading)), 0)


def _closed(layout: Layout, cell: int, heading: int) -> bool:
    """Whether an arm of a floor cell would open no way: to a wall, a station, or a one-way cell that leads here."""
    beside = layout.neighbour(cell, heading)
    if beside is None or layout.kind[beside] not in (CellKind.FLOOR, CellKind.QUEUE):
        return True
    return layout.kind[beside] == CellKind.FLOOR and _ways(layout, beside) == 1 << (heading + 2) % 4
