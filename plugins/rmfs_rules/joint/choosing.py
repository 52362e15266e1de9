"""One decision: which orders go to which stations with given pods, few pods for them, and what that costs."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from attrs import field, validators
from numpy.typing import NDArray

from rmfs_core import JointDecision, OrderAssignment, PodTrip, SolveReport
from rmfs_core.warehouse import columns_of, stock_of
from rmfs_rules.helpers import OVERSIZE_WAIT_S, largest_capacity, station_to_keep
from rmfs_rules.helpers.sending import ticks_from

if TYPE_CHECKING:
    from rmfs_core.traffic import Roads
    from rmfs_core.warehouse import Order, WarehouseView

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Sent = list[tuple[int, int]]
"""Pods (ids) and the stations that they are sent to."""
Chosen = list[tuple[int, int]]
"""Orders (places in `Lines`) and their stations."""

NO_NOISE, NO_FLAGS = np.zeros((0, 0), np.int64), np.zeros((0, 0), np.bool_)
"""Nothing that orders lack by chance; nowhere a place that they have."""
KEPT = -1
"""Free capacity of a station that is kept for an order."""


def unused_capacity_weight() -> Any:
    """Return the parameter ``unused_capacity_weight`` of a rule that goes by `Period.cost`."""
    return field(
        default=2.0,
        validator=validators.gt(0),
        metadata={"doc": "W_u in the cost: what a free place that stays unused costs, in pod-station visits"},
    )


class ByPeriods:
    """A rule that decides with `Period`."""

    whole_orders: ClassVar[bool] = True

    def prepare(self, roads: Roads) -> None:  # noqa: ARG002
        """Load what is compiled, or compile it."""
        load()


class Period:
    """The orders, stations and pods of one decision.

    Parameters
    ----------
    warehouse
        The warehouse now.
    max_wait_s
        How long an order may wait, as `assign_best_pairs` has it.

    Attributes
    ----------
    lines
        The orders with their open lines.
    places
        Places of the orders with open lines, ascending, int64.
    most_items
        Open items of the largest order of the backlog.
    """

    def __init__(self, warehouse: WarehouseView, max_wait_s: float | None) -> None:
        from rmfs_rules.joint import order_search, pod_search  # compiled: imported when needed, for it takes its time

        self._orders: Any = order_search
        self._pods: Any = pod_search
        self.warehouse, self.max_wait_s = warehouse, max_wait_s
        self.lines, self._stock, self._stations = warehouse.lines, warehouse.stock, warehouse.stations
        self.most_items = int(self.lines.items.max(initial=1))
        self._largest = float(largest_capacity(warehouse))
        of_stations = [(s.free_capacity, s.load, s.capacity, s.counts_orders) for s in self._stations]
        self._free, self._load, self._capacity, self._counting = np.array(of_stations, np.int64).reshape(-1, 4).T.copy()
        self._available, self._supply = warehouse.available(), np.zeros(0, np.int64)
        if not warehouse.unlimited_stock:
            sums = np.bincount(self._stock.sku, self._stock.items, warehouse.n_skus)
            self._supply = sums.astype(np.int64)
        self.places, self._known_ticks = np.flatnonzero(self.lines.open_lines), set[int]()
        self._lacks = np.zeros((len(of_stations), len(self.lines.items)), np.int32)  # of one choice after another

    def choice(self, sent: Sent, until: Floats | None = None) -> Any:
        """Return the stations and pods, `order_search.Choice`, with what pods bring that are sent; none is chosen.

        It holds until the next choice is asked for.
        """
        at, stock = self._available.copy(), self._stock
        for pod, station in sent:
            entries = slice(*stock.of_pod[pod : pod + 2].tolist())
            at[station, stock.sku[entries]] += stock.items[entries]
        choice = self._orders.Choice(
            at, self._supply.copy(), self._lacks, self._free.copy(), self._load.copy(), self._capacity,
            self._counting > 0,
            np.full(len(at), np.inf) if until is None else until, self._placed, self._largest,
        )  # fmt: skip
        self._orders.begin(self.lines, self.most_items, choice)
        return choice

    def filled(self, sent: Sent, *, oldest: bool = False, until: Floats | None = None) -> Chosen:
        """Return orders that are chosen greedily, as `assign_best_pairs` does, with what pods bring that are sent.

        Again and again the pair of order and station with the fewest missing lines for each place that the order takes;
        ties go to the oldest order, then to the station with the lowest load.

        Parameters
        ----------
        sent
            Pods that are sent besides those that are at or bound for stations.
        oldest
            Whether the oldest order goes, to the station where it lacks fewest lines.
        until
            Load of each station from which on it takes no more. Left out: it takes all that fit.
        """
        if until is not None and not (self._load < until).any():
            return []
        choice = self.choice(sent, until)
        late = self._waiting_first(oldest, choice)
        return [*late, *self._orders.fill(self.places, oldest, NO_NOISE, self.lines, choice)]

    def refilled(self, orders: Ints, kept: Chosen, sent: Sent, noise: Ints) -> Chosen:
        """Return the orders that are kept, and more of some as long as any fits: those that lack least.

        Parameters
        ----------
        orders
            Those that may be chosen besides, places, ascending.
        kept
            Orders that are chosen already.
        sent
            As `filled` has it.
        noise
            What the orders lack besides, in millionths of a line, shape (orders, stations).
        """
        return [*kept, *self._orders.fill(orders, False, noise, self.lines, self._after(kept, sent))]

    def completed(self, chosen: Chosen, sent: Sent) -> Chosen:
        """Return orders that are chosen besides, oldest first, of which the pods that come have all that is wanted.

        Each goes to the station with the lowest load, of those where that is so.
        """
        choice, further, rest = self._after(chosen, sent), Chosen(), self.places
        while True:
            found, able = self._orders.complete(rest, self.lines, choice)
            if not able:
                return further
            place, rest = int(rest[found]), rest[found + 1 :]
            for station in sorted(able, key=lambda at: (choice.load[at], at)):
                if self.warehouse.unlimited_stock or self.serve([*chosen, *further, (place, station)], sent):
                    self._orders.take(place, station, self.lines, choice)
                    further.append((place, station))
                    break

    def foremost(self, number: int, chosen: Chosen, sent: Sent) -> Ints:
        """Return the places of all orders, or of those that are chosen and of those that would go first.

        Of these at most as many as said, for each station with free places as many as for the others, with what pods
        bring that are sent.
        """
        if len(self.places) <= number:
            return self.places
        choice, found = self.choice(sent), {place for place, _ in chosen}
        taking = np.flatnonzero(self._free > 0).tolist()
        for station in taking:
            first = self._first(number // len(taking), station, choice)
            choice.lacks[:, first] += self._orders.OUT
            found.update(first.tolist())
        return np.array(sorted(found), np.int64)

    def pods_for(self, chosen: Chosen, *, by_worth: bool = False) -> Sent:
        """Return few pods that bring what chosen orders lack at their stations.

        Again and again the pod that brings a station most goes there; of equals one that is bound for no station, the
        nearest, the lowest id. Then those that the others make needless stay. All pods together have what orders want.

        Parameters
        ----------
        chosen
            The orders.
        by_worth
            Whether of equals that are bound for no station the one with most items that the backlog wants goes first.
        """
        new = {at for _, at in chosen} - self._known_ticks
        if not chosen or (new and self.serve(chosen, [])):  # nothing has to be sent: driving times do not matter
            return []
        lines, pods = self.lines, self._known_pods
        if by_worth:
            wanted = np.bincount(lines.sku, lines.quantity, self.warehouse.n_skus).astype(np.int64)
            pods = pods._replace(wanted=wanted)
        for station in new:
            pods.ticks[station] = ticks_from(self.warehouse, self._cells, self._stations[station])
        self._known_ticks |= new
        trips, enough = self._pods.few(_pairs(chosen), lines, self._stock, pods)
        assert enough, "all pods together have enough"
        return [(pod, station) for pod, station in trips.tolist()]

    def serve(self, chosen: Chosen, sent: Sent) -> bool:
        """Whether the pods at, bound for and sent to stations have what chosen orders want, dealt out in this order."""
        enough: bool = self._pods.serve(_pairs(chosen), _pairs(sent), self.lines, self._stock, self._known_pods)
        return enough

    def late(self) -> list[int]:
        """Return the orders that have waited too long, oldest first, as `assign_best_pairs` has it."""
        if self.max_wait_s is None and self.most_items <= self._largest:
            return []  # nobody's arrival matters
        limit_s, least = (OVERSIZE_WAIT_S, self._largest) if self.max_wait_s is None else (self.max_wait_s, 0)
        waited_s = self.warehouse.now_s - self.lines.arrival_s[self.places]
        late: list[int] = self.places[(waited_s >= limit_s) & (self.lines.items[self.places] > least)].tolist()
        return late

    def cost(self, chosen: Chosen, sent: Sent, weight: float) -> float:
        """Return the objective (1): visits to stations with free places, and ``weight`` for every place left free.

        At a station that counts orders, a free place counts times the items of the largest order.
        """
        free = self._free.tolist()
        visits = len(sent) + sum(
            len(at.inbound_pods) for at, places in zip(self._stations, free, strict=True) if places
        )
        for place, station in chosen:
            free[station] -= self.warehouse.size_at(self._order(place), self._stations[station])
        unused = [free[at.id] * (self.most_items if at.counts_orders else 1) for at in self._stations]
        return float(visits + weight * sum(unused))

    def decision(self, chosen: Chosen, sent: Sent, cost: float | None = None) -> JointDecision:
        """Return orders and pods as the kernel takes them, and their cost, if it is known."""
        if not chosen:
            return JointDecision()
        return JointDecision(
            [OrderAssignment(int(self.lines.order_id[place]), station) for place, station in chosen],
            [PodTrip(pod, station) for pod, station in sent],
            None if cost is None else SolveReport("heuristic", cost),
        )

    def _waiting_first(self, oldest: bool, choice: Any) -> Chosen:
        """Choose the orders that have waited too long; for those that fit nowhere stations are kept."""
        chosen = Chosen()
        kept: dict[int, bool] = {}  # stations kept for an order that waits, and whether that is larger than any station
        for place in self.late():
            _, at = self._orders.best(np.array([place]), oldest, NO_NOISE, self.lines, choice)
            if at >= 0:
                self._orders.take(place, at, self.lines, choice)
                chosen.append((place, at))
            elif self.max_wait_s is not None or not any(kept.values()):
                keep = station_to_keep(self.warehouse, self._order(place), dict(enumerate(choice.free.tolist())), kept)
                if keep is not None:
                    kept[keep] = bool(self.lines.items[place] > self._largest)
                    choice.free[keep] = KEPT
            if len(kept) == sum(station.open for station in self._stations):
                break
        return chosen

    def _order(self, place: int) -> Order:
        return self.warehouse.order(int(self.lines.order_id[place]))

    def _first(self, number: int, station: int, choice: Any) -> Ints:
        """Return the orders that would go first to a station, at most so many, in any order."""
        items, lacks = self.lines.items[self.places], choice.lacks[station, self.places].astype(np.int64)
        if self._counting[station]:
            items = np.ones_like(items)
        sizes = np.where(items > self._largest, self._capacity[station], items)
        able = np.flatnonzero((lacks < self._orders.OUT) & (sizes <= self._free[station]))
        keys = lacks[able] * self._orders.SCALE // items[able] * len(items) + able  # of equals, the oldest first
        first: Ints = (np.partition(keys, number)[:number] if number < len(keys) else keys) % len(items)
        return self.places[first]

    def _after(self, chosen: Chosen, sent: Sent) -> Any:
        """Return what `choice` does once some orders are chosen."""
        choice = self.choice(sent)
        self._orders.take_all(_pairs(chosen), self.lines, choice)
        return choice

    @cached_property
    def _placed(self) -> Flags:
        """Whether orders have a place at stations that count orders, shape (stations, places), or (0, 0): none has."""
        if not self.warehouse.split_orders_open:
            return NO_FLAGS
        placed = np.zeros((len(self._stations), len(self.lines.items)), np.bool_)
        for place in self.lines.begun.tolist():
            placed[:, place] = [at.counts_orders and self._order(place).has_place_at(at.id) for at in self._stations]
        return placed

    @cached_property
    def _known_pods(self) -> Any:
        """What is known of the pods, `pod_search.Pods`; driving times are filled in when they are needed."""
        pods, stations = len(self._stock.at), len(self._stations)
        trips = [(pod.id, station.id) for station in self._stations for pod in station.inbound_pods]
        used, gains = np.zeros(len(self._stock.items), np.int64), np.zeros((stations, pods), np.int64)
        none, busy = np.zeros(0, np.int64), np.zeros(pods, np.bool_)
        return self._pods.Pods(_pairs(trips), none, np.zeros((stations, pods), np.int64), used, gains, busy)

    @cached_property
    def _cells(self) -> Ints:
        """Cell of each pod."""
        cells = self._stock.location.copy()
        for robot in self.warehouse.robots:
            if robot.task is not None:
                cells[robot.task] = self.warehouse.pods[robot.task].cell
        return cells


def load() -> None:
    """Load what is compiled, or compile it."""
    from rmfs_rules.joint import order_search as orders  # as above
    from rmfs_rules.joint import pod_search as pods

    lines, stock, none, one = columns_of((), 1), stock_of((), 1), _pairs(()), np.ones(1, np.int64)
    choice = orders.Choice(
        none[None, :0, 0], one[:0], np.zeros((1, 0), np.int32), one, one, one, one > 0, one / 1, NO_FLAGS, 1.0
    )
    orders.begin(lines, 1, choice)
    orders.take_all(none, lines, choice)
    orders.fill(one[:0], False, NO_NOISE, lines, choice)
    orders.complete(one[:0], lines, choice)
    known = pods.Pods(none, one[:0], NO_NOISE, one[:0], NO_NOISE, one[:0] > 0)
    pods.few(none, lines, stock, known)
    pods.serve(none, none, lines, stock, known)


def _pairs(pairs: Sequence[tuple[int, int]]) -> Ints:
    """Return pairs as an array, shape (n, 2)."""
    return np.array(pairs, np.int64).reshape(-1, 2)
