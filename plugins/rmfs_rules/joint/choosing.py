"""One decision: which orders go to which stations with given pods, few pods for them, and what that costs."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from rmfs_core import JointDecision, OrderAssignment, PodTrip, SolveReport
from rmfs_core.warehouse import CAPACITY, columns_of, stock_of
from rmfs_rules.helpers.late import assign_late
from rmfs_rules.helpers.pairs import places_taken
from rmfs_rules.helpers.parameters import POSITIVE, parameter
from rmfs_rules.helpers.sending import ticks_from, worth
from rmfs_rules.joint import order_search, pod_search
from rmfs_rules.joint.order_search import OUT, SCALE, Choice
from rmfs_rules.joint.pod_search import Pods

if TYPE_CHECKING:
    from rmfs_core.warehouse import WarehouseView
    from rmfs_core.world.travel import Travel

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]
Sent = list[tuple[int, int]]
"""Pods (ids) and the stations that they are sent to."""
Chosen = list[tuple[int, int]]
"""Orders (rows in `Lines`) and their stations."""

NO_NOISE = np.zeros((0, 0), np.int64)
"""Nothing that orders lack by chance."""


def unused_capacity_weight() -> Any:
    """Return the parameter ``unused_capacity_weight`` of a rule that goes by `Period.cost`."""
    return parameter(2.0, POSITIVE, "W_u in the cost: what a slot that stays unused costs, in pod-station visits")


class ByPeriods:
    """A rule that decides with `Period`."""

    whole_orders: ClassVar[bool] = True

    def prepare(self, travel: Travel) -> None:  # noqa: ARG002
        """Load what is compiled, or compile it."""
        lines, stock, none, one = columns_of((), 1), stock_of((), 1), _pairs(()), np.ones(1, np.int64)
        lacks, placed = np.zeros((1, 0), np.int32), np.zeros((1, 0), np.bool_)
        choice = Choice(lines, one[None], one, lacks, np.zeros(1, CAPACITY), np.ones(1), placed, 1.0)
        order_search.begin(none, 1, choice)
        order_search.fill(one[:0], False, NO_NOISE, choice)
        order_search.complete(one[:0], choice)
        pods = Pods(none, one[:0], none[:0].reshape(1, 0))
        pod_search.few(none, lines, stock, pods)
        pod_search.serve(none, none, lines, stock, pods)
        worth(stock, one[:0], one)


class Period:
    """The orders, stations and pods of one decision.

    Parameters
    ----------
    warehouse
        The warehouse now.
    max_wait_s
        How long an order may wait, as `assign_late` has it.

    Attributes
    ----------
    lines
        The orders with their open lines.
    rows
        Indices of the orders with open lines, ascending, int64.
    """

    def __init__(self, warehouse: WarehouseView, max_wait_s: float | None) -> None:
        self.warehouse, self._max_wait_s = warehouse, max_wait_s
        self.lines, self._stock, self._stations = warehouse.lines, warehouse.stock, warehouse.stations
        self.rows, self._available = np.flatnonzero(self.lines.open_lines), warehouse.available()
        self._largest, self._most = float(warehouse.largest_capacity), int(self.lines.items.max(initial=1))
        self._supply = np.zeros(0, np.int64)
        if not warehouse.unlimited_stock:
            self._supply = np.bincount(self._stock.sku, self._stock.items, warehouse.n_skus).astype(np.int64)
        self._visits = sum(len(station.inbound_pods) for station in self._stations if station.free_capacity)
        self._ticks: Ints | None = None  # from each pod, by station
        self._placed = places_taken(warehouse)

    def choice(self, sent: Sent, chosen: Chosen, until: Floats | None = None) -> Choice:
        """Return the orders, the stations, and what pods have there if some are sent, once some orders are chosen."""
        at, stock = self._available.copy(), self._stock
        for pod, station in sent:
            entries = slice(*stock.of_pod[pod : pod + 2].tolist())
            at[station, stock.sku[entries]] += stock.items[entries]
        lacks, endless = np.zeros((len(at), len(self.lines.items)), np.int32), np.full(len(at), np.inf)
        stations, until = self.warehouse.capacities.copy(), endless if until is None else until
        choice = Choice(self.lines, at, self._supply.copy(), lacks, stations, until, self._placed, self._largest)
        order_search.begin(_pairs(chosen), self._most, choice)
        return choice

    def filled(self, sent: Sent, *, oldest: bool = False, until: Floats | None = None) -> Chosen:
        """Return orders that are chosen greedily, late ones first, with the stock of the pods that are sent.

        Again and again the pair of order and station with the fewest missing lines for each slot that the order takes;
        ties go to the oldest order, then to the station with the lowest load.

        Parameters
        ----------
        sent
            Pods that are sent in addition to pods at or bound for stations.
        oldest
            Whether the oldest order goes, to the station where it lacks fewest lines.
        until
            Load of each station from which on it takes no more. Left out: it takes all that fit.
        """
        if until is not None and all(station.load >= until[station.id] for station in self._stations):
            return []
        choice, late = self.choice(sent, [], until), Chosen()

        def assign(row: int) -> bool:
            found = order_search.fill(np.array([row]), oldest, NO_NOISE, choice)
            late.extend(found)
            return bool(found)

        assign_late(self.warehouse, self._max_wait_s, choice.stations["free"], assign)
        return [*late, *order_search.fill(self.rows, oldest, NO_NOISE, choice)]

    def completed(self, chosen: Chosen, sent: Sent) -> Chosen:
        """Return orders that are chosen besides, oldest first, of which the pods that come have all that is wanted.

        Each goes to the station with the lowest load, of those where that is so.
        """
        choice, further, rest = self.choice(sent, chosen), Chosen(), self.rows
        while True:
            found, able = order_search.complete(rest, choice)
            if not able:
                return further
            row, rest = int(rest[found]), rest[found + 1 :]
            for station in sorted(able, key=lambda at: (choice.stations["load"][at], at)):
                if self.warehouse.unlimited_stock or self.serve([*chosen, *further, (row, station)], sent):
                    order_search.take(row, station, choice)
                    further.append((row, station))
                    break

    def foremost(self, number: int, chosen: Chosen, sent: Sent) -> Ints:
        """Return the rows of all orders, or of those that are chosen and of those that would go first.

        Of these at most as many as said, for each station with free slots as many as for the others, with what pods
        bring that are sent.
        """
        if len(self.rows) <= number:
            return self.rows
        choice, found, items = self.choice(sent, []), {row for row, _ in chosen}, self.lines.items[self.rows]
        taking = np.flatnonzero(choice.stations["free"] > 0).tolist()
        for at in taking:
            there, lacks = choice.stations[at], choice.lacks[at, self.rows].astype(np.int64)
            shared = np.ones_like(items) if there["counts_orders"] else items
            sizes = np.where(shared > self._largest, there["capacity"], shared)
            able = np.flatnonzero((lacks < OUT) & (sizes <= there["free"]))
            first = able[np.argsort(lacks[able] * SCALE // shared[able], kind="stable")[: number // len(taking)]]
            choice.lacks[:, self.rows[first]] += OUT
            found.update(self.rows[first].tolist())
        return np.array(sorted(found), np.int64)

    def pods_for(self, chosen: Chosen, *, by_worth: bool = False) -> Sent:
        """Return few pods that bring what chosen orders lack at their stations.

        Again and again the pod that brings a station most goes there; of equals one that is bound for no station, the
        nearest, the lowest id. Then pods that the others make needless stay. All pods together have what orders want.

        Parameters
        ----------
        chosen
            The orders.
        by_worth
            Whether of equals that are bound for no station the one with most items that the backlog wants goes first.
        """
        if not chosen or (self._ticks is None and self.serve(chosen, [])):  # driving times do not matter
            return []
        if self._ticks is None:
            cells = self._stock.location.copy()
            carried = np.flatnonzero(cells < 0)
            cells[carried] = [self.warehouse.pods[pod].cell for pod in carried.tolist()]
            self._ticks = np.array([ticks_from(self.warehouse, cells, station) for station in self._stations])
        pods, lines = self._pods._replace(ticks=self._ticks), self.lines
        if by_worth:
            wanted = np.bincount(lines.sku, lines.quantity, self.warehouse.n_skus).astype(np.int64)
            pods = pods._replace(worth=worth(self._stock, np.arange(len(pods.worth)), wanted))
        return [(pod, station) for pod, station in pod_search.few(_pairs(chosen), lines, self._stock, pods).tolist()]

    def serve(self, chosen: Chosen, sent: Sent) -> bool:
        """Whether the pods at, bound for and sent to stations have what chosen orders want, dealt out in this order."""
        return bool(pod_search.serve(_pairs(chosen), _pairs(sent), self.lines, self._stock, self._pods))

    def cost(self, chosen: Chosen, sent: Sent, weight: float) -> float:
        """Return the objective (1): visits to stations with free slots, and ``weight`` for every slot left free.

        At a station that counts orders, a free slot counts times the items of the largest order.
        """
        free: list[int] = self.warehouse.capacities["free"].tolist()
        for row, station in chosen:
            order = self.warehouse.order(int(self.lines.order_id[row]))
            free[station] -= self.warehouse.size_at(order, self._stations[station])
        unused = [free[at.id] * (self._most if at.counts_orders else 1) for at in self._stations]
        return float(self._visits + len(sent) + weight * sum(unused))

    def decision(self, chosen: Chosen, sent: Sent, cost: float | None = None) -> JointDecision:
        """Return orders and pods as the kernel takes them, and their cost, if it is known."""
        if not chosen:
            return JointDecision()
        return JointDecision(
            [OrderAssignment(int(self.lines.order_id[row]), station) for row, station in chosen],
            [PodTrip(pod, station) for pod, station in sent],
            None if cost is None else SolveReport("heuristic", cost),
        )

    @cached_property
    def _pods(self) -> Pods:
        """The pods, all alike and as near."""
        trips = [(pod.id, station.id) for station in self._stations for pod in station.inbound_pods]
        number = len(self._stock.at)
        return Pods(_pairs(trips), np.zeros(number, np.int64), np.zeros((len(self._stations), number), np.int64))


def _pairs(pairs: Sequence[tuple[int, int]]) -> Ints:
    """Return pairs as an array, shape (n, 2)."""
    return np.array(pairs, np.int64).reshape(-1, 2)
