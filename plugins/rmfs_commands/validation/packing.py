"""Packing: whose a box is, what totes take, and who packs when."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import Any

from attrs import Factory, define

from rmfs_commands.processes.events import (
    OrderConsolidated,
    OrderPacked,
    PackingAssigned,
    PackingStarted,
    PartArrived,
    PartPut,
    PartSent,
)
from rmfs_commands.processes.packing import task_ticks
from rmfs_commands.validation.case import Case, Handlers, seconds
from rmfs_commands.validation.tables import packing_hours
from rmfs_core.clock import to_ticks
from rmfs_core.events import BundleStored, ItemPicked, OrderAssigned, OrderCancelled, OrderCompleted
from rmfs_core.simulation.going import Going
from rmfs_core.warehouse import Warehouse
from rmfs_core.wording import counted


@define
class _Packed:
    """How far an order is: where it is bound for, what of it has come and is in its box, when packing began."""

    packing: int
    box: int | None
    come: int = 0
    in_box: int = 0
    consolidated: bool = False
    begun: int | None = None
    packed: bool = False


@define
class _Pick:
    """A pick of an order at a station: in which visit, when its order's capacity was freed, when it was handled."""

    visit: int
    released: int
    handled: int


@define
class _Station:
    """Parts of an order at a picking station: items that were assigned, by tick, picks, and items in totes."""

    assigned: list[tuple[int, int]] = Factory(list)
    picks: list[_Pick] = Factory(list)
    sent: int = 0


class PackingCheck:
    """A box is one order's, a tote takes as long as its conveyor, and nothing is packed before all of it is there."""

    def __init__(self, case: Case) -> None:
        self.case, self.section = case, case.trace.scenario.get("packing") or {}
        self.orders: dict[int, _Packed] = {}
        self.at: dict[tuple[int, int], _Station] = defaultdict(_Station)
        self.in_visit: dict[int, int] = {}  # when the last item of a visit was handled, or its last bundle stored
        self.boxes: dict[tuple[int, int], int] = {}
        self.counted: set[int] = set()
        self.cancelled: set[int] = set()
        self.totes: dict[int, PartSent] = {}
        self.come: dict[int, tuple[int, bool]] = {}  # when a tote came, and whether it was put
        self.puts: dict[int, int] = {}  # what putting it takes
        self.work: dict[tuple[int, str], list[tuple[int, int]]] = defaultdict(list)
        self.parts: dict[int, set[tuple[int, int]]] = defaultdict(set)
        self.open: dict[int, bool] = {}  # whether lines are left in the backlog
        self.known: dict[tuple[str, int], int] = {}  # ticks of what was under way in the state that the run begins in
        self.hours = packing_hours(case.trace)
        self.handlers: Handlers = {}
        if self.section:
            self.handlers = {
                OrderAssigned: self.assigned,
                ItemPicked: self.picked,
                BundleStored: lambda event: self.in_visit.update({event.visit: event.tick}),
                OrderCompleted: self.completed,
                OrderCancelled: lambda event: self.cancelled.add(event.order),
                PackingAssigned: self.bound,
                PartSent: self.sent,
                PartArrived: self.arrived,
                PartPut: self.put,
                OrderConsolidated: self.consolidated,
                PackingStarted: self.started,
                OrderPacked: self.packed,
            }

    def begin(self, warehouse: Warehouse, going: Sequence[Going], totes: int, puts_s: Mapping[str, float]) -> None:
        """Take note of how far orders are in a state, whose totes are so many, and what putting them takes."""
        now = self.case.trace.began
        self.totes = {tote: PartSent(now, 0, 0, 0, tote, 0) for tote in range(1, totes + 1)}
        self.puts = {int(tote): to_ticks(put_s) for tote, put_s in puts_s.items()}
        for order in warehouse.arrived.values():
            self.cancelled |= {order.id} if order.cancelled else set()
            self.parts[order.id] = {(part.station, part.period) for part in order.parts}
            self.open[order.id] = bool(order.open_lines)
            for part in order.parts:
                there, picked = self.at[order.id, part.station], part.items - part.unpicked_items
                there.assigned.append((-1, part.items))
                there.picks += [_Pick(0, now, now)] * picked
                there.sent += picked
            if (at := order.packing) is not None:
                whole = at.items_in_box == order.items
                own = _Packed(at.station, at.box, at.items_in_box, at.items_in_box, whole, None, at.packed)
                self.orders[order.id] = own
                if at.box is not None and not at.packed:
                    self.boxes[at.station, at.box] = order.id
                    self.counted |= {order.id} if self._has_box(order.complete) else set()
        visits = {one.robot: one.visit for one in going if one.visit and one.picks}
        at_work = {s.id: visits.get(s.line[0].id, -1 - s.id) if s.line else -1 - s.id for s in warehouse.stations}
        for one in going:  # what is in hand was picked last
            if one.kind == "release" and (held := warehouse.stations[one.station or 0].in_hand) is not None:
                there, visit = self.at[held[0], one.station or 0], at_work[one.station or 0]
                there.sent, there.picks[-1] = there.sent - 1, _Pick(visit, one.tick, one.tick)
                self.in_visit[visit] = one.tick
        for one in going:
            self._goes_on(one, at_work)
        for station in warehouse.packing:
            begun = [(task, task.since_s) for task in station.tasks]
            for task, since_s in begun + [(task, task.since_s) for task, _ in station.working]:
                if task.kind == "put":
                    self.come[task.tote] = to_ticks(since_s), False
                    self.totes[task.tote] = PartSent(now, task.order.id, station.id, 0, task.tote, task.items)
                if task.kind == "put" or task.order.packing is None or task.order.packing.box is None:
                    self.orders[task.order.id].come += task.items

    def _has_box(self, picked: bool) -> bool:
        """Whether an order that is not packed has its box."""
        return self.section["packing_from"] == "packed" or not picked

    def _goes_on(self, one: Going, at_work: Mapping[int, int]) -> None:
        """Take note of a tote on its way, or of a task at work."""
        number, at = one.order or 0, one.station or 0
        if one.kind == "tote":
            there, visit = self.at[number, at], at_work[at]
            there.sent -= one.items
            there.picks[there.sent : there.sent + one.items] = [_Pick(visit, one.tick, one.tick)] * one.items
            self.in_visit.setdefault(visit, one.tick)
        elif one.kind == "totes":
            self.in_visit[-1 - at] = one.tick
        elif one.kind == "conveyor":
            packing = self.orders[number].packing
            self.totes[one.tote] = PartSent(one.since, number, packing, 0, one.tote, one.items)
            self.known["conveyor", one.tote] = one.tick - one.since
        elif one.kind in ("put", "pack"):
            crew = "sorter" if one.kind == "put" and self.section["sorters"] else "packer"
            if one.kind == "pack":
                self.orders[number].begun = one.since
                self.known["pack", number] = one.tick - one.since
                self.work[at, crew].append((one.since, 1))
            else:
                self.puts[one.tote] = one.tick - one.since

    def _add(self, kind: str, event: Any, what: str) -> None:
        self.case.add(kind, event.tick, f"{self.case.order(event.order)} {what}")

    def assigned(self, event: OrderAssigned) -> None:
        """Note the part."""
        self.parts[event.order].add((event.station, event.period))
        self.open[event.order] = not event.complete
        self.at[event.order, event.station].assigned.append((event.tick, event.items))

    def picked(self, event: ItemPicked) -> None:
        """Note the pick."""
        released = event.picker_free_tick if self.case.keeps_places else event.tick
        self.at[event.order, event.station].picks.append(_Pick(event.visit, released, event.picker_free_tick))
        self.in_visit[event.visit] = event.picker_free_tick

    def completed(self, event: OrderCompleted) -> None:
        """Free a box, where it counts until the last pick."""
        if self.section["packing_from"] == "picked":
            self.counted.discard(event.order)

    def bound(self, event: PackingAssigned) -> None:
        """Check that an order is bound once, with its first part, and that a split one has a box to itself."""
        parts = self.parts[event.order]
        split = len(parts) > 1 or self.open.get(event.order, False)
        if event.order in self.orders or not parts:
            again = "again" if event.order in self.orders else "before a part of it is assigned"
            self._add("packing-bound", event, f"is bound for a packing station {again}")
        if (event.box is not None) != split:
            has = "has no box though it is split" if event.box is None else "has a box though it is not split"
            self._add("packing-bound", event, has)
        self.orders[event.order] = _Packed(event.packing, event.box)
        if event.box is None:
            return
        holder = self.boxes.get((event.packing, event.box))
        if holder is not None:
            self._add("box", event, f"gets box {event.box + 1}, which {self.case.order(holder)} has")
        self.boxes[event.packing, event.box] = event.order
        self.counted.add(event.order)
        there = sum(self.orders[order].packing == event.packing for order in self.counted)
        most, until = self.section["boxes"], self.section["packing_from"]
        if there > most or (until == "packed" and not 0 <= event.box < most):
            self._add("box", event, f"gets box {event.box + 1} of {most}, as one of {there} orders with boxes there")

    def _order(self, event: Any) -> _Packed:
        if event.order not in self.orders:
            self._add("packing-bound", event, "was bound for no packing station before")
        order = self.orders.setdefault(event.order, _Packed(event.packing, None))
        if order.packing != event.packing:
            where = f"packing station {order.packing + 1}, not for {event.packing + 1}"
            self._add("packing-bound", event, f"is bound for {where}")
        return order

    def sent(self, event: PartSent) -> None:
        """Check that a tote has what was picked, all of it, and leaves when the last item is handled."""
        order, part = self._order(event), self.at[event.order, event.station]
        if event.tote != len(self.totes) + 1:
            self._add("tote", event, f"is in tote {event.tote}; expected {len(self.totes) + 1}")
        self.totes[event.tote] = event
        picks = part.picks[part.sent : part.sent + event.items]
        before = part.sent
        part.sent += event.items
        if len(picks) < event.items or event.items < 1:
            self._add("tote", event, f"has {counted(event.items, 'item')} in a tote; {len(picks)} of them were picked")
            return
        by_visit = self.section["tote"] == "visit" and order.box is not None
        if by_visit:
            visit, leaves = picks[-1].visit, self.in_visit[picks[-1].visit]
            whole = {pick.visit for pick in picks} == {visit}
            whole &= sum(pick.visit == visit for pick in part.picks[: before + event.items + 1]) == event.items
        else:
            leaves = picks[-1].handled
            due = sum(items for tick, items in part.assigned if tick < picks[-1].released)
            whole = part.sent >= due
        if not whole or event.tick != leaves:
            which = "all of a visit" if by_visit else "all of a part"
            told = f"leaves {self.case.station(event.station)} in a tote with {counted(event.items, 'item')}"
            self._add("tote", event, f"{told}; expected {which}, at {seconds(leaves)}")

    def arrived(self, event: PartArrived) -> None:
        """Check that a tote has taken as long as its conveyor."""
        order, sent = self._order(event), self.totes.get(event.tote)
        if sent is None or event.tote in self.come or (sent.order, sent.items) != (event.order, event.items):
            items = counted(event.items, "item")
            self._add("conveyor-time", event, f"comes in tote {event.tote} with {items}, which was not sent")
            return
        self.come[event.tote] = event.tick, False
        self.puts[event.tote] = self._ticks("put", event.order, event.items)
        order.come += event.items
        taken, ticks = event.tick - sent.tick, self.known.pop(("conveyor", event.tote), None)
        ticks = self._conveyor(sent.station, event.packing) if ticks is None else ticks
        if taken != ticks:
            self._add("conveyor-time", event, f"is on a conveyor for {seconds(taken)}; expected {seconds(ticks)}")

    def _conveyor(self, picking: int, packing: int) -> int:
        speed, layout = self.section.get("conveyor_speed_m_per_s"), self.case.layout
        if speed is None:
            return to_ticks(self.section.get("conveyor_s", 60.0))
        return to_ticks(layout.distance(layout.stations[picking].station, layout.packing[packing]) / speed)

    def put(self, event: PartPut) -> None:
        """Check that a part is put once, after it has come, and in the time it takes."""
        order = self._order(event)
        since, done = self.come.get(event.tote, (event.tick + 1, False))
        if event.start_tick < since or done or order.box is None or self.totes[event.tote].items != event.items:
            why = "again" if done else "before it has come" if event.start_tick < since else "though it needs no box"
            self._add("put", event, f"is put into a box {why}, tote {event.tote} with {counted(event.items, 'item')}")
        if event.tick - event.start_tick != (ticks := self.puts.get(event.tote, 0)):
            took = f"{seconds(event.tick - event.start_tick)}; expected {seconds(ticks)}"
            self._add("put", event, f"is put into its box in {took}")
        self.come[event.tote] = since, True
        order.in_box += event.items
        crew = "sorter" if self.section["sorters"] else "packer"
        self._begins(event, crew, event.start_tick)
        self.work[event.packing, crew].append((event.tick, -1))

    def _items(self, order: int) -> int:
        return self.case.trace.instance.orders[order].items

    def consolidated(self, event: OrderConsolidated) -> None:
        """Check that all of a split order is in its box."""
        order = self._order(event)
        if order.in_box != self._items(event.order) or order.consolidated:
            self._add(
                "consolidated", event, f"is complete in its box with {order.in_box} of {self._items(event.order)}"
            )
        order.consolidated = True

    def started(self, event: PackingStarted) -> None:
        """Check that all of an order is there."""
        order, items = self._order(event), self._items(event.order)
        there = order.come if order.box is None else order.in_box if order.consolidated else 0
        if there != items:
            self._add("packed-early", event, f"is begun to be packed with {there} of {items} items there")
        if order.begun is not None:
            self._add("pack-time", event, "is begun to be packed again")
        order.begun = event.tick
        self._begins(event, "packer", event.tick)

    def packed(self, event: OrderPacked) -> None:
        """Check that packing took as long as it does; the box is free then."""
        order, ticks = self._order(event), self.known.pop(("pack", event.order), None)
        if ticks is None:
            ticks = self._ticks("pack", event.order, self._items(event.order))
        if order.packed or order.begun != event.start_tick or event.tick - event.start_tick != ticks:
            begun = "never" if order.begun is None else seconds(order.begun)
            told = f"is packed{' again' if order.packed else ''} from {seconds(event.start_tick)}"
            self._add("pack-time", event, f"{told}, begun {begun}; expected {seconds(ticks)} for it")
        order.packed = True
        self.counted.discard(event.order)
        if order.box is not None:
            self.boxes.pop((order.packing, order.box), None)
        self.work[event.packing, "packer"].append((event.tick, -1))

    def _ticks(self, kind: str, order: int, items: int) -> int:
        return task_ticks(self.case.services, self.case.packing, kind, order, items)

    def _begins(self, event: PartPut | PackingStarted, crew: str, start: int) -> None:
        if not self.hours[event.packing].at(start):
            self._add("packers", event, f"is begun at {seconds(start)}, while packers are closed")
        self.work[event.packing, crew].append((start, 1))

    def at_end(self) -> None:
        """Check that no more were at work than there are, and that a complete run has packed all it has."""
        for (packing, crew), changes in self.work.items():
            working, most = 0, self.section[f"{crew}s"]
            for tick, change in sorted(changes):
                working += change
                if working > most and tick >= self.case.trace.began:  # before that a state's packers were at work
                    told = f"{working} {crew}s are at work at packing station {packing + 1}; there are {most}"
                    self.case.add("packers", tick, told)
                    break
        left = (
            [i for i in range(len(self.case.trace.instance.orders)) if not self._is_packed(i)] if self.section else []
        )
        if left and self.case.trace.status == "complete":
            self.case.add("not-packed", self.case.trace.tick, f"{self.case.order(left[0])} is not packed at the end")

    def _is_packed(self, order: int) -> bool:
        return order in self.cancelled or (order in self.orders and self.orders[order].packed)

    @property
    def all_packed(self) -> bool:
        """Whether nothing is left to pack."""
        return not self.section or all(map(self._is_packed, range(len(self.case.trace.instance.orders))))
