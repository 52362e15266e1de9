"""Literal versions of the rules that assign whole orders, and of filters."""

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from attrs import define, field

from oracles.worlds import Moment, standing
from rmfs_core import OrderAssignment
from rmfs_core.warehouse import Order, Pod, Station

Parts = tuple[float, ...]
"""A score, the first part of which decides; higher goes first."""
OVERSIZE_WAIT_S = 600.0


def due(order: Order) -> float:
    return math.inf if order.due_s is None else order.due_s


def wants(order: Order) -> Counter[int]:
    return Counter({line.sku: line.quantity for line in order.open_lines})


def free_on(pod: Pod) -> Counter[int]:
    return Counter({sku: pod.free_items(sku) for sku in pod.contents})


@define
class Greedy:
    """Again and again the pair of order and station that fits and has the highest score.

    Parameters
    ----------
    now
        The moment; each choice is applied to its world.
    score
        Score of an order at a station; None where it may not go there.
    rank
        Of orders with the same score the one with the lowest goes first, then the oldest.
    prefer
        Of the stations with an order's highest score the one for which this is lowest, then the lowest load.
    first
        Whether an order goes before all others.
    max_wait_s, fast_lane
        Parameters of the rules.
    orders
        Which orders are in question; None: all that are shown.
    chosen
        The choice.
    """

    now: Moment
    score: Callable[[Order, Station], Parts | None] = lambda order, station: ()
    rank: Callable[[Order], float] = lambda order: 0.0
    prefer: Callable[[Order, Station], float] = lambda order, station: 0.0
    first: Callable[[Order], bool] = lambda order: False
    max_wait_s: float | None = None
    fast_lane: int = 0
    taken: Callable[[Order, Station], None] = lambda order, station: None
    orders: list[Order] | None = None
    chosen: list[tuple[Order, Station]] = field(factory=list)
    kept: dict[int, Order] = field(factory=dict)
    there: dict[int, Pod] = field(init=False)
    left: dict[int, Counter[int]] = field(init=False)

    def __attrs_post_init__(self) -> None:
        self.there = {s.id: pod for s in self.now.stations if (pod := standing(self.now.world, s)) is not None}
        self.left = {pod.id: free_on(pod) for pod in self.there.values()}

    def waiting(self) -> list[Order]:
        """Orders that are not chosen yet, oldest first."""
        return [order for order in self.now.backlog if self.orders is None or order in self.orders]

    def fits(self, order: Order, station: Station) -> bool:
        """Whether a pair fits: the places of a fast lane are for what the pod at the station completes."""
        size, free = self.now.world.size_at(order, station), station.free_capacity
        if station.id in self.kept or size > free:
            return False
        if not self.fast_lane or not station.load or size <= free - self.fast_lane or size == 0:
            return True
        return station.id in self.there and wants(order) <= self.left[self.there[station.id].id]

    def best(self, orders: Iterable[Order]) -> tuple[Order, Station] | None:
        """The pair that goes next, of some orders."""
        pairs = [
            (
                not self.first(order),
                tuple(-part for part in score),
                self.rank(order),
                self.now.backlog.index(order),
                self.prefer(order, station),
                station.load,
                station.id,
            )
            for order in orders
            for station in self.now.stations
            if self.fits(order, station) and (score := self.score(order, station)) is not None
        ]
        if not pairs:
            return None
        *_, age, _, _, at = min(pairs)
        return self.now.backlog[age], self.now.stations[at]

    def take(self, order: Order, station: Station) -> None:
        self.chosen.append((order, station))
        for pod in self.there.values():
            if station.id in pod.bound_for and not self.now.world.unlimited_stock:
                self.left[pod.id] -= wants(order)
        self.taken(order, station)
        self.now.world.assign(order, station, [line.sku for line in order.open_lines], period=1_000_000)

    def large(self, order: Order) -> bool:
        """Whether an order has more items than any station takes."""
        return not self.now.stations[0].counts_orders and order.open_items > max(s.capacity for s in self.now.stations)

    def late(self) -> list[Order]:
        """Orders that have waited too long: without a limit the oldest, if it is larger than any station and none picks
        such an order."""
        limit_s = OVERSIZE_WAIT_S if self.max_wait_s is None else self.max_wait_s
        waited = [order for order in self.waiting() if self.now.now_s - order.arrival_s >= limit_s]
        if self.max_wait_s is not None:
            return waited
        picked = {request.order for station in self.now.stations for request in station.open_requests}
        most = max((station.capacity for station in self.now.stations), default=0)
        counts = self.now.stations[0].counts_orders
        if not counts and any(sum(line.quantity for line in order.lines) > most for order in picked):
            return []
        return [order for order in waited[:1] if order == self.waiting()[0] and self.large(order)]

    def room(self, station: Station) -> int:
        return station.free_capacity

    def serve_late(self) -> None:
        """Choose the orders that have waited too long; each that fits nowhere keeps a station with most room for it."""
        for order in self.late():
            if (pair := self.best([order])) is not None:
                self.take(*pair)
            else:
                lacking = [
                    (self.now.world.size_at(order, station) - self.room(station), station.id)
                    for station in self.now.stations
                    if station.open
                    and station.id not in self.kept
                    and self.now.world.size_at(order, station) <= station.capacity
                ]
                if lacking:
                    self.kept[min(lacking)[1]] = order

    def decide(self) -> list[OrderAssignment]:
        """Choose the orders that have waited too long, then others, until nothing fits."""
        self.serve_late()
        while (pair := self.best(self.waiting())) is not None:
            self.take(*pair)
        return [OrderAssignment(order.id, station.id) for order, station in self.chosen]


def by_pairs(
    now: Moment,
    *,
    tie_break: str = "oldest",
    late_first: bool = False,
    max_wait_s: float | None = None,
    fast_lane: int = 0,
    **how: Any,
) -> list[OrderAssignment]:
    """Decide with the parameters that these rules share."""
    lots = {order: float(now.rng.random()) for order in now.backlog} if tie_break == "random" else {}
    ranks: dict[str, Callable[[Order], float]] = {"due": due, "random": lots.__getitem__, "oldest": lambda order: 0.0}
    late = [order for order in now.backlog if late_first and due(order) < now.now_s]
    greedy = Greedy(
        now, rank=ranks[tie_break], first=late.__contains__, max_wait_s=max_wait_s, fast_lane=fast_lane, **how
    )
    return greedy.decide()


def first_come(now: Moment, told: Any, **options: Any) -> list[OrderAssignment]:
    return by_pairs(now, **options)


def pod_match(now: Moment, told: Any, *, spread: float = 0.0, **options: Any) -> list[OrderAssignment]:
    """Sum over the SKUs of min(items wanted, items on inbound pods that no request was promised), less the load."""
    left = {pod.id: free_on(pod) for pod in now.world.pods}

    def score(order: Order, station: Station) -> Parts:
        match = sum(min(n, sum(left[p.id][sku] for p in station.inbound_pods)) for sku, n in wants(order).items())
        return (match - spread * sum(request.items for request in station.open_requests),)

    def taken(order: Order, station: Station) -> None:
        for sku, number in wants(order).items():
            missing = number
            for pod in station.inbound_pods:  # in the order in which they were sent
                items = min(missing, left[pod.id][sku])
                missing -= items
                left[pod.id][sku] -= 0 if now.world.unlimited_stock else items

    return by_pairs(now, score=score, taken=taken, **options)


def common_lines(now: Moment, told: Any, **options: Any) -> list[OrderAssignment]:
    """Open lines whose SKU is wanted by an open request at the station."""

    def score(order: Order, station: Station) -> Parts:
        wanted = {request.sku for request in station.open_requests}
        return (sum(sku in wanted for sku in wants(order)),)

    return by_pairs(now, score=score, **options)


def workload(now: Moment, told: Any, *, prefer: str = "fewest", **options: Any) -> list[OrderAssignment]:
    """The station that works on the fewest orders goes first, or on the most."""

    def score(order: Order, station: Station) -> Parts:
        orders = len({request.order.id for request in station.open_requests})
        return (-orders if prefer == "fewest" else orders,)

    return by_pairs(now, score=score, **options)


def near_best_pod(now: Moment, told: Any, **options: Any) -> list[OrderAssignment]:
    """The oldest order goes where one of the pods with most of it is near."""
    free = [pod for pod in now.world.pods if pod.location is not None and not pod.bound_for]

    def drive(order: Order, station: Station) -> float:
        items = {pod: sum((wants(order) & free_on(pod)).values()) for pod in free}
        most = max(items.values(), default=0)
        return min((now.ticks(pod, station) for pod in free if items[pod] == most > 0), default=0)

    return by_pairs(now, prefer=drive, **options)


def earliest_due(now: Moment, told: Any, **options: Any) -> list[OrderAssignment]:
    """The order that is due first goes."""
    return Greedy(now, rank=due, **options).decide()


def least_slack(now: Moment, told: Any, *, item_s: float = 13.0, **options: Any) -> list[OrderAssignment]:
    """The order with the lowest slack: due time - now - item_s * open items."""
    return Greedy(now, rank=lambda order: due(order) - now.now_s - item_s * order.open_items, **options).decide()


@define
class Drawn(Greedy):
    """Any pair that fits: the next one that was told, where that fits."""

    told: Iterator[OrderAssignment] = field(kw_only=True)

    def best(self, orders: Iterable[Order]) -> tuple[Order, Station] | None:
        """A pair of some orders."""
        able = [(order, station) for order in orders for station in self.now.stations if self.fits(order, station)]
        told = next(self.told, None) if able else None
        pairs = [pair for pair in able if told == OrderAssignment(pair[0].id, pair[1].id)]
        return next(iter(pairs or able), None)


def drawn(now: Moment, told: list[OrderAssignment], *, max_wait_s: float | None = None) -> list[OrderAssignment]:
    """Pairs that fit, until none does; tests of the rule `random` have how likely each is."""
    return Drawn(now, max_wait_s=max_wait_s, told=iter(told)).decide()


def station_queue(
    now: Moment, told: Any, *, queue_length: int = 20, urgent_s: float = 600.0, fast_lane: int = 1
) -> list[OrderAssignment]:
    """Orders queue for stations, and each station takes from its queue."""
    queue_of: dict[int, int] = now.memory.setdefault("queue_of", {})
    for order, at in [*queue_of.items()]:
        if not now.world.orders[order].open_lines or not now.stations[at].open:
            del queue_of[order]
    available = {s: sum((free_on(pod) for pod in s.inbound_pods), Counter[int]()) for s in now.stations}
    wanted = {s: {request.sku for request in s.open_requests} for s in now.stations}
    greedy = Greedy(now, fast_lane=fast_lane)
    while pairs := [
        (
            -sum((wants(order) & available[station]).values()),
            -sum(sku in wanted[station] for sku in wants(order)) / len(order.open_lines),
            due(order),
            now.backlog.index(order),
            [*queue_of.values()].count(station.id),
            station.id,
        )
        for order in now.backlog
        for station in now.stations
        if order.id not in queue_of
        and not greedy.large(order)
        and station.open
        and [*queue_of.values()].count(station.id) < queue_length
        and (station.counts_orders or order.open_items <= station.capacity)
    ]:
        *_, age, _, at = min(pairs)
        queue_of[now.backlog[age].id] = at
    at_station = {s: Counter() if (pod := standing(now.world, s)) is None else free_on(pod) for s in now.stations}

    def score(order: Order, station: Station) -> Parts | None:
        if queue_of.get(order.id) != station.id and not greedy.large(order):
            return None
        urgent = due(order) <= now.now_s + urgent_s
        return urgent, wants(order) <= at_station[station], wants(order) <= available[station]

    greedy.score, greedy.orders = score, [order for order in now.backlog if order.id in queue_of or greedy.large(order)]
    return greedy.decide()


def most_covered(now: Moment, told: Any, *, n: int, lines: str = "all") -> list[str]:
    """The n orders with the highest share of lines whose SKU is on a pod at or bound for a station."""
    pods = {pod for station in now.stations for pod in station.inbound_pods}
    there = {sku for pod in pods for sku, items in pod.contents.items() if items > 0}

    def share(order: Order) -> float:
        counted = order.lines if lines == "all" else order.open_lines
        return sum(line.sku in there for line in counted) / len(counted)

    return [order.name for order in sorted(now.backlog, key=lambda order: -share(order))][:n]


def held_back(now: Moment, every_s: float, orders: int | None) -> set[int]:
    last_wave_s = now.now_s // every_s * every_s
    since = [order for order in now.world.arrived.values() if order.arrival_s > last_wave_s]
    released = 0 if orders is None else len(since) // orders * orders
    return {order.id for order in since[released:]}


def waves(now: Moment, told: Any, *, every_s: float = 1800.0, orders: int | None = None) -> list[str]:
    """Orders until the last wave are released, and after it n orders whenever there are n."""
    return [order.name for order in now.backlog if order.id not in held_back(now, every_s, orders)]


def next_wave(now: Moment, told: Any, *, every_s: float = 1800.0, orders: int | None = None) -> float | None:
    return (now.now_s // every_s + 1) * every_s if held_back(now, every_s, orders) else None
