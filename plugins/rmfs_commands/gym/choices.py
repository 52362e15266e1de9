"""Choices of a policy: the features of every candidate, which of them may be chosen, and what they stand for.

Each kind of choice has a fixed number of slots, each of which has a row of features. A slot that stands for nothing now
has a row of zeros and is masked out.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from rmfs_core import rule_helpers
from rmfs_core.clock import TICKS_PER_S
from rmfs_core.roles import Role
from rmfs_core.warehouse import Order, Pod, Request, Robot, Station, WarehouseView

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
    """

    name: str
    text: str
    half: float | None = None


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
FEATURES: Mapping[Role, tuple[Feature, ...]] = MappingProxyType(
    {Role.POA: _OF_ORDERS, Role.PPS: _OF_PODS, Role.PR: _OF_LOCATIONS, Role.TA: _OF_ROBOTS}
)
"""The columns of an observation, by what is decided."""


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
        of a storage location (PR), a `Robot` (TA).
    subject
        For which `Station` a pod is chosen, or for which `Pod` a location or a robot; None for POA.
    """

    decides: Role
    observation: NDArray[np.float32]
    mask: NDArray[np.bool_]
    options: Mapping[int, Any]
    subject: Station | Pod | None = None


def slots_of(decides: Role, warehouse: WarehouseView, orders_shown: int) -> int:
    """Return how many slots a choice has: the same all through a run."""
    match decides:
        case Role.POA:
            return orders_shown * len(warehouse.stations)
        case Role.PPS:
            return len(warehouse.pods)
        case Role.PR:
            return len(warehouse.travel.layout.storage_locations)
        case _:
            return len(warehouse.robots)


def nothing(decides: Role, slots: int) -> Choice:
    """Return the choice in which no slot stands for anything: what is left when a run is over."""
    return _choice(decides, slots, {}, [0.0] * len(FEATURES[decides]))


def of_orders(warehouse: WarehouseView, orders_shown: int) -> Choice | None:
    """Choose an order and its station; None where no order fits anywhere.

    Slots are pairs: of the oldest orders that fit anywhere each with every station, by id.
    """
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
    options = {
        row * len(stations) + column: (orders[row], stations[column])
        for row, column in zip(rows.tolist(), columns.tolist(), strict=True)
    }
    return _choice(Role.POA, orders_shown * len(stations), options, values)


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
    """

    def __init__(self, warehouse: WarehouseView) -> None:
        self._warehouse = warehouse
        self._demand = warehouse.open_demand().tolist()
        self._lacking: dict[int, list[tuple[Request, int]]] = {}  # with the items that are left
        self._inbound = Counter({station.id: len(station.inbound_pods) for station in warehouse.stations})
        self._idle = _idle(warehouse)
        self._pods = len(warehouse.pods)

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
        return _choice(Role.PPS, self._pods, {pod.id: pod for pod in pods}, values, station)

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


def of_locations(warehouse: WarehouseView, pod: Pod) -> Choice:
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
        _idle(warehouse),
    ]
    options = dict(zip(slots.tolist(), free.tolist(), strict=True))
    return _choice(Role.PR, len(locations), options, values, pod)


def of_robots(warehouse: WarehouseView, pod: Pod, robots: Sequence[Robot]) -> Choice:
    """Choose the robot that fetches a pod. Slots are the robots, by id."""
    travel, station = warehouse.travel, warehouse.station(pod.bound_for[0])
    times = travel.times_to(pod.cell, False)
    values = [
        [times[robot.cell, robot.heading] / TICKS_PER_S for robot in robots],
        int(travel.times_to(station.cell, True)[pod.cell].min()) / TICKS_PER_S,
        len(station.line),
        len(warehouse.waiting_pods),
        _idle(warehouse),
    ]
    return _choice(Role.TA, len(warehouse.robots), {robot.id: robot for robot in robots}, values, pod)


def _wanted(pod: Pod, demand: Sequence[int]) -> int:
    return sum(min(demand[sku], items) for sku, items in pod.contents.items())


def _idle(warehouse: WarehouseView) -> float:
    return len(warehouse.idle_robots) / len(warehouse.robots)


_HALF = {
    decides: (
        np.array([i for i, feature in enumerate(features) if feature.half is not None]),
        np.array([feature.half for feature in features if feature.half is not None]),
    )
    for decides, features in FEATURES.items()
}


def _choice(
    decides: Role,
    slots: int,
    options: Mapping[int, Any],
    values: Sequence[Any],
    subject: Station | Pod | None = None,
) -> Choice:
    """Return a choice from one value, or one for each option, of every feature."""
    at = list(options)
    shown = np.empty((len(at), len(values)))
    for column, value in enumerate(values):
        shown[:, column] = value
    squashed, half = _HALF[decides]
    shown[:, squashed] /= shown[:, squashed] + half
    observation = np.zeros((slots, len(values)), np.float32)
    observation[at] = shown
    mask = np.zeros(slots, np.bool_)
    mask[at] = True
    return Choice(decides, observation, mask, options, subject)
