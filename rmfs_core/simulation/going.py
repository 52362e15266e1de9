"""Things that are going on at a moment of a run, as plain data.

A process that waits for a tick tells what for, as the value of the event that it waits for: so the clock has what is
going on, in the order in which it ends. A robot's story (`Simulation`) can be entered with what was going on in it.
"""

from __future__ import annotations

from typing import NamedTuple


class Going(NamedTuple):
    """Something that ends at a tick; 0: when something else happens. Ids and ticks; ``kind`` says what has a meaning.

    ``leg``: a robot drives ``legs`` (cell, wait), on the first since ``since``; ``wait``: it stands before the first.
    ``drive``: it goes on when it has a path, or is woken. ``room``: it waits under a pod for a queue cell.
    ``line``: it stands in a line. ``lift``, ``set``: it lifts a pod, or sets it down. ``charge``: it is charged.
    ``picker``, ``pick``, ``stow``: in a ``visit`` with so many ``picks`` so far, it waits for the picker, an item of
    ``sku`` is picked, a bundle is stored. ``release``: the item in hand at a station is handled. ``bundle``: items
    are ordered. ``alarm``: rules wake up. ``arrivals``, ``bundles``, ``hours``: the next of these happens.
    ``tote``: the last of the ``items`` of an ``order`` in a tote at a station is handled; 0: it takes more.
    ``totes``: the last item of a visit is handled. ``conveyor``: a tote comes to its packing station. ``put``,
    ``pack``: such a task of a tote ends at a packing ``station``. ``packers``: that opens.
    """

    kind: str
    robot: int | None = None
    station: int | None = None
    sku: int | None = None
    items: int = 0
    visit: int = 0
    picks: int = 0
    since: int = 0
    legs: tuple[tuple[int, int], ...] = ()
    overtaken: int = 0
    tick: int = 0
    order: int | None = None
    tote: int = 0
