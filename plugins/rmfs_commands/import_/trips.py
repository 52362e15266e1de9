"""Instances of path finding: a text map, and a trip for each robot, as `rmfs plan` takes them."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from attrs import frozen
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from rmfs_commands.import_.grids import Grid, read_kiva, read_octile, read_weighted
from rmfs_commands.import_.notes import Imported, Notes
from rmfs_commands.layouts import parse_map
from rmfs_commands.plan.movingai import Trip, read_text, read_trips
from rmfs_core.errors import InputError
from rmfs_core.randomness import stream
from rmfs_core.wording import counted, shown_short
from rmfs_core.world import STEPS, CellKind, Layout

MOST_AGENTS, MOST_SHOWN, DEFAULT_AGENTS = 100_000, 100, 10
"""Robots of a problem; robots in the command that is shown; robots of `rmfs plan` unless told."""


@frozen
class _Problem:
    """A problem of the League of Robot Runners: starts, and the cells of each task one after another."""

    starts: list[int]
    tasks: list[list[int]]


class _Trips:
    """Trips that are taken one by one, if no other has the same start or goal and there is a way."""

    def __init__(self, layout: Layout) -> None:
        self.part = _parts(layout)
        self.starts: set[int] = set()
        self.goals: set[int] = set()
        self.taken: list[Trip] = []
        self.doubled = self.cut_off = 0

    def add(self, start: int, goal: int) -> bool:
        """Take a trip; return whether it was taken."""
        if start in self.starts or goal in self.goals:
            self.doubled += 1
        elif self.part[start] != self.part[goal]:
            self.cut_off += 1
        else:
            self.starts.add(start)
            self.goals.add(goal)
            self.taken.append(Trip(start, goal))
            return True
        return False


def import_movingai(map_file: Path, scen: Path | None) -> Imported:
    """Read a map of MovingAI, and the trips of a scenario."""
    notes = Notes()
    grid = read_octile(map_file, "movingai", notes)
    layout = parse_map(grid.text, str(map_file))
    trips = _Trips(layout)
    if scen is not None:
        given = read_trips(scen, layout)
        for trip in given:
            trips.add(trip.start, trip.goal)
        notes.add("trips whose start or goal another has", trips.doubled)
        notes.add("trips without a way in four directions", trips.cut_off)
        notes.add("optimal lengths of trips", len(trips.taken), "0")
    return _imported("MovingAI", map_file, grid, layout, trips, notes)


def import_rhcr(file: Path, seed: int) -> Imported:
    """Read a map of RHCR; each of its robots goes from its start to a goal that is drawn."""
    notes = Notes()
    weighted = read_text(file).lower().startswith("grid size")
    grid = read_weighted(file, notes) if weighted else read_kiva(file, notes)
    layout = parse_map(grid.text, str(file))
    lost = [(cell, ways & ~int(layout.moves[cell])) for cell, ways in enumerate(grid.ways)]
    beside = [layout.neighbour(cell, heading) for cell, ways in lost for heading in range(4) if ways >> heading & 1]
    free = sum(cell is not None and layout.kind[cell] != CellKind.WALL for cell in beside)
    notes.add("ways that a text map cannot say", int(free))
    trips = _Trips(layout)
    rng = stream(seed, "imported trips")
    goals = [int(cell) for cell in rng.permutation(np.array(grid.goals, dtype=np.int64))]
    for start in map(int, rng.permutation(np.array(grid.starts, dtype=np.int64))):
        goal = next((goal for goal in reversed(goals) if goal != start and trips.part[goal] == trips.part[start]), None)
        if goal is not None and trips.add(start, goal):
            goals.remove(goal)
    return _imported("RHCR", file, grid, layout, trips, notes)


def import_lorr(file: Path) -> Imported:
    """Read a map of the League of Robot Runners, or a problem, which names a map, robots and tasks.

    A robot goes to the first location of a task that no other robot goes to; robots take the tasks in the order of the
    files.
    """
    notes = Notes()
    if read_text(file).lstrip()[:1] != "{":
        grid = read_octile(file, "lorr", notes)
        layout = parse_map(grid.text, str(file))
        return _imported("League of Robot Runners", file, grid, layout, _Trips(layout), notes)
    map_file, problem = _read_problem(file, notes)
    grid = read_octile(map_file, "lorr", notes)
    layout = parse_map(grid.text, str(map_file))
    for number, cell in enumerate([*problem.starts, *(cell for task in problem.tasks for cell in task)]):
        if not (cell < len(layout.kind) and layout.kind[cell] != CellKind.WALL):
            what = f"robot {number + 1} begins" if number < len(problem.starts) else "a task is"
            raise InputError(str(file), f"{what} at location {cell}, which is no free cell of {map_file}")
    first: dict[int, int] = {}
    for robot, cell in enumerate(problem.starts, 1):
        if (other := first.setdefault(cell, robot)) != robot:
            found = f"found robots {other} and {robot} both at location {cell}"
            raise InputError(str(file), f"{found}; expected a location of its own for each robot")
    trips = _Trips(layout)
    waiting = list(reversed(problem.tasks))
    further = passed = later = 0
    for start in problem.starts:
        while waiting and start not in trips.starts:
            task = waiting.pop()
            taken = next((place for place, cell in enumerate(task) if trips.add(start, cell)), None)
            if taken is None:
                passed += 1
            else:
                further, later = further + len(task) - 1, later + (taken > 0)
    notes.add("tasks whose first location another robot goes to", later, "trips to the first that is left")
    notes.add("tasks without a location that is left and in reach", passed)
    notes.add("tasks beyond the first of each robot", len(waiting))
    notes.add("further locations of tasks", further)
    notes.add("robots without a task", len(problem.starts) - len(trips.taken))
    return _imported("League of Robot Runners", map_file, grid, layout, trips, notes)


def _read_problem(file: Path, notes: Notes) -> tuple[Path, _Problem]:
    try:
        told = json.loads(read_text(file))
    except (ValueError, RecursionError) as error:
        line = f", line {error.lineno}" if isinstance(error, json.JSONDecodeError) else ""
        raise InputError(f"{file}{line}", "this is no valid JSON") from None
    if not isinstance(told, dict):
        raise InputError(str(file), f"expected a table with mapFile, agentFile and taskFile, found {shown_short(told)}")
    named = [told.get(key) for key in ("mapFile", "agentFile", "taskFile")]
    for key, name in zip(("mapFile", "agentFile", "taskFile"), named, strict=True):
        if not isinstance(name, str) or not name:
            raise InputError(f"{file}, {key}", f"expected the name of a file, found {shown_short(name)}")
        if Path(name).anchor or ".." in Path(name).parts:  # somebody else's files shall not name the reader's own
            raise InputError(f"{file}, {key}", f"expected a file in the problem's folder, found {shown_short(name)}")
    size = told.get("teamSize")
    if type(size) is not int or not 1 <= size <= MOST_AGENTS:
        problem = f"expected a whole number from 1 to {MOST_AGENTS:,}, found {shown_short(size)}"
        raise InputError(f"{file}, teamSize", problem)
    map_file, agents, tasks = (file.parent / str(name) for name in named)
    starts = [line[0] for line in _locations(agents, size)]
    others = told.keys() - {"mapFile", "agentFile", "taskFile", "teamSize", "version"}
    notes.add("other keys of the problem (delays, counters, tasks shown at a time)", len(others))
    return map_file, _Problem(starts, _locations(tasks, None))


def _locations(file: Path, number: int | None) -> list[list[int]]:
    """Return the lines of locations of a file: as many as asked for, or else all that its first line counts."""
    lines = [(i, line) for i, line in enumerate(read_text(file).splitlines(), 1) if line.strip() and line[0] != "#"]
    read = [[_location(text, f"{file}, line {i}") for text in line.split(",") if text.strip()] for i, line in lines]
    if not read or len(read[0]) != 1:
        raise InputError(str(file), "expected the number of entries in the first line, then one line for each")
    wanted = read[0][0] if number is None else number
    if min(wanted, read[0][0], len(read) - 1) < wanted:
        found = min(read[0][0], len(read) - 1)
        raise InputError(str(file), f"found {counted(found, 'line')} of locations; expected {wanted:,}")
    empty = next((i for (i, _), line in zip(lines, read, strict=True) if not line), None)
    if empty is not None:
        raise InputError(f"{file}, line {empty}", "expected at least one location, found none")
    return read[1 : 1 + wanted]


def _location(text: str, place: str) -> int:
    text = text.strip()
    if text.isascii() and text.isdecimal() and len(text) < 9:
        return int(text)
    raise InputError(place, f"expected the number of a cell, found {shown_short(text)}")


def _parts(layout: Layout) -> Sequence[int]:
    """Return for each cell which part of the map it belongs to: each cell of a part can be reached from all others."""
    size = layout.width * layout.height
    moves, cells = layout.moves.astype(np.int32), np.arange(size, dtype=np.int32)
    pairs = [(cells[moves >> heading & 1 == 1], x + y * layout.width) for heading, (x, y) in enumerate(STEPS)]
    rows = np.concatenate([found for found, _ in pairs])
    columns = np.concatenate([found + step for found, step in pairs])
    matrix = csr_array((np.ones(len(rows), dtype=np.int8), (rows, columns)), shape=(size, size))
    labels: list[int] = connected_components(matrix, directed=True, connection="strong")[1].tolist()
    return labels


def _imported(kind: str, file: Path, grid: Grid, layout: Layout, trips: _Trips, notes: Notes) -> Imported:
    free = np.flatnonzero(layout.kind != CellKind.WALL).tolist()
    if not free:
        raise InputError(str(file), "found no free cell; expected some")
    room = sum(number // 2 for number in Counter(trips.part[cell] for cell in free).values())
    files = {"map.txt": grid.text}
    read = {"cells": grid.width * grid.height, "free cells": len(free)}
    command = "plan {}/map.txt"
    if trips.taken:
        files["trips.scen"] = "".join(_lines(trips.taken, grid))
        read["trips"] = len(trips.taken)
        command += f" --scen {{}}/trips.scen --agents {min(len(trips.taken), MOST_SHOWN)}"
    elif room < DEFAULT_AGENTS:
        command += f" --agents {max(room, 1)}"
    return Imported(kind, read, files, command, notes)


def _lines(trips: Iterable[Trip], grid: Grid) -> Iterable[str]:
    """Yield the lines of a scenario of MovingAI; how long the shortest ways are is left open."""
    yield "version 1\n"
    for trip in trips:
        (y, x), (to_y, to_x) = divmod(trip.start, grid.width), divmod(trip.goal, grid.width)
        yield "\t".join(map(str, (0, "map.txt", grid.width, grid.height, x, y, to_x, to_y, 0))) + "\n"
