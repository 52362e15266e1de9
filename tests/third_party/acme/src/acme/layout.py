"""A layout of one aisle, and a format of maps in which each row is made of runs: ``3# 2.`` is ``###..``."""

from __future__ import annotations

import re

from rmfs import InputError
from rmfs.layouts import parse_map
from rmfs_core.scenario import LayoutSection
from rmfs_core.world import Layout


def aisle(section: LayoutSection, text: str | None, queue_length: int | None, place: str) -> Layout:
    """Make an aisle between two rows of storage locations, with a picking station at its end."""
    storage, floor = "#" * section.block_length, "." * section.block_length
    queue = "q" * (queue_length or 2)
    return parse_map(f"{storage}..{'@' * len(queue)}@\n{floor}..{queue}O\n{storage}..{'.' * len(queue)}.", place)


def runs(section: LayoutSection, text: str | None, queue_length: int | None, place: str) -> Layout:
    """Read a map of runs."""
    if text is None:
        raise InputError("layout.map_file", "expected a map of runs such as `3# 2.`")
    rows = [re.sub(r"(\d+)(.) ?", lambda run: int(run[1]) * run[2], row) for row in text.splitlines()]
    return parse_map("\n".join(rows), place)
