"""Events of a run, as observers are told of them. Every id is the object's ``id``; times are ticks (1 ms).

An event is sent when its change has been applied. ``tick`` is the time at which it is sent; an event that reports
something that took time carries when it started too.
"""

from __future__ import annotations

from attrs import frozen

from rmfs_core.clock import to_seconds
from rmfs_core.roles import Role

__all__ = [
    "BundleArrived",
    "BundleAssigned",
    "BundleBound",
    "BundleStored",
    "DecisionMade",
    "Event",
    "ItemPicked",
    "OrderArrived",
    "OrderAssigned",
    "OrderCancelled",
    "OrderCompleted",
    "OrderInStock",
    "PodLifted",
    "PodMoveDecided",
    "PodStored",
    "QueueJoined",
    "RobotMoved",
    "RobotRested",
    "RobotSent",
    "RobotsOnDuty",
    "StationClosed",
    "StationOpened",
    "TaskAssigned",
    "TripDecided",
    "VisitEnded",
    "VisitStarted",
]


@frozen
class Event:
    """Base of all events."""

    tick: int

    @property
    def time_s(self) -> float:
        """Simulated time at which the event is sent, in seconds."""
        return to_seconds(self.tick)


@frozen
class _OfOrder(Event):
    order: int


@frozen
class OrderArrived(_OfOrder):
    """An order has arrived: it is in the backlog, unless the stock cannot serve it yet."""


@frozen
class OrderInStock(_OfOrder):
    """An order that had to wait for stock has joined the backlog: the pods hold enough for all its lines now."""


@frozen
class OrderCancelled(_OfOrder):
    """An order of which nothing was assigned has left: the backlog, or the orders that wait for stock."""


@frozen
class OrderAssigned(Event):
    """Lines of an order became requests at a station (one part). ``complete``: no line is left in the backlog."""

    order: int
    station: int
    skus: tuple[int, ...]
    items: int
    period: int
    complete: bool


@frozen
class TripDecided(Event):
    """A pod is bound for a station from now on."""

    pod: int
    station: int


@frozen
class TaskAssigned(Event):
    """A robot was given the task to fetch a pod."""

    robot: int
    pod: int


@frozen
class RobotMoved(Event):
    """A robot finished one leg: stood ``wait_ticks``, turned for ``turn_ticks``, drove straight, and rests at ``to``.

    ``start_tick`` is the start of the wait; the run takes what is left of the time. ``heading`` is the heading after
    the turn: 0 east, 1 north, 2 west, 3 south. ``pod`` is what the robot carries, or None. A leg that ``run.until_s``
    cuts off is told at that time: ``to`` is the last cell whose centre the robot has passed, at speed.
    """

    start_tick: int
    robot: int
    origin: int
    to: int
    heading: int
    wait_ticks: int
    turn_ticks: int
    distance_m: int
    pod: int | None


@frozen
class PodLifted(Event):
    """A robot has lifted a pod at its storage location (a cell)."""

    start_tick: int
    robot: int
    pod: int
    cell: int


@frozen
class PodStored(Event):
    """A robot has set a pod down at a storage location (a cell) and is idle."""

    start_tick: int
    robot: int
    pod: int
    cell: int


@frozen
class QueueJoined(Event):
    """A pod arrived at a station's queue; its position in the line is fixed."""

    robot: int
    pod: int
    station: int


@frozen
class VisitStarted(Event):
    """A pod stands at the station cell: one pod-station visit. ``visit`` counts up over the run from 1."""

    visit: int
    robot: int
    pod: int
    station: int


@frozen
class ItemPicked(Event):
    """An item was picked. The pick began at ``start_tick``; the picker handles the item until ``picker_free_tick``."""

    start_tick: int
    picker_free_tick: int
    visit: int
    station: int
    pod: int
    order: int
    sku: int


@frozen
class VisitEnded(Event):
    """A pod leaves the station cell. ``next_station`` is where the robot carries it on to, or None: to storage."""

    visit: int
    pod: int
    station: int
    picks: int
    next_station: int | None


@frozen
class OrderCompleted(_OfOrder):
    """The last item of an order was picked, or handled, as ``stations.release`` says."""


@frozen
class BundleArrived(Event):
    """A bundle, items of one SKU that are to be stored on one pod, waits to be assigned. Ids count up from 0."""

    bundle: int
    name: str
    sku: int
    items: int


@frozen
class BundleAssigned(Event):
    """A bundle is to be stored at a replenishment station."""

    bundle: int
    station: int


@frozen
class BundleBound(Event):
    """A bundle is to be stored on a pod, whose space it has from now on; the pod is bound for the bundle's station."""

    bundle: int
    pod: int


@frozen
class BundleStored(Event):
    """A bundle was stored on a pod, its items included in the pod's contents; that began at ``start_tick``."""

    start_tick: int
    visit: int
    station: int
    pod: int
    bundle: int
    sku: int
    items: int


@frozen
class _OfStation(Event):
    station: int


@frozen
class StationOpened(_OfStation):
    """A station takes orders from now on. Stations are open when a run starts, until the first events say otherwise."""


@frozen
class StationClosed(_OfStation):
    """A station takes no new orders from now on; it finishes its own."""


@frozen
class RobotsOnDuty(Event):
    """Robots 1 to ``number`` take tasks from now on, the others none. At first all do."""

    number: int


@frozen
class RobotSent(Event):
    """A robot without a task sets out for a cell to rest in."""

    robot: int
    cell: int


@frozen
class RobotRested(Event):
    """A robot that was sent to rest has come to a cell: where it was sent, unless it had to make way for another."""

    robot: int
    cell: int


@frozen
class PodMoveDecided(Event):
    """A robot was given the task to carry a stored pod to another storage location (a cell), without a visit."""

    robot: int
    pod: int
    cell: int


@frozen
class DecisionMade(Event):
    """A rule decided POA, PPS or both; ROA, RPS or both.

    Parameters
    ----------
    period
        Number of POA (or joint) calls so far, this one included; a PPS decision belongs to the period it follows.
    decides
        POA, PPS, or both; ROA, RPS, or both.
    backlog
        Orders in the backlog that the rule saw; bundles that wait, for ROA and RPS.
    assignments, trips
        How many of each the decision has; for trips of RPS, bundles that it put on pods.
    status, objective, bound, stopped_early
        As the rule reported (see `rmfs_core.SolveReport`); status ``"decided"`` for rules that report nothing.
    wall_s
        Wall-clock seconds the rule took. The one field that differs from run to run.
    """

    period: int
    decides: Role
    rule: str
    backlog: int
    assignments: int
    trips: int
    status: str
    objective: float | None
    bound: float | None
    stopped_early: bool
    wall_s: float
