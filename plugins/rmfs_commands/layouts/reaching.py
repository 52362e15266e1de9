"""Whether all of a layout can be reached: the entry point ``reaching`` of the group ``rmfs.formats``."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from rmfs_core.errors import InputError
from rmfs_core.world.grid import CellKind, Layout

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
    floor = np.flatnonzero(layout.kind == CellKind.FLOOR)
    if not len(floor):
        raise InputError(place, "the layout has no floor; expected aisles (`.` in a map)")
    storage = layout.storage_locations
    open_to_floor = {cell for cell in storage if _floor_beside(layout, cell)}
    _refuse(layout, place, storage, open_to_floor, "have no floor next to them, so no pod gets in or out")
    start = _floor_beside(layout, storage[0])[0]
    steps = {int(cell): _steps(layout, int(cell)) for cell in floor}
    backward: dict[int, list[int]] = {cell: [] for cell in steps}
    for cell, targets in steps.items():
        for beside in targets:
            backward[beside].append(cell)
    aisles = reached([start], steps)
    exits = [beside for cells in layout.stations for beside in _steps(layout, cells.station)]
    home = layout.where(start)
    _refuse(layout, place, floor, aisles | reached(exits, steps), f"cannot be reached over the floor from {home}")
    _refuse(layout, place, floor, reached([start], backward), f"have no way over the floor to {home}")
    served = {cell for cell in storage if aisles.intersection(_floor_beside(layout, cell))}
    _refuse(layout, place, storage, served, f"cannot be reached with a pod from {home}")
    served = {cell for cell in layout.chargers if aisles.intersection(_floor_beside(layout, cell))}
    _refuse(layout, place, layout.chargers, served, f"are chargers that cannot be reached from {home}")
    served = {cell for cell in layout.maintenance if aisles.intersection(_floor_beside(layout, cell))}
    _refuse(layout, place, layout.maintenance, served, f"are maintenance cells that cannot be reached from {home}")
    for cells in layout.stations:
        _check_station(layout, place, cells.station, cells.queue[-1], aisles)


def _check_station(layout: Layout, place: str, station: int, entry: int, aisles: set[int]) -> None:
    if not layout.moves[station]:
        raise InputError(f"{place}, {layout.where(station)}", "no floor next to the station to leave it")
    entered = any(
        beside in aisles and layout.may_step(beside, (heading + 2) % 4) for heading, beside in layout.beside(entry)
    )
    if not entered:
        raise InputError(f"{place}, {layout.where(entry)}", "no aisle leads into the end of this queue")


def _steps(layout: Layout, cell: int) -> list[int]:
    return [n for h, n in layout.beside(cell) if layout.may_step(cell, h) and layout.kind[n] == CellKind.FLOOR]


def _floor_beside(layout: Layout, cell: int) -> list[int]:
    return [n for _, n in layout.beside(cell) if layout.kind[n] == CellKind.FLOOR]


def reached(starts: Iterable[int], steps: Mapping[int, Sequence[int]]) -> set[int]:
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
    bad = [int(cell) for cell in cells if int(cell) not in good]
    if bad:
        named = "; ".join(layout.where(cell) for cell in bad[:SHOWN])
        more = f" and {len(bad) - SHOWN} more" if len(bad) > SHOWN else ""
        raise InputError(place, f"found cells that {problem}: {named}{more}")
