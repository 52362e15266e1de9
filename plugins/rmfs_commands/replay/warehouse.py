"""The warehouse in a recorded run, apart from robots on their way: told from its events, first to last."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from itertools import accumulate
from typing import Any

from rmfs_commands.replay.columns import KINDS
from rmfs_commands.replay.reading import Replay, picked_before

_KINDS = tuple(KINDS.values())


class WarehouseAt:
    """The warehouse at a time, which goes on only.

    Parameters
    ----------
    replay
        The run.

    Attributes
    ----------
    pod_cell, robot_pod, busy, moving
        Cell of each pod that is stored, pod of each robot that carries one, robots that have a task, and of them those
        that carry a pod elsewhere without a visit.
    open
        Items of each order that are to be picked at each station.
    bundles
        Bundles that are to be stored at each station, and whether their pods are known.
    closed
        Stations that take no orders.
    robots_down, chargers_down
        Robots out of service, and cells of chargers that are.
    backlog, done, picks
        Orders in the backlog and complete, and items picked.
    """

    def __init__(self, replay: Replay) -> None:
        start = replay.start
        self._replay = replay
        self._contents = [dict(pod.contents) for pod in start.instance.pods]
        self._demand: Counter[int] = Counter()
        for _, sku, items in picked_before(start):
            self._demand[sku] -= items
        self._events = replay.columns.events
        self._ticks = {kind: list(accumulate(columns["tick"])) for kind, columns in self._events.items()}
        self._next = 0
        self._seen: Counter[str] = Counter()
        self._picks: list[list[tuple[int, int]]] = [[] for _ in start.stations]
        self._note_picks()
        self.pod_cell = {i: pod["cell"] for i, pod in enumerate(start.pods) if pod["robot"] is None}
        self.robot_pod = {pod["robot"]: i for i, pod in enumerate(start.pods) if pod["robot"] is not None}
        self.busy = set(self.robot_pod)
        self.moving: set[int] = set()
        self.bundles: list[dict[int, bool]] = [{} for _ in start.stations]
        self.closed: set[int] = set()
        self.robots_down: set[int] = set()
        self.chargers_down: set[int] = set()
        self.open: list[Counter[int]] = [Counter() for _ in start.stations]
        self.tick = self.backlog = self.done = self.picks = 0
        self._handlers: dict[str, Callable[[Mapping[str, Any], int], None]] = {
            "order_arrived": self._arrived,
            "order_assigned": self._assigned,
            "task_assigned": lambda e, i: self.busy.add(e["robot"][i]),
            "pod_move_decided": self._moves,
            "robot_sent": lambda e, i: self.busy.add(e["robot"][i]),
            "robot_rested": lambda e, i: self.busy.discard(e["robot"][i]),
            "pod_lifted": self._lifted,
            "pod_stored": self._stored,
            "item_picked": self._picked,
            "order_completed": self._completed,
            "order_cancelled": self._cancelled,
            "bundle_assigned": lambda e, i: self.bundles[e["station"][i]].update({e["bundle"][i]: False}),
            "bundle_bound": self._bound,
            "bundle_stored": self._bundle_stored,
            "station_opened": lambda e, i: self.closed.discard(e["station"][i]),
            "station_closed": lambda e, i: self.closed.add(e["station"][i]),
            "robot_up": lambda e, i: self.robots_down.discard(e["robot"][i]),
            "robot_down": lambda e, i: self.robots_down.add(e["robot"][i]),
            "charger_up": lambda e, i: self.chargers_down.discard(e["cell"][i]),
            "charger_down": lambda e, i: self.chargers_down.add(e["cell"][i]),
        }

    def go(self, tick: int) -> None:
        """Go on to a time."""
        order = self._replay.columns.order
        while self._next < len(order):
            kind = _KINDS[order[self._next]]
            i = self._seen[kind]
            if self._ticks[kind][i] > tick:
                break
            if handler := self._handlers.get(kind):
                handler(self._events[kind], i)
            self._seen[kind] += 1
            self._next += 1
        self.tick = tick

    def open_items(self, pod: int) -> int:
        """Return how many items on a pod orders wait for that have arrived."""
        return sum(
            self._demand[sku] if number is None else min(self._demand[sku], number)
            for sku, number in self._contents[pod].items()
        )

    def is_picking(self, station: int) -> bool:
        """Whether a station's picker handles an item, or stores a bundle."""
        picks = self._picks[station]
        while picks and picks[-1][1] <= self.tick:
            picks.pop()
        return bool(picks) and picks[-1][0] <= self.tick

    def _note_picks(self) -> None:
        """Note begin and end of each pick, and of storing each bundle, last one first."""
        for kind in ("item_picked", "bundle_stored"):
            columns, ticks = self._events[kind], self._ticks[kind]
            later = columns.get("picker_free_tick") or [0] * len(ticks)
            for i, tick in enumerate(ticks):
                self._picks[columns["station"][i]].append((tick - columns["start_tick"][i], tick + later[i]))
        for picks in self._picks:
            picks.sort(reverse=True)

    def _arrived(self, event: Mapping[str, Any], i: int) -> None:
        self._demand.update(dict(self._replay.start.instance.orders[event["order"][i]].lines))
        self.backlog += 1

    def _assigned(self, event: Mapping[str, Any], i: int) -> None:
        self.open[event["station"][i]][event["order"][i]] += event["items"][i]
        self.backlog -= event["complete"][i]

    def _cancelled(self, event: Mapping[str, Any], i: int) -> None:
        self._demand.subtract(dict(self._replay.start.instance.orders[event["order"][i]].lines))
        self.backlog -= 1

    def _lifted(self, event: Mapping[str, Any], i: int) -> None:
        self.pod_cell.pop(event["pod"][i], None)
        self.robot_pod[event["robot"][i]] = event["pod"][i]

    def _moves(self, event: Mapping[str, Any], i: int) -> None:
        self.busy.add(event["robot"][i])
        self.moving.add(event["robot"][i])

    def _bound(self, event: Mapping[str, Any], i: int) -> None:
        for bundles in self.bundles:
            if event["bundle"][i] in bundles:
                bundles[event["bundle"][i]] = True

    def _bundle_stored(self, event: Mapping[str, Any], i: int) -> None:
        del self.bundles[event["station"][i]][event["bundle"][i]]
        contents, sku = self._contents[event["pod"][i]], event["sku"][i]
        if contents.get(sku, 0) is not None:  # None: it never runs out
            contents[sku] = contents.get(sku, 0) + event["items"][i]

    def _stored(self, event: Mapping[str, Any], i: int) -> None:
        self.robot_pod.pop(event["robot"][i], None)
        self.busy.discard(event["robot"][i])
        self.moving.discard(event["robot"][i])
        self.pod_cell[event["pod"][i]] = event["cell"][i]

    def _picked(self, event: Mapping[str, Any], i: int) -> None:
        station, order, sku, pod = (event[name][i] for name in ("station", "order", "sku", "pod"))
        self.open[station][order] -= 1
        self.open[station] += Counter()  # without those of which nothing is left
        self._demand[sku] -= 1
        self.picks += 1
        before = self._replay.start.state is not None and self._ticks["item_picked"][i] <= self._replay.start.began
        if not before and (number := self._contents[pod].get(sku)):  # else the state has what is left
            self._contents[pod][sku] = number - 1

    def _completed(self, event: Mapping[str, Any], i: int) -> None:  # noqa: ARG002
        self.done += 1
