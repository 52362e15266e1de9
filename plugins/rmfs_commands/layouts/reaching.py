"""Whether all of a layout can be reached: the entry point ``reaching`` of the group ``rmfs.formats``."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from rmfs_core.errors import InputError
from rmfs_core.wording import shown_short
from rmfs_core.world.grid import STEPS, CellKind, Layout

SHOWN = 3
"""Cells that a message names at most."""


def check_layout(layout: Layout, place: str) -> None:
    """Raise `InputError` naming the cells when something cannot be reached.

    The aisles, which are the floor without the lanes that lead away from stations, must be strongly connected by
    themselves: then a robot with a pod, which may not cross storage locations, gets from everywhere to everywhere, and
    so does one without. Storage locations must be next to them; queues must be entered from them, and stations left
    to them.
    """
    if len(layout.stations) == layout.replenishing:
        raise InputError(place, "the layout has no picking station; expected at least one (`O` in a map)")
    if not layout.storage_locations:
        raise InputError(place, "the layout has no storage location; expected some (`#` in a map)")
    is_floor = layout.kind == CellKind.FLOOR
    floor = np.flatnonzero(is_floor)
    if not len(floor):
        raise InputError(place, "the layout has no floor; expected aisles (`.` in a map)")
    beside, storage = neighbours(layout.width, layout.height), layout.storage_locations
    to_floor = is_floor[beside]
    open_to_floor = {*np.flatnonzero(to_floor.any(axis=0)).tolist()}
    _refuse(layout, place, storage, open_to_floor, "have no floor next to them, so no pod gets in or out")
    start = int(beside[to_floor[:, storage[0]], storage[0]][0])
    steps: list[list[int]] = [[] for _ in layout.kind]
    backward: list[list[int]] = [[] for _ in layout.kind]
    for heading in range(4):
        leaving = np.flatnonzero(to_floor[heading] & (layout.moves >> heading & 1 == 1))
        for cell, following in zip(leaving.tolist(), beside[heading, leaving].tolist(), strict=True):
            steps[cell].append(following)
            backward[following].append(cell)
    aisles = reached([start], steps)
    exits = [following for cells in layout.stations for following in steps[cells.station]]
    home = layout.where(start)
    _refuse(layout, place, floor, aisles | reached(exits, steps), f"cannot be reached over the floor from {home}")
    _refuse(layout, place, floor, reached([start], backward), f"have no way over the floor to {home}")
    is_aisle = np.zeros(len(is_floor), dtype=bool)
    is_aisle[[*aisles]] = True
    served = {*np.flatnonzero(is_aisle[beside].any(axis=0)).tolist()}
    _refuse(layout, place, storage, served, f"cannot be reached with a pod from {home}")
    _refuse(layout, place, layout.chargers, served, f"are chargers that cannot be reached from {home}")
    _refuse(layout, place, layout.maintenance, served, f"are maintenance cells that cannot be reached from {home}")
    for cells in layout.stations:
        _check_station(layout, place, cells.station, cells.queue[-1], aisles)


def neighbours(width: int, height: int) -> NDArray[np.int64]:
    """Return the neighbour of each cell in each heading, the cell itself beyond the edge; shape (4, cells)."""
    cells = np.pad(np.arange(width * height).reshape(height, width), 1, mode="edge")
    return np.array([cells[1 + dy : 1 + dy + height, 1 + dx : 1 + dx + width].ravel() for dx, dy in STEPS])


def _check_station(layout: Layout, place: str, station: int, entry: int, aisles: set[int]) -> None:
    if not layout.moves[station]:
        raise InputError(f"{place}, {layout.where(station)}", "no floor next to the station to leave it")
    entered = any(
        beside in aisles and layout.may_step(beside, (heading + 2) % 4) for heading, beside in layout.beside(entry)
    )
    if not entered:
        raise InputError(f"{place}, {layout.where(entry)}", "no aisle leads into the end of this queue")


def reached(starts: Iterable[int], steps: Mapping[int, Sequence[int]] | Sequence[Sequence[int]]) -> set[int]:
    """Return where steps lead from some cells, these included; ``steps`` has the cells next to each."""
    found = set(starts)
    frontier = deque(found)
    while frontier:
        for beside in steps[frontier.popleft()]:
            if beside not in found:
                found.add(beside)
                frontier.append(beside)
    return found


def _refuse(layout: Layout, place: str, cells: Iterable[int], good: set[int], problem: str) -> None:
    bad = [int(cell) for cell in cells if cell not in good]
    if bad:
        named = "; ".join(layout.where(cell) for cell in bad[:SHOWN])
        more = f" and {len(bad) - SHOWN} more" if len(bad) > SHOWN else ""
        raise InputError(place, f"found cells that {problem}: {named}{more}")


def malformed(layout: Layout) -> Iterator[str]:
    """Yield what is not as `Layout` has it."""
    cells = layout.width * layout.height
    for name, array in (("kind", layout.kind), ("moves", layout.moves)):
        if not isinstance(array, np.ndarray) or array.dtype != np.int8 or array.shape != (cells,):
            yield f"`{name}` {shown_short(array)}; expected an array of int8, shape ({cells},)"
            return
    for number, station in enumerate(layout.stations, 1):
        if any(not 0 <= cell < cells for cell in (station.station, *station.queue)) or station.places < 1:
            expected = f"cells from 0 to {cells - 1}, and a queue of at least one"
            yield f"station {number} {shown_short(station)}; expected {expected}"
