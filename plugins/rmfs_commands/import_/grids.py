"""Grids of path finding: RHCR's ``.map`` and ``.grid``, maps of the League of Robot Runners and of MovingAI."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

from attrs import frozen

from rmfs_commands.import_.notes import Notes
from rmfs_commands.layouts.textmap import FLOOR_SIGN
from rmfs_commands.plan.movingai import grid_rows, read_text
from rmfs_core.errors import InputError
from rmfs_core.scenario.model import MOST_CELLS
from rmfs_core.wording import counted, shown_short
from rmfs_core.world import check_size

KINDS = {
    "movingai": {".": ".", "G": ".", "S": ".", "@": "@", "O": "@", "T": "@", "W": "@"},
    "lorr": {".": ".", "E": "#", "S": "#", "@": "@", "T": "@"},
    "rhcr": {".": ".", "e": "#", "r": ".", "@": "@"},
}
"""Signs of each format, with their signs in a text map."""

COLUMNS = ("id", "type", "station", "x", "y", "weight_to_NORTH", "weight_to_WEST", "weight_to_SOUTH", "weight_to_EAST")
_BITS = (2, 4, 8, 1)
"""Of the headings of these weights."""
_SIZE = re.compile(r"\s*([0-9]{1,7})\s*,\s*([0-9]{1,7})\s*")
_SIGNS_OF_A_LINE = 10_000


@frozen
class Grid:
    """A text map.

    Parameters
    ----------
    text, width, height
        The map, and its size.
    starts, goals
        Cells (row * width + column) at which robots begin, and to which they are sent.
    ways
        Bits of the headings in which each cell may be left; empty where every free cell next to it may be entered.
    """

    text: str
    width: int
    height: int
    starts: tuple[int, ...] = ()
    goals: tuple[int, ...] = ()
    ways: tuple[int, ...] = ()


def read_octile(path: Path, kind: str, notes: Notes) -> Grid:
    """Read a map that begins with ``type octile``; what its signs become is said by `KINDS`."""
    signs = KINDS[kind]
    rows = grid_rows(read_text(path), path, "".join(signs))
    counts = Counter("".join(rows))
    if kind == "movingai":
        notes.add("swamp (S)", counts["S"], "floor")
        notes.add("trees and water (T, W)", counts["T"] + counts["W"], "walls")
        notes.add("type of the map, octile", 1, "robots step to the four adjacent cells")
    else:
        notes.add("emitter and service points (E, S)", counts["E"] + counts["S"], "storage locations")
    return _grid(rows, signs)


def read_kiva(path: Path, notes: Notes) -> Grid:
    """Read RHCR's ``.map``: rows and columns, three numbers of its simulation, and a sign for each cell."""
    lines = read_text(path).splitlines()
    height, width = _size(lines[0] if lines else "", f"{path}, line 1", "rows and columns such as `33,46`")
    first = 1
    while first < min(len(lines), 4) and lines[first].strip().isdecimal():
        first += 1
    rows = [line.rstrip("\r") for line in lines[first : first + height]]
    if len(rows) < height:
        raise InputError(
            str(path), f"found {counted(len(rows), 'row')} of the map; expected {height}, as its first line says"
        )
    for number, row in enumerate(rows, first + 1):
        if len(row) != width:
            raise InputError(
                f"{path}, line {number}", f"found {counted(len(row), 'cell')}; expected {width}, as the first line says"
            )
        unknown = next((sign for sign in row if sign not in KINDS["rhcr"]), None)
        if unknown is not None:
            known = " ".join(KINDS["rhcr"])
            raise InputError(f"{path}, line {number}", f"unknown sign {unknown!r}; expected one of {known}")
    everything = "".join(rows)
    starts, goals = (tuple(i for i, sign in enumerate(everything) if sign == which) for which in "re")
    notes.add("endpoints (e)", len(goals), "storage locations")
    notes.add("homes (r)", len(starts), "floor, from where trips begin")
    notes.add("numbers of the simulation above the map", first - 1)
    grid = _grid(rows, KINDS["rhcr"])
    return Grid(grid.text, grid.width, grid.height, starts, goals)


def read_weighted(path: Path, notes: Notes) -> Grid:
    """Read RHCR's ``.grid``: a line for each cell, with the weights of the ways from it; y counts from the south."""
    lines = read_text(path).splitlines()
    if len(lines) < 3 or not lines[0].lower().startswith("grid size"):
        raise InputError(f"{path}, line 1", "expected the lines `Grid size (x, y)`, the size, and names of columns")
    width, height = _size(lines[1], f"{path}, line 2", "the size such as `77,37`")
    names = tuple(name.strip() for name in lines[2].split(","))
    if names[: len(COLUMNS)] != COLUMNS:
        raise InputError(f"{path}, line 3", f"expected the columns {','.join(COLUMNS)}, found {shown_short(lines[2])}")
    signs, left = ["@"] * (width * height), [0] * (width * height)
    kinds: dict[str, list[int]] = {}
    heavy = 0
    seen: set[int] = set()
    for number, line in enumerate(lines[3:], 4):
        if not line.strip():
            continue
        fields = [part.strip() for part in line.split(",")]
        place = f"{path}, line {number}"
        if len(fields) < len(COLUMNS):
            raise InputError(place, f"found {len(fields)} fields; expected {len(names)}, as in line 3")
        x, y = (_whole(text, place) for text in fields[3:5])
        if not (x < width and y < height) or (cell := (height - 1 - y) * width + x) in seen:
            raise InputError(place, f"found the cell x {x}, y {y}; expected each of {width} x {height} cells once")
        seen.add(cell)
        weights = [_weight(text, place) for text in fields[5:9]]
        if fields[1] != "Obstacle":
            left[cell] = sum(bit for bit, weight in zip(_BITS, weights, strict=True) if weight is not None)
            heavy += sum(weight not in (None, 1.0) for weight in weights)
            signs[cell] = FLOOR_SIGN.get(left[cell], "@")
            kinds.setdefault(fields[1], []).append(cell)
    if len(seen) < width * height:
        raise InputError(str(path), f"found {counted(len(seen), 'cell')}; expected {width * height:,}, as line 2 says")
    starts, goals = (kinds.get(name, []) for name in ("Induct", "Eject"))
    starts, goals = starts or kinds.get("Home", []), goals or kinds.get("Endpoint", [])
    notes.add("ways of a weight other than 1", heavy, "ways like all others")
    notes.add("inducts or homes", len(starts), "floor, from where trips begin")
    notes.add("ejects or endpoints", len(goals), "floor, where trips end")
    text = "".join("".join(signs[i : i + width]) + "\n" for i in range(0, len(signs), width))
    return Grid(text, width, height, tuple(sorted(starts)), tuple(sorted(goals)), tuple(left))


def _grid(rows: list[str], signs: dict[str, str]) -> Grid:
    table = str.maketrans(signs)
    return Grid("".join(row.translate(table) + "\n" for row in rows), len(rows[0]), len(rows))


def _size(text: str, place: str, expected: str) -> tuple[int, int]:
    match = _SIZE.fullmatch(text[:_SIGNS_OF_A_LINE])
    sizes = (int(match[1]), int(match[2])) if match else (0, 0)
    if not 1 <= sizes[0] * sizes[1] <= MOST_CELLS:
        raise InputError(place, f"expected {expected}, {MOST_CELLS:,} cells at most, found {shown_short(text)}")
    check_size(*sizes, place)
    return sizes


def _whole(text: str, place: str) -> int:
    if text.isascii() and text.isdecimal() and len(text) < 8:
        return int(text)
    raise InputError(place, f"expected a whole number, found {shown_short(text)}")


def _weight(text: str, place: str) -> float | None:
    """Return the weight of a way, None where there is none."""
    if text == "inf":
        return None
    if re.fullmatch(r"[0-9]{1,9}(\.[0-9]{0,12})?", text):
        return float(text)
    raise InputError(place, f"expected a weight such as 1, or inf where there is no passage, found {shown_short(text)}")
