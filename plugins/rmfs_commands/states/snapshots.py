"""The state of a running warehouse as JSON's objects, and what changes of it from one decision to the next."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import attrs

from rmfs_commands.cli.map_drawing import draw_map
from rmfs_commands.processes.events import OrderPacked, PackingAssigned, PackingStarted, PartArrived, PartPut, PartSent
from rmfs_commands.states.answers import ARGUMENTS
from rmfs_commands.states.patches import difference
from rmfs_commands.states.plain import (
    BundleMemento,
    OrderMemento,
    PackingMemento,
    PodMemento,
    RobotMemento,
    StationMemento,
    TaskMemento,
)
from rmfs_commands.states.state import FORMAT, VERSIONS
from rmfs_core.clock import to_seconds
from rmfs_core.events import (
    BundleStored,
    Event,
    ItemPicked,
    OrderArrived,
    OrderAssigned,
    OrderCancelled,
    OrderInStock,
    PodLifted,
    PodStored,
    TripDecided,
    VisitEnded,
)
from rmfs_core.scenario.writing import plain
from rmfs_core.warehouse import UNLIMITED

if TYPE_CHECKING:
    from rmfs_core.info import Question, RunInfo


OF_ORDERS = (
    *(OrderArrived, OrderInStock, OrderAssigned, OrderCancelled),
    *(PackingAssigned, PartSent, PartArrived, PartPut, PackingStarted, OrderPacked),
)
"""Events that change an order."""
OF_PODS = (TripDecided, PodLifted, ItemPicked, BundleStored, VisitEnded, PodStored)
"""Events that change a pod."""
HEARD = (*OF_ORDERS, *OF_PODS)
"""Events that a state is followed by."""
PASSING = ("backlog", "random")
"""Keys that belong to one call of a rule, and need not be there at the next."""


def call_of(question: Question) -> dict[str, Any]:
    """Return the keys of a state that say what a rule is asked: ``ask``, and ``backlog`` where filters left orders out.

    Parameters
    ----------
    question
        Of one of the decisions that a state can be asked for (`rmfs_commands.states.state.DECIDING`).
    """
    given = question.arguments
    ask: dict[str, Any] = {"decides": question.decides.label, "period": question.period}
    ask |= {name: told(given[name]) for name, told in ARGUMENTS.items() if name in given}
    filtered = question.warehouse.filtered
    return {"ask": ask, **({"backlog": [order.name for order in question.warehouse.backlog]} if filtered else {})}


class Snapshots:
    """Follows the state of a run.

    Orders and pods are written when an event tells of them; stations and robots are few and looked at each time.

    Parameters
    ----------
    run
        The run before its first event.
    """

    def __init__(self, run: RunInfo) -> None:
        self._view = view = run.warehouse
        self._skus = run.instance.skus
        self._pods = [pod.name for pod in view.pods]
        self._at = (*view.stations, *(station for station in view.replenishment_stations if not station.picks))
        self._stations = [station.name for station in self._at]
        self._orders = {order.id: order.name for order in view.orders}
        self._dated, battery = False, run.scenario.robots.battery
        self._chargers_fail = battery is not None and battery.charger_outages is not None
        self._told_of_orders: dict[int, None] = {}
        self._told_of_pods: set[int] = set()
        self._last: dict[str, tuple[object, dict[str, Any]]] = {}
        self.state: dict[str, Any] = {
            "format": FORMAT,
            "version": VERSIONS[bool(view.replenishment_stations or view.packing_stations)],
            "time_s": view.now_s,
            "skus": list(run.instance.skus),
            "layout": {"map": draw_map(run.layout).splitlines()},
            "motion": attrs.asdict(run.motion),
            "pods": {pod.name: self._pod(PodMemento.of(pod, view.home(pod))) for pod in view.pods},
            "stations": self._look_at_stations(),
            "orders": {},
            "robots": {robot.name: self._robot(RobotMemento.of(robot)) for robot in view.robots},
            "waiting": [pod.name for pod in view.waiting_pods],
            "empty_pods": list(view.blocked_locations),
            "reserved": [],
            "seed": run.scenario.seed,
            **self._bundles(),
            **self._packing(),
        }
        if max(view.sizes, default=1) > 1:
            self.state["sizes"] = dict(zip(self._skus, view.sizes, strict=True))
        """The state as it was last looked at."""

    def told(self, event: Event) -> None:
        """Take note of the orders and pods that an event tells of."""
        if isinstance(event, OrderArrived):
            self._orders[event.order] = self._view.order(event.order).name
        if isinstance(event, OF_ORDERS):
            self._told_of_orders[event.order] = None
        elif isinstance(event, OF_PODS):
            self._told_of_pods.add(event.pod)

    def corrected(self, orders: Iterable[int], pods: Iterable[int]) -> None:
        """Take note of orders and pods that no event tells of."""
        self._told_of_orders.update(dict.fromkeys(orders))
        self._told_of_pods.update(pods)

    def forget(self, order: int) -> None:
        """Let an order be in the state no more."""
        self._told_of_orders.pop(order, None)
        self.state["orders"].pop(self._orders.pop(order), None)

    def look(self, call: Mapping[str, Any]) -> dict[str, Any]:
        """Look at the warehouse again; return the patch that leads there from the state before.

        Parameters
        ----------
        call
            Keys of this call of a rule: ``ask``, and perhaps ``backlog`` and ``random``.
        """
        view = self._view
        orders = [OrderMemento.of(view.order(order)) for order in self._told_of_orders]
        self._dated |= any(one.data.due_tick is not None or one.data.priority or one.cancelled for one in orders)
        stations = self._look_at_stations()
        robots = {robot.name: self._robot(RobotMemento.of(robot)) for robot in view.robots}
        later = self._dated or bool(view.replenishment_stations or view.packing_stations)
        later |= _needs_version_2(stations, robots) or self._chargers_fail
        whole = {
            "version": VERSIONS[later],
            "time_s": view.now_s,
            "stations": stations,
            "robots": robots,
            "waiting": [pod.name for pod in view.waiting_pods],
            "reserved": list(view.reserved_locations),
            **self._chargers_down(),
            **self._bundles(),
            **self._packing(),
            **call,
        }
        patch = difference({key: self.state[key] for key in (*whole, *PASSING) if key in self.state}, whole)
        for key in PASSING:
            self.state.pop(key, None)
        self.state.update(whole)
        pods = [view.pods[pod] for pod in sorted(self._told_of_pods)]
        for section, changed in (
            ("pods", {pod.name: self._pod(PodMemento.of(pod, view.home(pod))) for pod in pods}),
            ("orders", {order.data.name: self._order(order) for order in orders}),
        ):
            before = self.state[section]
            if within := difference({name: before[name] for name in changed if name in before}, changed):
                patch[section] = within
            before.update(changed)
        self._told_of_orders.clear()
        self._told_of_pods.clear()
        return patch

    def _order(self, order: OrderMemento) -> dict[str, Any]:
        parts = [
            {"station": self._stations[station], "skus": [self._skus[sku] for sku in skus], "period": period}
            for station, skus, period in order.parts
        ]
        lines = {self._skus[sku]: quantity for sku, quantity in order.data.lines}
        state: dict[str, Any] = {"lines": lines, "arrival_s": to_seconds(order.data.arrival_tick)}
        if order.data.due_tick is not None:
            state["due_s"] = to_seconds(order.data.due_tick)
        if order.cancelled:
            state["cancelled"] = True
        if self._view.replenishment_stations:
            state["waits_for_stock"] = bool(order.waits)
        packing = order.packing
        if packing is not None:
            told = {name: value for name, value in attrs.asdict(packing).items() if value is not None}
            state["packing"] = told | {"station": str(packing.station + 1)}
        return state | ({"priority": order.data.priority} if order.data.priority else {}) | {"parts": parts}

    def _packing(self) -> dict[str, Any]:
        """Return the packing stations, where there are some."""
        stations = [PackingMemento.of(station) for station in self._view.packing_stations]
        if not stations:
            return {}
        told = [
            {
                "orders": [self._orders[order] for order in station.orders],
                "tasks": [self._task(task) for task in station.tasks],
                "working": [self._task(task) for task in station.working],
                **({"zero_s": to_seconds(station.zero)} if station.zero else {}),
            }
            for station in stations
        ]
        return {"packing": {"section": plain(stations[0].section), "stations": told}}

    def _task(self, task: TaskMemento) -> dict[str, Any]:
        told = {name: value for name, value in task._asdict().items() if value is not None}
        return told | {"order": self._orders[task.order]}

    def _pod(self, pod: PodMemento) -> dict[str, Any]:
        state: dict[str, Any] = {"contents": {self._skus[sku]: n for sku, n in pod.data.contents}, "home": pod.home}
        if pod.cell is not None:
            state["cell"] = pod.cell
        if len(pod.bound_for) > 1:
            state["bound_for"] = [self._stations[station] for station in pod.bound_for]
        if pod.capacity < UNLIMITED:
            state["capacity"] = pod.capacity
        return state

    def _chargers_down(self) -> dict[str, list[int]]:
        """Return the chargers that are out of service, in a warehouse where some may be."""
        if not self._chargers_fail:
            return {}
        return {"chargers_down": [c for c in self._view.travel.layout.chargers if c not in self._view.chargers]}

    def _bundles(self) -> dict[str, Any]:
        """Return the bundles that are not stored, in a warehouse where some can be."""
        stations = self._view.replenishment_stations
        if not stations:
            return {}
        bundles = (*self._view.bundles, *(bundle for station in stations for bundle in station.bundles))
        return {"bundles": [self._bundle(BundleMemento.of(bundle)) for bundle in bundles]}

    def _bundle(self, bundle: BundleMemento) -> dict[str, Any]:
        state: dict[str, Any] = {"name": bundle.name, "sku": self._skus[bundle.sku], "items": bundle.items}
        state |= {"arrival_s": to_seconds(bundle.arrival_tick), "id": bundle.id}
        if bundle.station is not None:
            state["station"] = self._stations[bundle.station]
        return state if bundle.pod is None else {**state, "pod": self._pods[bundle.pod]}

    def _look_at_stations(self) -> dict[str, Any]:
        now = self._view.now_tick
        return {station.name: self._station(StationMemento.of(station, now)) for station in self._at}

    def _station(self, station: StationMemento) -> dict[str, Any]:
        last, written = self._last.get(station.name, (None, {}))
        if last == station:
            return written
        requests = []
        for number, order, sku, pod in station.requests:
            entry = {"order": self._orders[order], "sku": self._skus[sku], "id": number}
            if pod is not None:
                entry["pod"] = self._pods[pod]
            requests.append(entry)
        capacity = {"order_capacity" if station.counts_orders else "item_capacity": station.capacity}
        written = {
            **(capacity if station.picks else {}),
            **({"bundle_capacity": station.bundle_capacity} if station.bundle_capacity else {}),
            "queue_length": station.queue_length,
            "requests": requests,
            "inbound": [self._pods[pod] for pod in station.inbound],
            "line": [self._pods[pod] for pod in station.line],
            "queue_room": station.queue_room,
        }
        if station.in_hand is not None:
            order, sku = station.in_hand
            written["in_hand"] = {"order": self._orders[order], "sku": self._skus[sku]}
        written |= {key: False for key in ("staffed", "active", "in_service") if not getattr(station, key)}
        for key, tick in (("picker_free_s", station.picker_free), ("changes_s", station.changes)):
            if tick is not None:
                written[key] = to_seconds(tick)
        self._last[station.name] = station, written
        return written

    def _robot(self, robot: RobotMemento) -> dict[str, Any]:
        state: dict[str, Any] = {"cell": robot.cell, "heading": robot.heading}
        if robot.task is not None:
            state["task"] = self._pods[robot.task]
        told = {"goal": robot.goal, "charge": robot.charge, "low": int(robot.low) or None}
        state |= {name: value for name, value in told.items() if value is not None}
        return state | {key: False for key in ("on_duty", "in_service") if not getattr(robot, key)}


def _needs_version_2(stations: Mapping[str, Mapping[str, Any]], robots: Mapping[str, Mapping[str, Any]]) -> bool:
    """Whether stations or robots tell what version 1 does not know."""
    told = {key for one in (*stations.values(), *robots.values()) for key in one}
    return bool(told & {"in_hand", "picker_free_s", "staffed", "active", "changes_s", "on_duty", "in_service"})
