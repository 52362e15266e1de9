"""Rules against literal versions of their definitions, on random worlds.

The literal versions look at one pair after another in plain Python, and apply each choice to the warehouse before the
next one, so they share no bookkeeping with the rules.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import Any

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import Order, Pod, Station, Warehouse, WarehouseView
from rmfs_core.warehouse.backlog import Backlog
from rmfs_rules.common_lines import CommonLines
from rmfs_rules.demand import Demand
from rmfs_rules.due import EarliestDue, LeastSlack
from rmfs_rules.first_come import FirstCome
from rmfs_rules.helpers.pairs import PairOptions, pod_at
from rmfs_rules.near_best_pod import NearBestPod
from rmfs_rules.nearest_pod import NearestPod
from rmfs_rules.pod_match import PodMatch
from rmfs_rules.scorers import Completes, Lexicographic, WorkAmount
from rmfs_rules.workload import Workload

SKUS = "abcdef"
Score = Callable[[Warehouse, Order, Station], int | tuple[int, ...]]
Value = Callable[[Warehouse, Pod, Station], tuple[float, ...]]


@st.composite
def worlds(draw: st.DrawFn) -> Callable[..., Warehouse]:
    """Draw a world in the middle of a run; calling the result builds it, the same each time.

    With ``late`` its orders arrived at different times, and it is later.
    """
    lines = st.dictionaries(st.sampled_from(SKUS), st.integers(1, 3), min_size=1, max_size=4)
    orders = draw(st.lists(lines, max_size=9))
    finite = draw(st.booleans())
    contents = st.dictionaries(
        st.sampled_from(SKUS), st.integers(1, 4) if finite else st.none(), min_size=1, max_size=3
    )
    pods = draw(st.lists(contents, min_size=1, max_size=12))
    capacities = draw(st.lists(st.integers(1, 9), min_size=1, max_size=3))
    counts_orders = draw(st.booleans())
    number = st.integers(0, 20)
    bound = draw(st.lists(st.tuples(number, number), max_size=5))
    begun = draw(st.lists(st.tuples(number, number, st.booleans()), max_size=4))
    at_station = draw(st.booleans())
    due_s = draw(st.dictionaries(st.sampled_from([str(i) for i in range(len(orders))] or ["none"]), st.integers(0, 9)))
    arrivals = draw(st.lists(st.sampled_from([0, 0, 500, 900]), min_size=9, max_size=9).map(sorted))

    def build(*, late: bool = False) -> Warehouse:
        world = small_world(
            {str(i): order for i, order in enumerate(orders)},
            {str(i): pod for i, pod in enumerate(pods)},  # type: ignore[misc]
            capacities=capacities,
            counts_orders=counts_orders,
            due_s={order: 100.0 * due for order, due in due_s.items() if order != "none"},
        )
        if late:
            _arrive(world, arrivals)
        _assign_some(world, begun)
        if at_station:
            _put_at_station(world, world.pods[0], world.stations[0])
        for pod_number, station_number in bound:
            pod = world.pods[pod_number % len(pods)]
            station = world.stations[station_number % len(capacities)]
            if station.id not in pod.bound_for:
                world.bind(pod, station)
        return world

    return build


def _arrive(world: Warehouse, arrivals: list[int]) -> None:
    """Let orders arrive at some seconds, and let it be later."""
    world.backlog = Backlog(world.n_skus)
    world.open_demand[:] = world.ordered[:] = 0
    for order, arrival_s in zip(world.orders, arrivals, strict=False):
        world.order_arrives(order, 1000 * arrival_s)
    world.advance(1_000_000)


def _assign_some(world: Warehouse, begun: list[tuple[int, int, bool]]) -> None:
    for order_number, station_number, whole in begun:
        if world.orders:
            order = world.orders[order_number % len(world.orders)]
            station = world.stations[station_number % len(world.stations)]
            lines = order.open_lines[: None if whole else 1]
            size = 1 if station.counts_orders else sum(line.quantity for line in lines)
            if lines and size <= station.free_capacity:
                world.assign(order, station, [line.sku for line in lines])


def _put_at_station(world: Warehouse, pod: Pod, station: Station) -> None:
    world.place_at_station(world.robots[0], pod, station)


def negative(score: int | tuple[int, ...]) -> tuple[int, ...]:
    """Return a score of one or several parts with all of them negative."""
    return tuple(-part for part in (score if isinstance(score, tuple) else (score,)))


def literal_assignments(world: Warehouse, score: Score) -> Iterator[tuple[int, int]]:
    """Yield (order, station) of the best pair, again and again, after the definition of the greedy POA rules."""
    while True:
        pairs = [
            (negative(score(world, order, station)), age, station.load, station.id)
            for age, order in enumerate(world.backlog.orders)
            for station in world.stations
            if world.size_at(order, station) <= station.free_capacity
        ]
        if not pairs:
            return
        _, age, _, station_id = min(pairs)
        order = world.backlog.orders[age]
        yield order.id, station_id
        world.assign(order, world.stations[station_id], [line.sku for line in order.open_lines], period=2)


class Literal:
    """One decision with the parameters that the POA rules share, after their definition.

    Parameters
    ----------
    world
        The world, to which each choice is applied.
    score
        Score of an order at a station.
    goes_first
        What goes before the age of orders with the same score.
    options
        The rule's ``max_wait_s``, ``fast_lane``, ``late_first``.
    """

    def __init__(
        self, world: Warehouse, score: Score, goes_first: Callable[[Order], float], options: dict[str, Any]
    ) -> None:
        self.world, self.score, self.goes_first = world, score, goes_first
        self.max_wait_s, self.places = options.get("max_wait_s"), options.get("fast_lane", 0)
        self.late_first = options.get("late_first", False)
        self.kept: dict[int, bool] = {}  # station -> whether it is kept for an order larger than any station
        self.there = {s.id: pod for s in world.stations if (pod := pod_at(WarehouseView(world), s)) is not None}
        self.left = {pod.id: Counter({sku: pod.free_items(sku) for sku in pod.contents}) for pod in self.there.values()}
        self.made: list[tuple[int, int]] = []

    def fits(self, order: Order, station: Station) -> bool:
        """Whether a pair fits: the places of a fast lane are for what the pod at the station completes."""
        size, free = self.world.size_at(order, station), station.free_capacity
        if station.id in self.kept:
            return False
        if not self.places or not station.load or size <= max(free - self.places, 0):
            return size <= free
        wanted = Counter({line.sku: line.quantity for line in order.open_lines})
        return size <= free and station.id in self.there and wanted <= self.left[self.there[station.id].id]

    def pairs(self, orders: Iterable[Order]) -> list[tuple[Any, ...]]:
        """Return the pairs that fit, with what goes first before them."""
        late = [order.due_s is not None and order.due_s < self.world.now / 1000 for order in self.world.orders]
        return [
            (
                not (self.late_first and late[order.id]),
                negative(self.score(self.world, order, station)),
                self.goes_first(order),
                self.world.backlog.orders.index(order),
                station.load,
                station.id,
            )
            for order in orders
            for station in self.world.stations
            if self.fits(order, station)
        ]

    def take(self, pairs: list[tuple[Any, ...]]) -> None:
        """Apply the best of some pairs."""
        *_, age, _, at = min(pairs)
        order, station = self.world.backlog.orders[age], self.world.stations[at]
        self.made.append((order.id, at))
        for pod in self.there.values():
            if at in pod.bound_for and not self.world.unlimited_stock:
                self.left[pod.id].subtract({line.sku: line.quantity for line in order.open_lines})
        self.world.assign(order, station, [line.sku for line in order.open_lines], period=2)

    def keep(self, order: Order) -> None:
        """Keep the station with most room of those that could take an order, if they took nothing else."""
        lacking = {
            station: self.world.size_at(order, station) - station.free_capacity
            for station in self.world.stations
            if station.id not in self.kept and self.world.size_at(order, station) <= station.capacity
        }
        if lacking:
            station = min(lacking, key=lambda station: (lacking[station], station.id))
            self.kept[station.id] = self.large(order)

    def large(self, order: Order) -> bool:
        """Whether an order has more items than any station takes."""
        return not self.world.stations[0].counts_orders and order.open_items > max(
            station.capacity for station in self.world.stations
        )

    def decide(self) -> list[tuple[int, int]]:
        """Decide: orders that waited too long first, then all."""
        limit_s = 600 if self.max_wait_s is None else self.max_wait_s
        for order in self.world.backlog.orders:
            waited = self.world.now / 1000 - order.arrival_s >= limit_s
            if (
                len(self.kept) < len(self.world.stations)
                and waited
                and (self.max_wait_s is not None or self.large(order))
            ):
                if pairs := self.pairs([order]):
                    self.take(pairs)
                elif self.max_wait_s is not None or not any(self.kept.values()):
                    self.keep(order)
        while pairs := self.pairs(self.world.backlog.orders):
            self.take(pairs)
        return self.made


def match(world: Warehouse, order: Order, station: Station) -> int:
    """Items of the order available on the station's inbound pods."""
    return sum(
        min(line.quantity, sum(pod.free_items(line.sku) for pod in station.inbound_pods)) for line in order.open_lines
    )


def in_common(world: Warehouse, order: Order, station: Station) -> int:
    """Lines of the order whose SKU is wanted at the station."""
    wanted = {request.sku for request in station.open_requests}
    return sum(line.sku in wanted for line in order.open_lines)


def literal_trips(world: Warehouse, max_fetches: int, value: Value) -> Iterator[tuple[int, int]]:
    """Yield (pod, station) of the best pod for the station whose turn it is, after the definition of the PPS rules."""
    leaving = list(world.leaving_pods())
    given_up: set[int] = set()
    sent: set[int] = set()
    while True:
        stations = [s for s in world.stations if s.uncovered_requests and s.id not in given_up]
        if not stations:
            return
        station = min(stations, key=lambda s: (len(s.inbound_pods), -s.uncovered_items, s.id))
        times = world.travel.times_to(station.cell, True)
        ranked = [
            (tuple(-part for part in value(world, pod, station)), times[pod.cell].min(), pod.id)
            for pod in world.pods
            if pod.id not in sent
            and station.id not in pod.bound_for
            and (pod in leaving or (max_fetches > 0 and pod.location is not None and not pod.bound_for))
            and any(pod.free_items(request.sku) > 0 for request in station.uncovered_requests)
        ]
        if not ranked:
            given_up.add(station.id)
            continue
        pod = world.pods[min(ranked)[2]]
        yield pod.id, station.id
        sent.add(pod.id)
        max_fetches -= pod not in leaving
        world.bind(pod, station)


def system_demand(world: Warehouse, pod: Pod, _: Station) -> tuple[int]:
    """Open demand of the system that the pod's contents could serve."""
    demand: dict[int, int] = {}
    for order in world.orders:
        for line in order.open_lines:
            demand[line.sku] = demand.get(line.sku, 0) + line.quantity
    for station in world.stations:
        for request in station.open_requests:
            demand[request.sku] = demand.get(request.sku, 0) + request.items
    return (sum(min(demand.get(sku, 0), items) for sku, items in pod.contents.items()),)


def orders_at(station: Station) -> int:
    """Orders that the station works on."""
    return len({request.order.id for request in station.open_requests})


def near_best_pod(world: Warehouse, order: Order, station: Station) -> tuple[int, int]:
    """The oldest order goes first; it goes where one of the pods with most of it is near."""
    items = {
        pod: sum(min(line.quantity, pod.free_items(line.sku)) for line in order.open_lines)
        for pod in world.pods
        if pod.location is not None and not pod.bound_for
    }
    most = max(items.values(), default=0)
    times = world.travel.times_to(station.cell, True)
    near = min((times[pod.cell].min() for pod in items if items[pod] == most > 0), default=0)
    return -world.backlog.orders.index(order), -int(near)


def wanted_at(station: Station) -> dict[int, Counter[int]]:
    """Uncovered items by order and SKU; the order that was assigned first comes first."""
    wanted: dict[int, Counter[int]] = {}
    for request in station.uncovered_requests:
        wanted.setdefault(request.order.id, Counter())[request.sku] += request.items
    return wanted


def completed(wanted: Iterable[Counter[int]], items: Counter[int]) -> list[bool]:
    """Whether each order is completed with items, when one takes its items after the other."""
    found = []
    for needs in wanted:
        found.append(needs <= items)
        if found[-1]:
            items = items - needs
    return found


def picks(station: Station, items: Counter[int]) -> Counter[int]:
    """Items that serve uncovered requests of the station."""
    return items & sum(wanted_at(station).values(), Counter())


def picks_of(_: Warehouse, pod: Pod, station: Station) -> int:
    """Uncovered items of the station that the pod serves."""
    return picks(station, Counter({sku: pod.free_items(sku) for sku in pod.contents})).total()


def completes(world: Warehouse, pod: Pod, station: Station) -> tuple[int, int]:
    """Orders of the station that the pod completes, and its picks there."""
    items = Counter({sku: pod.free_items(sku) for sku in pod.contents})
    return sum(completed(wanted_at(station).values(), items)), picks(station, items).total()


def completes_backlog(world: Warehouse, pod: Pod, station: Station) -> tuple[int, int]:
    """The same, with the orders of the backlog that what is left completes."""
    items = Counter({sku: pod.free_items(sku) for sku in pod.contents})
    here, served = completes(world, pod, station)
    lines = [Counter({line.sku: line.quantity for line in order.open_lines}) for order in world.backlog.orders]
    return here + sum(completed(lines, items - picks(station, items))), served


def work(value: str, world: Warehouse, pod: Pod, station: Station) -> tuple[float]:
    """What the items are worth that the pod serves: 1 each, or shares of the orders' ages or lateness; drives cost."""

    def share(order: Order) -> float:
        since_s = {"picks": None, "age": order.arrival_s, "lateness": order.due_s}[value]
        if value == "picks" or since_s is None:
            return float(value == "picks")
        return max(world.now / 1000 - since_s, 0) / order.unpicked_items

    items = Counter({sku: pod.free_items(sku) for sku in pod.contents})
    wanted = wanted_at(station)
    whole = dict(zip(wanted, completed(wanted.values(), items), strict=True))
    total = 0.0
    for request in station.uncovered_requests:
        served = min(items[request.sku], request.items)
        items[request.sku] -= served
        total += share(request.order) * (request.items * whole[request.order.id] + served)
    for order in world.backlog.orders:
        for line in order.open_lines:
            served = min(items[line.sku], line.quantity)
            items[line.sku] -= served
            total += 0.2 * served * share(order)
    drive = world.travel.times_to(station.cell, True)[pod.cell].min() / 1000
    return (round(total - drive / 3, 6),)


@settings(max_examples=300, deadline=None)
@given(worlds())
def test_order_assignment_is_what_its_definition_says(build: Callable[[], Warehouse]) -> None:
    """Rules that score pairs, with unlimited and finite stock, item and order capacity."""
    rules: tuple[tuple[PairOptions, Score], ...] = (
        (PodMatch(), match),
        (CommonLines(), in_common),
        (FirstCome(), lambda world, order, station: 0),
        (Workload(), lambda world, order, station: -orders_at(station)),
        (Workload(prefer="most"), lambda world, order, station: orders_at(station)),
        (NearBestPod(), near_best_pod),
    )
    shared = not build().unlimited_stock and any(len(pod.bound_for) > 1 for pod in build().pods)
    for rule, score in rules[shared:]:  # what a pod that goes on has left, promises to others may change: no part of it
        decided = [
            (given.order, given.station)
            for given in rule.assign_orders(WarehouseView(build()), np.random.default_rng(0))
        ]
        assert decided == list(literal_assignments(build(), score)), rule


OPTIONS = st.fixed_dictionaries(
    {},
    optional={
        "max_wait_s": st.sampled_from([0.0, 100.0, 600.0, 2000.0]),
        "fast_lane": st.integers(1, 3),
        "tie_break": st.just("due"),
        "late_first": st.just(True),
    },
)


def due(order: Order) -> float:
    """When an order is due."""
    return math.inf if order.due_s is None else order.due_s


@settings(max_examples=400, deadline=None)
@given(worlds(), OPTIONS)
def test_options_are_what_they_say(build: Callable[..., Warehouse], options: dict[str, Any]) -> None:
    """Orders that waited, the fast lane, ties and late orders, in all rules that assign whole orders."""
    later = partial(build, late=True)
    rules: tuple[tuple[type[PairOptions], Score], ...] = (
        (PodMatch, match),
        (CommonLines, in_common),
        (FirstCome, lambda world, order, station: 0),
        (Workload, lambda world, order, station: -orders_at(station)),
    )
    shared = not later().unlimited_stock and any(len(pod.bound_for) > 1 for pod in later().pods)
    rng = np.random.default_rng(0)
    tie = due if "tie_break" in options else lambda order: 0.0
    for rule, score in rules[shared:]:
        decided = rule(**options).assign_orders(WarehouseView(later()), rng)
        assert [(one.order, one.station) for one in decided] == Literal(later(), score, tie, options).decide(), rule
    lane = {key: value for key, value in options.items() if key in ("max_wait_s", "fast_lane")}
    for by_due, tie in (
        (EarliestDue(**lane), due),
        (LeastSlack(**lane), lambda order: due(order) - 13.0 * order.open_items),
    ):
        decided = by_due.assign_orders(WarehouseView(later()))
        literal = Literal(later(), lambda world, order, station: 0, tie, lane).decide()
        assert [(one.order, one.station) for one in decided] == literal, by_due


@settings(max_examples=300, deadline=None)
@given(worlds(), st.integers(0, 4))
def test_pod_selection_is_what_its_definition_says(build: Callable[[], Warehouse], max_fetches: int) -> None:
    """demand, nearest-pod, completes and lexicographic, with stored and leaving pods."""
    rules: tuple[tuple[Demand | NearestPod, Value], ...] = (
        (Demand(), system_demand),
        (NearestPod(), lambda world, pod, _: ()),
    )
    for rule, value in rules:
        decided = [(trip.pod, trip.station) for trip in rule.select_pods(WarehouseView(build()), max_fetches)]
        assert decided == list(literal_trips(build(), max_fetches, value)), rule
    rng = np.random.default_rng(0)
    by_demand = Lexicographic(("picks", "demand", "nearest"))
    for scored, value in (
        (Completes(), completes),
        (Completes(count_backlog=True), completes_backlog),
        (by_demand, lambda *at: (picks_of(*at), *system_demand(*at))),
    ):
        trips = scored.select_pods(WarehouseView(build()), max_fetches, rng)
        assert [(trip.pod, trip.station) for trip in trips] == list(literal_trips(build(), max_fetches, value)), scored


@settings(max_examples=150, deadline=None)
@given(worlds())
def test_work_is_what_its_definition_says(build: Callable[[], Warehouse]) -> None:
    """work-amount sends no pod that another beats by more than what sums of fractions are off."""
    for value in ("picks", "age", "lateness"):
        world = build()
        world.now = 250_000
        no_better_pod(world, value)


def no_better_pod(world: Warehouse, value: str) -> None:
    """Fail where another pod than one that work-amount sends is worth more."""
    rule = WorkAmount(value=value)
    trips = rule.select_pods(WarehouseView(world), 9, np.random.default_rng(0))
    for trip in trips:
        station, pod = world.stations[trip.station], world.pods[trip.pod]
        rivals = [
            other
            for other in world.pods
            if (other in world.leaving_pods() or (other.location is not None and not other.bound_for))
            and station.id not in other.bound_for
            and any(other.free_items(request.sku) > 0 for request in station.uncovered_requests)
        ]
        best = max(work(value, world, other, station) for other in rivals)
        assert work(value, world, pod, station)[0] >= best[0] - 1e-5
        world.bind(pod, station)
