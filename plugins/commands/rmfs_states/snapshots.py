"""The state of a running warehouse as JSON's objects, and what changes of it from one decision to the next."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import attrs

from rmfs_core.clock import to_seconds
from rmfs_core.warehouse import Order, Pod, Robot, Station, Warehouse
from rmfs_core.warehouse.parts import UNLIMITED
from rmfs_core.world import draw_map
from rmfs_states.patches import difference
from rmfs_states.state import FORMAT, VERSION

if TYPE_CHECKING:
    from rmfs_core.events import OrderAssigned
    from rmfs_core.info import RunInfo


PASSING = ("backlog", "random")
"""What belongs to one call of a rule, and need not be there at the next."""


class Snapshots:
    """Follows the state of a run.

    Orders are written when events tell of them, pods when something about them differs; stations and robots are few
    and looked at each time.

    Parameters
    ----------
    run
        The run before its first event.
    """

    def __init__(self, run: RunInfo) -> None:
        self._warehouse: Warehouse = run.warehouse._state
        self._skus = run.instance.skus
        self._storage = frozenset(run.layout.storage_locations)
        self._orders: dict[str, Any] = {}
        self._pods: dict[int, tuple[object, ...]] = {}
        warehouse = self._warehouse
        self.state: dict[str, Any] = {
            "format": FORMAT,
            "version": VERSION,
            "time_s": to_seconds(warehouse.now),
            "skus": list(run.instance.skus),
            "layout": {"map": draw_map(run.layout).splitlines()},
            "motion": attrs.asdict(run.motion),
            "pods": self._changed_pods(),
            "stations": {station.name: self._station(station) for station in warehouse.stations},
            "orders": {},
            "robots": {robot.name: self._robot(robot) for robot in warehouse.robots},
            "waiting": [pod.name for pod in warehouse.waiting.values()],
            "empty_pods": list(warehouse.blocked),
            "reserved": [],
            "seed": run.scenario.seed,
        }
        """The state as it was last looked at."""

    def order_arrived(self, order: int) -> None:
        """Take in an order."""
        self._write_order(self._warehouse.orders[order], [])

    def order_assigned(self, event: OrderAssigned) -> None:
        """Take in a part of an order; what one period assigns to a station is one part, in however many steps."""
        order = self._warehouse.orders[event.order]
        parts = [dict(part) for part in self._known(order)["parts"]]
        skus = [self._skus[sku] for sku in event.skus]
        part = {"station": self._warehouse.stations[event.station].name, "skus": skus, "period": event.period}
        same = [p for p in parts if (p["station"], p["period"]) == (part["station"], part["period"])]
        if same:
            same[0]["skus"] = [*same[0]["skus"], *skus]
        else:
            parts.append(part)
        self._write_order(order, parts)

    def look(self, call: Mapping[str, Any]) -> dict[str, Any]:
        """Look at the warehouse again; return the patch that leads there from the state before.

        Parameters
        ----------
        call
            What belongs to this call of a rule: ``ask``, and perhaps ``backlog`` and ``random``.
        """
        warehouse = self._warehouse
        whole = {
            "time_s": to_seconds(warehouse.now),
            "stations": {station.name: self._station(station) for station in warehouse.stations},
            "robots": {robot.name: self._robot(robot) for robot in warehouse.robots},
            "waiting": [pod.name for pod in warehouse.waiting.values()],
            "reserved": self._reserved(),
            **call,
        }
        patch = difference({key: self.state[key] for key in (*whole, *PASSING) if key in self.state}, whole)
        for key in PASSING:
            self.state.pop(key, None)
        self.state.update(whole)
        for section, changed in (("pods", self._changed_pods()), ("orders", self._orders)):
            before = self.state[section]
            if within := difference({name: before[name] for name in changed if name in before}, changed):
                patch[section] = within
            before.update(changed)
        self._orders = {}
        return patch

    def _known(self, order: Order) -> dict[str, Any]:
        known: dict[str, Any] = self._orders.get(order.name) or self.state["orders"][order.name]
        return known

    def _write_order(self, order: Order, parts: list[dict[str, Any]]) -> None:
        lines = {self._skus[line.sku]: line.quantity for line in order.lines}
        self._orders[order.name] = {"lines": lines, "arrival_s": order.arrival_s, "parts": parts}

    def _changed_pods(self) -> dict[str, Any]:
        """Return the pods that differ from what they were when last looked at."""
        changed = {}
        finite = not self._warehouse.unlimited_stock
        for pod in self._warehouse.pods:
            itinerary = pod._itinerary
            bound_for = tuple(itinerary) if len(itinerary) > 1 else None
            look = (pod._location, bound_for, tuple(pod._contents.values()) if finite else None)
            if self._pods.get(pod.id) != look:
                self._pods[pod.id] = look
                changed[pod.name] = self._pod(pod)
        return changed

    def _pod(self, pod: Pod) -> dict[str, Any]:
        items = {self._skus[sku]: None if n >= UNLIMITED else n for sku, n in pod.contents.items()}
        state: dict[str, Any] = {"contents": items, "home": self._warehouse.homes[pod.id]}
        if pod.location is not None:
            state["cell"] = pod.location
        if len(pod.bound_for) > 1:
            state["bound_for"] = [self._warehouse.stations[station].name for station in pod.bound_for]
        return state

    def _station(self, station: Station) -> dict[str, Any]:
        requests = []
        for request in station._requests.values():
            entry = {"order": request.order.name, "sku": self._skus[request.sku], "id": request.id}
            if request._pod is not None:
                entry["pod"] = request._pod.name
            requests.append(entry)
        return {
            "order_capacity" if station.counts_orders else "item_capacity": station.capacity,
            "queue_length": station.queue_length,
            "requests": requests,
            "inbound": [pod.name for pod in station._inbound.values()],
            "line": [self._warehouse.pods[pod].name for pod in station.pods_in_line],
            "queue_room": station.queue_room,
        }

    def _robot(self, robot: Robot) -> dict[str, Any]:
        state: dict[str, Any] = {"cell": robot.cell, "heading": robot.heading}
        if robot.task is not None:
            state["task"] = self._warehouse.pods[robot.task].name
        return state

    def _reserved(self) -> list[int]:
        warehouse = self._warehouse
        there = {pod._location for pod in warehouse.pods}
        return sorted(self._storage.difference(warehouse.free_locations, warehouse.blocked, there))
