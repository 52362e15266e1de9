"""The simulation: robots, stations and arrivals as simpy processes that read like the story they tell."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterable, Iterator
from itertools import groupby
from operator import itemgetter
from pathlib import Path
from typing import Any

import simpy

from rmfs_core import events
from rmfs_core.clock import to_ticks
from rmfs_core.decisions import JointDecision
from rmfs_core.entrypoints import format_module, process
from rmfs_core.errors import StandstillError, refusing
from rmfs_core.info import RunInfo
from rmfs_core.rules import RuleSet
from rmfs_core.scenario import Scenario, located
from rmfs_core.simulation.context import RunContext
from rmfs_core.simulation.driving.base import Process
from rmfs_core.simulation.driving.free import FreeDriving
from rmfs_core.simulation.going import Going
from rmfs_core.simulation.rounds import Decisions
from rmfs_core.simulation.setup import open_warehouse, unmet_needs
from rmfs_core.warehouse import Bundle, Order, Pod, Request, Robot, Station
from rmfs_core.warehouse.promises import next_request
from rmfs_core.world import Instance, Layout

MOST_ALARMS = 100_000
"""Rounds in a row that rules may wake up for: once a second for a day. More, and they wait for what never happens."""


class Simulation:
    """One run.

    Parameters
    ----------
    scenario
        Stations, robots, rules and limits.
    instance
        Orders, pods, SKUs.
    layout
        The grid.
    rules
        The selected rules, with all observers registered.
    out
        The folder of the results; None where none are kept.
    begun
        State that the run begins in, as the process ``state`` makes it; None: at time 0, with nothing begun.
    """

    def __init__(
        self,
        scenario: Scenario,
        instance: Instance,
        layout: Layout,
        rules: RuleSet,
        out: Path | None = None,
        begun: Any = None,
    ) -> None:
        with located(scenario):
            for rule in rules.deciding:
                for problem in unmet_needs(rule, f"rules.{rule.role.key}", scenario, instance):
                    raise problem
            opening = open_warehouse(scenario, instance, layout) if begun is None else begun.opening
            for rule in rules.deciding:  # what they have compiled is loaded now, so that no decision's time has it in
                with refusing(f"rules.{rule.role.key}", f"{rule.describe()}, prepare:"):
                    rule.prepare(opening.warehouse.travel)
        self.context = RunContext(scenario, rules, opening.warehouse, begun=begun is not None)
        start, self.stories = self._starting, dict[int, tuple[Any, ...]]()
        starts = start("transport"), start("move"), start("rest")
        self.decisions = Decisions(self.context, *starts, self._assigned)
        self.driving = (rules.pp.traits.way or FreeDriving)(self.context)
        # Short names for what the processes use
        self.scenario, self.rules, self.warehouse = scenario, rules, opening.warehouse
        self.env, self.view, self._tell = self.context.env, self.context.view, self.context.tell
        self.motion = opening.warehouse.travel.motion
        self.services, self.hours = opening.services, opening.hours
        apart = rules.pp.traits.reserves is not None
        self.info = RunInfo(scenario, instance, layout, self.motion, self.view, out, apart)
        # What changes in the run, besides the warehouse
        self._at_stations = opening.at_stations
        self.waiting_for_slot: list[list[tuple[simpy.Event, Robot]]] = [[] for _ in self.warehouse.stations]
        self.visits = self.completed = 0
        coming = scenario.instance.arrivals.backlog is not None
        arrived = self.warehouse.arrived
        self._coming = [order for order in reversed(self.warehouse.orders) if coming and order.id not in arrived]
        robots, stations = scenario.robots, scenario.stations
        chargers = robots.battery and robots.battery.charger_outages
        fails = robots.failures or robots.maintenance or stations.outages or chargers
        self.outages = self._asked_for("outages", "robots.failures", fails)
        self.shifts = self._asked_for("hours", "stations.open", opening.hours)
        self.supply = self._asked_for("supply", "instance.replenishment", instance.restocked)
        self.packing = self._asked_for("packing", "packing", opening.warehouse.packing)
        self.status, self.started, self.interrupted, self._begun = "partial", False, False, begun
        self.at_horizon: Callable[[Simulation], None] = lambda _: None
        """Is called where ``run.until_s`` ends the run, before robots under way are put anywhere."""

    @property
    def now(self) -> int:
        """Simulated time in ticks."""
        return self.warehouse.now

    def start(self) -> None:
        """Place what is at the stations, tell the observers, and let everything begin at time 0, or go on."""
        placed = self._place_at_stations()
        self.context.observers.call("run_started", run=self.info)
        if self._begun is not None:
            self._begun.tell(self.context.tell)
        if self.shifts is not None:
            self.shifts.keep()
        if self._begun is not None:
            self._begun.resume(self)
            return
        self.driving.begin()
        for clock in self.clocks.values():
            self.env.process(clock())
        for robot, pod in placed:  # after the first round: a pod leaves only when that found nothing for it
            self.env.process(self.visit_stations(robot, pod))

    @property
    def clocks(self) -> dict[str, Callable[[], Process]]:
        """Processes that go on whatever robots do, in the order in which they begin."""
        found = {} if self.shifts is None else {"hours": self.shifts.follow}
        found |= {} if self.outages is None else {"outages": self.outages.follow}
        found["arrivals"] = self._arrivals
        return found if self.supply is None else found | {"bundles": self.supply.follow}

    def run(self) -> None:
        """Simulate until every order is complete (and packed), ``run.until_s`` is reached, or somebody interrupts.

        Raises
        ------
        RunError
            When a rule misbehaves, or orders are left and nothing will ever happen again.
        """
        self.start()
        self.started = True
        until, decisions = self.scenario.run.until_s, self.decisions
        end = math.inf if until is None else to_ticks(until) + 1
        orders, warehouse, peek, step = len(self.warehouse.orders), self.warehouse, self.env.peek, self.env.step
        while self.completed < orders and not self.interrupted:
            if (upcoming := peek()) > warehouse.now:
                if upcoming >= end or decisions.alarms_in_a_row > MOST_ALARMS:
                    if upcoming == math.inf or decisions.alarms_in_a_row > MOST_ALARMS:
                        raise self.standstill()
                    warehouse.advance(int(end) - 1)
                    self.at_horizon(self)
                    self.driving.cut_off()
                    self.status = "horizon"
                    return
                warehouse.advance(upcoming)  # type: ignore[arg-type]  # a whole number of ticks
            step()
        self.status = "complete" if self.completed == orders else "partial"

    def notes(self) -> Iterator[str]:
        """Yield sentences on what may be a surprise at the end of a run that is not complete."""
        found: Iterator[str] = format_module("endings").notes(self.warehouse, self.hours, self.info.instance.skus)
        return found

    def standstill(self) -> StandstillError:
        """Return the error of a run in which nothing will ever happen again."""
        return StandstillError(format_module("endings").standstill(self.warehouse, self.rules, self.info.instance.skus))

    # Processes

    def _arrivals(self) -> Process:
        """Orders join the backlog, at their times or when it has a gap, or are cancelled; a round runs at the start."""
        orders = () if self._coming else self.warehouse.orders
        given, there = zip(orders, self.info.instance.orders, strict=False), self.warehouse.arrived
        steps = [(order.arrival_tick, self._arrive, order) for order in orders if order.id not in there]
        steps += [(tick, self._cancel, order) for order, data in given if (tick := data.cancelled_tick) is not None]
        steps = [step for step in steps if step[0] > self.now or step[2].id not in there]
        steps.sort(key=itemgetter(0))  # what is cancelled when others arrive leaves after they came
        if self._begun is None or not self._begun.decided:
            self._refill()
            if not steps or steps[0][0] > self.now:
                self.decisions.round()
        for tick, now in groupby(steps, key=itemgetter(0)):
            if tick > self.now:
                yield self._until(tick, Going("arrivals"))
            changed = [step(order) for _, step, order in now]
            if any(changed):
                self.decisions.round()

    # A robot's story begins at the start, or with what was going on when a state was written

    def transport(self, robot: Robot, pod: Pod, going: Going | None = None) -> Process:
        """A robot's task: fetch a pod, carry it along its stations, and store it."""
        assert pod.location is not None
        if going is None:
            yield from self.driving.to_location(robot, pod.location)
            yield from self._take_slot(robot, self.warehouse.stations[pod.bound_for[0]])
        yield from self._lift(robot, pod, going)
        yield from self.visit_stations(robot, pod)

    def _lift(self, robot: Robot, pod: Pod, going: Going | None = None) -> Process:
        if going is None:
            going = Going("lift", robot.id, since=self.now, tick=self.now + self.services.lift(pod.id))
        yield self._until(going.tick, going)
        cell = robot.cell
        self.warehouse.lift(robot, pod)
        self._tell(events.PodLifted(tick=self.now, start_tick=going.since, robot=robot.id, pod=pod.id, cell=cell))

    def visit_stations(self, robot: Robot, pod: Pod, going: Going | None = None) -> Process:
        """Carry a pod along its stations, and store it."""
        station: Station | None = self.warehouse.stations[pod.bound_for[0]]
        while station is not None:
            yield from self.driving.to_station(robot, station)
            station = yield from self._serve(robot, pod, station, going)
            going = None
        yield from self._store(robot, pod)

    def _serve(
        self, robot: Robot, pod: Pod, station: Station, going: Going | None = None
    ) -> Generator[simpy.Event, Any, Station | None]:
        """Stand at the station while the pod serves requests there; return where the robot carries it on to."""
        if going is None:
            self.visits += 1
            at = Going("picker", robot.id, visit=self.visits)
            self._tell(events.VisitStarted(self.now, at.visit, robot=robot.id, pod=pod.id, station=station.id))
        else:
            at = going
        picks = at.picks
        while True:
            request = next_request(station, pod)
            if going is not None:
                request = next((one for one in station.open_requests if one.sku == going.sku), None)
            bundle = self.warehouse.next_bundle(station, pod) if request is None else None
            if request is not None:
                self.warehouse.promises.secure(request, pod)
            elif bundle is None:
                break
            at = Going("picker", robot.id, None, None if request is None else request.sku, visit=at.visit, picks=picks)
            if going is None or going.kind == "picker":
                if (free := self.warehouse.picker_free(station)) > self.now:
                    yield self._until(free, at)
                if not station.in_service:
                    yield self.outages.repaired(station, at)
                going = None
            if request is not None:
                picks += yield from self._pick(request, pod, station, at if going is None else going)
            elif bundle is not None:
                yield from self._store_bundle(bundle, pod, station, at if going is None else going)
            going = None
        following = self._leave(robot, pod, station)
        next_station = None if following is None else following.id
        self._tell(events.VisitEnded(self.now, at.visit, pod.id, station.id, picks, next_station))
        if self.packing is not None and picks:
            self.env.process(self.packing.visit_ended(station.id, self.warehouse.picker_free(station)))
        return following

    def _pick(self, request: Request, pod: Pod, station: Station, at: Going) -> Generator[simpy.Event, Any, int]:
        if at.kind != "pick":
            item = station.id, at.visit, request.order.id, request.sku
            pick_ticks, handle_ticks, expected = self.services.pick(*item, self.now)
            self.warehouse.occupy_picker(station, self.now + handle_ticks, self.now + expected)
            now, ends = self.now, self.now + pick_ticks
            at = Going("pick", at.robot, sku=at.sku, visit=at.visit, picks=at.picks, since=now, tick=ends)
        picker_free = self.warehouse.picker_free(station)
        yield self._until(at.tick, at)
        self.warehouse.fulfil(request, pod, handled=False)
        picked = request.order.id, request.sku
        self._tell(events.ItemPicked(self.now, at.since, picker_free, at.visit, station.id, pod.id, *picked))
        if self.supply is not None:
            self.supply.item_picked(request.sku)
        if self.scenario.stations.release == "handled":
            self.release_later(request, at._replace(kind="release", robot=None, station=station.id, tick=picker_free))
            self.decisions.round()
        else:
            self._release(request, picker_free)
        return 1

    def _store_bundle(self, bundle: Bundle, pod: Pod, station: Station, at: Going) -> Process:
        if at.kind != "stow":
            ticks, expected = self.services.store(station.id, bundle.id, self.now)
            self.warehouse.occupy_picker(station, self.now + ticks, self.now + expected)
            at = at._replace(kind="stow", since=self.now, tick=self.now + ticks)
        yield self._until(at.tick, at)
        served = self.warehouse.store_bundle(bundle, pod)
        stored = at.since, at.visit, station.id, pod.id, bundle.id, bundle.sku, bundle.items
        self._tell(events.BundleStored(self.now, *stored))
        self._in_stock(served)
        self.decisions.round()

    def release_later(self, request: Request, going: Going) -> None:
        """Free the capacity of an item when it is handled."""
        self._until(going.tick, going).callbacks.append(lambda _: self._release(request, going.tick))

    def _release(self, request: Request, handled_tick: int) -> None:
        """Free the capacity of an item that is done; its pod may be gone."""
        self.warehouse.release(request)
        if request.order.complete:
            self.completed += self.packing is None
            self._tell(events.OrderCompleted(tick=self.now, order=request.order.id))
        if self.packing is not None:
            self.packing.released(request, handled_tick)
        self.decisions.round()

    def _store(self, robot: Robot, pod: Pod) -> Process:
        cell = self.decisions.storage_location(pod)
        self.stories[robot.id] = "store", pod, cell
        yield from self.store(robot, pod, cell)

    def store(self, robot: Robot, pod: Pod, cell: int, going: Going | None = None) -> Process:
        """Carry a pod to its storage location."""
        yield from self._set_down(robot, pod, cell, going)
        self.decisions.round()

    def _set_down(self, robot: Robot, pod: Pod, cell: int, going: Going | None = None) -> Process:
        if going is None:
            yield from self.driving.to_location(robot, cell)
            going = Going("set", robot.id, since=self.now, tick=self.now + self.services.lift(pod.id))
        yield self._until(going.tick, going)
        self.warehouse.store(robot, pod)
        self._tell(events.PodStored(tick=self.now, start_tick=going.since, robot=robot.id, pod=pod.id, cell=robot.cell))
        self._is_free(robot)

    def move(self, robot: Robot, pod: Pod, cell: int, going: Going | None = None) -> Process:
        """Carry a stored pod elsewhere, without a visit. Whatever was decided for it in the meantime comes next."""
        if going is None and pod.location is not None:
            yield from self.driving.to_location(robot, pod.location)
        if pod.location is not None:
            yield from self._lift(robot, pod, going)
            going = None
        yield from self._set_down(robot, pod, cell, going)
        self.decisions.round(by_clock=True)

    def rest(self, robot: Robot, cell: int, share: float, going: Going | None = None) -> Process:
        """Drive to where the robot rests; at a charger it stays until its battery is as full as it shall be."""
        if going is None:
            if cell not in self.warehouse.reserved:  # else PR has chosen it at the same moment, and the robot stays
                yield from self.driving.to_location(robot, cell)
            self._tell(events.RobotRested(tick=self.now, robot=robot.id, cell=robot.cell))
            if self.outages is None and (ticks := self.warehouse.ticks_to_charge(robot, share)):
                going = Going("charge", robot.id, tick=self.now + ticks)
        if self.outages is not None:
            yield from self.outages.charge(robot, share, going)
        elif going is not None:
            yield self._until(going.tick, going)
        self.warehouse.send(robot, None)
        self._is_free(robot)
        self.decisions.round(by_clock=True)

    # Between the processes

    def _asked_for(self, name: str, place: str, wanted: object) -> Any:
        """Return a process of the run where the scenario has something for it to do, else None."""
        return process(name, place)(self) if wanted else None

    def send(self, robot: Robot, cell: int) -> None:
        """Send a robot without a task to where it is repaired, or charges on."""
        self.warehouse.send(robot, cell)
        self._tell(events.RobotSent(tick=self.now, robot=robot.id, cell=cell))
        self._starting("rest")(robot, cell, 0.0)

    def _is_free(self, robot: Robot) -> None:
        """Let a robot without a task be out of service, if it has failed or shall be maintained."""
        if self.outages is not None:
            self.outages.update(robot)

    def _arrive(self, order: Order) -> bool:
        self.warehouse.order_arrives(order, self.now)
        self._tell(events.OrderArrived(tick=self.now, order=order.id))
        if self.supply is not None and order.waits_for_stock:
            self.supply.order_waits(order.lines)
        return True

    def _cancel(self, order: Order) -> bool:
        """Let an order leave, and return True; but one that is begun is picked on."""
        if order.parts:
            return False
        if self.supply is not None and order.waits_for_stock:
            self.supply.waits_no_more(order.lines)
        served = self.warehouse.cancel(order)
        self.completed += 1
        self._tell(events.OrderCancelled(tick=self.now, order=order.id))
        self._in_stock(served)
        return True

    def _in_stock(self, served: Iterable[Order]) -> None:
        for order in served:
            if self.supply is not None:
                self.supply.waits_no_more(order.lines)
            self._tell(events.OrderInStock(tick=self.now, order=order.id))

    def _assigned(self, decision: JointDecision) -> None:
        """Let it be chosen where orders are packed that are begun, and orders arrive instead of assigned ones."""
        if self.packing is not None:
            self.packing.assigned(decision)
        self._refill()

    def _refill(self) -> None:
        """Let the next orders arrive where the backlog is to be kept filled."""
        claims = self.warehouse.claims
        there = len(self.warehouse.backlog) + (0 if claims is None else len(claims.waiting))
        wanted = self.scenario.instance.arrivals.backlog or 0
        for _ in range(min(wanted - there, len(self._coming))):
            self._arrive(self._coming.pop())

    def _starting(self, story: str) -> Callable[..., Any]:
        """Return what sets a robot off on a story."""

        def start(robot: Robot, *what: Any) -> None:
            self.stories[robot.id] = story, *what
            self.env.process(getattr(self, story)(robot, *what))

        return start

    def _place_at_stations(self) -> list[tuple[Robot, Pod]]:
        """Put the pods that are at a station from the start into its line, each on a robot."""
        placed = []
        for robot, (station_id, pod_id) in zip(self.warehouse.robots, self._at_stations, strict=False):
            station, pod = self.warehouse.stations[station_id], self.warehouse.pods[pod_id]
            self.warehouse.place_at_station(robot, pod, station)
            self.driving.place(robot, station)
            placed.append((robot, pod))
            self.stories[robot.id] = "transport", pod
        return placed

    def _take_slot(self, robot: Robot, station: Station) -> Process:
        """Wait for a slot at a station: a pod sets out only when the queue will have a cell for it."""
        if station.queue_room > 0:
            self.warehouse.claim_slot(station)
        else:
            handed_over = self.env.event()
            self.waiting_for_slot[station.id].append((handed_over, robot))
            yield handed_over

    def _leave(self, robot: Robot, pod: Pod, station: Station) -> Station | None:
        """Leave the station cell; return the next station, or None when the pod is to be stored.

        A pod goes on only when the next queue has a cell. Otherwise it is stored and fetched again later: no robot
        ever holds one slot while it waits for another, so full queues cannot block each other.
        """
        self.warehouse.leave(robot, pod, station)
        self.driving.left(station)
        if self.waiting_for_slot[station.id]:
            self.waiting_for_slot[station.id].pop(0)[0].succeed()  # the slot goes to the robot that has waited longest
        else:
            self.warehouse.give_up_slot(station)
        if not pod.bound_for or robot.low:
            return None
        following = self.warehouse.stations[pod.bound_for[0]]
        if following.queue_room <= 0:
            return None
        self.warehouse.claim_slot(following)
        return following

    def _until(self, tick: int, going: Going) -> simpy.Event:
        """Return what happens at a tick; a state tells of it as what is going on."""
        return self.context.after(tick - self.now, going)
