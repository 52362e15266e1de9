"""The benchmark formats of MovingAI: grid maps and scenarios.

Source: N. Sturtevant, Benchmarks for grid-based pathfinding, IEEE Transactions on Computational Intelligence and AI in
Games 4(2), 2012, https://doi.org/10.1109/TCIAIG.2012.2197681; https://movingai.com/benchmarks/formats.html
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from rmfs_commands.layouts import parse_map
from rmfs_core.errors import InputError
from rmfs_core.wording import counted, shown_short
from rmfs_core.world import EAST, NORTH, SOUTH, WEST, CellKind, Layout, check_size
from rmfs_core.world.grid import LONGEST_SIDE

FREE, BLOCKED = ".GS", "@OTW"
MOST_SIGNS = 100_000_000
"""Signs that are read of a file; a device may have no end."""


@frozen
class Trip:
    """From one cell to another (indices)."""

    start: int
    goal: int


def read_map(path: str | Path) -> Layout:
    """Read a map: MovingAI's where the file begins with ``type``, else one of `rmfs_commands.layouts.parse_map`.

    On MovingAI's maps robots step in the four directions between free cells (``.``, ``G``, ``S``).

    Raises
    ------
    InputError
        When the file cannot be read or is no such map.
    """
    text = read_text(path)
    if not text.lstrip().startswith("type"):
        return parse_map(text, str(path))
    rows = grid_rows(text, path, FREE + BLOCKED)
    return open_layout(np.array([[sign in FREE for sign in row] for row in rows], dtype=bool))


def grid_rows(text: str, path: str | Path, known: str) -> list[str]:
    """Return the rows of a map that begins with ``type``, all of the width that it says, of known signs alone."""
    lines = text.splitlines()
    header = dict(line.split(maxsplit=1) for line in lines[:3] if len(line.split()) == 2)
    height, width = (
        _number(header.get(key, ""), f"{path}", f"a line `{key} N`, N from 1 to {LONGEST_SIDE:,}", least=1)
        for key in ("height", "width")
    )
    check_size(width, height, str(path))
    if len(lines) < 4 or lines[3].strip() != "map":
        raise InputError(f"{path}, line 4", "expected the line `map` after type, height and width")
    rows = lines[4 : 4 + height]
    if len(rows) < height:
        raise InputError(
            str(path), f"found {counted(len(rows), 'row')} of the map; expected {height}, as its height says"
        )
    for number, row in enumerate(rows, 5):
        if len(row) != width:
            raise InputError(
                f"{path}, line {number}",
                f"found {counted(len(row), 'cell')}; expected {width}, the map's width",
            )
        unknown = next((sign for sign in row if sign not in known), None)
        if unknown is not None:
            raise InputError(f"{path}, line {number}", f"unknown sign {unknown!r}; expected one of {' '.join(known)}")
    return rows


def open_layout(free: NDArray[np.bool_]) -> Layout:
    """Return a layout of floor and walls, on which robots step in all four directions. ``free`` is (rows, columns)."""
    height, width = free.shape
    moves = np.zeros((height, width), dtype=np.int8)
    moves[:, :-1] |= (free[:, :-1] & free[:, 1:]).astype(np.int8) << EAST
    moves[:, 1:] |= (free[:, :-1] & free[:, 1:]).astype(np.int8) << WEST
    moves[1:] |= (free[:-1] & free[1:]).astype(np.int8) << NORTH
    moves[:-1] |= (free[:-1] & free[1:]).astype(np.int8) << SOUTH
    kind = np.where(free, CellKind.FLOOR, CellKind.WALL).astype(np.int8).ravel()
    for array in (kind, moves):
        array.setflags(write=False)
    return Layout(width, height, kind, moves.ravel(), ())


def read_trips(path: str | Path, layout: Layout, limit: int | None = None) -> tuple[Trip, ...]:
    """Read a scenario: the first ``limit`` trips of its file.

    Raises
    ------
    InputError
        When the file cannot be read, has fewer trips, or one between cells that the map does not have free.
    """
    lines = read_text(path).splitlines()
    if not lines or not lines[0].startswith("version"):
        raise InputError(f"{path}, line 1", "expected the line `version 1`, as in MovingAI's scenarios")
    trips: list[Trip] = []
    for number, line in enumerate(lines[1:], 2):
        if line.strip() and (limit is None or len(trips) < limit):
            trips.append(_trip(line.split("\t") if "\t" in line else line.split(), layout, f"{path}, line {number}"))
    if limit is not None and len(trips) < limit:
        raise InputError(
            str(path), f"found {counted(len(trips), 'trip')}; expected at least {limit}, one for each robot"
        )
    return tuple(trips)


def _trip(fields: list[str], layout: Layout, place: str) -> Trip:
    if len(fields) < 8:
        expected = "expected bucket, map, width, height, start x, start y, goal x, goal y and optimal length"
        raise InputError(place, f"found {counted(len(fields), 'field')}; {expected}")
    numbers = [_number(text, place, f"a whole number from 0 to {LONGEST_SIDE:,}") for text in fields[2:8]]
    width, height = numbers[:2]
    if (width, height) != (layout.width, layout.height):
        raise InputError(place, f"found a map of {width} x {height} cells; the map given has "
                                f"{layout.width} x {layout.height}")  # fmt: skip
    cells = []
    for x, y in (numbers[2:4], numbers[4:6]):
        if not (0 <= x < layout.width and 0 <= y < layout.height):
            raise InputError(place, f"found the cell x {x}, y {y}, which is not on the map")
        cell = y * layout.width + x
        if layout.kind[cell] == CellKind.WALL:
            raise InputError(place, f"found the cell x {x}, y {y}, which is a wall")
        cells.append(cell)
    return Trip(*cells)


def _number(text: str, place: str, expected: str, least: int = 0) -> int:
    text = text.strip()
    if not re.fullmatch("[0-9]{1,9}", text) or not least <= int(text) <= LONGEST_SIDE:
        raise InputError(place, f"expected {expected}, found {shown_short(text)}")
    return int(text)


def read_text(path: str | Path) -> str:
    """Return a file's text; raise `InputError` when it cannot be read."""
    try:
        with Path(path).open(encoding="utf-8-sig") as stream:
            text = stream.read(MOST_SIGNS + 1)
    except UnicodeDecodeError as error:
        raise InputError(str(path), "cannot be read: it is no UTF-8 text") from error
    except (OSError, ValueError) as error:  # ValueError: of a name that no file can have
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(str(path), f"cannot be read: {reason}") from error
    if len(text) > MOST_SIGNS:
        raise InputError(str(path), f"found more than {MOST_SIGNS:,} signs; expected at most that many")
    return text
