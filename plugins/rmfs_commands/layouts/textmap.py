"""Layouts as text maps, one character a cell (1 m x 1 m), north at the top.

=========  ====================================================================================================
``#``      storage location
``C``      charger
``M``      maintenance cell: where robots are repaired that fail, or are maintained
``.``      floor; robots may leave it in every direction
``> < ^ v``  one-way floor: robots leave it in that direction only
``└ ┘ ┌ ┐``  crossing of one-way aisles: the two directions that the sign's arms point to
``─ │ ├ ┤ ┬ ┴``  floor that may be left in the directions of its arms
``O``      picking station
``I``      replenishment station
``P``      packing station, next to floor; robots do not enter it
``q``      queue cell; the queue of a station is the chain of them that ends next to it
``→ ← ↑ ↓``  queue cell with its direction, for queues that are folded
``⇒ ⇐ ⇑ ⇓``    the same, next to the station, where nobody waits: the next pod rolls in from the cell behind
``╚ ╝ ╔ ╗ ═ ║``  queue cell with two ways on, where its arms point: to the next cell, and past some to one farther ahead
``@``, blank  wall
=========  ====================================================================================================

Storage locations, chargers and maintenance cells can be entered from and left to every cell next to them. A queue is
entered at its far end, from the floor, and wherever an arm of a floor cell points at it; it is left through its
station. Its cells are one chain, and every way between them leads ahead: a robot on its way to its position passes
cells behind that position only.
"""

from __future__ import annotations

import numpy as np

from rmfs_core.errors import InputError
from rmfs_core.scenario import LayoutSection
from rmfs_core.world.grid import EAST, NORTH, RESTING, SOUTH, WEST, CellKind, Layout, StationCells, check_size, where

_E, _N, _W, _S = 1 << EAST, 1 << NORTH, 1 << WEST, 1 << SOUTH
FLOOR_MOVES = {
    ">": _E,
    "^": _N,
    "<": _W,
    "v": _S,
    "└": _N | _E,
    "┘": _N | _W,
    "┌": _S | _E,
    "┐": _S | _W,
    "─": _E | _W,
    "│": _N | _S,
    "├": _N | _S | _E,
    "┤": _N | _S | _W,
    "┬": _E | _W | _S,
    "┴": _E | _W | _N,
    ".": _E | _N | _W | _S,
}
FLOOR_SIGN = {moves: sign for sign, moves in FLOOR_MOVES.items()}
QUEUE_MOVES = {"→": _E, "↑": _N, "←": _W, "↓": _S}
QUEUE_MOVES |= {"╚": _N | _E, "╝": _N | _W, "╔": _S | _E, "╗": _S | _W, "═": _E | _W, "║": _N | _S}
QUEUE_SIGN = {moves: sign for sign, moves in QUEUE_MOVES.items()}
CLEAR_MOVES = {"⇒": _E, "⇑": _N, "⇐": _W, "⇓": _S}
CLEAR_SIGN = {moves: sign for sign, moves in CLEAR_MOVES.items()}
QUEUE_MOVES |= CLEAR_MOVES
KINDS = {"#": CellKind.STORAGE, "C": CellKind.CHARGER, "M": CellKind.MAINTENANCE} | dict.fromkeys(" @P", CellKind.WALL)
KINDS |= dict.fromkeys("OI", CellKind.STATION) | dict.fromkeys(FLOOR_MOVES, CellKind.FLOOR)
KINDS |= dict.fromkeys(("q", *QUEUE_MOVES), CellKind.QUEUE)


def text_map(_section: LayoutSection, text: str | None, _queue_length: int | None, place: str) -> Layout:
    """Read the text map, as `rmfs_core.world.make_layout` asks for it."""
    if text is None:
        raise InputError("layout.map_file", "expected the text map that the layout generator `text-map` reads")
    return parse_map(text, place)


def parse_map(text: str, place: str) -> Layout:
    """Read a text map.

    Parameters
    ----------
    text
        The map.
    place
        Its name in errors, such as the file's name.

    Raises
    ------
    InputError
        At an unknown character, a queue that is no chain to its station, or a map that is too large.
    """
    rows = [row.rstrip() for row in text.expandtabs().rstrip().splitlines()]
    while rows and not rows[0]:
        rows.pop(0)
    if not rows:
        raise InputError(place, "the map is empty; expected rows of characters such as `#` and `.`")
    return _MapReader(rows, place).layout()


class _MapReader:
    def __init__(self, rows: list[str], place: str) -> None:
        self.place = place
        self.width, self.height = max(map(len, rows)), len(rows)
        check_size(self.width, self.height, place)
        self.signs = "".join(row.ljust(self.width) for row in rows)

    def _wrong(self, cell: int, problem: str) -> InputError:
        return InputError(f"{self.place}, {where(cell, self.width)}", problem)

    def layout(self) -> Layout:
        self.kinds = [self._kind(cell, sign) for cell, sign in enumerate(self.signs)]  # looked up more quickly
        kind = np.array(self.kinds, dtype=np.int8)
        moves = np.zeros(len(kind), dtype=np.int8)
        layout = Layout(self.width, self.height, kind, moves, ())
        cells = sorted(np.flatnonzero(kind == CellKind.STATION).tolist(), key=lambda cell: self.signs[cell] == "I")
        stations = tuple(self._station(layout, cell) for cell in cells)
        self._check_queues_used(layout, stations)
        entries = {own.queue[-1] for own in stations}
        for cell in range(len(kind)):
            moves[cell] = self._moves(layout, cell, entries)
        for own in stations:
            for cell, following in zip(own.queue, (own.station, *own.queue), strict=False):
                ahead = (1 << heading for heading, beside in layout.beside(cell) if beside == following)
                moves[cell] = QUEUE_MOVES.get(self.signs[cell]) or next(ahead)
        moves.setflags(write=False)
        kind.setflags(write=False)
        packing = tuple(cell for cell, sign in enumerate(self.signs) if sign == "P")
        for cell in packing:
            if not any(self.kinds[beside] == CellKind.FLOOR for _, beside in layout.beside(cell)):
                raise self._wrong(cell, "the packing station has no floor next to it; expected some, such as `.`")
        return Layout(self.width, self.height, kind, moves, stations, self.signs.count("I"), packing)

    def _kind(self, cell: int, sign: str) -> CellKind:
        if sign not in KINDS:
            known = "# O I q C M P " + " ".join((*FLOOR_MOVES, *QUEUE_MOVES)) + " @ and blank"
            raise self._wrong(cell, f"unknown sign {sign!r}; expected one of {known}")
        return KINDS[sign]

    def _station(self, layout: Layout, station: int) -> StationCells:
        queue: list[int] = []
        at, ahead = station, {station}
        while True:
            queued = [n for _, n in layout.beside(at) if self.kinds[n] == CellKind.QUEUE and n not in ahead]
            feeding = [cell for cell in queued if self._feeds(layout, cell, at, ahead)]
            if len(feeding) > 1:
                cells = " and ".join(where(cell, self.width) for cell in feeding)
                raise self._wrong(at, f"the queue branches to {cells}; give the direction of its cells with → ← ↑ ↓")
            if not feeding:
                break
            at = feeding[0]
            queue.append(at)
            ahead.add(at)
        clear = [cell for cell in queue if self.signs[cell] in CLEAR_MOVES]
        if clear and (clear != queue[: len(clear)] or clear == queue):
            wrong = next((a for a, b in zip(clear, queue, strict=False) if a != b), station)
            expected = "expected such cells between the station and the cells where robots wait"
            raise self._wrong(wrong, f"found a queue cell where nobody waits (⇒ ⇐ ⇑ ⇓) out of place; {expected}")
        return StationCells(station, tuple(queue), len(clear))

    def _feeds(self, layout: Layout, cell: int, following: int, ahead: set[int]) -> bool:
        """Whether a queue cell has a way to the one that follows, and none to a cell that does not lie ahead."""
        ways = self._ways(layout, cell)
        return self.signs[cell] == "q" or (following in ways and ahead.issuperset(ways))

    def _ways(self, layout: Layout, cell: int) -> list[int | None]:
        """Cells that the arms of a queue cell point to, None beyond the edge."""
        moves = QUEUE_MOVES.get(self.signs[cell], 0)
        return [layout.neighbour(cell, heading) for heading in range(4) if moves >> heading & 1]

    def _check_queues_used(self, layout: Layout, stations: tuple[StationCells, ...]) -> None:
        used: set[int] = set()
        for cells in stations:
            for cell in cells.queue:
                if cell in used:
                    raise self._wrong(cell, "the queue cell belongs to two stations")
                used.add(cell)
        unused = [cell for cell in map(int, np.flatnonzero(layout.kind == CellKind.QUEUE)) if cell not in used]
        for cell in unused:
            if len(ways := self._ways(layout, cell)) > 1:
                to = " and ".join("beyond the map" if way is None else where(way, self.width) for way in ways)
                expected = "expected two cells of one queue, both nearer to its station"
                raise self._wrong(cell, f"the queue cell leads to {to}; {expected}")
        for cells in stations:
            if not cells.queue:
                problem = "the station has no queue; expected at least one queue cell (`q`) next to it"
                raise self._wrong(cells.station, problem)
        if unused:
            raise self._wrong(unused[0], "the queue cell leads to no station")

    def _moves(self, layout: Layout, cell: int, entries: set[int]) -> int:
        moves, kind = 0, self.kinds[cell]
        for heading, beside in layout.beside(cell):
            if not self._may_enter(cell, heading, beside, entries):
                continue
            asked = FLOOR_MOVES.get(self.signs[cell], _E | _N | _W | _S) >> heading & 1
            if asked or (kind == CellKind.FLOOR and self.kinds[beside] in RESTING):
                moves |= 1 << heading
        return moves if kind in (CellKind.FLOOR, *RESTING, CellKind.STATION) else 0

    def _may_enter(self, cell: int, heading: int, beside: int, entries: set[int]) -> bool:
        kind, target = self.kinds[cell], self.kinds[beside]
        if target == CellKind.FLOOR:
            # Never against a one-way cell.
            return FLOOR_MOVES[self.signs[beside]] != 1 << (heading + 2) % 4
        if target in RESTING:
            return bool(kind != CellKind.STATION)
        drawn = beside in entries or self.signs[cell] != "."
        return bool(target == CellKind.QUEUE and kind == CellKind.FLOOR and drawn)
