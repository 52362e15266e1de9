"""Packing stations as rules see them; the kernel replaces them when something changes."""

from __future__ import annotations

from typing import NamedTuple

from attrs import Factory, frozen

from rmfs_core.scenario.model import PackingSection
from rmfs_core.timetable import ALWAYS, Timetable
from rmfs_core.warehouse.parts import Order


class PackingTask(NamedTuple):
    """A waiting task of a packer: ``"put"`` the items of a tote into the order's box, or ``"pack"`` the order (``tote``
    is then the one that came last); how many items, its expected time, and since when it waits."""

    kind: str
    order: Order
    tote: int
    items: int
    duration_s: float
    since_s: float


@frozen(eq=False)
class PackingStation:
    """A packing station at one moment.

    Parameters
    ----------
    id, section
        Its id; how many boxes, packers and sorters it has, and how long tasks take.
    cell, conveyor_s
        Index of its cell, None without one; what totes take to it from each picking station, in seconds, by id.
    hours
        When its packers begin tasks; they finish begun ones.
    orders
        Orders that are bound for it and not packed, in the order in which that was decided.
    tasks, working
        Tasks that wait for a packer, longest waiting first; tasks at work, with their expected ends in seconds.
    free_boxes
        How many more split orders it can hold.
    """

    id: int
    section: PackingSection
    cell: int | None = None
    conveyor_s: tuple[float, ...] = ()
    hours: Timetable = ALWAYS
    orders: tuple[Order, ...] = ()
    tasks: tuple[PackingTask, ...] = ()
    working: tuple[tuple[PackingTask, float], ...] = ()
    free_boxes: int = Factory(lambda self: self.section.boxes, takes_self=True)

    @property
    def label(self) -> str:
        """Its name, for messages."""
        return str(self.id + 1)
