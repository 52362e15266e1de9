"""From counts to lines of orders: the oldest of a type or of a SKU first."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from rmfs_rules.mip.period.period import Line
from rmfs_rules.mip.period.placing import Slots
from rmfs_rules.mip.period.reduction import Reduced, masks_of
from rmfs_rules.mip.period.solution import Model, Part, Visits, parts_from

_Wanted = list[tuple[int, Line]]
"""Lines to place, each with the position of its order."""


@frozen
class Counts:
    """Answer of a model that counts interchangeable things.

    Parameters
    ----------
    visits
        New visits.
    whole
        How many orders of a type (its position among `Reduced.types`) go to a station as a whole.
    split
        How many orders of a type are split; a type that is not named has no such limit.
    lines
        How many lines of a kind go to a station, of the orders that are split.
    splits_limited
        Whether there is a limit on newly split orders.
    placed
        (order, station, SKU) of lines that are not counted but placed one by one.
    chosen
        (order, SKU) of the lines of split orders that go to some station; None where the oldest do.
    """

    visits: Visits
    whole: Mapping[tuple[int, int], int] = field(factory=dict)
    split: Mapping[int, int] = field(factory=dict)
    lines: Mapping[tuple[Line, int], int] = field(factory=dict)
    splits_limited: bool = False
    placed: tuple[tuple[int, int, int], ...] = ()
    chosen: frozenset[tuple[int, int]] | None = None


def parts_of(reduced: Reduced, counts: Counts) -> tuple[Part, ...]:
    """Return the assigned lines.

    Parameters
    ----------
    reduced
        The period.
    counts
        Counts by kind.
    """
    period = reduced.period
    rooms = list(period.capacities)
    parts: list[Part] = []
    wanted: _Wanted = []
    for number, kind in enumerate(reduced.types):
        orders = list(kind.orders)
        for station in range(len(rooms)):
            for _ in range(counts.whole.get((number, station), 0)):
                parts.append(Part(orders.pop(0), station, tuple(sku for sku, _ in kind.lines)))
                rooms[station] -= kind.size
        split = len(orders)
        if number in counts.split:
            split = counts.split[number]
        elif not _freely_split(reduced, counts, kind.begun):
            split = 0
        lines = [(order, line) for order in orders[:split] for line in kind.lines]
        wanted += [one for one in lines if counts.chosen is None or (one[0], one[1][0]) in counts.chosen]
    placed = list(counts.placed)
    if wanted:
        wanted.sort(key=lambda one: one[0])
        covered = period.covered_with(counts.visits)
        by_flow = period.single_items and not len(reduced.scarce)
        placed += _placed(covered, rooms, wanted) if by_flow else _counted(counts, wanted)
    return (*parts, *parts_from(placed))


def _freely_split(reduced: Reduced, counts: Counts, begun: bool) -> bool:
    """Whether lines of an order whose split is not counted may be assigned: over time, and its split is free."""
    if reduced.model is not Model.SPLIT_OVER_TIME or reduced.period.counting_orders:
        return False
    return begun or not counts.splits_limited


def _placed(covered: NDArray[np.bool_], rooms: list[int], wanted: _Wanted) -> list[tuple[int, int, int]]:
    """Place single items by augmenting paths; a line that finds no slot stays in the backlog."""
    mask = masks_of(covered).tolist()
    slots = Slots.covered(rooms, mask)
    lines = [(order, sku) for order, (sku, _) in wanted if mask[sku] and slots.add(mask[sku])]
    return [(order, slots.take(mask[sku], ()), sku) for order, sku in lines]


def _counted(counts: Counts, wanted: _Wanted) -> list[tuple[int, int, int]]:
    """Give each station as many lines of a kind as the counts say."""
    left = dict(counts.lines)
    placed = []
    for order, line in wanted:
        for (kind, station), number in left.items():
            if kind == line and number > 0:
                left[kind, station] -= 1
                placed.append((order, station, line[0]))
                break
    return placed
