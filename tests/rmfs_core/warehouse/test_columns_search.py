"""Compiled work on columns, on the smallest ones."""

from __future__ import annotations

import numpy as np

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import Lines, WarehouseView
from rmfs_core.warehouse.columns_search import enlist, leave, put


def writable(lines: Lines) -> Lines:
    """Return copies of columns."""
    return Lines(*(array.copy() for array in lines))


def test_lists_move_when_they_are_full_and_wait_for_space() -> None:
    """A list of two lines moves behind what is used before the third; without space for it nothing more is listed."""
    lines = writable(WarehouseView(small_world({str(i): ["a"] for i in range(3)}, {"p": ["a"]})).lines)
    lines.number[:] = 0
    room = np.zeros(1, np.int64)
    few = lines._replace(listed_order=np.zeros(3, np.int64), listed_items=np.zeros(3, np.int64))
    assert enlist(few, room, 0, 3, 0) == (2, 2)
    more = few._replace(listed_order=np.zeros(8, np.int64), listed_items=np.zeros(8, np.int64))
    more.listed_order[:3] = few.listed_order
    assert enlist(more, room, 2, 3, 2) == (3, 8)
    first = more.first[0]
    assert more.listed_order[first : first + 3].tolist() == [0, 1, 2]


def test_an_order_leaves_with_its_last_line_and_lists_stay_sorted() -> None:
    """The younger lines of the SKU move up."""
    lines = writable(WarehouseView(small_world({"1": ["a", "b"], "2": ["a"], "3": ["a"]}, {"p": ["a"]})).lines)
    assert leave(lines, np.array([0])) == 0
    assert leave(lines, np.array([1, 2])) == 2
    assert lines.listed_order[lines.first[0]] == 2
    assert (lines.number.tolist(), lines.items.tolist()) == ([1, 0], [0, 0, 1])


def test_entries_that_are_not_there_come_first() -> None:
    """An entry that is there is changed; how many are not is returned."""
    stock = WarehouseView(small_world({"1": ["a", "b"]}, {"p": {"a": 2}, "q": {"b": 1}})).stock
    own = stock._replace(items=stock.items.copy())
    rows = np.array([[0, 0, 7], [0, 1, 3]])
    assert put(own, rows) == 1
    assert (rows.tolist(), own.items.tolist()) == ([[0, 1, 3], [0, 0, 7]], [7, 1])
