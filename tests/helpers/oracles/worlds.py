"""Random small worlds in the middle of a run, the same ones for the same seed."""

import random
from collections import Counter
from collections.abc import Callable, Iterable
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from attrs import define, evolve, frozen

from rmfs_commands.processes.battery import battery_for_a_moment
from rmfs_commands.testing import small_instance, small_layout, small_world
from rmfs_core.clock import UNREACHABLE
from rmfs_core.scenario.model import PackingSection
from rmfs_core.warehouse import Order, PackingStation, PackingTask, Pod, Robot, Station, Warehouse, WarehouseView
from rmfs_core.warehouse.parts import UNLIMITED
from rmfs_core.warehouse.promises import next_request

SKUS = "abcdef"
START_S = 1000
T = TypeVar("T")


@define(eq=False)
class Moment:
    """The world that a rule is asked about; the world of a literal version changes with its choices."""

    world: Warehouse  # the world
    hidden: frozenset[int]  # ids of the orders that a filter leaves out
    rng: np.random.Generator  # what the rule draws from
    memory: dict[str, Any]  # what a literal version remembers from one moment of a run to the next
    max_fetches: int  # how many stored pods may be sent or moved
    max_moves: int
    chosen: int  # number that chooses a pod or robot that the rule is asked about

    @cached_property
    def free(self) -> dict[Pod, Counter[int]]:
        """Free items on each pod, as they are when it is asked first: what is chosen then promises others of them."""
        return {pod: Counter({sku: pod.free_items(sku) for sku in pod.contents}) for pod in self.world.pods}

    @cached_property
    def warehouse(self) -> WarehouseView:
        """The view of the rule."""
        view = WarehouseView(self.world)
        return view if not self.hidden else view.showing([one for one in view.backlog if one.id not in self.hidden])

    def answers(self, hook: str) -> bool:
        """Whether there is what a hook asks about."""
        if hook == "choose_packing_task":
            return bool(self.tasks)
        if hook == "plan_path":
            robot, travel = self.robot, self.world.travel
            return travel.ticks(robot.cell, robot.heading, self.goal, robot.pod is not None) < UNREACHABLE
        return hook != "choose_storage_location" or any(pod.location is None for pod in self.world.pods)

    @property
    def backlog(self) -> list[Order]:
        return [order for order in self.world.backlog.orders if order.id not in self.hidden]

    @property
    def orders(self) -> list[Order]:
        if not self.world.packing:
            return self.backlog
        begun = [order for order in self.world.arrived.values() if order.parts and order.packing is None]
        boxes = self.world.free_boxes or 0
        kept = {order.id for order in [order for order in begun if order.split][:boxes]}
        return [order for order in begun if order.id in kept or not order.split]

    @cached_property
    def tasks(self) -> list[PackingTask]:
        lots, orders = random.Random(f"{self.chosen} tasks"), [*self.world.arrived.values()]
        drawn = []
        for number in range(lots.randint(2, 6) if orders else 0):
            order, kind, items = lots.choice(orders), lots.choice(("put", "pack")), lots.randint(1, 4)
            duration_s = float(lots.choice((7, 11, 35, 40)))
            drawn.append(PackingTask(kind, order, number + 1, items, duration_s, 100.0 * number))
        return drawn

    @property
    def now_s(self) -> float:
        return self.world.now / 1000

    @property
    def stations(self) -> tuple[Station, ...]:
        return self.world.picking

    @property
    def pod(self) -> Pod:
        carried = [pod for pod in self.world.pods if pod.location is None]
        return carried[self.chosen % len(carried)]

    @property
    def robot(self) -> Robot:
        return self.world.robots[self.chosen % len(self.world.robots)]

    @property
    def goal(self) -> int:
        cells = [*self.world.travel.layout.storage_locations, *(station.cell for station in self.world.stations)]
        return cells[self.chosen % len(cells)]

    def ticks(self, pod: Pod, station: Station) -> int:
        return int(self.world.travel.times_to(station.cell, True)[pod.cell].min())

    def turned_ticks(self, pod: Pod, cell: int) -> int:
        """Driving time of the robot that carries a pod to a cell."""
        robot = self.world.robots[pod.robot or 0]
        return self.world.travel.ticks(robot.cell, robot.heading, cell, True)


def standing(world: Warehouse, station: Station) -> Pod | None:
    """Pod that stands at a station, not in its queue."""
    if station.line and station.line[0].cell == station.cell and station.line[0].pod is not None:
        return world.pods[station.line[0].pod]
    return None


@frozen
class Run:
    """A run: what happens in it is drawn from a seed, whatever a rule decides."""

    seed: int  # what everything is drawn from
    size: int  # how large it is: 0 to 4
    filtered: bool = False  # whether orders are hidden at some moments
    crowded: bool = False  # whether robots and pods are many
    stocked: bool = False  # whether bundles are many
    batteries: bool = False  # whether robots have batteries
    single: bool = False  # whether lines want one item each where stock is finite
    packing: bool = False  # whether there are packing stations

    def moment(self, world: Warehouse, phase: int, memory: dict[str, Any]) -> Moment:
        """Return what a rule is asked about after a phase."""
        lots = random.Random(f"{self.seed} asked {phase}")
        shown = lots.random() < 0.6 or not self.filtered
        hidden = () if shown else [order.id for order in world.orders if lots.random() < 0.4]
        rng = np.random.default_rng(self.seed + phase)
        return Moment(
            world, frozenset(hidden), rng, memory, lots.randint(0, 4), lots.randint(1, 3), lots.randrange(1000)
        )

    def begin(self) -> Warehouse:
        """Return the world when the first orders have arrived."""
        lots = random.Random(self.seed)
        most, finite = lots.choice([1, 2, 3, 3, 5]), self.stocked or lots.random() < 0.5

        most = 1 if self.single and finite else most

        def some(number: Callable[[], int | None], most_skus: int) -> dict[str, Any]:
            return {sku: number() for sku in lots.sample(SKUS, lots.randint(1, most_skus))}

        orders = {
            str(i): some(lambda: lots.randint(1, most), 4)
            for i in range(lots.randint(self.size > 0, 3 + 3 * self.size))
        }
        stock: Callable[[], int | None] = (lambda: lots.randint(0, 4)) if finite else (lambda: None)
        number = lots.randint(1, 3 + (7 if self.crowded else 3) * self.size)
        pods = {str(i): some(stock, 3) for i in range(number)}
        held = {sku for contents in pods.values() for sku in contents}
        rest = [sku for sku in SKUS if sku not in held or (finite and lots.random() < 0.3)]
        if not finite or lots.random() < 0.5:  # unlimited stock is of every SKU that is wanted
            pods["rest"] = dict.fromkeys(rest or SKUS, 30 if finite else None)
        stations, stores = lots.choice([1, 2, 2, 3]), lots.random() < 0.5
        layout = small_layout(stations, replenishment=1, chargers=2)
        plain = small_world(
            orders,
            pods,
            capacities=[lots.randint(1, 9) for _ in range(stations)],
            counts_orders=lots.random() < 0.35,
            robots=lots.randint(1, 6 if self.crowded else 4),
            layout=layout,
            bundle_capacity=lots.randint(1, 3) if stores else 0,
        )
        storing = Station(
            stations, layout.stations[stations], 0, False, 3, bundle_capacity=lots.randint(1, 4), picks=False
        )
        places = lots.sample(layout.storage_locations, len(plain.pods) + 3)
        instance = small_instance(orders, pods)
        for robot in plain.robots:
            plain.move(robot, robot.cell, lots.randrange(4))
        arrivals = sorted(lots.choice([0, 0, 300, 399, 400, 401, 900, 1100, 1300]) for _ in orders)
        later = [
            evolve(
                data,
                arrival_tick=1000 * arrival_s,
                due_tick=lots.choice([None, 1000 * lots.randint(2, 30) * 50, 1_000_000, 1_600_000]),
                priority=lots.choice([0, 0, 0, 1, -2]),
            )
            for data, arrival_s in zip(instance.orders, arrivals, strict=True)
        ]
        space = 4 * lots.randint(3, 6) if finite and lots.random() < 0.8 else UNLIMITED
        world = Warehouse(
            evolve(instance, orders=tuple(later)),
            plain.travel,
            [*plain.stations, storing],
            plain.robots,
            places[3:],
            blocked=places[: lots.randint(0, 3)],
            pod_capacity=[max(space, sum(number or 0 for _, number in pod.contents)) for pod in instance.pods],
            wait_for_stock=lots.random() < 0.3,
            packing=packing_stations(lots, stations) if self.packing else (),
        )
        for robot, cell in zip(world.robots, lots.sample(layout.storage_locations, len(world.robots)), strict=True):
            world.move(robot, cell, lots.randrange(4))
            if self.batteries:
                share = lots.choice([0.05, 0.2, 0.3, 0.5, 0.8, 0.95])
                world.put_battery(robot, battery_for_a_moment(share, low=lots.random() < 0.2))
        return world

    def go_on(self, world: Warehouse, phase: int) -> None:
        lots = random.Random(f"{self.seed} phase {phase}")
        world.advance(1000 * (START_S if not phase else lots.choice([int(world.now / 1000), 1100, 1300, 2000])))
        for order in world.orders:
            if order.id not in world.arrived and order.arrival_tick <= world.now:
                world.order_arrives(order)
        changes = (assign, assign, bind, bind, cancel, come, come, pick, pick, leave, put_down, fetch)
        changes += (bundle, bundle, shut, turn)
        changes += (assign, pack, pack) * self.packing
        changes += (bundle,) * (8 * self.stocked) + (turn, come, leave, bind) * self.crowded
        for number in range(lots.randint(0, 4 + 5 * self.size)):
            lots.choice(changes)(world, lots, 100 * phase + number)

    def world(self, phase: int) -> Warehouse:
        """Return a world of its own after a phase."""
        world = self.begin()
        for number in range(phase + 1):
            self.go_on(world, number)
        return world


def packing_stations(lots: random.Random, stations: int) -> list[PackingStation]:
    """Return a few, with few boxes, some as far as others."""
    return [
        PackingStation(
            at,
            PackingSection(boxes=lots.randint(1, 4)),
            conveyor_s=tuple(float(lots.choice((10, 20, 35))) for _ in range(stations)),
        )
        for at in range(lots.randint(1, 3))
    ]


def pack(world: Warehouse, lots: random.Random, _: int) -> None:
    """Bind an order for a packing station."""
    for order in one_of(lots, [one for one in world.arrived.values() if one.parts and one.packing is None]):
        for station in one_of(lots, [one for one in world.packing if one.free_boxes or not order.split]):
            world.bind_packing(order, station)


def one_of(lots: random.Random, things: Iterable[T]) -> list[T]:
    """Return one of some things; none where there is none."""
    found = [*things]
    return [lots.choice(found)] if found else []


def assign(world: Warehouse, lots: random.Random, period: int) -> None:
    for order in one_of(lots, world.backlog.orders):
        station, lines = lots.choice(world.picking), order.open_lines
        if lots.random() < 0.5:
            lines = lines[: lots.randint(1, len(lines))]
        size = world.size_at(order, station)
        if not station.counts_orders and len(lines) < len(order.open_lines):
            size = sum(line.quantity for line in lines)
        if size <= station.free_capacity:
            world.assign(order, station, [line.sku for line in lines], period)


def cancel(world: Warehouse, lots: random.Random, _: int) -> None:
    """Let an order leave of which nothing is assigned, from the backlog or from those that wait for stock."""
    for order in one_of(lots, [one for one in world.arrived.values() if one.open_lines and not one.parts]):
        if lots.random() < 0.4:
            world.cancel(order)


def bind(world: Warehouse, lots: random.Random, _: int) -> None:
    pod, station = lots.choice(world.pods), lots.choice(world.picking)
    going_away = pod.location is None and not pod.bound_for
    if station.id not in pod.bound_for and not going_away:
        world.bind(pod, station)


def come(world: Warehouse, lots: random.Random, _: int) -> None:
    """Let a pod stand at a station or in its queue."""
    stored = [pod for pod in world.pods if pod.location is not None and not pod.bound_for and pod.robot is None]
    station = lots.choice(world.stations)
    for pod in one_of(lots, stored):
        for robot in one_of(lots, world.idle):
            if len(station.line) < 3:
                world.place_at_station(robot, pod, station)


def pick(world: Warehouse, lots: random.Random, _: int) -> None:
    """Pick an item; it may be in the picker's hand."""
    station = lots.choice(world.picking)
    pod = standing(world, station)
    request = None if pod is None or station.in_hand else next_request(station, pod)
    if pod is not None and request is not None:
        world.fulfil(request, pod, handled=lots.random() < 0.8)


def leave(world: Warehouse, lots: random.Random, _: int) -> None:
    """Let a pod leave a station that needs it no more, for a storage location."""
    for pod in one_of(lots, world.leaving_pods()):
        station = world.stations[pod.bound_for[0]]
        world.leave(station.line[0], pod, station)
        world.reserve(lots.choice(world.free_locations))


def put_down(world: Warehouse, lots: random.Random, _: int) -> None:
    away = [pod for pod in world.pods if pod.location is None and not pod.bound_for]
    for pod in one_of(lots, away):
        robot = world.robots[pod.robot or 0]
        world.move(robot, lots.choice(sorted(world.reserved)), lots.randrange(4))
        world.store(robot, pod)


def fetch(world: Warehouse, lots: random.Random, _: int) -> None:
    for pod in one_of(lots, world.waiting.values()):
        for robot in one_of(lots, world.idle):
            world.take_task(robot, pod)


def bundle(world: Warehouse, lots: random.Random, _: int) -> None:
    """Let a bundle arrive, or assign one, or choose its pod, or store it."""
    if world.unlimited_stock:
        return
    if lots.random() < 0.4:
        world.bundle_arrives(lots.randrange(world.n_skus), lots.randint(1, 6))
    for one in one_of(lots, world.bundles.values()):
        station = lots.choice(world.storing)
        if station.free_bundle_capacity and lots.random() < 0.6:
            world.assign_bundle(one, station)
    for one in one_of(lots, [one for station in world.storing for one in station.bundles if one.pod is None]):
        able = [pod for pod in world.pods if pod.free_space >= one.size and (pod.location is not None or pod.bound_for)]
        if able and lots.random() < 0.4:
            world.bind_bundle(one, lots.choice(able))
    for station in world.storing:
        pod = standing(world, station)
        coming = None if pod is None else world.next_bundle(station, pod)
        if pod is not None and coming is not None and lots.random() < 0.3:
            world.store_bundle(coming, pod)


def shut(world: Warehouse, lots: random.Random, _: int) -> None:
    station = lots.choice(world.picking)
    if lots.random() < 0.5:
        world.staff(station, not station.staffed or lots.random() < 0.5, None)
    else:
        world.activate(station, not station.active)


def turn(world: Warehouse, lots: random.Random, _: int) -> None:
    """Let an idle robot be elsewhere."""
    taken = {robot.cell for robot in world.robots}
    for robot in one_of(lots, world.idle):
        layout = world.travel.layout
        free = [cell for cell in (*layout.storage_locations, *layout.chargers) if cell not in taken]
        world.move(robot, lots.choice(free), lots.randrange(4))
