"""Events that processes tell: of packing stations, and of robots, stations and chargers that fail.

Those that every run may tell are in `rmfs_core.events`; observers import all of them from `rmfs.events`.
"""

from __future__ import annotations

from attrs import frozen

from rmfs_core.events import Event

__all__ = [
    "ChargerDown",
    "ChargerUp",
    "OrderConsolidated",
    "OrderPacked",
    "PackingAssigned",
    "PackingStarted",
    "PartArrived",
    "PartPut",
    "PartSent",
    "RobotDown",
    "RobotUp",
    "StationDown",
    "StationUp",
]


@frozen
class _AtPacking(Event):
    order: int
    packing: int


@frozen
class PackingAssigned(_AtPacking):
    """The first part of an order is assigned: a packing station packs it, a split order from a box there.

    ``box`` is a number that no other order has there until this one is packed; None for an order that is not split.
    """

    box: int | None


@frozen
class PartSent(_AtPacking):
    """The last item of a part was handled at a station: its tote, with so many items, is on the conveyor."""

    station: int
    tote: int
    items: int


@frozen
class PartArrived(_AtPacking):
    """A tote has come to its packing station. They count up over the run from 1."""

    tote: int
    items: int


@frozen
class PartPut(Event):
    """The items of a tote were put into the box of their order; that began at ``start_tick``."""

    start_tick: int
    order: int
    packing: int
    tote: int
    items: int


@frozen
class OrderConsolidated(_AtPacking):
    """All items of a split order are in its box."""


@frozen
class PackingStarted(_AtPacking):
    """A packer has begun to pack an order."""


@frozen
class OrderPacked(Event):
    """An order is packed, which began at ``start_tick``; its box is free now, or since its last pick."""

    start_tick: int
    order: int
    packing: int


@frozen
class StationDown(Event):
    """A station has failed: nothing is begun there from now on; the pick in hand is finished."""

    station: int


@frozen
class StationUp(Event):
    """A station is in service again."""

    station: int


@frozen
class ChargerDown(Event):
    """The charger in a cell has failed: it charges nobody from now on."""

    cell: int


@frozen
class ChargerUp(Event):
    """The charger in a cell is in service again."""

    cell: int


@frozen
class RobotDown(Event):
    """A robot without a task is out of service from now on: it has failed, or its maintenance (``planned``) begins."""

    robot: int
    planned: bool


@frozen
class RobotUp(Event):
    """A robot is in service again."""

    robot: int
