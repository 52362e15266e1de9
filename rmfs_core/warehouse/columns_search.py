"""Compiled work on the columns of the warehouse; `columns` says what they are."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from rmfs_core.clock import TICKS_PER_S
from rmfs_core.jit import helper, njit
from rmfs_core.warehouse.columns import NEVER, Lines

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rmfs_core.warehouse.columns import Stock

    Plain = tuple[NDArray[Any], ...]
    Ints = NDArray[np.int64]


@njit(cache=True, interpreted=True)
def enlist(lines: Lines, room: Ints, line: int, end: int, used: int) -> tuple[int, int]:
    """Append lines to the lists of their SKUs, from ``line`` to before ``end``, until no space is left for the next.

    ``room`` says how long each list can get where it is; a list that is full moves to behind what is ``used``. Returns
    the first line that is not listed, and how much is used.
    """
    while line < end:
        sku = lines.sku[line]
        if lines.quantity[line] > 0:
            number, first = lines.number[sku], lines.first[sku]
            if number == room[sku]:
                more = 2 * number + 2
                if used + more > len(lines.listed_order):
                    break
                for at in range(number):
                    lines.listed_order[used + at] = lines.listed_order[first + at]
                    lines.listed_items[used + at] = lines.listed_items[first + at]
                first = lines.first[sku] = used
                room[sku] = more
                used += more
            lines.listed_order[first + number] = lines.order[line]
            lines.listed_items[first + number] = lines.quantity[line]
            lines.number[sku] += 1
        line += 1
    return line, used


@helper
def join(lines: Lines, told: Ints, order: int, line: int) -> int:
    """Write orders and their lines to the columns, from an order's row and a line on; return the next line.

    Of each order is told: id, tick of arrival, tick at which it is due, priority, number of lines; and of each of its
    lines: SKU, and open items, 0 if it is assigned.
    """
    at = 0
    while at < len(told):
        lines.order_id[order], lines.arrival_s[order] = told[at], told[at + 1] / TICKS_PER_S
        lines.due_s[order] = np.inf if told[at + 2] == NEVER else told[at + 2] / TICKS_PER_S
        lines.row[told[at]], lines.priority[order] = order, told[at + 3]
        lines.items[order] = lines.open_lines[order] = 0
        end = at + 5 + 2 * told[at + 4]
        for of_line in range(at + 5, end, 2):
            lines.order[line], lines.sku[line], lines.quantity[line] = order, told[of_line], told[of_line + 1]
            lines.items[order] += lines.quantity[line]
            lines.open_lines[order] += lines.quantity[line] > 0
            line += 1
        order += 1
        lines.begin[order] = line
        at = end
    return line


@helper
def leave(lines: Lines, left: Ints) -> int:
    """Take open lines out of the columns; return how many orders have left with their last one."""
    gone = 0
    for line in left:
        order, sku = lines.order[line], lines.sku[line]
        begin, end = lines.first[sku], lines.first[sku] + lines.number[sku]
        at, beyond = begin, end
        while at < beyond:  # a list is sorted by age
            middle = (at + beyond) // 2
            if lines.listed_order[middle] < order:
                at = middle + 1
            else:
                beyond = middle
        while at + 1 < end:
            lines.listed_order[at], lines.listed_items[at] = lines.listed_order[at + 1], lines.listed_items[at + 1]
            at += 1
        lines.number[sku] -= 1
        lines.items[order] -= lines.quantity[line]
        lines.open_lines[order] -= 1
        lines.quantity[line] = 0
        gone += lines.open_lines[order] == 0
    return gone


@njit(cache=True, interpreted=True)
def follow(columns: Plain, room: Ints, told: Ints, order: int, line: int, used: int) -> tuple[int, int, int]:
    """Let lines leave, whose number comes first, and orders join, as `leave`, `join` and `enlist` do.

    ``columns`` is what `Lines` are made of: named tuples take twice as long to read.
    Returns how many orders have left, the first line that is not listed, and how much is used.
    """
    lines = Lines(*columns)
    gone = leave(lines, told[1 : 1 + told[0]])
    end = join(lines, told[1 + told[0] :], order, line)
    line, used = enlist(lines, room, line, end, used)
    return gone, line, used


@njit(cache=True, interpreted=True)
def put(stock: Stock, rows: Ints) -> int:
    """Let entries (pod, SKU, items) have so many items; return how many are not there yet: the first of ``rows``."""
    missing = 0
    for row in range(len(rows)):
        pod, sku = rows[row, 0], rows[row, 1]
        at, beyond = stock.of_pod[pod], stock.of_pod[pod + 1]
        end = beyond
        while at < beyond:
            middle = (at + beyond) // 2
            if stock.sku[middle] < sku:
                at = middle + 1
            else:
                beyond = middle
        if at < end and stock.sku[at] == sku:
            stock.items[at] = rows[row, 2]
        else:
            for column in range(3):
                rows[missing, column], rows[row, column] = rows[row, column], rows[missing, column]
            missing += 1
    return missing
