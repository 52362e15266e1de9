"""A run on a real floor: its stories wait for facts where the simulation waits for ticks."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterable, Sequence
from contextlib import suppress
from typing import Any

import simpy
from attrs import evolve, frozen

from rmfs_commands.processes.hours import Hours
from rmfs_commands.processes.supply import Bundles, bundle_arrives
from rmfs_commands.session.packing import FloorPacking
from rmfs_core.errors import InputError
from rmfs_core.events import Event, QueueJoined, RobotMoved
from rmfs_core.rules import RuleSet
from rmfs_core.scenario import RuleChoice, Scenario
from rmfs_core.scenario.model import RulesSection
from rmfs_core.simulation.driving.base import Driving, Process
from rmfs_core.simulation.engine import Simulation
from rmfs_core.simulation.going import Going
from rmfs_core.warehouse import Bundle, Order, Pod, Request, Robot, Station
from rmfs_core.world import Instance, Layout, OrderData

AWAITED = {
    "drive": "robot_at",
    "queue": "pod_at_station",
    "lift": "pod_lifted",
    "set": "pod_stored",
    "pick": "picked",
    "stow": "bundle_stored",
    "charge": "robot_charged",
    "picker": "handled",
    "release": "handled",
}
"""By what is going on, the fact that ends it."""

Picking = Generator[simpy.Event, Any, int]
Order_ = Callable[..., None]
"""Takes a command: its kind, and its fields."""


@frozen(eq=False)
class Wait:
    """A story that waits for a fact.

    Parameters
    ----------
    event
        Happens with the fact.
    since
        Tick at which it began.
    what
        The pod's or robot's goal cell, the station's id, the bundle's id, or the order and SKU, by kind.
    """

    event: simpy.Event
    since: int
    what: Any = None


class AbandonedError(Exception):
    """A story ends, for the fact that it waits for will not come."""


class AbortedError(Exception):
    """A visit goes on without the pick that its story waits for."""


class OrderBook(Sequence[Order]):
    """Orders by id, as if those that are forgotten were there: no id is given twice."""

    def __init__(self) -> None:
        self._known: dict[int, Order] = {}
        self._number = 0

    def __len__(self) -> int:
        return self._number

    def __getitem__(self, index: Any) -> Any:
        try:
            return self._known[index]
        except KeyError:
            raise IndexError(index) from None

    def append(self, order: Order) -> None:
        """Take in the next order."""
        self._known[self._number] = order
        self._number += 1

    def forget(self, number: int) -> None:
        """Forget an order."""
        del self._known[number]


class Arrived(dict[int, Order]):
    """Orders by id that are not forgotten; there are as many as have ever arrived (`WarehouseView.orders_since`)."""

    _number = 0

    def __setitem__(self, number: int, order: Order) -> None:
        self._number += number not in self
        super().__setitem__(number, order)

    def __len__(self) -> int:
        return self._number


class FloorDriving(Driving):
    """How robots get from place to place where they drive themselves."""

    def __init__(self, floor: Floor) -> None:
        super().__init__(floor.context)
        self._floor = floor

    def to_location(self, robot: Robot, cell: int) -> Process:
        """Wait until the robot is there."""
        if robot.cell != cell:
            yield self._floor.wait("drive", robot.id, cell)

    def to_station(self, robot: Robot, station: Station) -> Process:
        """Wait until the pod stands in front of the picker."""
        yield self._floor.wait("queue", robot.id, station.id)


class FloorHours(Hours):
    """Opening hours of a floor (`Floor`), some of whose stations are closed or open whatever these say."""

    def staffed(self, station: int) -> tuple[bool, int | None]:
        """Return whether a station is open now, and the tick at which that changes; None: when the floor says so."""
        staffed, until = super().staffed(station)
        if staffed:  # from now on its timetable says when it closes
            self._run.opened.discard(station)
        if station in self._run.closed or station in self._run.opened:
            return station in self._run.opened, None
        return staffed, until


class FloorBundles(Bundles):
    """Bundles of a floor (`Floor`): they are ordered by commands, and arrive as facts."""

    def follow(self) -> Process:
        """Order what has run low at the start."""
        self.restock(range(self._run.warehouse.n_skus))
        yield from ()

    def comes(self, going: Going) -> None:
        """Have a bundle brought."""
        self._run.command("reorder", sku=going.sku, items=going.items)


class Floor(Simulation):
    """The simulation's stories, rounds, checks and changes, with facts in place of durations.

    Parameters
    ----------
    scenario, instance, layout, rules
        As for a run; orders and bundles of the instance are left out, because they arrive as facts.
    command
        Takes each command: its kind and its fields, with ids.
    begun
        The state in which it begins; None: with nothing under way.

    Attributes
    ----------
    waits
        By kind (`AWAITED`) and id of the robot (of the station: ``release``), the stories that wait for a fact.
    wanted
        By robot, ids of the order and SKU to be picked from its pod; or None, and the bundle to be stored on it.
    """

    def __init__(
        self,
        scenario: Scenario,
        instance: Instance,
        layout: Layout,
        rules: RuleSet,
        command: Order_,
        begun: Any = None,
    ) -> None:
        check_supported(scenario)
        super().__init__(scenario, evolve(instance, orders=(), bundles=()), layout, rules, None, begun)
        self.waits: dict[tuple[str, int], Wait] = {}
        self.command = command
        self.wanted: dict[int, tuple[Any, Any]] = {}
        self._seen: dict[int, int] = {}  # by robot, when its cell was told last
        there, self.book, self.warehouse.arrived = self.warehouse.orders, OrderBook(), Arrived()
        for order in there:
            self.book.append(order)
            self.warehouse.arrived[order.id] = order
        self.warehouse.orders = self.book
        if self.packing is not None:
            self.packing = FloorPacking(self, command)
        self.shifts = None if self.shifts is None else FloorHours(self)
        self.supply = None if self.supply is None else FloorBundles(self)
        self.closed: set[int] = set()
        """Ids of stations that take no order, whatever their timetables say."""
        self.opened: set[int] = set()
        """Ids of stations that were opened outside of their hours, until these have them open."""
        self.driving = FloorDriving(self)
        self.context.after = self._after
        if rules.poa_pps is not None:  # it looks at no request that was covered once; this is asked where one is left
            repair = RulesSection(poa=RuleChoice("first-come"), pps=RuleChoice("demand"))
            self.decisions.rules = evolve(
                rules, others={**rules.others, "pps": RuleSet.load(repair, scenario.folder).pps}
            )

    def tell_through(self, changed: Callable[[Callable[[Event], None]], Callable[[Event], None]]) -> None:
        """Tell observers events as they are ``changed``: given how to tell one, that returns how to tell it instead."""
        context: Any = self.context
        context.tell = changed(context.tell)
        self._tell = context.tell

    # What the stories wait for

    def wait(self, kind: str, who: int, what: Any = None) -> simpy.Event:
        """Return what happens with the next fact of this kind about a robot or station."""
        self.waits[kind, who] = Wait(self.env.event(), self.now, what)
        return self.waits[kind, who].event

    def happens(self, kind: str, who: int) -> None:
        """Let a story go on that waits, as far as it does without another fact."""
        self.waits.pop((kind, who)).event.succeed()
        self.settle()

    def settle(self) -> None:
        """Let everything happen that takes no time."""
        while self.env.peek() <= self.now:
            self.env.step()

    def advance(self, tick: int) -> None:
        """Let the time be a tick, and what rules and timetables have set for until then happen, at its own time."""
        self.env.timeout(tick - int(self.env.now))  # so that the clock goes on until then
        while (upcoming := self.env.peek()) <= tick:
            self.warehouse.advance(int(upcoming))
            self.env.step()
        self.warehouse.advance(tick)
        for kind, at in self.waits:
            if kind == "release":
                self._keep_in_hand(self.warehouse.stations[at])

    def _keep_in_hand(self, station: Station) -> None:
        """Let no other item be begun before the one in hand is handled, however long that takes."""
        if self.warehouse.picker_free(station) <= self.now:
            self.warehouse.occupy_picker(station, self.now + 1, self.now)

    def picked(self, robot: Robot) -> None:
        """Let an item be picked from the pod that a robot holds in front of a picker, and be in hand."""
        self._keep_in_hand(next(station for station in self.warehouse.stations if robot in station.line[:1]))
        self.happens("pick", robot.id)

    def _after(self, ticks: int, going: Going | None = None) -> simpy.Event:
        if going is None or going.kind not in AWAITED:
            return self.env.timeout(ticks, going)
        who = going.station if going.kind == "release" else going.robot
        assert who is not None
        return self.wait(going.kind, who, going.tick)

    # Facts that begin something

    def add_order(self, data: OrderData) -> Order:
        """Let an order be there that has not arrived yet."""
        warehouse = self.warehouse
        order = Order(len(self.book), data, lambda: warehouse.now)
        self.book.append(order)
        return order

    def arrive(self, order: Order) -> None:
        """Let an order arrive, or wait for its turn where the backlog is to be kept filled; no round runs."""
        if self.scenario.instance.arrivals.backlog is None:
            self._arrive(order)
        else:
            self._coming.insert(0, order)

    def round(self) -> None:
        """Let rules decide."""
        self._refill()
        self.decisions.round()
        self.settle()

    def cancel(self, order: Order) -> bool:
        """Let an order leave, unless it is begun; no round runs."""
        return self._cancel(order)

    def bring(self, sku: int, items: int, name: str) -> None:
        """Let a bundle arrive."""
        bundle_arrives(self, sku, items, name)
        self.settle()

    def drive(self, robot: Robot, cell: int, heading: int, charge: float | None = None) -> None:
        """Let a robot be in a cell, with a share of its battery's capacity left."""
        origin, warehouse = robot.cell, self.warehouse
        in_line = any(robot in station.line for station in warehouse.stations)
        metres = warehouse.travel.layout.distance(origin, cell)
        warehouse.move(robot, cell, heading)
        if (battery := warehouse.battery_of(robot)) is not None and charge is not None:
            battery.joules, battery.since = charge * battery.capacity_j, self.now
        wait = self.waits.get(("drive", robot.id))
        on_its_way = wait or (None if in_line else self.waits.get(("queue", robot.id)))
        start = self.now if on_its_way is None else max(on_its_way.since, self._seen.get(robot.id, 0))
        self._seen[robot.id] = self.now
        self._tell(RobotMoved(self.now, start, robot.id, origin, cell, heading, 0, 0, metres, robot.pod))
        if wait is not None and wait.what == cell:
            self.happens("drive", robot.id)

    def charged(self, robot: Robot) -> None:
        """Let a robot be charged as far as it was to be, however long that would have taken, and go on."""
        battery, share = self.warehouse.battery_of(robot), self.stories[robot.id][2]
        if battery is not None and battery.ticks_to(share):
            battery.joules, battery.since = max(share * battery.capacity_j, battery.low_j), self.now
        self.happens("charge", robot.id)

    def queue(self, robot: Robot, station: Station) -> None:
        """Let a robot stand at the end of a line."""
        self.warehouse.join_line(robot, station)
        assert robot.pod is not None
        self._tell(QueueJoined(self.now, robot=robot.id, pod=robot.pod, station=station.id))

    def handled(self, station: Station) -> None:
        """Let the item in hand be handled, and the picker be free for the next."""
        self.warehouse.occupy_picker(station, self.now)
        if ("release", station.id) in self.waits:
            self.happens("release", station.id)
        if isinstance(self.packing, FloorPacking) and self.packing.happens("handled", station.id):
            self.settle()
        if station.line and ("picker", station.line[0].id) in self.waits:
            self.happens("picker", station.line[0].id)

    # What stories do otherwise than in the simulation

    def _arrivals(self) -> Process:
        yield from ()

    def transport(self, robot: Robot, pod: Pod, going: Going | None = None) -> Process:
        """Fetch a pod, carry it along its stations, and store it, unless that is abandoned."""
        with suppress(AbandonedError):
            yield from super().transport(robot, pod, going)

    def visit_stations(self, robot: Robot, pod: Pod, going: Going | None = None) -> Process:
        """Carry a pod along its stations, and store it, unless that is abandoned."""
        with suppress(AbandonedError):
            yield from super().visit_stations(robot, pod, going)

    def move(self, robot: Robot, pod: Pod, cell: int, going: Going | None = None) -> Process:
        """Carry a stored pod elsewhere, unless that is abandoned."""
        with suppress(AbandonedError):
            yield from super().move(robot, pod, cell, going)

    def rest(self, robot: Robot, cell: int, share: float, going: Going | None = None) -> Process:
        """Drive to where the robot rests, unless that is abandoned."""
        with suppress(AbandonedError):
            yield from super().rest(robot, cell, share, going)

    def put_away(self, robot: Robot, pod: Pod) -> Process:
        """Store a pod that a robot carries, whatever was to be done with it."""
        yield from self._store(robot, pod)

    def _lift(self, robot: Robot, pod: Pod, going: Going | None = None) -> Process:
        self.command("lift", robot=robot.id, pod=pod.id)
        yield from super()._lift(robot, pod, going)

    def store(self, robot: Robot, pod: Pod, cell: int, going: Going | None = None) -> Process:
        """Have a pod carried to its storage location, unless that is abandoned."""
        self.command("store", robot=robot.id, pod=pod.id, cell=cell)
        with suppress(AbandonedError):
            yield from super().store(robot, pod, cell, going)

    def _pick(self, request: Request, pod: Pod, station: Station, at: Going) -> Picking:
        if request.pod is not pod:  # it was taken back while the picker had another item in hand
            return 0
        self.command("pick_next", station=station.id, pod=pod.id, order=request.order.id, sku=request.sku)
        assert at.robot is not None
        self.wanted[at.robot] = request.order.id, request.sku
        try:
            return (yield from super()._pick(request, pod, station, at))
        except AbortedError:
            self.warehouse.occupy_picker(station, self.now)
            return 0

    def _store_bundle(self, bundle: Bundle, pod: Pod, station: Station, at: Going) -> Process:
        self.command("store_bundle", station=station.id, pod=pod.id, bundle=bundle.name)
        assert at.robot is not None
        self.wanted[at.robot] = None, bundle.name
        yield from super()._store_bundle(bundle, pod, station, at)

    @property
    def next_tick(self) -> int | None:
        """When the next thing happens that no fact tells of: an alarm of a rule, a timetable; None: nothing."""
        upcoming = self.env.peek()
        return None if upcoming == math.inf else int(upcoming)


def check_supported(scenario: Scenario) -> None:
    """Refuse a scenario with what a session does not do yet, in one sentence."""
    robots, stations = scenario.robots, scenario.stations
    outages = robots.battery and robots.battery.charger_outages
    refused: Iterable[tuple[str, Any, str]] = (
        ("stations.release", scenario.packing and stations.release == "picked", "items go to packing when handled"),
        ("robots.failures", robots.failures or robots.maintenance, "failures come as facts (robot_failed)"),
        ("stations.outages", stations.outages, "closed stations come as facts (station_closed)"),
        ("robots.battery.charger_outages", outages, "chargers that fail have no facts yet"),
        ("run.until_s", scenario.run.until_s, "a session has no end"),
        ("instance.state_file", scenario.instance.state_file, "a session begins with nothing under way"),
    )
    for key, found, why in refused:
        if found:
            raise InputError(key, f"{why}; expected a scenario without it for a session")
