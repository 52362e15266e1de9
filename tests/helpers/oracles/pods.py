"""Literal versions of the rules that select pods for stations, and stations and pods for bundles."""

import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from oracles.orders import free_on, wants
from oracles.worlds import Moment
from rmfs_core import BundleAssignment, BundleDecision, PodTrip, StoreBundle
from rmfs_core.warehouse import Bundle, Order, Pod, Request, Station

Choose = Callable[[Station, list[Pod]], Pod]
Score = Callable[[Pod, Station], float]
CLOSE = 1e-6
"""Largest rounding error of sums of fractions."""


def trips(now: Moment, choose: Choose) -> list[PodTrip]:
    """Send pods one after another: the station with the fewest inbound pods is next, then the neediest.

    Pods that may be sent are stored and bound nowhere, of these at most so many, or leave a station.
    """
    world, leaving, fetches = now.world, [*now.world.leaving_pods()], now.max_fetches
    given_up: set[int] = set()
    made: list[PodTrip] = []
    while needy := [s for s in now.stations if s.uncovered_requests and s.id not in given_up]:
        station = min(needy, key=lambda s: (len(s.inbound_pods), -s.uncovered_items, s.id))
        sent = [trip.pod for trip in made]
        able = [
            pod
            for pod in world.pods
            if pod.id not in sent
            and station.id not in pod.bound_for
            and (pod in leaving or (fetches > 0 and pod.location is not None and not pod.bound_for))
            and any(pod.free_items(request.sku) > 0 for request in station.uncovered_requests)
        ]
        if not able:
            given_up.add(station.id)
            continue
        pod = choose(station, able)
        made.append(PodTrip(pod.id, station.id))
        fetches -= pod not in leaving
        world.bind(pod, station)
    return made


def by_scores(now: Moment, told: Sequence[PodTrip], scores: Iterable[Score | None]) -> list[PodTrip]:
    """Those with the best first score stay, of these those with the best next one, at last the lowest id.

    A score of None is drawn at random. Between pods whose scores differ by at most `CLOSE`, the rule's answer decides.
    """
    draws = iter(told)

    def choose(station: Station, able: list[Pod]) -> Pod:
        left, close, expected = able, False, next(draws, None)
        for score in scores:
            if len(left) > 1:
                lots = iter(now.rng.random(len(left)).tolist() if score is None else ())
                values = {pod: next(lots) if score is None else score(pod, station) for pod in left}
                near = [pod for pod in left if values[pod] >= max(values.values()) - CLOSE]
                close = close or len({values[pod] for pod in near}) > 1
                left = near
        return next((pod for pod in left if close and expected == PodTrip(pod.id, station.id)), left[0])

    return trips(now, choose)


def items_of(requests: Iterable[Request]) -> Counter[int]:
    return sum((Counter({request.sku: request.items}) for request in requests), Counter[int]())


def uncovered(station: Station) -> dict[Order, Counter[int]]:
    """Uncovered items by order and SKU; the order that was assigned first comes first."""
    wanted: dict[Order, Counter[int]] = {}
    for request in station.uncovered_requests:
        wanted.setdefault(request.order, Counter())[request.sku] += request.items
    return wanted


def completed(wanted: Iterable[Counter[int]], items: Counter[int]) -> list[bool]:
    """Whether each order is completed with items, when one takes its items after the other."""
    found = []
    for needs in wanted:
        found.append(needs <= items)
        if found[-1]:
            items = items - needs
    return found


def nearest(now: Moment) -> Score:
    return lambda pod, station: -now.ticks(pod, station) / 1000


def picks(pod: Pod, station: Station) -> float:
    """Uncovered requests that the pod can serve."""
    return (free_on(pod) & items_of(station.uncovered_requests)).total()


def demand(now: Moment) -> Score:
    """Items wanted in the whole system that the pod has free: of orders that arrived, and not picked."""
    wanted = Counter[int]()
    for order in now.world.arrived.values():
        wanted += wants(order)
    for station in now.stations:
        wanted += items_of(station.open_requests)
    return lambda pod, station: (wanted & free_on(pod)).total()


def completes(now: Moment, *, count_backlog: bool) -> Score:
    """Orders of the station that the pod completes, and those of the backlog that what is left completes."""

    def score(pod: Pod, station: Station) -> float:
        items = free_on(pod)
        here = sum(completed(uncovered(station).values(), items))
        rest = items - items_of(station.uncovered_requests)
        return here + count_backlog * sum(completed(map(wants, now.world.backlog.orders), rest))

    return score


def work(
    now: Moment,
    *,
    value: str = "picks",
    backlog_weight: float = 0.2,
    completion_boost: float = 1.0,
    time_cost_per_s: float = 1 / 3,
) -> Score:
    """Worth of the items that the pod serves, less the drive."""

    def each(order: Order) -> float:
        since_s = order.arrival_s if value == "age" else order.due_s
        if value == "picks":
            return 1.0
        return 0.0 if since_s is None else max(now.now_s - since_s, 0.0) / order.unpicked_items

    def score(pod: Pod, station: Station) -> float:
        items = free_on(pod)
        whole = dict(zip(uncovered(station), completed(uncovered(station).values(), items), strict=True))
        total = -time_cost_per_s * now.ticks(pod, station) / 1000
        for request in station.uncovered_requests:
            served = min(max(items[request.sku], 0), request.items)
            items[request.sku] -= served
            total += each(request.order) * (completion_boost * request.items * whole[request.order] + served)
        for order in now.world.backlog.orders:
            for sku, number in wants(order).items():
                served = min(max(items[sku], 0), number)
                items[sku] -= served
                total += backlog_weight * served * each(order)
        return total

    return score


def lexicographic(
    now: Moment,
    told: Sequence[PodTrip],
    *,
    scores: tuple[str, ...] = ("completes", "work", "nearest"),
    count_backlog: bool = False,
    **weights: Any,
) -> list[PodTrip]:
    """The pod with the best scores."""
    known: dict[str, Score | None] = {
        "completes": completes(now, count_backlog=count_backlog),
        "picks": picks,
        "work": work(now, **weights),
        "demand": demand(now),
        "nearest": nearest(now),
        "random": None,
    }
    return by_scores(now, told, [known[name] for name in scores])


def completes_most(now: Moment, told: Sequence[PodTrip], *, count_backlog: bool = False) -> list[PodTrip]:
    """The pod that completes most orders, then with most picks, then the nearest."""
    return lexicographic(now, told, scores=("completes", "picks", "nearest"), count_backlog=count_backlog)


def work_amount(now: Moment, told: Sequence[PodTrip], **weights: Any) -> list[PodTrip]:
    """The pod that gets most work done."""
    return lexicographic(now, told, scores=("work",), **weights)


def most_wanted(now: Moment, told: Sequence[PodTrip]) -> list[PodTrip]:
    """The pod that is wanted most, then the nearest."""
    return lexicographic(now, told, scores=("demand", "nearest"))


def nearest_pod(now: Moment, told: Sequence[PodTrip]) -> list[PodTrip]:
    return lexicographic(now, told, scores=("nearest",))


def drawn(now: Moment, told: Sequence[PodTrip], *, max_wait_s: float | None = None) -> list[PodTrip]:
    return trips(now, lambda _, able: able[int(now.rng.integers(len(able)))])


# Bundles


def first_bundle(now: Moment, told: Any) -> list[BundleAssignment]:
    """The oldest bundle goes to the least loaded station."""
    made = []
    for bundle in [*now.world.bundles.values()]:
        if able := [station for station in now.world.storing if station.free_bundle_capacity > 0]:
            station = min(able, key=lambda station: (len(station.bundles), station.id))
            made.append(BundleAssignment(bundle.id, station.id))
            now.world.assign_bundle(bundle, station)
    return made


def same_pod(now: Moment, told: Any) -> list[BundleAssignment]:
    """Each station has the room of one pod in mind."""
    stored = [pod for pod in now.world.pods if pod.location is not None and not pod.bound_for]
    new = max((pod.free_space for pod in stored), default=0)
    room: dict[Station, int] = {}

    def put(station: Station, size: int) -> None:
        room[station] = (room[station] if room[station] >= size else new) - size

    for station in now.world.storing:
        room[station] = max((pod.free_space for pod in station.inbound_pods), default=0)
        for bundle in station.bundles:
            if bundle.pod is None:
                put(station, bundle.size)
    made = []
    for bundle in [*now.world.bundles.values()]:
        able = [station for station in now.world.storing if station.free_bundle_capacity > 0]
        if enough := [station for station in able if room[station] >= bundle.size]:
            station = min(enough, key=lambda station: (room[station], station.id))
        elif able:
            station = min(able, key=lambda station: (len(station.bundles), station.id))
        else:
            break
        put(station, bundle.size)
        made.append(BundleAssignment(bundle.id, station.id))
        now.world.assign_bundle(bundle, station)
    return made


def drawn_stations(now: Moment, told: Sequence[BundleAssignment], *, max_wait_s: float | None = None) -> Any:
    """Any bundle and any station with a free place, until there is none; tests of the rule have how likely each is."""
    made = []
    for one in told:
        bundle, station = now.world.bundles.get(one.bundle), now.world.stations[one.station]
        if bundle is not None and station in now.world.storing and station.free_bundle_capacity > 0:
            made.append(one)
            now.world.assign_bundle(bundle, station)
    more = bool(now.world.bundles) and any(station.free_bundle_capacity > 0 for station in now.world.storing)
    return [*made, *["more"] * more]


Cost = Callable[[Moment, Pod, Bundle], float]


def held(now: Moment, pod: Pod) -> set[int]:
    """SKUs that a pod has free items of, or that are to come."""
    return {sku for sku, items in now.free[pod].items() if items > 0} | {bundle.sku for bundle in pod.bundles}


def items_with_bundles(now: Moment, pod: Pod, sku: int) -> int:
    """Free items, and those of bundles to come."""
    return now.free[pod][sku] + sum(bundle.items for bundle in pod.bundles if bundle.sku == sku)


def ordered(now: Moment) -> Counter[int]:
    """Items of all orders that have arrived."""
    return sum((Counter(dict(order.lines)) for order in now.world.arrived.values()), Counter[int]())


def together(now: Moment, pod: Pod, bundle: Bundle) -> int:
    """Orders until now that want the bundle's SKU and one of the others on the pod, added up over these."""
    orders = [{line.sku for line in order.lines} for order in now.world.arrived.values()]
    return sum({bundle.sku, sku} <= skus for sku in held(now, pod) - {bundle.sku} for skus in orders)


def wanted_now(now: Moment, pod: Pod) -> int:
    """Items wanted of the SKUs on a pod: of all orders that have arrived, less what was picked."""
    skus, left = held(now, pod), sum((wants(order) for order in now.world.arrived.values()), Counter[int]())
    for station in now.stations:
        left += items_of(station.open_requests)
    return sum(left[sku] for sku in skus)


def classes(of: Sequence[float], borders: tuple[float, ...]) -> list[int]:
    """Class of each: sorted, most first, and cut at shares."""
    best_first = sorted(range(len(of)), key=lambda one: (-of[one], one))
    ends = [math.floor(border * len(of)) for border in borders[:-1]]
    return [sum(best_first.index(one) >= end for end in ends) for one in range(len(of))]


def class_apart(now: Moment, pod: Pod, bundle: Bundle, borders: tuple[float, ...] = (0.1, 0.3, 1.0)) -> float:
    """When the class of a pod is tried: the bundle's own, the next down, the next up, and so on."""
    number = ordered(now)
    of_pods = classes([sum(number[sku] for sku in held(now, one)) for one in now.world.pods], borders)
    own = classes([number[sku] for sku in range(now.world.n_skus)], borders)[bundle.sku]
    turns = [own, *(own + sign * away for away in range(1, len(borders)) for sign in (1, -1))]
    return turns.index(of_pods[pod.id])


COSTS: dict[str, Cost] = {
    "emptiest-pod": lambda now, pod, bundle: -pod.free_space,
    "nearest-pod-with-room": lambda now, pod, bundle: 0,
    "same-sku": lambda now, pod, bundle: -items_with_bundles(now, pod, bundle.sku),
    "spread-sku": lambda now, pod, bundle: items_with_bundles(now, pod, bundle.sku),
    "correlated": lambda now, pod, bundle: -together(now, pod, bundle),
    "turnover-pod": class_apart,
    "least-demand": lambda now, pod, bundle: wanted_now(now, pod),
}
"""Cost of storing a bundle on a pod; the lowest is taken, then the nearest."""


def pod_for(now: Moment, bundle: Bundle, cost: Cost, stations: Sequence[Station]) -> Pod | None:
    """The pod that a bundle chooses, of those with room that are coming anyway or can be fetched."""
    coming = {pod for station in now.world.stations for pod in station.inbound_pods}
    able = [
        pod
        for pod in now.world.pods
        if pod.free_space >= bundle.size
        and (pod in coming or (now.max_fetches > 0 and pod.location is not None and not pod.bound_for))
    ]
    chosen = min(
        able,
        key=lambda pod: (cost(now, pod, bundle), min(now.ticks(pod, station) for station in stations), pod.id),
        default=None,
    )
    now.max_fetches -= chosen is not None and chosen not in coming
    return chosen


def stores(cost: Cost) -> Callable[..., list[StoreBundle]]:
    """Each bundle without a pod chooses one, station by station."""

    def decide(now: Moment, told: Any, **options: Any) -> list[StoreBundle]:
        made = []
        for station in now.world.storing:
            for bundle in [bundle for bundle in station.bundles if bundle.pod is None]:
                if (pod := pod_for(now, bundle, lambda *at: cost(*at, **options), (station,))) is not None:
                    made.append(StoreBundle(bundle.id, pod.id))
                    now.world.bind_bundle(bundle, pod)
        return made

    return decide


def drawn_pods(now: Moment, told: Sequence[StoreBundle], *, max_wait_s: float | None = None) -> list[StoreBundle]:
    """For each bundle a pod by lot: that with the lowest one."""
    lots: dict[Bundle, list[int]] = {}

    def lot(now: Moment, pod: Pod, bundle: Bundle) -> float:
        if bundle not in lots:
            lots[bundle] = now.rng.integers(1 << 62, size=len(now.world.pods)).tolist()
        return lots[bundle][pod.id]

    return stores(lot)(now, told)


def pod_first(now: Moment, told: Any, *, pod: str = "emptiest-pod") -> BundleDecision:
    """The oldest bundle chooses its pod, and then a station for it."""
    made, world = list[BundleAssignment](), now.world
    chosen = stores(COSTS[pod])(now, told)
    for bundle in [*world.bundles.values()]:
        able = [station for station in world.storing if station.free_bundle_capacity > 0]
        if able and (best := pod_for(now, bundle, COSTS[pod], able)) is not None:
            there = [s for s in able if s.id in best.bound_for] or able
            station = min(there, key=lambda s, best=best: (now.ticks(best, s), s.id))
            made.append(BundleAssignment(bundle.id, station.id))
            chosen.append(StoreBundle(bundle.id, best.id))
            world.assign_bundle(bundle, station)
            world.bind_bundle(bundle, best)
    return BundleDecision(made, chosen)
