"""RAWSim-O's graph of waypoints as a grid of cells.

Waypoints are a metre apart, along rows and columns; a way leads from each to some of those next to it. What a text map
cannot say is left out and counted: the map is drawn, read back, and compared with the graph.
"""

from __future__ import annotations

import math
from collections.abc import Container, Iterable, Mapping, Sequence

import numpy as np
from attrs import define, frozen
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from rmfs_commands.import_.notes import Notes
from rmfs_commands.layouts import parse_map
from rmfs_commands.layouts.reaching import reached
from rmfs_commands.layouts.textmap import FLOOR_SIGN, QUEUE_SIGN
from rmfs_core.errors import InputError
from rmfs_core.scenario.model import MOST_CELLS
from rmfs_core.world import CellKind, Layout, StationCells, check_layout, check_size

NEAR_M = 0.01
"""How far from the grid a waypoint may stand."""


@frozen
class Waypoint:
    """A waypoint.

    Parameters
    ----------
    x, y
        Metres from the north-west corner, to the east and to the south.
    ways
        Numbers of the waypoints that a way leads to.
    storage
        Whether pods stand there.
    place
        Where the file has it.
    """

    x: float
    y: float
    ways: tuple[int, ...]
    storage: bool
    place: str


@frozen
class StationPoints:
    """A station: its number, the number of its waypoint, and those of its queue in any order of driving.

    It is a picking station unless it is ``replenishing``.
    """

    number: int
    waypoint: int
    queue: tuple[int, ...]
    place: str
    replenishing: bool = False

    @property
    def name(self) -> str:
        """Its name in RAWSim-O."""
        return f"{'input' if self.replenishing else 'output'} station {self.number}"


@define(eq=False)
class Drawn:
    """A text map.

    Parameters
    ----------
    text, layout
        The map, and what it says.
    stations
        The picking stations in the order of the layout.
    north_west
        Metres to the east and to the south at which its first cell has its middle.
    """

    text: str
    layout: Layout
    stations: tuple[StationPoints, ...]
    north_west: tuple[float, float]

    def cell(self, x: float, y: float) -> int:
        """Return the cell of a point, or the nearest one of the grid."""
        column, row = (round(at - first) for at, first in zip((x, y), self.north_west, strict=True))
        column, row = min(max(column, 0), self.layout.width - 1), min(max(row, 0), self.layout.height - 1)
        return row * self.layout.width + column


def draw(
    points: Mapping[int, Waypoint],
    stations: Sequence[StationPoints],
    left_out: Iterable[int],
    size: tuple[float, float],
    place: str,
    notes: Notes,
) -> Drawn:
    """Draw waypoints as a text map.

    Parameters
    ----------
    points
        The waypoints by number.
    stations
        Picking and replenishment stations.
    left_out
        Numbers of waypoints that become walls.
    size
        Length (from west to east) and width of the tier in metres.
    place
        The file, for messages.
    notes
        Told what the map does not have.

    Raises
    ------
    InputError
        When the waypoints are no grid of 1 m, or the map is none that robots could work on.
    """
    graph = _Graph(points, size, place)
    graph.leave_out(left_out)
    queues = [graph.queue(station, notes) for station in stations]
    graph.close_lanes(notes)
    signs = {graph.cells[station.waypoint]: "I" for station in stations if station.replenishing}
    text = graph.text(queues, signs)
    drawn = parse_map(text, f"the map drawn from {place}")
    check_layout(drawn, f"the map drawn from {place}")
    graph.compare(drawn, notes)
    picking = [station for station in stations if not station.replenishing]
    order = sorted(picking, key=lambda station: graph.cells[station.waypoint])
    return Drawn(text, drawn, tuple(order), graph.north_west)


class _Graph:
    def __init__(self, points: Mapping[int, Waypoint], size: tuple[float, float], place: str) -> None:
        if not points:
            raise InputError(place, "found no waypoint; expected some")
        self.place, self.points = place, points
        self.cells, self.width, self.height, self.north_west = _grid(points, size, place)
        self.kind = np.zeros(self.width * self.height, dtype=np.int8)
        for number, point in points.items():
            self.kind[self.cells[number]] = CellKind.STORAGE if point.storage else CellKind.FLOOR
        self.ways: dict[int, int] = {}
        """Bits of the headings in which ways leave a cell."""
        self.apart = 0
        bits = {(1, 0): 1, (0, -1): 2, (-1, 0): 4, (0, 1): 8}
        for number, point in points.items():
            cell = self.cells[number]
            for other in point.ways:
                if other not in points:
                    raise InputError(point.place, f"found a path to waypoint {other}, which does not exist")
                to = self.cells[other]
                if bit := bits.get((to % self.width - cell % self.width, to // self.width - cell // self.width)):
                    self.ways[cell] = self.ways.get(cell, 0) | bit
                else:
                    self.apart += 1

    def beside(self, cell: int) -> list[tuple[int, int]]:
        """Return the bits of headings and the cells next to one."""
        row, column = divmod(cell, self.width)
        found = [(1, cell + 1)] if column + 1 < self.width else []
        found += [(2, cell - self.width)] if row else []
        found += [(4, cell - 1)] if column else []
        return found + ([(8, cell + self.width)] if row + 1 < self.height else [])

    def leads(self, cell: int, to: int) -> bool:
        """Whether a way leads from a cell to one next to it."""
        return any(other == to and self.ways.get(cell, 0) & bit for bit, other in self.beside(cell))

    def leave_out(self, numbers: Iterable[int]) -> None:
        for number in numbers:
            if number in self.cells:
                self.kind[self.cells[number]] = CellKind.WALL

    def queue(self, station: StationPoints, notes: Notes) -> StationCells:
        """Take the cells of a station's queue: a chain, of which each leads to the one before it."""
        at = self.cells.get(station.waypoint)
        if at is None:
            raise InputError(station.place, f"found no waypoint of {station.name}; expected one")
        self.kind[at] = CellKind.STATION
        unknown = [number for number in station.queue if number not in self.cells]
        if unknown:
            raise InputError(station.place, f"the queue has waypoint {unknown[0]}; there is none of that number")
        left = [self.cells[number] for number in station.queue if number != station.waypoint]
        left = [cell for cell in dict.fromkeys(left) if self.kind[cell] == CellKind.FLOOR]
        chain = _longest_chain(at, left, self)
        if not chain:
            expected = "expected waypoints from which ways lead to it, as its `Queues`"
            raise InputError(station.place, f"{station.name} has no queue; {expected}")
        self.kind[chain] = CellKind.QUEUE
        notes.add(f"waypoints of {station.name}'s queue off the chain", len(left) - len(chain), "floor")
        return StationCells(at, tuple(chain))

    def close_lanes(self, notes: Notes) -> None:
        """Make walls of floor that robots cannot come to and leave again: lanes of what is left out, dead ends."""
        floor = np.flatnonzero(self.kind == CellKind.FLOOR).tolist()
        steps = {cell: [n for bit, n in self.beside(cell) if self.ways.get(cell, 0) & bit] for cell in floor}
        steps = {cell: [n for n in nexts if self.kind[n] == CellKind.FLOOR] for cell, nexts in steps.items()}
        if not steps:
            raise InputError(self.place, "found no waypoint that is floor; expected aisles")
        number = {cell: i for i, cell in enumerate(steps)}
        pairs = [(number[cell], number[n]) for cell, nexts in steps.items() for n in nexts]
        rows, columns = np.array(pairs, dtype=np.int32).reshape(-1, 2).T  # older scipy searches these alone
        matrix = csr_array((np.ones(len(pairs), dtype=np.int8), (rows, columns)), shape=(len(steps), len(steps)))
        _, label = connected_components(matrix, directed=True, connection="strong")
        aisles = {cell for cell, i in number.items() if label[i] == int(np.bincount(label).argmax())}
        back: dict[int, list[int]] = {cell: [] for cell in steps}
        for cell, nexts in steps.items():
            for n in nexts:
                back[n].append(cell)
        stations = np.flatnonzero(self.kind == CellKind.STATION)
        exits = [n for cell in map(int, stations) for bit, n in self.beside(cell) if self.ways.get(cell, 0) & bit]
        keep = aisles | (reached([n for n in exits if n in steps], steps) & reached(aisles, back))
        closed = [cell for cell in steps if cell not in keep]
        self.kind[closed] = CellKind.WALL
        notes.add("waypoints of lanes that lead nowhere, such as those of replenishment", len(closed), "walls")

    def text(self, queues: Sequence[StationCells], own: Mapping[int, str]) -> str:
        """Return the text map; some cells have signs of their own."""
        drawn = {int(CellKind.STORAGE): "#", int(CellKind.STATION): "O"}
        signs = [drawn.get(kind, "@") for kind in self.kind.tolist()]
        for cell in map(int, np.flatnonzero(self.kind == CellKind.FLOOR)):
            signs[cell] = FLOOR_SIGN[self._of_floor(cell, {chain.queue[-1] for chain in queues})]
        for cell, sign in own.items():
            signs[cell] = sign
        for chain in queues:
            line = (chain.station, *chain.queue)
            for place, cell in enumerate(chain.queue, 1):
                signs[cell] = QUEUE_SIGN[self._of_queue(cell, line[:place])]
        return "".join("".join(signs[i : i + self.width]) + "\n" for i in range(0, len(signs), self.width))

    def _of_floor(self, cell: int, entries: Container[int]) -> int:
        """Return the ways of a floor cell to floor and queues; ways to storage locations go without saying.

        All four where ways lead to every floor cell next to it, and back. Where the only way leads back along one that
        comes in, the sign of a one-way cell would close that one: an arm towards a wall or a storage location keeps it
        open.
        """
        ways = back = idle = around = 0
        for bit, other in self.beside(cell):
            kind = self.kind[other]
            if kind == CellKind.FLOOR or other in entries:
                around |= bit
            if kind in (CellKind.FLOOR, CellKind.QUEUE):
                ways |= self.ways.get(cell, 0) & bit
                back |= bit if self.leads(other, cell) or other in entries else 0
            elif kind in (CellKind.WALL, CellKind.STORAGE):
                idle |= bit
        if ways == around == back:
            return 15
        idle |= 15 ^ sum(bit for bit, _ in self.beside(cell))
        if not ways:
            return idle or 15
        only_back = not ways & (ways - 1) and ways & back
        return ways | (idle & -idle) if only_back else ways

    def _of_queue(self, cell: int, ahead: Sequence[int]) -> int:
        """Return the way to the next cell of a queue, the last of those ahead, and one past some of them, too."""
        first = next(bit for bit, other in self.beside(cell) if other == ahead[-1])
        more = (bit for bit, n in self.beside(cell) if n in ahead[:-1] and self.leads(cell, n))
        return first | next(more, 0)

    def compare(self, drawn: Layout, notes: Notes) -> None:
        """Note ways that the map does not have, and such that it has besides."""
        lost = added = 0
        for cell in map(int, np.flatnonzero(self.kind != CellKind.WALL)):
            kept = sum(bit for bit, other in self.beside(cell) if self.kind[other] != CellKind.WALL)
            has, asked = int(drawn.moves[cell]) & kept, self.ways.get(cell, 0) & kept
            lost += (asked & ~has).bit_count()
            added += (has & ~asked).bit_count()
        notes.add("ways that a text map cannot say", lost)
        notes.add("no ways between cells that a text map always joins", added, "ways")
        notes.add("ways between waypoints that are not side by side", self.apart)


def _grid(
    points: Mapping[int, Waypoint], size: tuple[float, float], place: str
) -> tuple[dict[int, int], int, int, tuple[float, float]]:
    """Return the cell of every waypoint, how wide and high the grid is, and where its first cell is."""
    first = next(iter(points.values()))
    off_x, off_y = (value - math.floor(value) for value in (first.x, first.y))
    found: dict[int, tuple[int, int]] = {}
    for number, point in points.items():
        column, row = round(point.x - off_x), round(point.y - off_y)
        if max(abs(point.x - off_x - column), abs(point.y - off_y - row)) > NEAR_M:
            at = f"waypoint {number} at x {point.x:g}, y {point.y:g}, the first one at x {first.x:g}, y {first.y:g}"
            raise InputError(point.place, f"found {at}; expected whole metres between them, a grid of 1 m")
        found[number] = column, row
    west, north = (min(0, *(at[i] for at in found.values())) for i in (0, 1))
    width, height = (
        max(round(length), 1 + max(at[i] for at in found.values())) - least
        for i, (length, least) in enumerate(zip(size, (west, north), strict=True))
    )
    if width * height > MOST_CELLS:
        raise InputError(place, f"found {width:,} x {height:,} m; expected at most {MOST_CELLS:,} cells of 1 m x 1 m")
    check_size(width, height, place)
    cells: dict[int, int] = {}
    taken: dict[int, int] = {}
    for number, (column, row) in found.items():
        cell = (row - north) * width + column - west
        if (other := taken.setdefault(cell, number)) != number:
            raise InputError(points[number].place, f"found waypoints {other} and {number} at one point; expected one")
        cells[number] = cell
    return cells, width, height, (west + off_x, north + off_y)


def _longest_chain(station: int, cells: Sequence[int], graph: _Graph) -> list[int]:
    """Return the queue from the station on: in the order given, or turned round, as far as ways lead along it."""

    def chain(order: Iterable[int]) -> list[int]:
        at, found = station, []
        for cell in order:
            if not graph.leads(cell, at):
                break
            found.append(cell)
            at = cell
        return found

    return max(chain(cells), chain(reversed(cells)), key=len)


def nearest(layout: Layout, cell: int, kinds: frozenset[CellKind], taken: Iterable[int]) -> int | None:
    """Return the cell of some kinds nearest to one, along rows and columns, that is not taken; the first of equals."""
    free = np.isin(layout.kind, [int(kind) for kind in kinds])
    free[list(taken)] = False
    cells = np.flatnonzero(free)
    if not len(cells):
        return None
    away = np.abs(cells % layout.width - cell % layout.width) + np.abs(cells // layout.width - cell // layout.width)
    return int(cells[away.argmin()])
