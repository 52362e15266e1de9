"""Compiled work on the columns of the warehouse; `columns` says what they are."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rmfs_core.jit import njit

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from rmfs_core.warehouse.columns import Lines, Stock

    Ints = NDArray[np.int64]


@njit(cache=True)
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


@njit(cache=True)
def join(lines: Lines, orders: NDArray[np.float64], wanted: Ints, order: int, line: int) -> None:
    """Write orders and their lines to the columns, from an order's place and a line on.

    Parameters
    ----------
    lines
        The columns, with room for them.
    orders
        Id, arrival and due time in seconds, number of lines, and priority of each, shape (orders, 5).
    wanted
        SKU and open items of each line, 0 if it is assigned, shape (lines, 2).
    """
    first = line
    for told in orders:
        lines.order_id[order], lines.arrival_s[order], lines.due_s[order] = int(told[0]), told[1], told[2]
        lines.place[int(told[0])], lines.priority[order] = order, int(told[4])
        lines.items[order] = lines.open_lines[order] = 0
        for _ in range(int(told[3])):
            lines.order[line], lines.sku[line] = order, wanted[line - first, 0]
            lines.quantity[line] = wanted[line - first, 1]
            lines.items[order] += lines.quantity[line]
            lines.open_lines[order] += lines.quantity[line] > 0
            line += 1
        order += 1
        lines.begin[order] = line


@njit(cache=True)
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


@njit(cache=True)
def follow(
    lines: Lines, room: Ints, left: Ints, orders: NDArray[np.float64], wanted: Ints, order: int, line: int, used: int
) -> tuple[int, int, int]:
    """Let lines leave and orders join, as `leave`, `join` and `enlist` do; return what these return."""
    gone = leave(lines, left)
    join(lines, orders, wanted, order, line)
    line, used = enlist(lines, room, line, line + len(wanted), used)
    return gone, line, used


@njit(cache=True)
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
