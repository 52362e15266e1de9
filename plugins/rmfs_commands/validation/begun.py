"""A run that begins in a state: the state of the header, opened as a run opens it, and all checks at that moment."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import chain
from typing import Any

from attrs import evolve

from rmfs_commands.processes.events import StationDown
from rmfs_commands.trace.reader import Trace
from rmfs_commands.validation.case import Case
from rmfs_commands.validation.lines import LineCheck
from rmfs_commands.validation.orders import DecisionCheck, OrderCheck
from rmfs_commands.validation.outages import OutageCheck
from rmfs_commands.validation.packing import PackingCheck
from rmfs_commands.validation.picking import PickCheck
from rmfs_commands.validation.pods import PodCheck
from rmfs_commands.validation.replenishing import BundleCheck
from rmfs_commands.validation.state import State, Visit
from rmfs_commands.validation.stock import StockCheck
from rmfs_core import events
from rmfs_core.errors import InputError
from rmfs_core.events import Event
from rmfs_core.scenario import scenario_from_dict
from rmfs_core.simulation.setup import begin
from rmfs_core.world import Instance

FOLLOWED = (
    *(events.TaskAssigned, events.PodMoveDecided, events.RobotSent, events.RobotRested, events.VisitStarted),
    *(events.StationClosed, events.RobotsOnDuty, StationDown),
)
"""Events of the time before that tell checks what robots and stations are at; of all else the state tells more."""


def opened(trace: Trace, instance: Instance | None = None) -> Any:
    """Return what a run begins in, as its header has it; None where it begins at time 0.

    Parameters
    ----------
    trace
        The trace.
    instance
        The scenario's own; None: that of the header.

    Raises
    ------
    InputError
        When no run can begin in the state of the header.
    """
    if trace.state is None:
        return None
    scenario = scenario_from_dict(trace.scenario, name="header of the trace")
    return begin(scenario, instance or trace.instance, trace.layout, trace.state["content"])


def opening_of(case: Case) -> tuple[Any, Trace]:
    """Return what a run begins in, and its trace from then on; add faults where it tells of another past."""
    trace, begun, told = case.trace, None, list[Event]()
    try:
        begun = opened(trace)
    except InputError as error:
        raise InputError("header of the trace, state", str(error)) from error
    if begun is None:
        return None, trace
    begun.tell(told.append)
    found = trace.events[: len(told)]
    for one, expected in zip(found, told, strict=False):
        if one != expected:
            kind = f"{type(one).__name__} at {one.tick / 1000:.3f} s"
            case.add("header", one.tick, f"{kind} is not what the state tells of the time before")
            break
    if begun.opening.warehouse.now != trace.began or len(found) < len(told):
        case.add("header", trace.began, "the state of the header is of another time than the trace begins at")
    return begun, evolve(trace, events=trace.events[len(told) :])


class Beginning:
    """Sets checks to the moment in which a run begins.

    Parameters
    ----------
    case, state
        The case, and where everything is.
    begun
        Opening of the run: warehouse, processes under way, and robots' stories.
    """

    def __init__(self, case: Case, state: State, begun: Any) -> None:
        self.case, self.state, self.begun = case, state, begun
        self.warehouse, self.now = begun.opening.warehouse, case.trace.began
        self.doing = {one.robot: one for one in begun.going if one.robot is not None}
        self._robots()
        self._stations()
        self._orders()
        services, drawn = case.services, begun.state.run.drawn if begun.decided else {}
        for what, number in drawn.items():
            services.begun[tuple(int(one) if one.isdecimal() else one for one in what.split(" "))] = number
        for one in begun.going:  # of which the seed is asked when it is over
            if one.kind in ("lift", "set"):
                services.begun[(self.warehouse.robots[one.robot].task,)] -= 1

    def _robots(self) -> None:
        for robot, own in zip(self.warehouse.robots, self.state.robots, strict=True):
            one = self.doing.get(robot.id)
            if one is not None and not one.visit:
                own.free_tick = one.since if self.begun.decided else self.warehouse.now
            own.task = robot.task
            if robot.task is not None:
                self.state.pods[robot.task].fetched_by = robot.id
            if own.pod is not None:
                own.lifted_at = own.cell
                queue = [own.cell in cells.queue for cells in self.case.layout.stations]
                in_line = any(robot in station.line for station in self.warehouse.stations)
                own.lane = queue.index(True) if any(queue) and not in_line else None
        for pod, kept in zip(self.warehouse.pods, self.state.pods, strict=True):
            kept.bound = [(station, at - len(pod.bound_for)) for at, station in enumerate(pod.bound_for)]
            kept.next_station = None
        for robot, (story, *what) in self.begun.stories.items():
            if story == "store" and self.state.robots[robot].pod is not None:
                self.state.pods[what[0].id].to_storage = True

    def _stations(self) -> None:
        releases = {one.station: one.tick for one in self.begun.going if one.kind == "release"}
        for station, own in zip(self.warehouse.stations, self.state.stations, strict=True):
            own.line = [robot.id for robot in station.line]
            first = self.doing.get(station.line[0].id) if station.line else None
            at_work = first is not None and first.kind in ("pick", "stow")
            own.picker_free_tick = first.since if at_work and first else self.warehouse.picker_free(station)
            own.load = station.load
            own.open = Counter()
            for request in station.open_requests:
                own.open[request.sku] += request.items
            if station.in_hand is not None:
                own.in_hand = [(*station.in_hand, releases[station.id])]

    def _orders(self) -> None:
        held = Counter(station.in_hand for station in self.warehouse.stations if station.in_hand is not None)
        asked: Counter[tuple[int, int]] = Counter()
        for station in self.warehouse.stations:
            for request in station.open_requests:
                asked[request.order.id, request.sku] += request.items
        for order in self.warehouse.arrived.values():
            own = self.state.orders[order.id]
            own.arrived, own.waits, own.cancelled = True, order.waits_for_stock, order.cancelled
            own.completed = order.complete and not order.cancelled
            own.unassigned = {} if order.cancelled else {line.sku: line.quantity for line in order.open_lines}
            own.unpicked = {sku: own.unassigned.get(sku, 0) + asked[order.id, sku] for sku, _ in order.lines}
            own.in_hand = sum(held[order.id, sku] for sku, _ in order.lines)
            own.begun_tick = order.arrival_tick if order.parts else None
            quantity, there = dict(order.lines), set[int]()
            for part in order.parts:
                key = part.station, part.period
                own.part_of |= dict.fromkeys(part.skus, key)
                if left := part.unpicked_items + sum(held[order.id, sku] for sku in part.skus):
                    counts = self.case.trace.stations[part.station]["counts_orders"]
                    own.left[key] = left
                    own.size[key] = int(part.station not in there) if counts else sum(quantity[s] for s in part.skus)
                    there.add(part.station)

    def of_lines(self, lines: LineCheck) -> None:
        """Set visits: their number, and picks in those under way."""
        lines.visits = self.begun.visits
        if not self.begun.decided:
            lines.visits = 0
        for robot, one in self.doing.items():
            at = next((s for s in self.state.stations if s.visit is not None and s.visit.robot == robot), None)
            if at is not None and isinstance(at.visit, Visit):
                at.visit.picks = one.picks

    def of_pods(self, pods: PodCheck) -> None:
        """Set where pods are carried that are carried elsewhere."""
        stories = self.begun.stories.values()
        pods.bring({what[0].id: what[1] for story, *what in stories if story == "move"})

    def of_picks(self, picks: PickCheck) -> None:
        """Set what was drawn, and how long picks take that are under way."""
        told, names = self.begun.state.run, self.begun.names
        drawn = {} if told is None else told.drawn
        last = {} if told is None else {names.stations[name]: tuple(ids) for name, ids in told.begun.items()}
        under_way = {}
        for one in self.begun.going:
            if one.kind == "pick":
                at = next(s for s in self.warehouse.stations if s.line and s.line[0].id == one.robot)
                under_way[at.id] = [one.tick - one.since, self.warehouse.picker_free(at) - one.since]
        keys = {tuple(map(int, what.split(" "))): n for what, n in drawn.items() if what[0].isdecimal()}
        picks.begin(keys, last, under_way)

    def of_orders(self, orders: OrderCheck, decisions: DecisionCheck) -> None:
        """Set the number of orders that have come, of those that wait, and of periods."""
        arrived = [order for order in self.warehouse.arrived.values() if not order.cancelled]
        orders.come = len(self.warehouse.arrived)
        orders.waiting = sum(bool(order.open_lines) for order in arrived)
        decisions.period = self.begun.periods
        decisions.backlog, decisions.bundles = len(self.warehouse.backlog), len(self.warehouse.bundles)

    def of_stock(self, stock: StockCheck) -> None:
        """Set what orders have claimed, and which wait."""
        claims, waiting = stock.claims, self.warehouse.claims
        for order in self.warehouse.arrived.values():
            if not order.waits_for_stock and not order.cancelled:
                for sku, items in self.state.orders[order.id].unpicked.items():
                    claims.left[sku] -= items
        for order in () if waiting is None else sorted(waiting.waiting.values(), key=lambda one: one.arrival_tick):
            claims.wait(order.id)

    def of_bundles(self, bundles: BundleCheck) -> None:
        """Set bundles that are there, and that are on order."""
        there = [*self.warehouse.bundles.values(), *chain(*(one.bundles for one in self.warehouse.storing))]
        ordered = [(one.tick, one.sku, one.items) for one in self.begun.going if one.kind == "bundle"]
        wanting = [order for order in self.warehouse.arrived.values() if order.waits_for_stock]
        bundles.begin(self.now, there, self.warehouse.bundles_so_far, ordered, [order.id for order in wanting])

    def of_packing(self, packing: PackingCheck) -> None:
        """Set how far orders are to be packed."""
        if self.warehouse.packing:
            told = self.begun.state.run
            totes = max([0 if told is None else told.totes, *(task.tote for task in self._tasks())])
            packing.begin(self.warehouse, self.begun.going, totes, {} if told is None else told.puts_s)

    def of_outages(self, outages: OutageCheck) -> None:
        """Set when all fails next, and what is out of service."""
        told = self.begun.state.run
        charging = {one.robot for one in self.begun.going if one.kind == "charge"}
        outages.begin(self.warehouse, None if told is None else told.outages, charging)

    def _tasks(self) -> Sequence[Any]:
        working = [task for station in self.warehouse.packing for task, _ in station.working]
        return [*chain(*(station.tasks for station in self.warehouse.packing)), *working]
