"""RAWSim-O's block layout, which is the paper's: blocks of storage locations two deep, one-lane aisles, a hall.

The aisles between the blocks are one-way, in alternating directions; the outermost lanes form a ring that is driven
counter-clockwise. A picking station is next to the hall: its queue is entered from an aisle that leads out of the
storage area, folds twice, and ends at the station, which pods leave along the next aisle but one. With a shortcut, a
robot that finds nobody in line drives on from the first fold straight to the station; and the ring leads into the third
lane, too.

Source: Merschformann, Xie, Li (2018), RAWSim-O, Logistics Research 11:8, doi:10.23773/2018_8; the paper, Section 4.1.2.
"""

from __future__ import annotations

from rmfs_commands.layouts.textmap import FLOOR_SIGN, QUEUE_SIGN, parse_map
from rmfs_core.errors import InputError
from rmfs_core.scenario.model import MOST_CELLS, LayoutSection
from rmfs_core.world.grid import EAST, NORTH, SOUTH, WEST, Layout
from rmfs_core.world.layout_making import QUEUE_LENGTH

BLOCK_DEPTH = 2
ROW_PITCH = BLOCK_DEPTH + 1


def blocks(section: LayoutSection, text: str | None, queue_length: int | None, place: str) -> Layout:
    """Make the block layout, as `rmfs_core.world.make_layout` asks for it."""
    if text is not None:
        raise InputError("layout.map_file", "expected none with the layout generator `blocks`")
    return parse_map(block_map(section, queue_length or QUEUE_LENGTH, place), place)


def block_map(section: LayoutSection, queue_length: int, place: str = "layout") -> str:
    """Draw the block layout as a text map.

    Parameters
    ----------
    section
        Numbers of blocks, their length, the hall's width, stations on either side.
    queue_length
        Cells that a station's queue must have at least; it is three rows deep.
    place
        Name of the section in errors.

    Raises
    ------
    InputError
        When a side is too short for its stations.
    """
    return _BlockMap(section, queue_length, place).draw()


class _BlockMap:
    def __init__(self, section: LayoutSection, queue_length: int, place: str) -> None:
        self.section, self.place = section, place
        fitting = (section.block_rows - 1) // 2
        self.on_east = "O" * section.stations_east + "I" * (section.replenishment_east or 0)
        self.on_west = "O" * section.stations_west + "I" * (section.replenishment_west or 0)
        for side, signs in (("east", self.on_east), ("west", self.on_west)):
            if (count := len(signs)) > fitting:
                raise InputError(
                    f"{place}.{'replenishment' if 'I' in signs else 'stations'}_{side}",
                    f"found {count} stations next to {section.block_rows} rows of blocks; "
                    f"at most {fitting} fit, one to every two rows of blocks between the first and the last aisle",
                )
        if section.stations_east + section.stations_west == 0:
            raise InputError(f"{place}.stations_east", "found no picking station; expected at least one on either side")
        queue_columns = -(-queue_length // ROW_PITCH)
        self.west = queue_columns if self.on_west else 0
        inner = section.block_columns * (section.block_length + 1) - 1
        self.first_block = self.west + section.hall_width
        self.hall_east = self.first_block + inner
        self.east = self.hall_east + section.hall_width  # first column beyond the hall
        self.width = self.east + (queue_columns if self.on_east else 0)
        self.height = section.block_rows * ROW_PITCH + 1
        if self.width * self.height > 2 * MOST_CELLS:  # with the queues, whose length is no matter of the layout's
            found = f"found queues of {queue_length:,} cells next to {section.block_rows:,} rows of blocks"
            raise InputError("stations.queue_length", f"{found}; expected at most {2 * MOST_CELLS:,} cells in all")
        self.fitting = fitting
        self.signs = [["@"] * self.width for _ in range(self.height)]

    def draw(self) -> str:
        for row in range(self.height):
            for column in range(self.west, self.east):
                self.signs[row][column] = self._inner_sign(row, column)
        for i, sign in enumerate(self.on_east):
            self._station(1 + 2 * self._place(i, len(self.on_east)), sign, east=True)
        for i, sign in enumerate(self.on_west):
            self._station(2 + 2 * self._place(i, len(self.on_west)), sign, east=False)
        self._chargers(self.section.chargers or 0)
        self._maintenance_cells(self.section.maintenance_cells or 0)
        return "\n".join("".join(row) for row in self.signs) + "\n"

    def _chargers(self, count: int) -> None:
        """Make chargers of storage locations, spread evenly in the order of reading."""
        there = [(row, i) for row, signs in enumerate(self.signs) for i, sign in enumerate(signs) if sign == "#"]
        if count >= len(there):
            expected = f"expected fewer than the {len(there)} storage locations, some of which they replace"
            raise InputError(f"{self.place}.chargers", f"found {count}; {expected}")
        for i in range(count):
            row, column = there[(2 * i + 1) * len(there) // (2 * count)]
            self.signs[row][column] = "C"

    def _maintenance_cells(self, count: int) -> None:
        """Make maintenance cells of the last storage locations in the order of reading."""
        there = [(row, i) for row, signs in enumerate(self.signs) for i, sign in enumerate(signs) if sign == "#"]
        if count >= len(there):
            expected = f"expected fewer than the {len(there)} storage locations, some of which they replace"
            raise InputError(f"{self.place}.maintenance_cells", f"found {count}; {expected}")
        for row, column in there[len(there) - count :]:
            self.signs[row][column] = "M"

    def _place(self, i: int, count: int) -> int:
        """Spread ``count`` stations evenly over the rows where one fits."""
        return (2 * i + 1) * self.fitting // (2 * count)

    def _inner_sign(self, row: int, column: int) -> str:
        moves, aisle = 0, row // ROW_PITCH
        if row % ROW_PITCH == 0:  # alternating, counted from the north, but the last one closes the ring
            moves |= 1 << (EAST if aisle % 2 or aisle == self.section.block_rows else WEST)
        vertical = self._column_heading(column)
        if vertical is not None:
            moves |= 1 << vertical
        if not moves:
            return "#"
        inside = column + 1 < self.east, row > 0, column > self.west, row + 1 < self.height  # by heading
        return FLOOR_SIGN[sum(1 << h for h in range(4) if moves >> h & 1 and inside[h])]

    def _column_heading(self, column: int) -> int | None:
        """Heading of the lane in a column, or None where the column has storage locations."""
        if column < self.first_block:
            return SOUTH if (column - self.west) % 2 == 0 else NORTH
        if column >= self.hall_east:
            return NORTH if (self.east - 1 - column) % 2 == 0 else SOUTH
        block, within = divmod(column - self.first_block, self.section.block_length + 1)
        if within < self.section.block_length:
            return None
        return NORTH if block % 2 == 0 else SOUTH

    def _station(self, aisle: int, sign: str, *, east: bool) -> None:
        """Draw a station whose queue is entered from a horizontal aisle."""
        top = aisle * ROW_PITCH
        outward, inward = (EAST, WEST) if east else (WEST, EAST)
        columns = list(range(self.east, self.width)) if east else list(range(self.west - 1, -1, -1))
        for fold, heading in enumerate((outward, inward, outward)):
            for column in columns:
                self.signs[top + fold][column] = QUEUE_SIGN[1 << heading]
        self.signs[top][columns[-1]] = QUEUE_SIGN[1 << SOUTH]
        if self.section.queue == "shortcut":
            self.signs[top + 1][columns[-1]] = QUEUE_SIGN[1 << inward | 1 << SOUTH]
        self.signs[top + 1][columns[0]] = QUEUE_SIGN[1 << SOUTH]
        self.signs[top + 2][columns[-1]] = QUEUE_SIGN[1 << SOUTH]
        for column in columns:
            self.signs[top + 3][column] = FLOOR_SIGN[1 << inward]
        self.signs[top + 3][columns[-1]] = sign
        edge = self.east - 1 if east else self.west
        self._open(top, edge, outward)
        if self.section.queue == "shortcut":
            self._open(top + 2, edge, outward)

    def _open(self, row: int, column: int, heading: int) -> None:
        """Let the hall's outermost lane turn off into a queue."""
        moves = 1 << heading
        ring = self._column_heading(column)
        if ring is not None:
            moves |= 1 << ring
        self.signs[row][column] = FLOOR_SIGN[moves]
