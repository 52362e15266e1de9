"""Packing, after the last pick: totes on conveyors, parts put into boxes, orders packed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import simpy
from attrs import evolve

from rmfs_commands.processes.events import (
    OrderConsolidated,
    OrderPacked,
    PackingAssigned,
    PackingStarted,
    PartArrived,
    PartPut,
    PartSent,
)
from rmfs_commands.processes.hours import timetables
from rmfs_core.clock import to_seconds, to_ticks
from rmfs_core.decisions import JointDecision
from rmfs_core.errors import InputError
from rmfs_core.scenario import Scenario
from rmfs_core.scenario.model import PackingSection
from rmfs_core.simulation import checks
from rmfs_core.simulation.applying import Keep
from rmfs_core.simulation.asking import ImpossibleError, sequence_of
from rmfs_core.simulation.context import RunContext
from rmfs_core.simulation.driving.base import Process
from rmfs_core.simulation.going import Going
from rmfs_core.simulation.services import Services
from rmfs_core.timetable import ALWAYS
from rmfs_core.warehouse import Order, PackingStation, PackingTask, Request, Warehouse
from rmfs_core.wording import counted
from rmfs_core.world import Layout


class Packing:
    """Conveyors and packing stations at work.

    Nothing here waits for a free box: an order that needs one has had it since its first part was assigned. And a
    conveyor holds any number of totes.

    Parameters
    ----------
    run
        The run, a `Simulation`.
    context
        Waits, asks and tells instead of ``run.context``.
    """

    @staticmethod
    def stations(scenario: Scenario, layout: Layout) -> list[PackingStation]:
        """Return the packing stations of a scenario, as `packing_of` does."""
        return packing_of(scenario, layout)

    def __init__(self, run: Any, context: RunContext | None = None) -> None:
        self._simulation, self._run = run, context or run.context
        self._warehouse, self._services = run.warehouse, run.services
        self._section = run.warehouse.packing[0].section
        self.totes: list[dict[Order, int]] = [{} for _ in run.warehouse.picking]  # how many items are in each so far
        self.number, self.puts = 0, dict[int, int]()  # totes sent, and what putting takes (ticks) of those that wait

    def assigned(self, decision: JointDecision) -> None:
        """Ask where orders are packed of which a decision has assigned the first part."""
        ids = dict.fromkeys(int(given.order) for given in decision.assignments)
        orders = tuple(order for order in map(self._warehouse.orders.__getitem__, ids) if order.packing is None)
        if orders and (rule := self._run.rules.packing) is not None:
            answer, _ = self._run.ask(rule, orders=orders)
            self._run.apply(rule, apply_packing, answer, orders=orders)

    def released(self, request: Request, handled_tick: int) -> None:
        """Put an item into its order's tote, which leaves with the last of its part once that is handled."""
        order, totes = request.order, self.totes[request.station]
        totes[order] = totes.get(order, 0) + 1
        if not (order.has_place_at(request.station) or (self._section.tote == "visit" and order.split)):
            self._run.env.process(self.send(order, totes.pop(order), request.station, handled_tick))

    def visit_ended(self, station: int, handled_tick: int) -> Process:
        """Let totes leave that take what is picked in one visit, once the last item of this one is handled."""
        yield self._until(handled_tick, Going("totes", station=station))
        totes = self.totes[station]
        for order in [order for order in totes if order.split and self._section.tote == "visit"]:
            self._run.env.process(self.send(order, totes.pop(order), station, handled_tick))

    def _until(self, tick: int, going: Going) -> simpy.Event:
        return self._run.after(tick - self._warehouse.now, going)

    def _ticks(self, kind: str, items: int) -> int:
        """Return what a task is expected to take."""
        base, each = _times(self._section, kind)
        return to_ticks(base + each * items)

    def send(self, order: Order, items: int, picking: int, handled_tick: int) -> Process:
        """Let a tote leave for its order's packing station, once its last item is handled."""
        yield self._until(handled_tick, Going("tote", station=picking, order=order.id, items=items))
        self.number += 1
        packing, tote, put = self._warehouse.packing_of(order), self.number, self._ticks("put", items)
        ticks = to_ticks(self._warehouse.packing[packing.station].conveyor_s[picking])
        packed = handled_tick + ticks + (0 if packing.box is None else put) + self._ticks("pack", order.items)
        expected_s = max(packing.expected_s or 0, to_seconds(packed))
        self._warehouse.pack(order, expected_s=expected_s)
        self._run.tell(PartSent(handled_tick, order.id, packing.station, picking, tote, items))
        yield from self.convey(order, items, tote, handled_tick, handled_tick + ticks)

    def convey(self, order: Order, items: int, tote: int, since: int, arrives: int) -> Process:
        """Take a tote to its order's packing station."""
        yield self._until(arrives, Going("conveyor", order=order.id, items=items, tote=tote, since=since))
        packing = self._warehouse.packing_of(order)
        if packing.first_part_s is None:
            self._warehouse.pack(order, first_part_s=to_seconds(self._warehouse.now))
        self.puts[tote] = task_ticks(self._services, self._section, "put", order.id, items)
        self._run.tell(PartArrived(self._warehouse.now, order.id, packing.station, tote, items))
        self._wait(order, "pack" if packing.box is None else "put", tote, items)

    def _wait(self, order: Order, kind: str, tote: int, items: int) -> None:
        """Let a task wait for a packer, one who is free if there is one."""
        at = self._warehouse.packing_of(order).station
        seconds, since_s = to_seconds(self._ticks(kind, items)), to_seconds(self._warehouse.now)
        task = PackingTask(kind, order, tote, items, seconds, since_s)
        self._change(at, tasks=(*self._warehouse.packing[at].tasks, task))
        self.begin_tasks(at)

    def _change(self, at: int, **changes: Any) -> None:
        self._warehouse.packing[at] = evolve(self._warehouse.packing[at], **changes)

    def begin_tasks(self, at: int) -> None:
        """Start waiting tasks with the free packers of a packing station; if it is closed, when it opens."""
        now = self._warehouse.now
        while (station := self._warehouse.packing[at]).hours.at(now) and (tasks := next_tasks(station)):
            task = self._chosen(station, tasks)
            working = (*station.working, (task, to_seconds(now) + task.duration_s))
            self._change(at, tasks=tuple(other for other in station.tasks if other is not task), working=working)
            self._run.env.process(self._work(at, task))
        if station.tasks and not station.hours.at(now) and (opens := station.hours.next_change(now)) is not None:
            self.open_later(at, opens)

    def open_later(self, at: int, tick: int) -> None:
        """Start waiting tasks when a packing station opens."""
        self._until(tick, Going("packers", station=at)).callbacks.append(lambda _: self.begin_tasks(at))

    def _chosen(self, station: PackingStation, tasks: Sequence[PackingTask]) -> PackingTask:
        if (rule := self._run.rules.packing_task) is None or len(tasks) == 1:
            return tasks[0]
        answer, _ = self._run.ask(rule, station=station, tasks=tasks)
        return self._run.asker.apply(rule, lambda: checks.known("task", answer, tasks))

    def _work(self, at: int, task: PackingTask) -> Process:
        """Put a part into its box, or pack an order."""
        start, order = self._warehouse.now, task.order
        if task.kind == "put":
            ticks = self.puts.pop(task.tote)
        else:
            ticks = task_ticks(self._services, self._section, "pack", order.id, task.items)
            self._warehouse.pack(order, expected_s=to_seconds(start + to_ticks(task.duration_s)))
            self._run.tell(PackingStarted(start, order.id, at))
        yield from self.work(at, task, start, start + ticks)

    def work(self, at: int, task: PackingTask, start: int, ends: int) -> Process:
        """Be at a task until it is done."""
        order = task.order
        yield self._until(ends, Going(task.kind, station=at, order=order.id, tote=task.tote, since=start))
        station, end = self._warehouse.packing[at], self._warehouse.now
        self._change(at, working=tuple(one for one in station.working if one[0] is not task))
        if task.kind == "pack":
            self._change(at, orders=tuple(other for other in station.orders if other is not order))
            self._warehouse.pack(order, packed=True)
            self._run.tell(OrderPacked(end, start, order.id, at))
            self._simulation.completed += 1
            if order.split and self._section.packing_from == "packed":  # a box that is free now may be decided on
                self._simulation.decisions.round()
        else:
            there = self._warehouse.packing_of(order).items_in_box + task.items
            self._warehouse.pack(order, items_in_box=there)
            self._run.tell(PartPut(end, start, order.id, at, task.tote, task.items))
            if there == order.items:
                self._run.tell(OrderConsolidated(end, order.id, at))
                self._wait(order, "pack", task.tote, order.items)
        self.begin_tasks(at)


def next_tasks(station: PackingStation) -> tuple[PackingTask, ...]:
    """Return tasks that a free packer or sorter of a packing station could begin now; none if nobody is free."""
    packers, sorters = station.section.packers, station.section.sorters
    if not sorters:
        return station.tasks if len(station.working) < packers else ()
    for number, kind in ((sorters, "put"), (packers, "pack")):
        tasks = tuple(task for task in station.tasks if task.kind == kind)
        if tasks and sum(task.kind == kind for task, _ in station.working) < number:
            return tasks
    return ()


def _times(section: PackingSection, kind: str) -> tuple[float, float]:
    """Return the seconds of a kind of task, items aside, and those for each item."""
    return (section.tote_s, section.put_s) if kind == "put" else (section.pack_s, section.pack_item_s)


def task_ticks(services: Services, section: PackingSection, kind: str, order: int, items: int) -> int:
    """Return the ticks of a packer's task: ``"put"`` the next tote of an order, of so many items, or ``"pack"``."""
    (base, each), number = _times(section, kind), services.begun[kind, order, 0]
    services.begun[kind, order, 0] += items
    total = services.draw(base, f"{kind} order", order, services.count(kind, order))
    if hasattr(each, "spread"):
        each, items = sum(services.draw(each, f"{kind} item", order, number + n) for n in range(items)), 1
    return to_ticks(total + each * items)


def apply_packing(warehouse: Warehouse, answer: object, *, orders: Sequence[Order], keep: Keep) -> None:
    """Bind orders for packing stations, split ones with a box there."""
    given = sequence_of(answer, object)
    if len(given) != len(orders):
        raise ImpossibleError(f"named packing stations: {len(given)}; expected {len(orders)}, one for each order")
    for order, named in zip(orders, given, strict=True):
        station = checks.known("packing station", named, warehouse.packing)
        if order.split and station.free_boxes <= 0:
            where = f"packing station {station.label}, where no box is free"
            raise ImpossibleError(f"sent split order {order.label} to {where}")
        keep(PackingAssigned(warehouse.now, order.id, station.id, warehouse.bind_packing(order, station)))


def packing_of(scenario: Scenario, layout: Layout) -> list[PackingStation]:
    """Return the packing stations of a scenario; InputError where they make no sense."""
    section, cells = scenario.packing, layout.packing
    if section is None:
        return []
    number, speed = section.stations or len(cells) or 1, section.conveyor_speed_m_per_s
    if cells and number != len(cells):
        found = f"found {number}, but the map has {counted(len(cells), 'packing station')} (`P`)"
        raise InputError("packing.stations", f"{found}; expected as many, or no number")
    if speed is not None and not cells:
        raise InputError("packing.conveyor_speed_m_per_s", "expected a map that says where packing stations are (`P`)")
    hours, fixed_s = timetables(scenario, "packing.open", section.open, number), section.conveyor_s
    for at, timetable in hours.items():
        if not timetable.spans:
            raise InputError("packing.open", f"found no span for station {(at or 0) + 1}; expected one that opens it")
    picking, stations = layout.stations[: len(layout.stations) - layout.replenishing], []
    for at in range(number):
        ways = [layout.distance(own.station, cells[at]) if cells else 0 for own in picking]
        seconds = tuple(way / speed if speed else 60.0 if fixed_s is None else fixed_s for way in ways)
        stations.append(PackingStation(at, section, cells[at] if cells else None, seconds, hours.get(at, ALWAYS)))
    return stations
