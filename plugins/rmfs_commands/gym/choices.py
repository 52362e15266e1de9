"""Choices of a policy: the features of every candidate, which of them may be chosen, and what they stand for.

Each kind of choice has a fixed number of slots, each of which has a row of features. A slot that stands for nothing now
has a row of zeros and is masked out. Where a policy may wait, the last slot stands for that.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from itertools import chain
from numbers import Real
from types import MappingProxyType
from typing import Any

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from rmfs_core import InputError, rule_helpers
from rmfs_core.clock import TICKS_PER_S
from rmfs_core.roles import Role
from rmfs_core.warehouse import Order, Pod, Request, Robot, Station, WarehouseView
from rmfs_core.wording import raised, shown_short

_items_per_order: Any = rule_helpers.items_per_order
_sum_per_order: Any = rule_helpers.sum_per_order


@frozen
class Feature:
    """One column of an observation: a number from 0 to 1.

    Parameters
    ----------
    name
        For people and for code that looks a column up.
    text
        The quantity counted or measured.
    half
        For x without an upper bound, the x that is shown as 0.5: shown is x / (x + half). None: a share, as it is.
    of
        For a feature of one's own: the function that returns x, one number for all candidates, or one for each slot in
        the order of ``choice.options``. It is given the warehouse and the `Choice` with the features of `FEATURES`.
    """

    name: str
    text: str
    half: float | None = None
    of: Callable[[WarehouseView, Choice], Any] | None = None

    def __attrs_post_init__(self) -> None:
        half, of = self.half, self.of
        if half is not None and not (isinstance(half, Real) and 0 < half < math.inf):
            expected = "expected a number above 0, or None for a share"
            raise InputError(f"feature {self.name!r}: half", f"found {shown_short(half)}; {expected}")
        if of is not None and not callable(of):
            raise InputError(f"feature {self.name!r}: of", f"found {shown_short(of)}; expected a function")


_OF_ORDERS = (
    Feature("available", "items of the order on pods inbound to the station that no request was promised", 10),
    Feature("items", "open items of the order", 10),
    Feature("share", "share of these items that is available"),
    Feature("common", "share of the order's open lines whose SKU is wanted by an open request at the station"),
    Feature("waited", "seconds since the order arrived", 600),
    Feature("urgency", "600 / (600 + seconds until it is due); 1 when it is late, 0 without a due time"),
    Feature("load", "share of the station's capacity that is in use"),
    Feature("inbound", "pods at the station or bound for it", 10),
)
_OF_PODS = (
    Feature("serves", "requests of the station without a pod that the pod can serve", 10),
    Feature("completes", "orders at the station that then have a pod for every request", 10),
    Feature("wanted", "items on the pod that are wanted anywhere, as a share of those of the most wanted candidate"),
    Feature("drive", "seconds of driving to the station with the pod", 60),
    Feature("leaving", "1 for a pod that is about to leave a station, 0 for a stored one"),
    Feature("lacking", "requests of the station without a pod", 10),
    Feature("inbound", "pods at the station or bound for it", 10),
    Feature("idle", "share of the robots without a task"),
)
_OF_LOCATIONS = (
    Feature("drive", "seconds of driving there with the pod", 60),
    Feature("station", "seconds of driving from there to the nearest station with a pod", 60),
    Feature("home", "1 where the pod stood when the run started, 0 elsewhere"),
    Feature("wanted", "items on the pod that are wanted anywhere, as a share of those of the most wanted pod"),
    Feature("idle", "share of the robots without a task"),
)
_OF_ROBOTS = (
    Feature("drive", "seconds of driving to the pod without one", 60),
    Feature("carry", "seconds of driving from there to the station with the pod", 60),
    Feature("line", "robots at that station and in its queue", 10),
    Feature("waiting", "pods that wait for a robot", 10),
    Feature("idle", "share of the robots without a task"),
)
_OF_BOTH = (
    *_OF_ORDERS,
    Feature("pods", "pods that are sent to the station for the order", 1),
    Feature("further", "items of other orders that these pods have and no pod inbound to the station has", 10),
    Feature("drive", "seconds of driving to the station with the farthest of them", 60),
    Feature("used", "share of them that is bound for a station or carried already"),
    Feature("idle", "share of the robots without a task"),
)
FEATURES: Mapping[Role, tuple[Feature, ...]] = MappingProxyType(
    {
        Role.POA: _OF_ORDERS,
        Role.PPS: _OF_PODS,
        Role.PR: _OF_LOCATIONS,
        Role.TA: _OF_ROBOTS,
        Role.POA_PPS: _OF_BOTH,
    }
)
"""The columns of an observation, by what is decided."""

WAIT = Feature("wait", "1 for the slot that waits, 0 for the others")
"""The last column where a policy may wait."""


@frozen(eq=False)
class Choice:
    """One choice that a policy has to make.

    Parameters
    ----------
    decides
        Kind of the decision.
    observation
        Features (`FEATURES`) of each slot, float32, shape (slots, features).
    mask
        Which slots may be chosen, bool, shape (slots,).
    options
        Meaning of each slot that may be chosen: a pair of `Order` and `Station` (POA), a `Pod` (PPS), the cell
        of a storage location (PR), a `Robot` (TA), an `Order`, a `Station` and a tuple of `Pod` (POA+PPS); None for
        the slot that waits.
    subject
        For which `Station` a pod is chosen, or for which `Pod` a location or a robot; None for POA and POA+PPS.
    """

    decides: Role
    observation: NDArray[np.float32]
    mask: NDArray[np.bool_]
    options: Mapping[int, Any]
    subject: Station | Pod | None = None


@frozen
class Table:
    """How choices are shown: as a table of so many rows, with these columns.

    Parameters
    ----------
    orders_shown
        Of how many orders POA and POA+PPS choose: the oldest that fit anywhere.
    pods_shown
        In how many ways POA+PPS can serve an order at a station, each with another pod first.
    may_wait
        Whether a slot stands for waiting, where the decision allows it: not for PR.
    features
        Features of one's own.
    """

    orders_shown: int = 50
    pods_shown: int = 3
    may_wait: bool = False
    features: tuple[Feature, ...] = ()

    def __attrs_post_init__(self) -> None:
        if not isinstance(self.may_wait, bool):
            raise InputError("may_wait", f"found {shown_short(self.may_wait)}; expected True or False")
        names = {feature.name for feature in (*chain(*FEATURES.values()), WAIT)} if self.features else set[str]()
        for feature in self.features:
            if not isinstance(feature, Feature) or feature.of is None:
                expected = "expected `Feature`s with a function as `of`"
                raise InputError("features", f"found {shown_short(feature)}; {expected}")
            if feature.name in names:
                raise InputError("features", f"found a second feature {feature.name!r}; expected a name of its own")
            names.add(feature.name)

    def waits(self, decides: Role) -> bool:
        """Whether choices of a kind have a slot that waits: a pod that leaves a station has to go somewhere."""
        return self.may_wait and decides is not Role.PR

    def columns(self, decides: Role) -> tuple[Feature, ...]:
        """Return the features of a slot."""
        return (*FEATURES[decides], *self.features, *((WAIT,) if self.waits(decides) else ()))

    def slots(self, decides: Role, warehouse: WarehouseView) -> int:
        """Return how many slots a choice has: the same all through a run."""
        match decides:
            case Role.POA:
                slots = self.orders_shown * len(warehouse.stations)
            case Role.POA_PPS:
                slots = self.orders_shown * len(warehouse.stations) * self.pods_shown
            case Role.PPS:
                slots = len(warehouse.pods)
            case Role.PR:
                slots = len(warehouse.travel.layout.storage_locations)
            case _:
                slots = len(warehouse.robots)
        return slots + self.waits(decides)

    def nothing(self, decides: Role, warehouse: WarehouseView) -> Choice:
        """Return the choice in which no slot stands for anything: what is left when a run is over."""
        shape = self.slots(decides, warehouse), len(self.columns(decides))
        return Choice(decides, np.zeros(shape, np.float32), np.zeros(shape[0], np.bool_), {})

    def choice(
        self,
        decides: Role,
        warehouse: WarehouseView,
        options: Mapping[int, Any],
        values: Sequence[Any],
        subject: Station | Pod | None = None,
    ) -> Choice:
        """Return a choice from one value, or one for each option, of every feature of `FEATURES`."""
        at, own, waits = list(options), len(values), self.waits(decides)
        shown = np.empty((len(at), own))
        for column, value in enumerate(values):
            shown[:, column] = value
        squashed, half = _HALF[decides]
        shown[:, squashed] /= shown[:, squashed] + half
        slots = self.slots(decides, warehouse)
        observation = np.zeros((slots, own + len(self.features) + waits), np.float32)
        observation[at, :own] = shown
        mask = np.zeros(slots, np.bool_)
        mask[at] = True
        choice = Choice(decides, observation, mask, options, subject)
        constant = {i: shown[0, i] for i, value in enumerate(values) if np.ndim(value) == 0} if waits else {}
        for column, feature in enumerate(self.features, start=own):
            observation[at, column] = number = _of_ones_own(feature, warehouse, choice)
            if not number.ndim:
                constant[column] = float(number)
        if not waits or not _goes_on(warehouse):
            return choice
        for column, number in constant.items():  # what holds for all slots holds for the one that waits, too
            observation[-1, column] = number
        observation[-1, -1] = 1.0
        mask[-1] = True
        return Choice(decides, observation, mask, {**options, slots - 1: None}, subject)


PLAIN = Table()


_HALF = {
    decides: (
        np.array([i for i, feature in enumerate(features) if feature.half is not None]),
        np.array([feature.half for feature in features if feature.half is not None]),
    )
    for decides, features in FEATURES.items()
}


def _of_ones_own(feature: Feature, warehouse: WarehouseView, choice: Choice) -> NDArray[np.float64]:
    assert feature.of is not None, "Table has checked it"
    try:
        given, number = feature.of(warehouse, choice), len(choice.options)
    except Exception as error:
        raise ValueError(f"feature {feature.name!r}: raised {raised(error, feature.of)}") from error
    try:
        shown = np.asarray(given, np.float64)
        shown = shown if feature.half is None else shown / (shown + feature.half)
        right = shown.shape in ((), (number,)) and bool(((shown >= 0) & (shown <= 1)).all())
    except (TypeError, ValueError):
        right = False
    if not right:
        least = "of 0 to 1" if feature.half is None else "not below 0"
        expected = f"expected one number {least}, or one for each of {number} slots"
        raise ValueError(f"feature {feature.name!r}: returned {shown_short(given)}; {expected}")
    return shown


def _goes_on(warehouse: WarehouseView) -> bool:
    """Whether another decision is sure to come if nothing is decided now: some robot is at work."""
    return any(robot.task is not None for robot in warehouse.robots)


@frozen(eq=False)
class Pairs:
    """Pairs of an order and a station that fit, of the oldest orders that fit anywhere: the stations of each order.

    Parameters
    ----------
    orders
        The orders.
    row, station, at
        Of each pair the order's index in ``orders``, the station's id, and the order's position in the backlog.
    values
        Features of each pair, as POA has them.
    """

    orders: Sequence[Order]
    row: NDArray[np.int64]
    station: NDArray[np.int64]
    at: NDArray[np.int64]
    values: Sequence[NDArray[Any]]


def pairs_in(warehouse: WarehouseView, orders_shown: int) -> Pairs | None:
    """Return the pairs that fit; None where no order fits anywhere."""
    stations, backlog, lines = warehouse.stations, warehouse.backlog, warehouse.backlog_lines
    items = _items_per_order(warehouse)
    fits = _fitting(warehouse, items)
    shown = np.flatnonzero(fits.any(axis=1))[:orders_shown]
    if not len(shown):
        return None
    wanted = np.zeros((len(stations), warehouse.n_skus), np.int64)
    for station in stations:
        wanted[station.id, [request.sku for request in station.open_requests]] = 1
    orders = [backlog[position] for position in shown.tolist()]
    rows, columns = np.nonzero(fits[shown])
    at = shown[rows]
    available, common = (
        np.array([_sum_per_order(warehouse, of_line) for of_line in of_lines])[columns, at]
        for of_lines in (np.minimum(warehouse.available()[:, lines.sku], lines.quantity), wanted[:, lines.sku])
    )
    values = [
        available,
        items[at],
        available / items[at],
        common / _sum_per_order(warehouse, np.ones_like(lines.sku))[at],
        np.array([warehouse.now_s - order.arrival_s for order in orders])[rows],
        np.array([_urgency(order) for order in orders])[rows],
        np.array([station.load / station.capacity for station in stations])[columns],
        np.array([len(station.inbound_pods) for station in stations])[columns],
    ]
    return Pairs(orders, rows, columns, at, values)


def of_orders(warehouse: WarehouseView, table: Table = PLAIN) -> Choice | None:
    """Choose an order and its station; None where no order fits anywhere.

    Slots are pairs: of the oldest orders that fit anywhere each with every station, by id.
    """
    pairs = pairs_in(warehouse, table.orders_shown)
    if pairs is None:
        return None
    options = {
        row * len(warehouse.stations) + column: (pairs.orders[row], warehouse.stations[column])
        for row, column in zip(pairs.row.tolist(), pairs.station.tolist(), strict=True)
    }
    return table.choice(Role.POA, warehouse, options, pairs.values)


def _fitting(warehouse: WarehouseView, items: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return whether each order of the backlog fits each station now, as `WarehouseView.fits` does."""
    oversize = items > warehouse.largest_capacity
    fits = np.zeros((len(items), len(warehouse.stations)), np.bool_)
    for station in warehouse.stations:
        if station.counts_orders:
            sizes = np.array([not order.has_place_at(station.id) for order in warehouse.backlog], np.int64)
        else:
            sizes = np.where(oversize, station.capacity, items)
        fits[:, station.id] = sizes <= station.free_capacity
    return fits


def _urgency(order: Order) -> float:
    return 0.0 if (slack_s := order.slack_s) is None else 600 / (600 + max(slack_s, 0.0))


class PodChoices:
    """Choices of pods within one decision: those made so far take requests away. Slots are pods, by id.

    Parameters
    ----------
    warehouse
        The warehouse when the decision begins.
    table
        How the choices are shown.
    """

    def __init__(self, warehouse: WarehouseView, table: Table = PLAIN) -> None:
        self._warehouse, self._table = warehouse, table
        self._demand = warehouse.open_demand().tolist()
        self._lacking: dict[int, list[tuple[Request, int]]] = {}  # with the items that are left
        self._inbound = Counter({station.id: len(station.inbound_pods) for station in warehouse.stations})
        self._idle = idle_share(warehouse)

    def among(self, station: Station, pods: Sequence[Pod]) -> Choice:
        """Choose one of the pods for a station."""
        uncovered = [(request, request.items) for request in station.uncovered_requests]
        lacking = self._lacking.setdefault(station.id, uncovered)
        wanted = np.array([_wanted(pod, self._demand) for pod in pods])
        ticks = self._warehouse.travel.times_to(station.cell, True)[[pod.cell for pod in pods]].min(axis=1)
        served = np.array([_served(pod, lacking) for pod in pods])
        values = [
            *served.T,
            wanted / max(int(wanted.max()), 1),
            ticks / TICKS_PER_S,
            [pod.location is None for pod in pods],
            sum(items for _, items in lacking),
            self._inbound[station.id],
            self._idle,
        ]
        return self._table.choice(Role.PPS, self._warehouse, {pod.id: pod for pod in pods}, values, station)

    def take(self, station: Station, pod: Pod) -> None:
        """Take note that a pod was chosen for a station."""
        free = {sku: pod.free_items(sku) for sku in pod.contents}
        left = []
        for request, items in self._lacking[station.id]:
            taken = max(min(items, free.get(request.sku, 0)), 0)
            if taken:
                free[request.sku] -= taken
            if taken < items:
                left.append((request, items - taken))
        self._lacking[station.id] = left
        self._inbound[station.id] += 1


def _served(pod: Pod, lacking: Sequence[tuple[Request, int]]) -> tuple[int, int]:
    """Return how many items a pod can serve, oldest first, and how many orders lack nothing then."""
    free = {sku: pod.free_items(sku) for sku in {request.sku for request, _ in lacking} & pod.contents.keys()}
    served, lack = 0, dict.fromkeys([request.order.id for request, _ in lacking], 0)
    for request, items in lacking:
        taken = max(min(items, free.get(request.sku, 0)), 0)
        if taken:
            free[request.sku] -= taken
        served += taken
        lack[request.order.id] += items - taken
    return served, sum(not number for number in lack.values())


def of_locations(warehouse: WarehouseView, pod: Pod, table: Table = PLAIN) -> Choice:
    """Choose the storage location that a pod goes back to. Slots are the storage locations, by cell index."""
    locations = warehouse.travel.layout.storage_locations
    free = np.array(warehouse.free_storage_locations)
    slots = np.searchsorted(locations, free)
    assert pod.robot is not None, "the pod is being carried"
    drive = warehouse.travel.times_from(pod.cell, warehouse.robots[pod.robot].heading, True)[free]
    to_station = np.min(
        [warehouse.travel.times_to(station.cell, True)[free].min(axis=1) for station in warehouse.stations], axis=0
    )
    items, demand = warehouse.free_items, warehouse.open_demand()
    wanted = np.bincount(items.pod, weights=np.minimum(demand[items.sku], items.number), minlength=len(warehouse.pods))
    values = [
        drive / TICKS_PER_S,
        to_station / TICKS_PER_S,
        free == warehouse.home(pod),
        wanted[pod.id] / max(wanted.max(), 1.0),
        idle_share(warehouse),
    ]
    options = dict(zip(slots.tolist(), free.tolist(), strict=True))
    return table.choice(Role.PR, warehouse, options, values, pod)


def of_robots(warehouse: WarehouseView, pod: Pod, robots: Sequence[Robot], table: Table = PLAIN) -> Choice:
    """Choose the robot that fetches a pod. Slots are the robots, by id."""
    travel, station = warehouse.travel, warehouse.station(pod.bound_for[0])
    times = travel.times_to(pod.cell, False)
    values = [
        [times[robot.cell, robot.heading] / TICKS_PER_S for robot in robots],
        int(travel.times_to(station.cell, True)[pod.cell].min()) / TICKS_PER_S,
        len(station.line),
        len(warehouse.waiting_pods),
        idle_share(warehouse),
    ]
    return table.choice(Role.TA, warehouse, {robot.id: robot for robot in robots}, values, pod)


def _wanted(pod: Pod, demand: Sequence[int]) -> int:
    return sum(min(demand[sku], items) for sku, items in pod.contents.items())


def idle_share(warehouse: WarehouseView) -> float:
    """Return the share of the robots without a task."""
    return len(warehouse.idle_robots) / len(warehouse.robots)
