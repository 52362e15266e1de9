"""Literal versions of the rules that assign whole orders and select pods together."""

from collections import Counter
from typing import Any

from attrs import define, field

from oracles.orders import Greedy, Parts, free_on, wants
from oracles.worlds import Moment
from rmfs_core import JointDecision, OrderAssignment, PodTrip, SolveReport
from rmfs_core.warehouse import Order, Pod, Station

Chosen = list[tuple[Order, Station]]
Sent = list[tuple[Pod, Station]]
MOST_ORDERS = 500
"""Orders that `lns` looks at besides those that are chosen."""
MILLION = 1_000_000
"""Missing lines are compared in whole millionths of one for each place."""


@define
class Left:
    """Items left on pods while orders are chosen; below 0 items that they have to bring yet."""

    now: Moment  # the moment
    sent: Sent  # pods that are sent besides those that are at or bound for stations
    at: dict[int, Counter[int]] = field(init=False)
    supply: Counter[int] = field(init=False)

    def __attrs_post_init__(self) -> None:
        going = [*inbound(self.now), *self.sent]
        self.at = {station.id: Counter() for station in self.now.stations}
        for pod, station in going:
            self.at[station.id].update(free_on(pod))
        self.supply = sum((free_on(pod) for pod in self.now.world.pods), Counter())

    def missing(self, order: Order, station: Station) -> int:
        """Lines that a pod would have to be sent for, which none is sent for anyway."""
        return sum(0 <= self.at[station.id][sku] < number for sku, number in wants(order).items())

    def per_place(self, order: Order, station: Station) -> int:
        """The same for each place that the order takes, in millionths."""
        return self.missing(order, station) * MILLION // (1 if station.counts_orders else order.open_items)

    def in_stock(self, order: Order) -> bool:
        """Whether all pods together have enough left."""
        return self.now.world.unlimited_stock or wants(order) <= self.supply

    def take(self, order: Order, station: Station) -> None:
        self.at[station.id].subtract(wants(order))
        self.supply.subtract(wants(order))


def inbound(now: Moment) -> Sent:
    return [(pod, station) for station in now.stations for pod in station.inbound_pods]


class Places(Greedy):
    """Chooses orders without a change of the world; loads and free places are kept here."""

    def __init__(self, now: Moment, kept: Chosen = (), **how: Any) -> None:
        super().__init__(now, **how)
        self.free = {station.id: station.free_capacity for station in now.stations}
        self.load = {station.id: station.load for station in now.stations}
        for pair in kept:
            self.take(*pair)

    def waiting(self) -> list[Order]:
        taken = [order for order, _ in self.chosen]
        return [order for order in super().waiting() if order not in taken]

    def fits(self, order: Order, station: Station) -> bool:
        return station.id not in self.kept and self.now.world.size_at(order, station) <= self.free[station.id]

    def best(self, orders: Any) -> tuple[Order, Station] | None:
        pairs = [
            (tuple(-part for part in score), self.now.backlog.index(order), self.load[station.id], station.id)
            for order in orders
            for station in self.now.stations
            if self.fits(order, station) and (score := self.score(order, station)) is not None
        ]
        if not pairs:
            return None
        _, age, _, at = min(pairs)
        return self.now.backlog[age], self.now.stations[at]

    def take(self, order: Order, station: Station) -> None:
        size = self.now.world.size_at(order, station)
        self.free[station.id] -= size
        self.load[station.id] += size
        self.taken(order, station)
        self.chosen.append((order, station))

    def room(self, station: Station) -> int:
        return self.free[station.id]


def fill(
    now: Moment, sent: Sent, *, max_wait_s: float | None = None, oldest: bool = False, first_share: float | None = None
) -> Places:
    """Choose the orders with the fewest missing lines for each place; or the oldest, where fewest lines are missing.

    With ``first_share`` while the load of a station is below that share of its capacity.
    """
    left = Left(now, sent)

    def score(order: Order, station: Station) -> Parts | None:
        if not left.in_stock(order):
            return None
        if first_share is not None and places.load[station.id] >= first_share * station.capacity:
            return None
        if oldest:
            return -now.backlog.index(order), -left.missing(order, station)
        return (-left.per_place(order, station),)

    places = Places(now, score=score, taken=left.take, max_wait_s=max_wait_s)
    places.decide()
    return places


def dealt(now: Moment, chosen: Chosen, trips: Sent) -> tuple[dict[Pod, Counter[int]], dict[Station, Counter[int]]]:
    """Items left on pods, and lacking at stations, once the pods have served in the order of their trips."""
    stock = {pod: free_on(pod) for pod in now.world.pods}
    need = {station: Counter[int]() for station in now.stations}
    for order, station in chosen:
        need[station] += wants(order)
    for pod, station in trips:
        given = stock[pod] & need[station]
        stock[pod] -= given
        need[station] -= given
    return stock, need


def serve(now: Moment, chosen: Chosen, sent: Sent) -> bool:
    """Whether pods at, bound for and sent to stations have what chosen orders want."""
    return not any(need.total() for need in dealt(now, chosen, [*inbound(now), *sent])[1].values())


def pods_for(now: Moment, chosen: Chosen, *, by_worth: bool = False) -> Sent:
    """Few pods that bring what chosen orders lack: again and again the one that brings a station most.

    Of equals one that is bound for no station, the one with most that the backlog wants, the nearest. Then those that
    the others make needless stay.
    """
    busy, wanted = [pod for pod, _ in inbound(now)], sum((wants(order) for order in now.backlog), Counter())
    sent: Sent = []

    def rank(pod: Pod, station: Station) -> tuple[Any, ...]:
        worth = (free_on(pod) & wanted).total() if by_worth else 0
        return pod in busy, -worth, now.ticks(pod, station), pod.id, station.id

    while not serve(now, chosen, sent):
        stock, need = dealt(now, chosen, [*inbound(now), *sent])
        gain = {(p, s): (stock[p] & need[s]).total() for p in now.world.pods for s in now.stations}
        sent.append(min(gain, key=lambda trip: (-gain[trip], *rank(*trip))))
    for trip in sent[:-1]:
        others = [other for other in sent if other != trip]
        sent = others if serve(now, chosen, others) else sent
    return sent


def cost(now: Moment, chosen: Chosen, sent: Sent, weight: float) -> float:
    """Visits to stations with free places, and a weight for each place that stays free."""
    visits = len(sent) + sum(len(s.inbound_pods) for s in now.stations if s.free_capacity)
    largest = max((order.open_items for order in now.backlog), default=1)
    free = {station: station.free_capacity for station in now.stations}
    for order, station in chosen:
        free[station] -= now.world.size_at(order, station)
    return visits + weight * sum(left * (largest if s.counts_orders else 1) for s, left in free.items())


def decision(chosen: Chosen, sent: Sent, costs: float | None = None) -> JointDecision:
    if not chosen:
        return JointDecision()
    return JointDecision(
        [OrderAssignment(order.id, station.id) for order, station in chosen],
        [PodTrip(pod.id, station.id) for pod, station in sent],
        None if costs is None else SolveReport("heuristic", costs),
    )


def improving(now: Moment, rounds: int, weight: float, max_wait_s: float | None) -> tuple[float, Chosen, Sent]:
    """Orders for pods and pods for orders in turn, until that costs no less."""
    best: tuple[float, Chosen, Sent] | None = None
    for _ in range(rounds):
        chosen = fill(now, best[2] if best else [], max_wait_s=max_wait_s).chosen
        sent = pods_for(now, chosen)
        costs = cost(now, chosen, sent, weight)
        if best is not None and costs >= best[0]:
            break
        best = costs, chosen, sent
    assert best is not None
    return best


def alternating(
    now: Moment, told: Any, *, rounds: int = 10, unused_capacity_weight: float = 2.0, max_wait_s: float | None = None
) -> JointDecision:
    costs, chosen, sent = improving(now, rounds, unused_capacity_weight, max_wait_s)
    return decision(chosen, sent, costs)


def two_stage(
    now: Moment,
    told: Any,
    *,
    first_share: float = 0.75,
    first_orders: str = "cheapest",
    max_wait_s: float | None = None,
) -> JointDecision:
    """Pods for some orders, and then more orders for these pods."""
    first = fill(now, [], max_wait_s=max_wait_s, oldest=first_orders == "oldest", first_share=first_share)
    sent = pods_for(now, first.chosen, by_worth=True)
    left = Left(now, sent)
    places = Places(now, first.chosen, taken=left.take, max_wait_s=max_wait_s)
    if not [order for order in places.late() if order in places.waiting()]:
        for order in places.waiting():
            for station in sorted(now.stations, key=lambda station: (places.load[station.id], station.id)):
                complete = left.in_stock(order) and not left.missing(order, station)
                further = [*places.chosen, (order, station)]
                if complete and places.fits(order, station) and serve(now, further, sent):
                    places.take(order, station)
                    break
    return decision(places.chosen, sent)


def lns(
    now: Moment,
    told: Any,
    *,
    iterations: int = 50,
    share: float = 0.3,
    unused_capacity_weight: float = 2.0,
    max_wait_s: float | None = None,
) -> JointDecision:
    """Take back some orders, choose again, and keep what costs less."""
    weight = unused_capacity_weight
    costs, chosen, sent = improving(now, 10, weight, max_wait_s)
    late = Places(now, chosen, max_wait_s=max_wait_s)
    stay = Greedy(now, max_wait_s=max_wait_s).late()
    if not chosen or [order for order in stay if order in late.waiting()]:
        return decision(chosen, sent, costs)
    best, shown = (costs, ages(now, chosen)), foremost(now, chosen, sent)
    for _ in range(iterations):
        back = taken_back(now, chosen, sent, share)
        kept = [pair for pair in chosen if pair[0] not in back or pair[0] in stay]
        other = refilled(now, kept, shown)
        pods = pods_for(now, other)
        if (value := (cost(now, other, pods, weight), ages(now, other))) < best:
            best, chosen, sent = value, other, pods
    return decision(chosen, sent, best[0])


def ages(now: Moment, chosen: Chosen) -> list[int]:
    """Places of orders in the backlog, ascending."""
    return sorted(now.backlog.index(order) for order, _ in chosen)


def taken_back(now: Moment, chosen: Chosen, sent: Sent, share: float) -> list[Order]:
    """Orders by lot, those that want something of a pod that is sent, or those of a station."""
    way = int(now.rng.integers(3))
    if way == 0 or (way == 1 and not sent):
        drawn = (now.rng.random(len(chosen)) < share).tolist()
        return [order for (order, _), taken in zip(chosen, drawn, strict=True) if taken]
    if way == 1:
        pod, at = sent[int(now.rng.integers(len(sent)))]
        return [order for order, station in chosen if station is at and wants(order).keys() & pod.contents.keys()]
    at = chosen[int(now.rng.integers(len(chosen)))][1]
    return [order for order, station in chosen if station is at]


def foremost(now: Moment, chosen: Chosen, sent: Sent) -> list[Order]:
    """Orders that are chosen, and of the others for each station with free places those that would go there first."""
    if len(now.backlog) <= MOST_ORDERS:
        return now.backlog
    left, found = Left(now, sent), list[Order]()
    taking = [station for station in now.stations if station.free_capacity]
    for station in taking:
        able = [
            order
            for order in now.backlog
            if order not in found
            and left.in_stock(order)
            and now.world.size_at(order, station) <= station.free_capacity
        ]
        found += sorted(able, key=lambda order, at=station: left.per_place(order, at))[: MOST_ORDERS // len(taking)]
    return [order for order in now.backlog if order in found or order in [one for one, _ in chosen]]


def refilled(now: Moment, kept: Chosen, shown: list[Order]) -> Chosen:
    """The orders that are kept, and more as long as any fits, by scores that are off by up to half a line."""
    left = Left(now, pods_for(now, kept))
    noise = now.rng.integers(0, MILLION // 2, (len(shown), len(now.stations))).tolist()

    def score(order: Order, station: Station) -> Parts | None:
        lacking = left.per_place(order, station) + noise[shown.index(order)][station.id]
        return (-lacking,) if left.in_stock(order) else None

    places = Places(now, kept, score=score, taken=left.take)
    while (pair := places.best([order for order in places.waiting() if order in shown])) is not None:
        places.take(*pair)
    return places.chosen
