"""Exact driving times and fastest paths on the grid, other robots ignored.

Robots drive straight runs between stops and turn only at a standstill, so the state of the search is (cell, heading) at
rest, and its moves are turns and whole runs. Tables are computed on demand, one Dijkstra search each, and kept.

Who may pass what: a robot without a pod drives over the floor and under stored pods. A robot with a pod drives over
the floor only; storage cells are its start and its goal, never on its way. Queue cells are entered only on the way to a
cell of the same queue, and a station is never driven through.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Sequence
from copy import copy
from functools import cached_property, lru_cache
from threading import Lock
from time import perf_counter
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from rmfs_core import clock
from rmfs_core.decisions import Leg, Rows
from rmfs_core.motion import Motion
from rmfs_core.world.grid import RESTING, STEPS, CellKind, Layout

if TYPE_CHECKING:
    from rmfs_core.world.travel_search import Work

SPARE_TICKS = 3_000
"""How much longer than the fastest way those are that `Travel.times_near` has the times of, if not asked for more."""
TABLES_BYTES = 640 << 20
"""Memory that the tables of one layout may take, besides those of stations; the least recently used go first."""
TO, WAYS_TO = -1, -2
"""Instead of the heading in a cell that a table is from: tables to it, as rules and as searches of paths read them."""

ROWS_BYTES = 64 << 20
"""Memory for tables to cells of queues that is got at a time, except for one of them."""

Table: TypeAlias = NDArray[np.int32] | NDArray[np.int64]
Made = TypeVar("Made")


def travel_on(layout: Layout, motion: Motion) -> Travel:
    """Return the travel times of a layout and kind of robot for one run; the tables are those of all runs."""
    return shared_travel(layout, motion).for_a_run()


@lru_cache(maxsize=8)
def shared_travel(layout: Layout, motion: Motion) -> Travel:
    """Return the travel times whose tables the runs of this process share."""
    return Travel(layout, motion)


class _Tables:
    """Tables that were searched for, which runs share, also those of several threads.

    Those of stations, which every trip needs, stay; of the others the least recently used go first.
    """

    def __init__(self) -> None:
        self._lock = Lock()
        self._of_stations: dict[tuple[int, int, bool], Table] = {}
        self._others: OrderedDict[tuple[int, int, bool], Table] = OrderedDict()
        self._bytes = 0

    def get(self, key: tuple[int, int, bool]) -> Table | None:
        """Return a table, which is now the most recently used one; None if it is not there."""
        if (table := self._of_stations.get(key)) is not None:
            return table
        with self._lock:
            if (table := self._others.get(key)) is not None:
                self._others.move_to_end(key)
        return table

    def keep(self, key: tuple[int, int, bool], table: Table, *, of_station: bool) -> None:
        """Add a table that no run changes any more."""
        table.setflags(write=False)
        with self._lock:
            if of_station:
                self._of_stations[key] = table
            elif key not in self._others:
                self._others[key] = table
                self._bytes += table.nbytes
            while self._bytes > TABLES_BYTES and len(self._others) > 1:
                self._bytes -= self._others.popitem(last=False)[1].nbytes


class Travel:
    """Travel times of one layout and one kind of robot, for one run: searches write on arrays of its own.

    Parameters
    ----------
    layout
        The grid.
    motion
        Kinematics of the robots.

    Attributes
    ----------
    runs
        Ticks of a run by its number of cells, from rest to rest. Shape (longest run + 1,).
    turns
        Ticks of a turn by the difference of headings. Shape (4,).
    offsets
        Step in cell index per heading. Shape (4,).
    """

    def __init__(self, layout: Layout, motion: Motion) -> None:
        self._layout = layout
        self._motion = motion
        longest = max(layout.width, layout.height)
        self.runs = np.array([motion.run_ticks(cells) for cells in range(longest + 1)], dtype=np.int64)
        self.turns = np.array([motion.turn_ticks(0, heading) for heading in range(4)], dtype=np.int64)
        self.offsets = np.array([column + row * layout.width for column, row in STEPS], dtype=np.int64)
        self._lane, self._lanes = layout.lane, layout.lane.tolist()
        self._floor: NDArray[np.bool_] = layout.kind == CellKind.FLOOR
        self._queue = layout.kind == CellKind.QUEUE
        self._under: NDArray[np.bool_] = self._floor | np.isin(layout.kind, RESTING)
        self._moves, self._steps = layout.moves.astype(np.uint8).tobytes(), self.offsets.tolist()
        self._bytes_of: dict[tuple[int, bool], bytes] = {}
        self._passable: dict[tuple[int, bool], NDArray[np.bool_]] = {}
        for array in (self.runs, self.turns, self.offsets, self._floor, self._under):
            array.setflags(write=False)
        self._tables = _Tables()
        self._made: dict[object, object] = {}
        self.seconds = 0.0
        """Wall-clock seconds that tables have taken so far."""

    def for_a_run(self) -> Travel:
        """Return the same travel times for another run, which may be in another thread."""
        other = copy(self)
        for name in ("_work", "_times", "_near", "_near_table", "_rows"):
            vars(other).pop(name, None)
        other._made = {}
        other.seconds = 0.0
        return other

    def once(self, make: Callable[[Travel], Made]) -> Made:
        """Return what a function makes of these travel times; the same object whenever it is asked for."""
        if make not in self._made:
            self._made[make] = make(self)
        return cast(Made, self._made[make])

    @property
    def layout(self) -> Layout:
        """The grid."""
        return self._layout

    @property
    def motion(self) -> Motion:
        """Kinematics of the robots."""
        return self._motion

    @cached_property
    def _search(self) -> Any:
        """The compiled searches: imported when needed, for that takes its time."""
        from rmfs_core.world import travel_search

        return travel_search

    @cached_property
    def _work(self) -> Work:
        """Memory that the searches write on."""
        size = self._layout.height, self._layout.width
        return self._search.work_on(*size, self.runs, self.turns)  # type: ignore[no-any-return]

    @cached_property
    def _times(self) -> Table:
        """Memory for times that are not kept."""
        return self._room(1)[0]  # type: ignore[no-any-return]

    @cached_property
    def _near(self) -> Table:
        """Memory that `times_near` writes on."""
        return self._room(1)[0]  # type: ignore[no-any-return]

    @cached_property
    def _near_table(self) -> Table:
        """The same as others may read it."""
        table = self._near.reshape(-1, 4)
        table.setflags(write=False)
        return table

    @cached_property
    def _rows(self) -> list[Table]:
        """Memory for tables to cells of queues: that of many takes less time to get than piece by piece."""
        return list(self._room(min(64, 1 + ROWS_BYTES // self._times.nbytes)))

    def _room(self, tables: int) -> Any:
        """Return memory for so many tables of ticks by (cell, heading)."""
        return np.empty((tables, 4 * len(self._lane)), self._search.times_on(len(self._lane), self.runs, self.turns))

    def load_searches(self) -> None:
        """Load the compiled searches now (or compile them), not within the first decision that needs them."""
        station = self.layout.stations[0].station
        self.times_near(station, 0, self.layout.storage_locations[0], loaded=True)
        self.times_from(station, 0, loaded=True)
        self.times_to(station, loaded=True)
        self.fastest_path(station, 0, self.layout.storage_locations[0], loaded=True)

    def times_to(self, goal: int, loaded: bool) -> NDArray[np.int64]:
        """Ticks from standing in each cell with each heading to rest at ``goal``. Shape (cells, 4), read-only.

        `UNREACHABLE` where there is no way.
        """
        return self._table((goal, TO, loaded))  # type: ignore[no-any-return]

    def ways_to(self, goal: int, loaded: bool) -> Table:
        """As `times_to`, as searches for paths read it: in four bytes each where these hold the ticks of all ways.

        Where there is no way, as many ticks as `far` says of the table, or more.
        """
        return self._table((goal, WAYS_TO, loaded))  # type: ignore[no-any-return]

    def times_near(
        self, cell: int, heading: int, goal: int, loaded: bool, spare_ticks: int = SPARE_TICKS
    ) -> tuple[Table, int]:
        """As `ways_to`, for whom few of its times are enough, and up to how many ticks it has them.

        They are those along all ways from standing in ``cell`` with ``heading`` that take no more than the ticks
        returned, as many as the fastest and ``spare_ticks``; `UNREACHABLE` if all are right. Any other time is too low,
        but with the way there no less than these ticks. Valid until the next call of this or of `nearest`.
        """
        known = self._tables.get((goal, WAYS_TO, loaded))
        if known is not None or self._lanes[goal] >= 0:
            return self.ways_to(goal, loaded) if known is None else known, clock.UNREACHABLE
        started, start, table = perf_counter(), 4 * cell + heading, self._near
        within = self._search.times_near(goal, table, start, spare_ticks, *self._grid(goal, loaded), self._work)
        self.seconds += perf_counter() - started
        return self._near_table, within

    def nearest(self, stops: Sequence[tuple[int, int]], goal: int, loaded: bool) -> int:
        """Index of the stop (cell, heading), of one or more, that is the fewest ticks from ``goal``: the first such."""
        width, work, (cells, headings) = self._layout.width, self._work, np.array(stops).T
        rows, columns = goal // width - cells // width, goal % width - cells % width
        least = work.least[np.sign(rows) + 1, np.sign(columns) + 1, headings].min(axis=1)
        for cells in (abs(rows), abs(columns)):
            least += work.step * cells + work.stop * (cells > 0)
        ticks, nearest = clock.UNREACHABLE + 1, 0
        for i in least.argsort(kind="stable").tolist():
            if least[i] > ticks:
                break
            cell, heading = stops[i]
            times, _ = self.times_near(cell, heading, goal, loaded, 0)
            ticks, nearest = min((ticks, nearest), (int(times[cell, heading]), i))
        return nearest

    def times_from(self, cell: int, heading: int, loaded: bool) -> NDArray[np.int64]:
        """Ticks from standing in ``cell`` with ``heading`` to rest in each cell, whatever the heading there.

        Shape (cells,), read-only. Storage cells are goals here; `UNREACHABLE` where there is no way.
        """
        return self._table((cell, heading, loaded))  # type: ignore[no-any-return]

    def ticks(self, cell: int, heading: int, goal: int, loaded: bool) -> int:
        """Ticks from standing in ``cell`` with ``heading`` to rest at ``goal``."""
        table = self.ways_to(goal, loaded)
        ticks = int(table[cell, heading])
        return ticks if ticks < clock.far(table) else clock.UNREACHABLE

    def fastest_path(self, cell: int, heading: int, goal: int, loaded: bool) -> tuple[Leg, ...]:
        """Legs of a fastest path to ``goal``; of equally fast ones the one that turns last and stops first.

        Raises
        ------
        ValueError
            When there is no way.
        """
        table = self.ways_to(goal, loaded)
        if table[cell, heading] >= clock.far(table):
            raise ValueError(f"no path from {self.layout.where(cell)} to {self.layout.where(goal)}")
        ends = self._search.descend(cell, heading, goal, table, *self._grid(goal, loaded))
        return tuple(Leg(int(end)) for end in ends)

    def run_problem(self, start: int, leg_start: int, to: int, goal: int, loaded: bool) -> str | None:
        """Say why a straight run from ``leg_start`` to ``to`` is impossible on a path from ``start`` to ``goal``.

        None when it is possible.
        """
        heading = self.heading(leg_start, to)
        if heading is None:
            return f"{self.layout.where(leg_start)} to {self.layout.where(to)} is no straight run"
        from_start, to_goal = self._crossed(start, loaded), self._crossed(goal, loaded)
        cell, step = leg_start, self._steps[heading]
        while cell != to:
            if not self._moves[cell] >> heading & 1:
                return f"no robot may go from {self.layout.where(cell)} in heading {heading}"
            cell += step
            if not (from_start[cell] or to_goal[cell] or cell == goal):
                carrying = "with a pod" if loaded else "without a pod"
                return f"a robot {carrying} may not pass {self.layout.where(cell)} on its way"
        return None

    def wrong_leg(self, start: int, goal: int, ends: Rows, longest_wait: int, loaded: bool) -> int:
        """Number of the first leg that cannot be driven from a cell to a goal, or waits too long; -1 if none is so."""
        crossed = self.passable(start, loaded), self.passable(goal, loaded)
        grid = self.layout.width, self.layout.moves, *crossed
        return self._search.wrong_leg(start, goal, ends, longest_wait, *grid)  # type: ignore[no-any-return]

    def heading(self, cell: int, to: int) -> int | None:
        """Heading of a straight run between two cells, None when they are in neither one row nor one column."""
        width = self._layout.width
        if cell // width == to // width:
            return None if to == cell else 0 if to > cell else 2
        return None if (to - cell) % width else 1 if to < cell else 3

    def passable(self, end: int, loaded: bool) -> NDArray[np.bool_]:
        """Cells that a robot may cross on its way from or to a cell. Shape (cells,), read-only."""
        key = self._lanes[end], loaded
        cells = self._passable.get(key)
        if cells is None:
            queue = (self._lane == key[0]) & self._queue & (key[0] >= 0)
            cells = self._passable[key] = (self._floor if loaded else self._under) | queue
            cells.setflags(write=False)  # all are: the searches are compiled for one type of array
        return cells

    def _crossed(self, end: int, loaded: bool) -> bytes:
        """Return `passable` as bytes: a single one of them is quicker to look at."""
        key = self._lanes[end], loaded
        found = self._bytes_of.get(key)
        if found is None:
            found = self._bytes_of[key] = self.passable(end, loaded).tobytes()
        return found

    def _grid(self, end: int, loaded: bool) -> tuple[NDArray[np.int64] | NDArray[np.int8] | NDArray[np.bool_], ...]:
        """Return moves, passable cells, offsets, run and turn times."""
        return self.layout.moves, self.passable(end, loaded), self.offsets, self.runs, self.turns

    def _table(self, key: tuple[int, int, bool]) -> Any:
        """Return a table as it was kept, or else search for it and keep it: from a cell and heading, or to the cell."""
        table = self._tables.get(key)
        if table is None:
            table = self._search_for(*key)
            self._tables.keep(key, table, of_station=self._lanes[key[0]] >= 0)
        return table

    def _search_for(self, cell: int, heading: int, loaded: bool) -> Any:
        """Return a new table."""
        grid, times, in_lane = self._grid(cell, loaded), self._times, self._lanes[cell] >= 0
        if heading == TO and in_lane:
            table = self.ways_to(cell, loaded)  # which paths need anyway
            if table.itemsize == 8:
                return table
        elif heading == WAYS_TO:
            times = self._rows.pop() if in_lane and self._rows else self._room(1)[0]
        started = perf_counter()
        if heading == TO and in_lane:
            table = self._search.wide(table.reshape(-1)).reshape(-1, 4)
        elif heading >= 0:
            table = self._search.times_from(cell, heading, times, self._lane, *grid, self._work)
        else:
            self._search.times_to(cell, times, *grid, self._work)
            read = times.view()
            read.setflags(write=False)  # `wide` is compiled for one type of array
            table = (times if heading == WAYS_TO else self._search.wide(read)).reshape(-1, 4)
        self.seconds += perf_counter() - started
        return table
